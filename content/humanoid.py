# SPDX-License-Identifier: MIT
"""Makes humanoid.glb, a clothed stylised human.

    blender -b --factory-startup --python content/humanoid.py -- content/humanoid.glb
"""

import math
import os
import sys

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import rig as kit  # noqa: E402
from rig import Cage, Pose, Skeleton, blend, bump, capsule, carve, ellipsoid, ramp, rough, spline  # noqa: E402

SKIN, CLOTH, LEATHER = "skin", "cloth", "leather"
LOOKS = {SKIN: (0.0, 0.55, False), CLOTH: (0.0, 0.85, True), LEATHER: (0.15, 0.50, False)}

FLESH, LIP, EYE_WHITE, IRIS, PUPIL = (0.72, 0.42, 0.30), (0.55, 0.22, 0.18), (0.85, 0.84, 0.80), (0.08, 0.20, 0.22), (0.01, 0.01, 0.01)
TUNIC, TUNIC_HEM, TROUSERS = (0.10, 0.24, 0.22), (0.45, 0.34, 0.14), (0.16, 0.13, 0.11)
BOOT, SOLE, BELT, BUCKLE, HAIR = (0.17, 0.07, 0.03), (0.05, 0.03, 0.02), (0.22, 0.10, 0.04), (0.75, 0.58, 0.25), (0.10, 0.045, 0.02)

# ---- Measures of the left side; the right side is its mirror image ------------------------------------------------

ARM_DROP = math.radians(42)
ARM = np.array([math.cos(ARM_DROP), 0.0, -math.sin(ARM_DROP)])  # along the arm, away from the body
ABOVE = np.array([math.sin(ARM_DROP), 0.0, math.cos(ARM_DROP)])  # off the arm's upper side
FRONT = np.array([0.0, -1.0, 0.0])
SHOULDER = np.array([0.178, 0.012, 1.425])
ELBOW_AT, WRIST_AT, KNUCKLES_AT = 0.275, 0.525, 0.612  # along the arm from the shoulder
HIP, KNEE, ANKLE = np.array([0.092, 0.005, 0.905]), np.array([0.100, -0.012, 0.495]), np.array([0.105, 0.022, 0.095])
BALL, TOE = np.array([0.112, -0.105, 0.035]), np.array([0.114, -0.185, 0.030])
HEAD = np.array([0.0, -0.012, 1.625])  # the middle of the skull
EYE = HEAD + np.array([0.033, -0.0735, 0.0])
EYE_RADIUS = 0.0185

# Fingers: place across the palm, length, and how far the knuckle stands ahead of or behind the row.
FINGERS = {"index": (0.031, 0.078, 0.0), "middle": (0.0105, 0.087, 0.004), "ring": (-0.0105, 0.080, 0.001),
           "pinky": (-0.030, 0.063, -0.007)}
PHALANGES = (0.0, 0.44, 0.73, 1.0)
FINGER_CURL = 9.0  # degrees at each joint at rest


def along_arm(t, above=0.0, front=0.0):
    return SHOULDER + t * ARM + above * ABOVE + front * FRONT


def finger_path(name):
    """The joints of a finger from knuckle to tip, and its straight direction."""
    across, length, ahead = FINGERS[name]
    spread = math.radians(140 * across)
    straight = math.cos(spread) * ARM + math.sin(spread) * FRONT
    points, angle = [along_arm(KNUCKLES_AT + ahead, -0.001, across)], math.radians(6)
    for a, b in zip(PHALANGES, PHALANGES[1:]):
        points.append(points[-1] + (b - a) * length * (math.cos(angle) * straight - math.sin(angle) * ABOVE))
        angle += math.radians(FINGER_CURL)
    return points


def thumb_path():
    start = along_arm(WRIST_AT + 0.020, -0.006, 0.022)
    directions = [(0.72, -0.22, 0.66), (0.82, -0.25, 0.52), (0.90, -0.26, 0.36)]
    points = [start]
    for (a, n, f), length in zip(directions, (0.040, 0.032, 0.028)):
        points.append(points[-1] + length * (a * ARM + n * ABOVE + f * FRONT))
    return points


def skeleton():
    s = Skeleton()
    s.add("root", None, (0, 0, 0), (0, 0.12, 0))
    s.add("hips", "root", (0, 0.005, 0.945), (0, 0.004, 1.03))
    s.chain(["spine1", "spine2", "chest"], "hips",
            [(0, 0.004, 1.03), (0, 0.006, 1.14), (0, 0.012, 1.25), (0, 0.018, 1.445)])
    s.chain(["neck", "head"], "chest", [(0, 0.022, 1.460), (0, 0.004, 1.550), (0, -0.004, 1.755)])
    for side, tag in ((1, ".L"), (-1, ".R")):
        at = lambda p: np.array(p) * (side, 1, 1)
        s.add("eye" + tag, "head", at(EYE), at(EYE + 0.03 * FRONT))
        s.add("clavicle" + tag, "chest", at((0.022, -0.005, 1.440)), at(SHOULDER))
        s.chain([n + tag for n in ("upper_arm", "forearm", "hand")], "clavicle" + tag,
                [at(along_arm(t, 0, b)) for t, b in ((0, 0), (ELBOW_AT, -0.006), (WRIST_AT, 0), (KNUCKLES_AT, 0))])
        s.chain([f"thumb{i}{tag}" for i in (1, 2, 3)], "hand" + tag, [at(p) for p in thumb_path()])
        for finger in FINGERS:
            s.chain([f"{finger}{i}{tag}" for i in (1, 2, 3)], "hand" + tag, [at(p) for p in finger_path(finger)])
        s.chain([n + tag for n in ("thigh", "shin", "foot", "toe")], "hips", [at(p) for p in (HIP, KNEE, ANKLE, BALL, TOE)])
    return s


# ---- Clothes --------------------------------------------------------------------------------------------------------


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
    levels = [(0.846, 0.196, 0.140, 0.146, 0.004), (0.832, 0.198, 0.142, 0.148, 0.004),
              (0.824, 0.207, 0.151, 0.157, 0.004), (0.836, 0.210, 0.153, 0.160, 0.004),
              (0.858, 0.208, 0.151, 0.158, 0.004), (0.866, 0.202, 0.146, 0.153, 0.004),
              (0.905, 0.197, 0.138, 0.150, 0.004), (0.950, 0.187, 0.128, 0.143, 0.004),
              (0.990, 0.172, 0.118, 0.131, 0.004), (1.025, 0.155, 0.108, 0.113, 0.003),
              (1.060, 0.151, 0.106, 0.107, 0.003), (1.090, 0.162, 0.116, 0.112, 0.003),
              (1.140, 0.166, 0.121, 0.112, 0.004), (1.205, 0.170, 0.123, 0.114, 0.008),
              (1.268, 0.178, 0.128, 0.119, 0.012), (1.330, 0.184, 0.127, 0.121, 0.013),
              (1.390, 0.187, 0.113, 0.114, 0.015), (1.443, 0.181, 0.090, 0.097, 0.017),
              (1.471, 0.135, 0.076, 0.078, 0.019), (1.489, 0.096, 0.070, 0.066, 0.020),
              (1.500, 0.073, 0.068, 0.056, 0.020), (1.524, 0.069, 0.064, 0.051, 0.018),
              (1.530, 0.066, 0.061, 0.048, 0.018), (1.522, 0.063, 0.058, 0.045, 0.018),
              (1.490, 0.063, 0.058, 0.045, 0.018)]
    low, high = 14, 17  # the armhole's first and last level
    cage = Cage()
    rings = [cage.add(oval(*level, columns)) for level in levels]
    at = lambda side, i, level: rings[level][(i if side > 0 else columns // 2 - i) % columns]
    holes = {frozenset((at(s, i, k), at(s, i + 1, k), at(s, i + 1, k + 1), at(s, i, k + 1)))
             for s in (1, -1) for i in range(-2, 2) for k in range(low, high)}
    cage.tube(rings, seam=columns // 4)
    cage.faces = [f for f in cage.faces if frozenset(f) not in holes]
    for hard in (2, 5):
        cage.harden(rings[hard])
    cage.cut(rings[2])
    cage.cut(rings[-3])

    #          along, above, front, middle above: shoulder, upper arm, elbow, the rolled cuff and its inner fold
    sleeve = [(0.020, 0.072, 0.074, -0.012), (0.060, 0.068, 0.069, -0.006), (0.110, 0.062, 0.063, -0.002),
              (0.165, 0.058, 0.059, 0.0), (0.215, 0.056, 0.057, 0.0), (0.250, 0.055, 0.056, 0.0),
              (0.275, 0.055, 0.056, 0.0), (0.300, 0.055, 0.056, 0.0), (0.335, 0.053, 0.053, 0.0),
              (0.366, 0.052, 0.052, 0.0), (0.370, 0.060, 0.060, 0.0), (0.392, 0.062, 0.061, 0.0),
              (0.416, 0.059, 0.058, 0.0), (0.412, 0.052, 0.051, 0.0), (0.385, 0.047, 0.046, 0.0)]
    for side in (1, -1):
        hole = ([at(side, -i, high) for i in range(0, 2)] + [at(side, -2, k) for k in range(high, low, -1)]
                + [at(side, i, low) for i in range(-2, 2)] + [at(side, 2, k) for k in range(low, high)]
                + [at(side, 2, high), at(side, 1, high)])
        loops = [hole]
        for t, above, front, middle in sleeve:
            turn = 2 * math.pi / len(hole)
            loops.append(cage.add([(side, 1, 1) * along_arm(t, middle + above * math.cos(k * turn), front * math.sin(k * turn))
                                   for k in range(len(hole))]))
        cage.tube(loops, seam=7)
        cage.cut(hole)
        for hard in (11, 13):
            cage.harden(loops[hard])
        cage.cut(loops[14])
        cage.points = relax(cage, set(loops[1]) | set(hole), 3)

    part = kit.subdivide(cage, 1, CLOTH, TUNIC)
    part.displace(tunic_folds(part.points))
    x, y, z = part.points.T
    t = (np.abs(x) - SHOULDER[0]) * ARM[0] + (z - SHOULDER[2]) * ARM[2]
    above = (np.abs(x) - SHOULDER[0]) * ABOVE[0] + (z - SHOULDER[2]) * ABOVE[2]
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
        points = [0.5 * p + 0.5 * np.mean([points[n] for n in sorted(near[i])], axis=0) if i in near else p
                  for i, p in enumerate(points)]
    return [tuple(p) for p in points]


def tunic_folds(points):
    """Pleats below and above the belt, drag folds from the armpits, rings about the elbows. Metres along the normal."""
    x, y, z = points.T
    side = np.abs(x)
    t = (side - SHOULDER[0]) * ARM[0] + (z - SHOULDER[2]) * ARM[2]
    above = (side - SHOULDER[0]) * ABOVE[0] + (z - SHOULDER[2]) * ABOVE[2]
    arm = ramp(t, 0.0, 0.08) * (side > 0.15) * (np.abs(above) < 0.1)
    body = 1.0 - arm
    angle = np.arctan2(y, x)
    wobble = rough(points, 7.0, 1)
    skirt = body * (1 - ramp(z, 0.93, 1.04)) * ramp(z, 0.842, 0.885)
    pleats = 0.0065 * skirt * np.sin(13 * angle + 2.2 * wobble)
    blouse = 0.0040 * body * bump(z, 1.10, 0.045) * np.sin(17 * angle + 2.5 * wobble)
    drag = 0.0030 * body * bump(z, 1.27, 0.09) * np.sin(95 * (z - 0.75 * side) + 2.0 * wobble)
    creases = np.sin(150 * t + 2.2 * wobble + 14 * y)
    elbow = 0.0042 * arm * bump(t, ELBOW_AT, 0.065) * creases
    upper = 0.0026 * arm * bump(t, 0.12, 0.08) * np.sin(95 * t + 50 * y + 2 * wobble)
    cuff = 1 - ramp(t, 0.35, 0.368) * arm
    return pleats + blouse + drag + (elbow + upper) * cuff + 0.0014 * rough(points, 16.0, 2) * ramp(z, 0.85, 0.88)


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
    levels = [(1.010, 0.145, 0.098, 0.100, 0.003), (0.965, 0.164, 0.106, 0.122, 0.004),
              (0.920, 0.172, 0.110, 0.130, 0.004), (0.880, 0.174, 0.108, 0.129, 0.004)]
    #        z     middle x, half width, front y, back y
    leg = [(0.838, 0.097, 0.086, -0.092, 0.104), (0.795, 0.098, 0.083, -0.088, 0.096),
           (0.730, 0.099, 0.079, -0.085, 0.085), (0.655, 0.100, 0.072, -0.079, 0.074),
           (0.585, 0.100, 0.065, -0.074, 0.065), (0.540, 0.100, 0.062, -0.072, 0.059),
           (0.510, 0.100, 0.060, -0.071, 0.056), (0.480, 0.100, 0.060, -0.068, 0.058),
           (0.445, 0.101, 0.061, -0.062, 0.064), (0.410, 0.101, 0.064, -0.059, 0.072),
           (0.378, 0.102, 0.069, -0.058, 0.077), (0.354, 0.102, 0.062, -0.050, 0.071),
           (0.315, 0.102, 0.052, -0.042, 0.062)]
    cage = Cage()
    waist = [cage.add(oval(*level, columns)) for level in levels]
    cage.tube(waist, seam=columns // 4)
    crotch = cage.add([(0, 0.070, 0.852), (0, 0.006, 0.838), (0, -0.060, 0.850)])
    front = 3 * columns // 4
    for side in (1, -1):
        half = [waist[-1][(front + side * m) % columns] for m in range(columns // 2 + 1)]
        rings = [half + crotch] + [cage.add([(side * x, y, z) for x, y, z in leg_ring(*level)]) for level in leg]
        cage.tube(rings, seam=LEG_COLUMNS - 2)
        cage.cut(rings[0])
    part = kit.subdivide(cage, 1, CLOTH, TROUSERS)
    x, y, z = part.points.T
    wobble = rough(part.points, 8.0, 3)
    behind = ramp(y, -0.03, 0.05)
    knee = 0.0050 * bump(z, 0.495, 0.055) * (0.35 + 0.65 * behind) * np.sin(150 * z + 2.4 * wobble)
    shin = 0.0040 * bump(z, 0.395, 0.035) * np.sin(170 * z + 2.6 * wobble + 10 * x)
    drag = 0.0035 * bump(z, 0.80, 0.07) * np.sin(80 * (z + 0.9 * np.abs(x)) + 2 * wobble)
    part.displace((knee + shin + drag + 0.0016 * rough(part.points, 14.0, 4)) * ramp(z, 0.335, 0.36))
    return part


def boot():
    """The left boot without its sole: a folded top, a shaft, and rings that turn from level to upright at the heel."""
    cage = Cage()
    shaft = [(0.318, 0.104, 0.056, -0.043, 0.068), (0.345, 0.104, 0.062, -0.049, 0.074),
             (0.356, 0.104, 0.066, -0.053, 0.078), (0.350, 0.104, 0.072, -0.058, 0.083),
             (0.318, 0.104, 0.071, -0.057, 0.082), (0.298, 0.104, 0.070, -0.056, 0.080),
             (0.294, 0.104, 0.062, -0.048, 0.073), (0.245, 0.104, 0.058, -0.046, 0.073),
             (0.185, 0.104, 0.049, -0.042, 0.068), (0.140, 0.105, 0.045, -0.044, 0.066)]
    rings = [cage.add(leg_ring(*level)) for level in shaft]
    #        back or bottom (y, z), front or top (y, z), half width
    foot = [((0.074, 0.092), (-0.048, 0.118), 0.043), ((0.080, 0.058), (-0.058, 0.110), 0.043),
            ((0.076, 0.026), (-0.072, 0.102), 0.043), ((0.040, 0.014), (-0.090, 0.093), 0.043),
            ((-0.005, 0.014), (-0.110, 0.084), 0.044), ((-0.048, 0.014), (-0.130, 0.076), 0.047),
            ((-0.085, 0.014), (-0.148, 0.069), 0.050), ((-0.118, 0.014), (-0.165, 0.063), 0.051),
            ((-0.150, 0.014), (-0.182, 0.056), 0.047), ((-0.178, 0.016), (-0.197, 0.045), 0.036),
            ((-0.190, 0.020), (-0.202, 0.036), 0.022)]
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
    part = kit.subdivide(cage, 1, LEATHER, BOOT)
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
    outline = ([(spline(ys, left, y)[0], y) for y in y_out] + [(spline(ys, right, y)[0], y) for y in y_in])
    lean = lambda y: 0.012 * ramp(y, 0.09, -0.20)
    ring = lambda z, scale: [(ANKLE[0] + lean(y) + x * scale, -0.058 + (y + 0.058) * (1 - (1 - scale) * 0.35), z(y))
                             for x, y in outline]
    arch = lambda y: 0.0 + 0.009 * ramp(y, 0.02, -0.005) * ramp(y, -0.085, -0.05) + 0.006 * ramp(y, -0.17, -0.205)
    cage = Cage()
    rings = [cage.add(ring(lambda y: 0.027, 0.86)), cage.add(ring(lambda y: 0.026, 1.0)),
             cage.add(ring(arch, 1.0)), cage.add(ring(arch, 0.6)), cage.add(ring(arch, 0.2))]
    cage.tube(rings, seam=0)
    cage.cap(rings[0])
    cage.cap(rings[-1])
    cage.harden(rings[1])
    cage.harden(rings[2])
    cage.cut(rings[1])
    cage.cut(rings[2])
    return kit.subdivide(cage, 0, LEATHER, SOLE)


def belt():
    """A strap with four hard edges, closed, over the tunic's waist."""
    columns = 32
    cage = Cage()
    levels = [(1.062, 0.154, 0.109, 0.111, 0.003), (1.066, 0.164, 0.119, 0.121, 0.003), (1.053, 0.166, 0.121, 0.123, 0.003),
              (1.028, 0.168, 0.122, 0.125, 0.003), (1.014, 0.168, 0.122, 0.126, 0.003), (1.018, 0.156, 0.110, 0.114, 0.003)]
    rings = [cage.add(oval(*level, columns)) for level in levels]
    cage.tube(rings + [rings[0]], seam=10)
    for ring in (rings[0], rings[1], rings[4], rings[5]):
        cage.harden(ring)
        cage.cut(ring)
    return kit.subdivide(cage, 0, LEATHER, BELT)


def box(cage, centre, half, bevel, lean=0.0):
    """A bevelled block: chamfer faces between hard sides."""
    (cx, cy, cz), (hx, hy, hz) = centre, half
    rings = []
    for y, inset in ((hy, bevel), (hy - bevel, 0.0), (-hy + bevel, 0.0), (-hy, bevel)):
        x0, z0 = hx - inset, hz - inset
        corners = [(x0, z0 - bevel), (x0 - bevel, z0), (bevel - x0, z0), (-x0, z0 - bevel),
                   (-x0, bevel - z0), (bevel - x0, -z0), (x0 - bevel, -z0), (x0, bevel - z0)]
        c, s = math.cos(lean), math.sin(lean)
        rings.append(cage.add([(cx + c * x - s * y, cy + s * x + c * y, cz + z) for x, z in corners]))
    cage.tube(rings, seam=5)
    for ring in (rings[0], rings[-1]):
        cage.cap(ring[1:] + ring[:1])
        cage.cut(ring)
    for ring in rings[1:3]:
        cage.harden(ring)


def buckle():
    """A square frame with a pin, fixed to the hips."""
    cage = Cage()
    y, depth, z = -0.124, 0.006, 1.040
    ring = lambda w, h, at: cage.add([(w, at, z + h), (-w, at, z + h), (-w, at, z - h), (w, at, z - h)])
    rings = [ring(0.032, 0.031, y), ring(0.030, 0.029, y - depth), ring(0.021, 0.020, y - depth), ring(0.019, 0.018, y)]
    cage.tube(rings + [rings[0]], seam=0)
    for r in rings:
        cage.harden(r)
        cage.cut(r)
    box(cage, (0.0, y - depth, z), (0.021, 0.0035, 0.0035), 0.001)
    return kit.subdivide(cage, 0, LEATHER, BUCKLE, joint="hips")


def pouch():
    """A bag on the right hip with a flap, fixed to the hips."""
    cage = Cage()
    place = (-0.148, -0.088, 0.985)
    lean = math.radians(-42)
    box(cage, place, (0.036, 0.020, 0.042), 0.008, lean)
    out = np.array((math.sin(lean), -math.cos(lean), 0))
    box(cage, tuple(np.array(place) + 0.006 * out + (0, 0, 0.022)), (0.039, 0.019, 0.024), 0.005, lean)
    part = kit.subdivide(cage, 1, LEATHER, BELT, joint="hips")
    box_pin = np.linalg.norm(part.points - (np.array(place) + 0.026 * out), axis=1) < 0.012
    part.colours[box_pin] = BUCKLE
    return part


# ---- Skin -----------------------------------------------------------------------------------------------------------


def arm():
    """The left forearm and hand: ten columns to the wrist, then five rows across the palm, four fingers, a thumb."""
    cage = Cage()
    #            along, across, thick: the strip inside the sleeve, then the visible forearm
    forearm = [(0.330, 0.046, 0.046), (0.372, 0.046, 0.045), (0.410, 0.044, 0.041), (0.450, 0.039, 0.035),
               (0.487, 0.033, 0.029), (0.510, 0.031, 0.025)]
    rings = []
    for t, across, thick in forearm:
        angles = [math.radians(a) for a in (30, 60, 90, 120, 150, 210, 240, 270, 300, 330)]
        rings.append(cage.add([along_arm(t, thick * math.sin(a), across * math.cos(a)) for a in angles]))
    #        along, half width at index and pinky side, thickness, arch of the palm
    palm = [(0.528, 0.032, -0.030, 0.0150, 0.0), (0.553, 0.039, -0.035, 0.0160, 0.001), (0.580, 0.043, -0.040, 0.0150, 0.002),
            (0.602, 0.044, -0.042, 0.0135, 0.002)]
    for t, index, pinky, thick, arch in palm:
        across = [index + (pinky - index) * k / 4 for k in range(5)]
        lift = [arch * (1 - ((k - 2) / 2) ** 2) for k in range(5)]
        edge = [0.62, 1.0, 1.0, 1.0, 0.62]
        top = [along_arm(t - 0.004 * abs(k - 1.3), lift[k] + thick * edge[k], across[k]) for k in range(5)]
        bottom = [along_arm(t - 0.004 * abs(k - 1.3), lift[k] - thick * edge[k], across[k]) for k in range(5)]
        rings.append(cage.add(top + bottom[::-1]))
    cage.tube(rings, seam=9)
    thumb_hole = (rings[7][0], rings[8][0], rings[8][9], rings[7][9])
    cage.faces = [f for f in cage.faces if set(f) != set(thumb_hole)]

    ends = rings[-1]
    for k, finger in enumerate(FINGERS):
        base = [ends[k], ends[k + 1], ends[8 - k], ends[9 - k]]
        width = {"index": 0.0092, "middle": 0.0096, "ring": 0.0090, "pinky": 0.0080}[finger]
        extrude_finger(cage, base, finger_path(finger), width, FRONT)
    knuckle = thumb_path()
    extrude_finger(cage, thumb_hole, knuckle, 0.0108, 0.72 * FRONT - 0.35 * ARM - 0.55 * ABOVE, first=0.55)
    cage.cut(rings[6])
    part = kit.subdivide(cage, 1, SKIN, FLESH)
    nails = np.zeros(len(part.points))
    for path in [thumb_path()] + [finger_path(f) for f in FINGERS]:
        tip = path[-1]
        nails = np.maximum(nails, bump(np.linalg.norm(part.points - tip, axis=1), 0, 0.012))
    part.colours = part.colours * (1 - 0.12 * nails[:, None] * (0, 1, 1))
    return part


def extrude_finger(cage, base, path, width, side, first=0.16):
    """Grows a finger from a face: rings along `path` with three loops at each joint. base[0], base[1] are its upper side,
    base[0] towards `side`."""
    lengths = np.cumsum([0.0] + [np.linalg.norm(b - a) for a, b in zip(path, path[1:])])
    total = lengths[-1]
    j1, j2 = lengths[1] / total, lengths[2] / total
    stations = [(first * j1, 1.06), (0.5 * (first + 1) * j1, 0.98), (j1 - 0.07, 1.02), (j1 + 0.02, 1.05), (j1 + 0.09, 0.97),
                (j2 - 0.07, 0.95), (j2 + 0.02, 0.97), (j2 + 0.09, 0.89), (0.965, 0.74), (1.0, 0.42)]
    rings = [list(base)]
    for s, scale in stations:
        at = spline(lengths / total, np.array(path), s)[0]
        tangent = spline(lengths / total, np.array(path), min(s + 0.03, 1.0))[0] - spline(lengths / total, np.array(path), s - 0.03)[0]
        tangent /= np.linalg.norm(tangent)
        across = side - (side @ tangent) * tangent
        across /= np.linalg.norm(across)
        up = np.cross(tangent, across)
        up *= math.copysign(1.0, up @ ABOVE)
        w = width * scale
        rings.append(cage.add([at + w * (across + up), at + w * (up - across), at - w * (across + up), at + w * (across - up)]))
    cage.tube(rings, seam=3)
    cage.cut(rings[1])
    cage.faces.append(tuple(rings[-1]))


def skull(p, smile=0.0):
    """Distance to head and neck, in metres from the middle of the skull; x sideways, y forwards, z up."""
    m = np.column_stack([np.abs(p[:, 0]), p[:, 1], p[:, 2]])  # the face is symmetric
    d = ellipsoid(m, (0, -0.016, 0.036), (0.074, 0.092, 0.084))
    d = blend(d, ellipsoid(m, (0, 0.030, -0.018), (0.062, 0.060, 0.080)), 0.03)
    d = blend(d, ellipsoid(m, (0, 0.032, -0.074), (0.049, 0.050, 0.036)), 0.03)
    d = blend(d, capsule(m, (0.056, -0.012, -0.050), (0.018, 0.066, -0.098), 0.014, 0.014), 0.022)  # jaw
    d = blend(d, ellipsoid(m, (0, 0.074, -0.099), (0.020, 0.015, 0.015)), 0.018)  # chin
    d = blend(d, ellipsoid(m, (0.045 + 0.003 * smile, 0.054, -0.032 + 0.009 * smile), (0.020, 0.020, 0.018)), 0.02)  # cheek
    d = carve(d, ellipsoid(m, (0.035, 0.098, 0.001), (0.021, 0.020, 0.014)), 0.014)  # eye socket
    d = blend(d, capsule(m, (0.011, 0.083, 0.018), (0.050, 0.066, 0.020), 0.008, 0.006), 0.012)  # brow
    nose = capsule(m, (0, 0.083, 0.012), (0, 0.106, -0.028), 0.0070, 0.0098)
    nose = blend(nose, ellipsoid(m, (0.0115, 0.096, -0.034), (0.008, 0.011, 0.008)), 0.007)
    d = blend(d, nose, 0.008)
    d = carve(d, ellipsoid(m, (0.006, 0.1005, -0.0435), (0.0035, 0.005, 0.004)), 0.003)  # nostril
    eye = np.array([EYE[0], -(EYE[1] - HEAD[1]), 0.0])
    lids = np.linalg.norm(m - eye, axis=1) - (EYE_RADIUS + 0.0022)
    u = np.clip((m[:, 0] - eye[0]) / 0.0165, -1.0, 1.0)
    upper, lower = 0.0068 * (1 - u * u) + 0.001 * u, -0.0052 * (1 - u * u) + 0.001 * u
    gap = np.maximum(m[:, 2] - upper, lower - m[:, 2])
    d = np.minimum(d, 1.0)
    d = blend(d, lids, 0.005)
    d = carve(d, np.maximum(gap, np.linalg.norm(m - eye - (0, 0.026, 0), axis=1) - 0.017), 0.002)
    lips, slit = mouth(m, smile)
    d = blend(d, lips, 0.006)
    d = carve(d, slit, 0.004)
    ear = ellipsoid(turned(m, (0.072, -0.016, -0.004), 30), (0, 0, 0), (0.0085, 0.022, 0.033))
    ear = carve(ear, ellipsoid(turned(m, (0.079, -0.012, 0.001), 30), (0, 0, 0), (0.006, 0.013, 0.021)), 0.006)
    d = blend(d, ear, 0.007)
    neck = capsule(m, (0, -0.022, -0.060), (0, -0.034, -0.20), 0.050, 0.056)
    cords = capsule(m, (0.052, -0.020, -0.050), (0.010, 0.016, -0.185), 0.010, 0.010)
    return blend(blend(d, cords, 0.02), neck, 0.022)


def mouth(m, smile):
    """Distances to the lips and to the slit between them."""
    corner = np.array([0.025 + 0.007 * smile, 0.073 + 0.0005 * smile, -0.066 + 0.0085 * smile])
    middle = np.array([0.0, 0.0860 - 0.002 * smile, -0.0655 - 0.0015 * smile])
    upper = capsule(m, middle + (0.004, -0.001, 0.0045), corner + (-0.003, 0, 0.001), 0.0052, 0.0028)
    lower = capsule(m, middle + (0, -0.002, -0.0064), corner + (-0.007, 0.001, -0.0025), 0.0064, 0.0034)
    return np.minimum(upper, lower), capsule(m, middle + (0, 0.006, 0), corner + (0.001, 0.004, 0), 0.0018, 0.0020)


def turned(p, centre, degrees):
    """Points in the axes of something at `centre` turned about the vertical."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    q = p - np.array(centre)
    return np.column_stack([c * q[:, 0] + s * q[:, 1], -s * q[:, 0] + c * q[:, 1], q[:, 2]])


def spaced(count, low, high, density):
    """`count` values from low to high, as close as density(value) says."""
    fine = np.linspace(low, high, 2001)
    share = np.concatenate([[0], np.cumsum(0.5 * (density(fine[1:]) + density(fine[:-1])))])
    return np.interp(np.linspace(0, share[-1], count), share, fine)


def to_world(p):
    return p * (1, -1, 1) + HEAD


HEAD_COLUMNS = 54
# Half the circle from the front to the back of the head, closer at the eyes and the mouth.
BEARINGS = spaced(HEAD_COLUMNS // 2 + 1, 0.0, 180.0, lambda a: 0.35 + 1.15 * (1 - ramp(a, 38, 75)) + 1.1 * bump(a, 100, 14))
BEARINGS = np.radians(np.concatenate([BEARINGS, -BEARINGS[-2:0:-1]]))


def rays(elevations, drop):
    """A ring of rays for each elevation; `drop` lowers their starts, for the neck."""
    a, e = BEARINGS[None, :], np.radians(elevations)[:, None]
    directions = np.stack([np.cos(e) * np.sin(a), np.cos(e) * np.cos(a), np.sin(e) + 0 * a], axis=2)
    origins = np.zeros_like(directions)
    origins[:, :, 2] = np.asarray(drop)[:, None]
    origins[:, :, 1] = 0.15 * np.asarray(drop)[:, None]
    return origins.reshape(-1, 3), directions.reshape(-1, 3)


def head():
    """Head and neck, with the morph target `smile`: the same rays cast on the same face with other lips and cheeks."""
    face = spaced(33, 56.0, -58.0, lambda e: 0.45 + 1.0 * bump(e, 0, 9) + 0.95 * bump(e, -22, 5) + 1.2 * bump(e, -37, 9))
    elevations = np.concatenate([[78.0], face, [-56, -48, -36, -22, -8, 0]])
    drop = np.concatenate([np.zeros(34), [-0.012, -0.035, -0.062, -0.092, -0.122, -0.155]])
    origins, directions = rays(elevations, drop)
    cage = Cage()
    surfaces = [to_world(kit.cast(lambda p, s=s: skull(p, s), origins, directions, 0.2)) for s in (0.0, 1.0)]
    rings = [cage.add(ring) for ring in surfaces[0].reshape(len(elevations), HEAD_COLUMNS, 3)]
    cage.tube(rings, seam=HEAD_COLUMNS // 2)
    crown = to_world(kit.cast(skull, np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), 0.2))
    cage.fan(rings[0], crown[0])
    cage.cut(rings[4])
    part = kit.subdivide(cage, 0, SKIN, FLESH)
    part.shape = np.concatenate([surfaces[1], crown])
    x, y, z = ((part.points - HEAD) * (1, -1, 1)).T
    lips = 0.85 * ramp(mouth(np.column_stack([np.abs(x), y, z]), 0.0)[0], 0.0035, 0.0)[:, None]
    blush = (0.25 * bump(np.abs(x), 0.047, 0.02) * bump(z, -0.034, 0.02) * (y > 0.03))[:, None]
    part.colours = part.colours * (1 - blush * (0.1, 0.5, 0.5)) * (1 - lips) + np.array(LIP) * lips
    return part


def eyes():
    """The left eyeball, fixed to its joint: a ball whose rings are closer at the iris."""
    count = 14
    cage = Cage()
    polar = np.radians([7, 14, 22, 30, 40, 58, 80, 110, 145])
    ring = lambda a: [EYE + EYE_RADIUS * np.array([math.sin(a) * math.cos(k), -math.cos(a), math.sin(a) * math.sin(k)])
                      for k in 2 * math.pi * np.arange(count) / count]
    rings = [cage.add(ring(a)) for a in polar]
    cage.tube(rings)
    cage.fan(rings[0], EYE + EYE_RADIUS * FRONT)
    cage.fan(rings[-1], EYE - EYE_RADIUS * FRONT)
    cage.cut(rings[5])
    part = kit.subdivide(cage, 0, SKIN, EYE_WHITE, joint="eye.L")
    angle = np.degrees(np.arccos(np.clip((part.points - EYE) @ FRONT / EYE_RADIUS, -1, 1)))
    part.colours[angle < 31] = IRIS
    part.colours[angle < 15] = PUPIL
    return part


def hair():
    """A cap of combed locks over the skull, its rim turned in; the same rays as the head's."""
    bearing = np.degrees(np.abs(BEARINGS))
    rim = spline([0, 18, 40, 60, 72, 80, 92, 106, 118, 128, 150, 180], [39, 37, 31, 27, 2, 4, 25, 27, 10, -26, -38, -40], bearing)
    rows = 12
    cage = Cage()
    rings = []
    origins, directions = [], []
    for k in range(1, rows + 2):
        e = np.radians(90 - (90 - rim) * min(k, rows) / rows)
        directions.append(np.column_stack([np.cos(e) * np.sin(BEARINGS), np.cos(e) * np.cos(BEARINGS), np.sin(e)]))
    directions = np.concatenate(directions)
    scalp = kit.cast(bald, np.zeros_like(directions), directions, 0.2)
    k = np.repeat(np.arange(1, rows + 2), HEAD_COLUMNS)
    comb = np.tile(BEARINGS, rows + 1)
    locks = np.sin(15 * comb + 3.0 * rough(scalp, 9.0, 7) + 0.25 * k)
    lift = 0.013 + 0.010 * bump(scalp[:, 2], 0.10, 0.05) + 0.0038 * locks * ramp(k, 1, 4) + 0.002 * rough(scalp, 25.0, 8)
    lift = lift + 0.012 * bump(k / rows, 0.86, 0.16) * (np.cos(comb) > 0.55)  # a quiff
    lift = lift * np.where(k == rows, 0.80, 1.0)
    lift[k == rows + 1] = -0.003
    points = to_world(scalp + directions * lift[:, None])
    rings = [cage.add(ring) for ring in points.reshape(rows + 1, HEAD_COLUMNS, 3)]
    cage.tube(rings, seam=HEAD_COLUMNS // 2)
    cage.fan(rings[0], to_world(np.array([[0.0, 0.0, bald_height() + 0.020]]))[0])
    cage.harden(rings[-2])
    cage.cut(rings[-2])
    part = kit.subdivide(cage, 0, LEATHER, HAIR)
    part.colours = part.colours * (1 + 0.35 * np.concatenate([locks, [0.0]])[:, None])
    return part


def bald(p):
    """The skull without ears and features, under the hair."""
    d = ellipsoid(p, (0, -0.016, 0.036), (0.074, 0.092, 0.084))
    d = blend(d, ellipsoid(p, (0, 0.030, -0.018), (0.062, 0.060, 0.080)), 0.03)
    return blend(d, capsule(p, (0, -0.022, -0.060), (0, -0.034, -0.20), 0.050, 0.056), 0.022)


def bald_height():
    return kit.cast(bald, np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), 0.2)[0, 2]


def eyebrows():
    """The left brow: a tapering tube pressed on the face."""
    cage = Cage()
    steps = np.linspace(0, 1, 9)
    bearing, elevation = np.radians(9 + 33 * steps), np.radians(13 + 5 * steps - 7 * steps**3)
    directions = np.column_stack([np.cos(elevation) * np.sin(bearing), np.cos(elevation) * np.cos(bearing), np.sin(elevation)])
    path = kit.cast(skull, np.zeros_like(directions), directions, 0.2)
    half = 0.0050 * (0.75 + 0.6 * steps - 1.05 * steps**2)
    rings = []
    for p, d, w in zip(path, directions, half):
        ring = [(0, 0.5), (0.55, 0.35), (0.3, -0.4), (-0.3, -0.4), (-0.55, 0.35)]
        ring = [p + d * (0.0012 + 0.0042 * v) + np.array([0, 0, 1]) * (2.0 * w * u) for u, v in ring]
        rings.append(cage.add(to_world(np.array(ring))))
    cage.tube(rings, seam=2)
    for ring in (rings[0], rings[-1]):
        cage.faces.append(tuple(ring))
        cage.cut(ring)
    return kit.subdivide(cage, 0, LEATHER, HAIR)


# ---- Clips ----------------------------------------------------------------------------------------------------------


def grounded(pose):
    """Lifts or lowers a pose until its lowest sole is on the floor."""
    soles = []
    for tag in (".L", ".R"):
        heel = pose.tip("foot" + tag, end=False) + pose.world("foot" + tag) @ kit.Vector((0, 0.06, -0.095))
        ball = pose.tip("toe" + tag, end=False) + pose.world("foot" + tag) @ kit.Vector((0, 0, -0.035))
        toe = pose.tip("toe" + tag) + pose.world("toe" + tag) @ kit.Vector((0, 0, -0.030))
        soles += [heel.z, ball.z, toe.z]
    pose.shift.z -= min(soles)
    return pose


def legs(pose, tag, thigh, shin, out=0.0, foot=None):
    """Thigh and shin by their angles from straight down, forwards positive; the foot stays level unless told."""
    side = 1 if tag == ".L" else -1
    down = lambda a: (side * math.sin(math.radians(out)), -math.sin(math.radians(a)), -math.cos(math.radians(a)))
    pose.aim("thigh" + tag, down(thigh)).aim("shin" + tag, down(shin))
    pitch = math.radians(0 if foot is None else foot)
    rest = BALL - ANKLE
    c, s = math.cos(pitch), math.sin(pitch)
    pose.aim("foot" + tag, (side * rest[0], c * rest[1] - s * rest[2] * 0, rest[2] + s * abs(rest[1])))
    return pose


def fist(pose, tag, amount):
    """Curls fingers and thumb; 1 is a fist."""
    side = 1 if tag == ".L" else -1
    axis = kit.Vector(FRONT)
    for finger in FINGERS:
        for i, most in ((1, 70), (2, 95), (3, 55)):
            pose.turns[f"{finger}{i}{tag}"] = kit.Quaternion(axis, -side * math.radians(most * amount))
    fold = kit.Vector((side * ABOVE[0], 0, ABOVE[2]))
    for i, most in ((1, 25), (2, 40), (3, 45)):
        pose.turns[f"thumb{i}{tag}"] = kit.Quaternion(fold, side * math.radians(most * amount))
    return pose


def arms(pose, tag, upper, fore, hand=None, curl=0.25):
    """Aims upper arm, forearm and hand; directions as for the left arm: outwards, forwards, up."""
    side = 1 if tag == ".L" else -1
    to = lambda d: (side * d[0], -d[1], d[2])
    lift = max(0.0, upper[2] / np.linalg.norm(upper))
    pose.turn("clavicle" + tag, y=-side * 28 * lift, z=side * -12 * upper[1] / np.linalg.norm(upper))
    pose.aim("upper_arm" + tag, to(upper)).aim("forearm" + tag, to(fore)).aim("hand" + tag, to(hand or fore))
    return fist(pose, tag, curl)


def make_clips(rig, bones):
    new = lambda start=None: Pose(bones, start)

    def stand():
        pose = new()
        for tag in (".L", ".R"):
            legs(pose, tag, 2, -2, out=2)
            arms(pose, tag, (0.28, 0.0, -1), (0.2, 0.18, -1))
        return pose

    def clip(name, seconds, keys):
        kit.make_clip(rig, bones, name, seconds, lambda t: grounded(kit.between(keys, t)))

    def stride(front, back, thigh_f, shin_f, foot_f, thigh_b, shin_b, foot_b, twist):
        pose = new().turn("hips", x=4, z=-7 * twist).turn("spine2", z=9 * twist).turn("chest", z=9 * twist).turn("head", z=-8 * twist)
        legs(pose, front, thigh_f, shin_f, out=1, foot=foot_f)
        legs(pose, back, thigh_b, shin_b, out=1, foot=foot_b)
        swing = 0.75 * abs(twist)
        arms(pose, back, (0.25, swing, -1), (0.05, swing + 0.75, -0.75), curl=0.45)
        arms(pose, front, (0.3, -swing, -1), (0.2, 0.25 - 0.4 * swing, -1), curl=0.45)
        return pose

    walk = []
    for half, (front, back, sign) in enumerate(((".L", ".R", 1), (".R", ".L", -1))):
        at = 0.5 * half
        walk += [(at, stride(front, back, 30, 22, 16, -20, -38, -32, sign)),
                 (at + 0.12, stride(front, back, 24, 2, 0, -10, -72, -55, 0.5 * sign)),
                 (at + 0.30, stride(front, back, 2, -4, 0, 28, -52, -12, -0.3 * sign))]
    walk.append((1.0, walk[0][1]))
    clip("walk", 1.0, walk)

    low = new().turn("hips", x=22).turn("spine1", x=16).turn("spine2", x=16).turn("chest", x=10).turn("neck", x=-22).turn("head", x=-18)
    for tag in (".L", ".R"):
        legs(low, tag, 98, -48, out=22, foot=-4)
        arms(low, tag, (0.45, 0.75, -0.7), (-0.25, 0.7, 0.75), curl=0.6)
    clip("crouch", 1.8, [(0.0, stand()), (0.75, low), (1.05, low), (1.8, stand())])

    reach = new().turn("hips", y=-3).turn("spine1", x=-6, y=-6).turn("spine2", x=-8, y=-8).turn("chest", x=-8, y=-6).turn("neck", x=-14).turn("head", x=-14)
    legs(reach, ".L", 2, -3, out=3, foot=-30)
    legs(reach, ".R", 2, -3, out=3, foot=-30)
    arms(reach, ".L", (0.05, 0.12, 1), (-0.08, 0.15, 1), curl=0.0)
    arms(reach, ".R", (0.6, 0.05, -1), (0.45, 0.3, -0.9), curl=0.3)
    wave = [new(reach) for _ in range(2)]
    for pose, lean in zip(wave, (0.95, -0.55)):
        pose.aim("upper_arm.L", (0.55, -0.1, 0.7)).aim("forearm.L", (lean, -0.1, 0.9)).aim("hand.L", (1.5 * lean, -0.1, 0.8))
    clip("reach_and_wave", 2.4, [(0.0, stand()), (0.6, reach), (0.8, reach), (1.1, wave[0]), (1.35, wave[1]),
                                 (1.6, wave[0]), (1.85, wave[1]), (2.4, stand())])

    turned_out = new().turn("hips", z=18).turn("spine1", z=20).turn("spine2", z=22).turn("chest", z=22).turn("neck", z=14).turn("head", z=14)
    legs(turned_out, ".L", 4, -8, out=9)
    legs(turned_out, ".R", 10, -12, out=9)
    for tag, forwards in ((".L", -0.7), (".R", 0.7)):
        arms(turned_out, tag, (1, forwards, 0.1), (0.5 if forwards > 0 else 0.9, forwards + 0.5, 0.25))
    bow = new().turn("hips", x=38).turn("spine1", x=26).turn("spine2", x=26).turn("chest", x=22, z=-18).turn("neck", x=12).turn("head", x=12)
    for tag in (".L", ".R"):
        legs(bow, tag, 6, -4, out=4)
        bow.move(y=0.09)
    arms(bow, ".L", (0.15, 0.55, -0.9), (-0.3, 0.1, -1))
    arms(bow, ".R", (0.8, -0.6, 0.35), (0.75, -0.75, 0.6), curl=0.1)
    clip("twist_and_bow", 2.4, [(0.0, stand()), (0.6, turned_out), (0.85, turned_out), (1.55, bow), (1.8, bow), (2.4, stand())])

    chamber = new().turn("hips", x=-6).turn("spine1", x=8).turn("spine2", x=6)
    legs(chamber, ".R", 12, -18, out=3)
    legs(chamber, ".L", 108, -30, out=4, foot=-50)
    kick = new().turn("hips", x=-20, y=4).turn("spine1", x=10).turn("spine2", x=6).turn("neck", x=8)
    legs(kick, ".R", 4, -6, out=3)
    legs(kick, ".L", 92, 84, out=6, foot=62)
    for pose, high in ((chamber, 0.55), (kick, 0.2)):
        arms(pose, ".L", (0.55, -0.25, -0.8), (0.1, 0.9, 0.35), curl=1.0)
        arms(pose, ".R", (0.6, 0.3, -0.7), (-0.45, 0.75, high), curl=1.0)
    clip("kick", 1.4, [(0.0, stand()), (0.4, chamber), (0.58, kick), (0.72, kick), (0.92, chamber), (1.4, stand())])


def follow_thighs(rig, part, floor):
    """The skirt, and the trousers beneath it down to `floor`, go with the thighs, the more the lower."""
    names = [b.name for b in rig.data.bones]
    x, _, z = part.points.T
    share, left = 0.92 * ramp(z, 0.985, 0.845), ramp(x, -0.09, 0.09)
    skirt = np.zeros_like(part.weights)
    skirt[:, names.index("hips")] = 1 - share
    skirt[:, names.index("thigh.L")] = share * left
    skirt[:, names.index("thigh.R")] = share * (1 - left)
    mask = ramp(z, 1.02, 0.95)
    if floor:
        mask = mask * ramp(z, floor - 0.04, floor + 0.03)
    return mask[:, None] * skirt + (1 - mask[:, None]) * part.weights


def weigh(rig, parts, hands):
    """Smooth weights: from the hull of all layers, but for hands from their own surface, for fingers melt in the hull."""
    stiff = ("root", "eye.L", "eye.R")
    soft = [p for p in parts if p.joint is None]
    hull = kit.heat_weights(rig, soft, stiff, voxel=0.008)
    for part in soft:
        part.weights = kit.carry_weights(hull, part.points)
    for part, floor in ((parts[0], None), (parts[1], 0.84)):
        part.weights = follow_thighs(rig, part, floor)
    for part in hands:
        own = kit.carry_weights(kit.heat_weights(rig, [part], stiff), part.points)
        along = (np.abs(part.points[:, 0]) - SHOULDER[0]) * ARM[0] + (part.points[:, 2] - SHOULDER[2]) * ARM[2]
        share = ramp(along, 0.41, 0.47)[:, None]
        part.weights = share * own + (1 - share) * part.weights


def main():
    kit.empty_scene()
    bones = skeleton()
    rig = bones.build("humanoid")
    left = [arm(), boot(), sole()]
    body = [tunic(), trousers(), belt(), buckle(), pouch()] + left + [p.mirrored() for p in left]
    face = [head(), hair()] + [q for p in (eyes(), eyebrows()) for q in (p, p.mirrored())]

    weigh(rig, body + face, hands=[p for p in (left[0], body[-3])])
    colour_factors = kit.factors(body + face, LOOKS)
    materials = kit.make_materials(LOOKS, colour_factors)
    kit.join("body", rig, body, materials, colour_factors)
    kit.join("face", rig, face, materials, colour_factors, morph="smile")
    make_clips(rig, bones)
    kit.export(kit.output_path("humanoid.glb"))


main()
