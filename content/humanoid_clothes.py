# SPDX-License-Identifier: MIT
"""The humanoid's clothes: tunic, trousers, boots, belt, buckle and pouch."""

import math

import numpy as np
from humanoid_measures import (
    ANKLE,
    BELT,
    BOOT,
    BUCKLE,
    CLOTH,
    ELBOW_AT,
    LEATHER,
    SOLE,
    TROUSERS,
    TUNIC,
    TUNIC_HEM,
    along_arm,
    arm_coordinates,
)
from surface import Cage, bump, ramp, rough, spline, subdivide


def oval(z, half_width, front, back, centre_y, columns, power=0.85):
    """A level ring, first point at the left side (+X), then round by the back."""
    ring = []
    for j in range(columns):
        c, s = math.cos(2 * math.pi * j / columns), math.sin(2 * math.pi * j / columns)
        x = half_width * math.copysign(abs(c) ** power, c)
        ring.append((x, centre_y + (back if s > 0 else front) * math.copysign(abs(s) ** power, s), z))
    return ring


def tunic():
    """A belted tunic: one tube from the hem's fold to the collar's, with sleeves let in at the sides."""
    columns = 16
    #         z    half width, front, back, middle
    levels = [
        (0.846, 0.196, 0.140, 0.146, 0.004),
        (0.832, 0.198, 0.142, 0.148, 0.004),
        (0.824, 0.207, 0.151, 0.157, 0.004),
        (0.836, 0.210, 0.153, 0.160, 0.004),
        (0.858, 0.208, 0.151, 0.158, 0.004),
        (0.866, 0.202, 0.146, 0.153, 0.004),
        (0.905, 0.197, 0.138, 0.150, 0.004),
        (0.950, 0.187, 0.128, 0.143, 0.004),
        (0.990, 0.172, 0.118, 0.131, 0.004),
        (1.025, 0.155, 0.108, 0.113, 0.003),
        (1.060, 0.151, 0.106, 0.107, 0.003),
        (1.090, 0.162, 0.116, 0.112, 0.003),
        (1.140, 0.166, 0.121, 0.112, 0.004),
        (1.205, 0.170, 0.123, 0.114, 0.008),
        (1.268, 0.178, 0.128, 0.119, 0.012),
        (1.330, 0.184, 0.127, 0.121, 0.013),
        (1.390, 0.187, 0.113, 0.114, 0.015),
        (1.443, 0.181, 0.090, 0.097, 0.017),
        (1.471, 0.135, 0.076, 0.078, 0.019),
        (1.489, 0.096, 0.070, 0.066, 0.020),
        (1.500, 0.073, 0.068, 0.056, 0.020),
        (1.524, 0.069, 0.064, 0.051, 0.018),
        (1.530, 0.066, 0.061, 0.048, 0.018),
        (1.522, 0.063, 0.058, 0.045, 0.018),
        (1.490, 0.063, 0.058, 0.045, 0.018),
    ]
    low, high = 14, 17  # the armhole's first and last level
    cage = Cage()
    rings = [cage.add(oval(*level, columns)) for level in levels]
    at = lambda side, i, level: rings[level][(i if side > 0 else columns // 2 - i) % columns]
    holes = {
        frozenset((at(s, i, k), at(s, i + 1, k), at(s, i + 1, k + 1), at(s, i, k + 1)))
        for s in (1, -1)
        for i in range(-2, 2)
        for k in range(low, high)
    }
    cage.tube(rings, seam=columns // 4)
    cage.faces = [f for f in cage.faces if frozenset(f) not in holes]
    for hard in (2, 5):
        cage.harden(rings[hard])
    cage.cut(rings[2])
    cage.cut(rings[-3])

    # along, above, front, middle above: shoulder, upper arm, elbow, the rolled cuff and its inner fold
    sleeve = [
        (0.020, 0.072, 0.074, -0.012),
        (0.060, 0.068, 0.069, -0.006),
        (0.110, 0.062, 0.063, -0.002),
        (0.165, 0.058, 0.059, 0.0),
        (0.215, 0.056, 0.057, 0.0),
        (0.250, 0.055, 0.056, 0.0),
        (0.275, 0.055, 0.056, 0.0),
        (0.300, 0.055, 0.056, 0.0),
        (0.335, 0.053, 0.053, 0.0),
        (0.366, 0.052, 0.052, 0.0),
        (0.370, 0.060, 0.060, 0.0),
        (0.392, 0.062, 0.061, 0.0),
        (0.416, 0.059, 0.058, 0.0),
        (0.412, 0.052, 0.051, 0.0),
        (0.385, 0.047, 0.046, 0.0),
    ]
    for side in (1, -1):
        hole = (
            [at(side, -i, high) for i in range(0, 2)]
            + [at(side, -2, k) for k in range(high, low, -1)]
            + [at(side, i, low) for i in range(-2, 2)]
            + [at(side, 2, k) for k in range(low, high)]
            + [at(side, 2, high), at(side, 1, high)]
        )
        loops = [hole]
        for t, above, front, middle in sleeve:
            turn = 2 * math.pi / len(hole)
            loops.append(
                cage.add(
                    [
                        (side, 1, 1)
                        * along_arm(t, middle + above * math.cos(k * turn), front * math.sin(k * turn))
                        for k in range(len(hole))
                    ]
                )
            )
        cage.tube(loops, seam=7)
        cage.cut(hole)
        for hard in (11, 13):
            cage.harden(loops[hard])
        cage.cut(loops[14])
        cage.points = relax(cage, set(loops[1]) | set(hole), 3)

    part = subdivide(cage, 1, CLOTH, TUNIC)
    part.displace(tunic_folds(part.points))
    part.points = pleated(part.points)
    x, y, z = part.points.T
    t, above = arm_coordinates(part.points)
    on_arm = (np.abs(x) > 0.2) & (np.abs(above) < 0.09) & (t > 0.03)
    trim = (z < 0.864) & ~on_arm | on_arm & (t > 0.367) | (z > 1.499) & ~on_arm
    part.colours[trim] = TUNIC_HEM
    return part


def relax(cage, chosen, rounds):
    """Moves the chosen points of a cage to the mean of their neighbours."""
    near = {i: set() for i in chosen}
    for f in cage.faces:
        for a, b in zip(f, f[1:] + f[:1]):
            if a in near:
                near[a].add(b)
            if b in near:
                near[b].add(a)
    points = [np.array(p) for p in cage.points]
    for _ in range(rounds):
        points = [
            0.5 * p + 0.5 * np.mean([points[n] for n in sorted(near[i])], axis=0) if i in near else p
            for i, p in enumerate(points)
        ]
    return [tuple(p) for p in points]


def pleated(points):
    """The skirt's pleats, which move its hem and the fold inside it together."""
    x, y, z = points.T
    radial = points * (1, 1, 0)
    radial /= np.linalg.norm(radial, axis=1)[:, None]
    depth = (
        0.011
        * (1 - ramp(z, 0.87, 1.02))
        * (1 - ramp(arm_coordinates(points)[0], 0.0, 0.1) * (np.abs(x) > 0.3))
    )
    wave = np.sin(8 * np.arctan2(y, x) + 1.6 * rough(points * (1, 1, 0.2), 6.0, 9))
    return points + radial * (depth * wave)[:, None]


def tunic_folds(points):
    """Gathers above the belt, drag folds from the armpits, rings about the elbows: metres along normals."""
    x, y, z = points.T
    side = np.abs(x)
    t, above = arm_coordinates(points)
    arm = ramp(t, 0.0, 0.08) * (side > 0.15) * (np.abs(above) < 0.1)
    body = 1.0 - arm
    angle = np.arctan2(y, x)
    wobble = rough(points, 7.0, 1)
    blouse = 0.0060 * body * bump(z, 1.10, 0.045) * np.sin(8 * angle + 2.5 * wobble)
    drag = (
        0.0065
        * body
        * bump(z, 1.25, 0.11)
        * ramp(side, 0.02, 0.10)
        * np.sin(85 * (z - 0.75 * side) + 2.6 * wobble)
    )
    creases = np.sin(135 * t + 2.2 * wobble + 14 * y)
    elbow = 0.0065 * arm * bump(t, ELBOW_AT, 0.065) * creases
    upper = 0.0045 * arm * bump(t, 0.12, 0.08) * np.sin(95 * t + 50 * y + 2 * wobble)
    cuff = 1 - ramp(t, 0.35, 0.368) * arm
    return blouse + drag + (elbow + upper) * cuff + 0.0014 * rough(points, 16.0, 2) * ramp(z, 0.85, 0.88)


LEG_COLUMNS = 12


def leg_angle(m):
    """From the front; point 0 is inside of the front, and points go round by the outside."""
    return 2 * math.pi * (m - 1) / LEG_COLUMNS


def leg_ring(z, centre_x, half_width, front, back):
    """A level ring about the left leg."""
    ring, middle, half = [], 0.5 * (front + back), 0.5 * (back - front)
    for m in range(LEG_COLUMNS):
        a = leg_angle(m)
        ring.append((centre_x + half_width * math.sin(a), middle - half * math.cos(a), z))
    return ring


def trousers():
    """Trousers tucked into the boots. The waist ends open under the tunic."""
    columns = 16
    levels = [
        (1.010, 0.145, 0.098, 0.100, 0.003),
        (0.965, 0.164, 0.106, 0.122, 0.004),
        (0.920, 0.172, 0.110, 0.130, 0.004),
        (0.880, 0.174, 0.108, 0.129, 0.004),
    ]
    #        z     middle x, half width, front y, back y
    leg = [
        (0.838, 0.097, 0.086, -0.092, 0.104),
        (0.795, 0.098, 0.083, -0.088, 0.096),
        (0.730, 0.099, 0.079, -0.085, 0.085),
        (0.655, 0.100, 0.072, -0.079, 0.074),
        (0.585, 0.100, 0.065, -0.074, 0.065),
        (0.540, 0.100, 0.062, -0.072, 0.059),
        (0.510, 0.100, 0.060, -0.071, 0.056),
        (0.480, 0.100, 0.060, -0.068, 0.058),
        (0.445, 0.101, 0.061, -0.062, 0.064),
        (0.410, 0.101, 0.064, -0.059, 0.072),
        (0.378, 0.102, 0.069, -0.058, 0.077),
        (0.354, 0.102, 0.062, -0.050, 0.071),
        (0.315, 0.102, 0.052, -0.042, 0.062),
    ]
    cage = Cage()
    waist = [cage.add(oval(*level, columns)) for level in levels]
    cage.tube(waist, seam=columns // 4)
    crotch = cage.add([(0, 0.070, 0.852), (0, 0.006, 0.838), (0, -0.060, 0.850)])
    front = 3 * columns // 4
    for side in (1, -1):
        half = [waist[-1][(front + side * m) % columns] for m in range(columns // 2 + 1)]
        rings = [half + crotch] + [
            cage.add([(side * x, y, z) for x, y, z in leg_ring(*level)]) for level in leg
        ]
        cage.tube(rings, seam=LEG_COLUMNS - 2)
        cage.cut(rings[0])
    part = subdivide(cage, 1, CLOTH, TROUSERS)
    x, y, z = part.points.T
    wobble = rough(part.points, 8.0, 3)
    behind = ramp(y, -0.03, 0.05)
    knee = 0.0075 * bump(z, 0.495, 0.065) * (0.35 + 0.65 * behind) * np.sin(130 * z + 2.4 * wobble)
    shin = 0.0060 * bump(z, 0.395, 0.035) * np.sin(150 * z + 2.6 * wobble + 10 * x)
    drag = 0.0055 * bump(z, 0.79, 0.07) * np.sin(80 * (z + 0.9 * np.abs(x)) + 2 * wobble)
    part.displace((knee + shin + drag + 0.0016 * rough(part.points, 14.0, 4)) * ramp(z, 0.335, 0.36))
    return part


def boot():
    """The left boot without its sole: a folded top, a shaft, and rings that turn upright at the heel."""
    cage = Cage()
    shaft = [
        (0.318, 0.104, 0.056, -0.043, 0.068),
        (0.345, 0.104, 0.062, -0.049, 0.074),
        (0.356, 0.104, 0.066, -0.053, 0.078),
        (0.350, 0.104, 0.072, -0.058, 0.083),
        (0.318, 0.104, 0.071, -0.057, 0.082),
        (0.298, 0.104, 0.070, -0.056, 0.080),
        (0.294, 0.104, 0.062, -0.048, 0.073),
        (0.245, 0.104, 0.058, -0.046, 0.073),
        (0.185, 0.104, 0.049, -0.042, 0.068),
        (0.140, 0.105, 0.045, -0.044, 0.066),
    ]
    rings = [cage.add(leg_ring(*level)) for level in shaft]
    #        back or bottom (y, z), front or top (y, z), half width
    foot = [
        ((0.074, 0.092), (-0.048, 0.118), 0.043),
        ((0.080, 0.058), (-0.058, 0.110), 0.043),
        ((0.076, 0.026), (-0.072, 0.102), 0.043),
        ((0.040, 0.014), (-0.090, 0.093), 0.043),
        ((-0.005, 0.014), (-0.110, 0.084), 0.044),
        ((-0.048, 0.014), (-0.130, 0.076), 0.047),
        ((-0.085, 0.014), (-0.148, 0.069), 0.050),
        ((-0.118, 0.014), (-0.165, 0.063), 0.051),
        ((-0.150, 0.014), (-0.182, 0.056), 0.047),
        ((-0.178, 0.016), (-0.197, 0.045), 0.036),
        ((-0.190, 0.020), (-0.202, 0.036), 0.022),
    ]
    for k, ((by, bz), (fy, fz), width) in enumerate(foot):
        lean = 0.012 * k / len(foot)  # feet point a little outwards
        points = []
        for a in map(leg_angle, range(LEG_COLUMNS)):
            f = 0.5 + 0.5 * math.cos(a)
            points.append((ANKLE[0] + lean + width * math.sin(a), by + f * (fy - by), bz + f * (fz - bz)))
        rings.append(cage.add(points))
    cage.tube(rings, seam=7)
    cage.cap(rings[-1][1:] + rings[-1][:1])
    for hard in (3, 5, 6):
        cage.harden(rings[hard])
    cage.cut(rings[6])
    cage.cut(rings[12])
    part = subdivide(cage, 1, LEATHER, BOOT)
    x, y, z = part.points.T
    wobble = rough(part.points, 11.0, 5)
    ankle = 0.0032 * bump(z, 0.135, 0.045) * (y > -0.09) * np.sin(190 * z + 60 * y + 2 * wobble)
    vamp = 0.0016 * bump(y, -0.11, 0.03) * ramp(z, 0.03, 0.05) * np.sin(210 * y + wobble)
    part.displace(ankle + vamp + 0.0010 * rough(part.points, 22.0, 6))
    part.colours[(z > 0.296)] = BELT
    return part


def sole():
    """A slab under the left boot, with a heel and hard edges all round."""
    count = 28
    ys = [-0.205, -0.185, -0.150, -0.110, -0.060, -0.010, 0.040, 0.070, 0.088]
    left = [0.0, 0.036, 0.051, 0.055, 0.050, 0.044, 0.043, 0.036, 0.0]
    right = [0.0, -0.040, -0.052, -0.053, -0.045, -0.040, -0.043, -0.036, 0.0]
    half = count // 2
    steps = 0.5 - 0.5 * np.cos(np.pi * np.arange(half) / half)  # closer at toe and heel
    y_out = ys[0] + steps * (ys[-1] - ys[0])
    y_in = ys[0] + (ys[-1] - ys[0]) * (0.5 + 0.5 * np.cos(np.pi * np.arange(half) / half))
    outline = [(spline(ys, left, y)[0], y) for y in y_out] + [(spline(ys, right, y)[0], y) for y in y_in]
    lean = lambda y: 0.012 * ramp(y, 0.09, -0.20)
    ring = lambda z, scale: [
        (ANKLE[0] + lean(y) + x * scale, -0.058 + (y + 0.058) * (1 - (1 - scale) * 0.35), z(y))
        for x, y in outline
    ]
    arch = lambda y: 0.009 * ramp(y, 0.02, -0.005) * ramp(y, -0.085, -0.05) + 0.006 * ramp(y, -0.17, -0.205)
    cage = Cage()
    rings = [
        cage.add(ring(lambda y: 0.027, 0.86)),
        cage.add(ring(lambda y: 0.026, 1.0)),
        cage.add(ring(arch, 1.0)),
        cage.add(ring(arch, 0.6)),
        cage.add(ring(arch, 0.2)),
    ]
    cage.tube(rings, seam=0)
    cage.cap(rings[0])
    cage.cap(rings[-1])
    cage.harden(rings[1])
    cage.harden(rings[2])
    cage.cut(rings[1])
    cage.cut(rings[2])
    return subdivide(cage, 0, LEATHER, SOLE)


def belt():
    """A strap with four hard edges, closed, over the tunic's waist."""
    columns = 32
    cage = Cage()
    levels = [
        (1.062, 0.154, 0.109, 0.111, 0.003),
        (1.066, 0.164, 0.119, 0.121, 0.003),
        (1.053, 0.166, 0.121, 0.123, 0.003),
        (1.028, 0.168, 0.122, 0.125, 0.003),
        (1.014, 0.168, 0.122, 0.126, 0.003),
        (1.018, 0.156, 0.110, 0.114, 0.003),
    ]
    rings = [cage.add(oval(*level, columns)) for level in levels]
    cage.tube(rings + [rings[0]], seam=10)
    for ring in (rings[0], rings[1], rings[4], rings[5]):
        cage.harden(ring)
        cage.cut(ring)
    return subdivide(cage, 0, LEATHER, BELT)


def box(cage, centre, half, bevel, lean=0.0):
    """A bevelled block: chamfer faces between hard sides."""
    (cx, cy, cz), (hx, hy, hz) = centre, half
    rings = []
    for y, inset in ((hy, bevel), (hy - bevel, 0.0), (-hy + bevel, 0.0), (-hy, bevel)):
        x0, z0 = hx - inset, hz - inset
        corners = [
            (x0, z0 - bevel),
            (x0 - bevel, z0),
            (bevel - x0, z0),
            (-x0, z0 - bevel),
            (-x0, bevel - z0),
            (bevel - x0, -z0),
            (x0 - bevel, -z0),
            (x0, bevel - z0),
        ]
        c, s = math.cos(lean), math.sin(lean)
        rings.append(cage.add([(cx + c * x - s * y, cy + s * x + c * y, cz + z) for x, z in corners]))
    cage.tube(rings, seam=5)
    for ring in (rings[0], rings[-1]):
        cage.cap(ring[1:] + ring[:1])
        cage.cut(ring)
    for ring in rings:
        cage.harden(ring)


def buckle():
    """A square frame with a pin, fixed to the hips."""
    cage = Cage()
    y, depth, z = -0.124, 0.006, 1.040
    ring = lambda w, h, at: cage.add([(w, at, z + h), (-w, at, z + h), (-w, at, z - h), (w, at, z - h)])
    rings = [
        ring(0.032, 0.031, y),
        ring(0.030, 0.029, y - depth),
        ring(0.021, 0.020, y - depth),
        ring(0.019, 0.018, y),
    ]
    cage.tube(rings + [rings[0]], seam=0)
    for r in rings:
        cage.harden(r)
        cage.cut(r)
    box(cage, (0.0, y - depth, z), (0.021, 0.0035, 0.0035), 0.001)
    return subdivide(cage, 0, LEATHER, BUCKLE, joint="hips")


def pouch():
    """A bag on the right hip with a flap, fixed to the hips."""
    cage = Cage()
    place = (-0.148, -0.088, 0.985)
    lean = math.radians(-42)
    box(cage, place, (0.036, 0.020, 0.042), 0.008, lean)
    out = np.array((math.sin(lean), -math.cos(lean), 0))
    box(cage, tuple(np.array(place) + 0.006 * out + (0, 0, 0.022)), (0.039, 0.019, 0.024), 0.005, lean)
    part = subdivide(cage, 0, LEATHER, BELT, joint="hips")
    return part
