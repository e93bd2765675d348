# SPDX-License-Identifier: MIT
"""The humanoid's forearms and hands, head, eyes and hair."""

import math

import numpy as np
from humanoid_measures import (
    ABOVE,
    ARM,
    EYE,
    EYE_RADIUS,
    EYE_WHITE,
    FINGERS,
    FLESH,
    FRONT,
    HAIR,
    HEAD,
    IRIS,
    LEATHER,
    LIP,
    PUPIL,
    SKIN,
    along_arm,
    finger_path,
    thumb_path,
)
from surface import Cage, blend, bump, capsule, carve, cast, ellipsoid, ramp, rough, spline, subdivide


def arm():
    """The left forearm and hand: ten columns to the wrist, five across the palm, four fingers, a thumb."""
    cage = Cage()
    #            along, across, thick: the strip inside the sleeve, then the visible forearm
    forearm = [
        (0.330, 0.046, 0.046),
        (0.372, 0.046, 0.045),
        (0.410, 0.044, 0.041),
        (0.450, 0.039, 0.035),
        (0.487, 0.033, 0.029),
        (0.510, 0.031, 0.025),
    ]
    rings = []
    for t, across, thick in forearm:
        angles = [math.radians(a) for a in (30, 60, 90, 120, 150, 210, 240, 270, 300, 330)]
        rings.append(cage.add([along_arm(t, thick * math.sin(a), across * math.cos(a)) for a in angles]))
    #        along, half width at index and pinky side, thickness, arch of the palm
    palm = [
        (0.528, 0.032, -0.030, 0.0150, 0.0),
        (0.553, 0.039, -0.035, 0.0160, 0.001),
        (0.580, 0.043, -0.040, 0.0150, 0.002),
        (0.602, 0.044, -0.042, 0.0135, 0.002),
    ]
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
    part = subdivide(cage, 1, SKIN, FLESH)
    nails = np.zeros(len(part.points))
    for path in [thumb_path()] + [finger_path(f) for f in FINGERS]:
        tip = path[-1]
        nails = np.maximum(nails, bump(np.linalg.norm(part.points - tip, axis=1), 0, 0.012))
    part.colours = part.colours * (1 - 0.12 * nails[:, None] * (0, 1, 1))
    return part


def extrude_finger(cage, base, path, width, side, first=0.16):
    """Grows a finger from a face: rings along `path` with three loops at each joint.

    base[0] and base[1] are its upper side, base[0] towards `side`.
    """
    lengths = np.cumsum([0.0] + [np.linalg.norm(b - a) for a, b in zip(path, path[1:])])
    total = lengths[-1]
    j1, j2 = lengths[1] / total, lengths[2] / total
    stations = [
        (first * j1, 1.06),
        (0.5 * (first + 1) * j1, 0.98),
        (j1 - 0.07, 1.02),
        (j1 + 0.02, 1.05),
        (j1 + 0.09, 0.97),
        (j2 - 0.07, 0.95),
        (j2 + 0.02, 0.97),
        (j2 + 0.09, 0.89),
        (0.965, 0.74),
        (1.0, 0.42),
    ]
    rings = [list(base)]
    for s, scale in stations:
        at = spline(lengths / total, np.array(path), s)[0]
        tangent = (
            spline(lengths / total, np.array(path), min(s + 0.03, 1.0))[0]
            - spline(lengths / total, np.array(path), s - 0.03)[0]
        )
        tangent /= np.linalg.norm(tangent)
        across = side - (side @ tangent) * tangent
        across /= np.linalg.norm(across)
        up = np.cross(tangent, across)
        up *= math.copysign(1.0, up @ ABOVE)
        w = width * scale
        rings.append(
            cage.add(
                [
                    at + w * (across + up),
                    at + w * (up - across),
                    at - w * (across + up),
                    at + w * (across - up),
                ]
            )
        )
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
    d = blend(
        d, ellipsoid(m, (0.045 + 0.003 * smile, 0.054, -0.032 + 0.009 * smile), (0.020, 0.020, 0.018)), 0.02
    )  # cheek
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
    ear = carve(
        ear, ellipsoid(turned(m, (0.079, -0.012, 0.001), 30), (0, 0, 0), (0.006, 0.013, 0.021)), 0.006
    )
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
    return np.minimum(upper, lower), capsule(
        m, middle + (0, 0.006, 0), corner + (0.001, 0.004, 0), 0.0018, 0.0020
    )


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


HEAD_COLUMNS = 52
# Half the circle from the front to the back of the head, closer at the eyes and the mouth.
BEARINGS = spaced(
    HEAD_COLUMNS // 2 + 1, 0.0, 180.0, lambda a: 0.35 + 1.15 * (1 - ramp(a, 38, 75)) + 1.1 * bump(a, 100, 14)
)
BEARINGS = np.radians(np.concatenate([BEARINGS, -BEARINGS[-2:0:-1]]))


def rays(elevations, drop):
    """A ring of rays for each elevation; `drop` lowers their starts, for the neck."""
    a, e = BEARINGS[None, :], np.radians(elevations)[:, None]
    directions = np.stack([np.cos(e) * np.sin(a), np.cos(e) * np.cos(a), np.sin(e) + 0.0 * a], axis=2)
    origins = np.zeros_like(directions)
    origins[:, :, 2] = np.asarray(drop)[:, None]
    origins[:, :, 1] = 0.15 * np.asarray(drop)[:, None]
    return origins.reshape(-1, 3), directions.reshape(-1, 3)


def head():
    """Head and neck; the morph target `smile` is the same rays cast on a face with other lips and cheeks."""
    face = spaced(
        33, 56.0, -58.0, lambda e: 0.45 + 1.0 * bump(e, 0, 9) + 0.95 * bump(e, -22, 5) + 1.2 * bump(e, -37, 9)
    )
    elevations = np.concatenate([[78.0], face, [-56, -48, -36, -22, -8, 0]])
    drop = np.concatenate([np.zeros(34), [-0.012, -0.035, -0.062, -0.092, -0.122, -0.155]])
    origins, directions = rays(elevations, drop)
    cage = Cage()
    surfaces = [to_world(cast(lambda p, s=s: skull(p, s), origins, directions, 0.2)) for s in (0.0, 1.0)]
    rings = [cage.add(ring) for ring in surfaces[0].reshape(len(elevations), HEAD_COLUMNS, 3)]
    cage.tube(rings, seam=HEAD_COLUMNS // 2)
    crown = to_world(cast(skull, np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), 0.2))
    cage.fan(rings[0], crown[0])
    cage.cut(rings[4])
    part = subdivide(cage, 0, SKIN, FLESH)
    part.shape = np.concatenate([surfaces[1], crown])
    x, y, z = ((part.points - HEAD) * (1, -1, 1)).T
    lips = 0.85 * ramp(mouth(np.column_stack([np.abs(x), y, z]), 0.0)[0], 0.0035, 0.0)[:, None]
    blush = (0.25 * bump(np.abs(x), 0.047, 0.02) * bump(z, -0.034, 0.02) * (y > 0.03))[:, None]
    part.colours = part.colours * (1 - blush * (0.1, 0.5, 0.5)) * (1 - lips) + np.array(LIP) * lips
    return part


def eye():
    """The left eyeball, fixed to its joint: a ball whose rings are closer at the iris."""
    count = 14
    cage = Cage()
    polar = np.radians([7, 14, 22, 30, 40, 58, 80, 110, 145])
    ring = lambda a: [
        EYE + EYE_RADIUS * np.array([math.sin(a) * math.cos(k), -math.cos(a), math.sin(a) * math.sin(k)])
        for k in 2 * math.pi * np.arange(count) / count
    ]
    rings = [cage.add(ring(a)) for a in polar]
    cage.tube(rings)
    cage.fan(rings[0], EYE + EYE_RADIUS * FRONT)
    cage.fan(rings[-1], EYE - EYE_RADIUS * FRONT)
    cage.cut(rings[5])
    part = subdivide(cage, 0, SKIN, EYE_WHITE, joint="eye.L")
    angle = np.degrees(np.arccos(np.clip((part.points - EYE) @ FRONT / EYE_RADIUS, -1, 1)))
    part.colours[angle < 31] = IRIS
    part.colours[angle < 15] = PUPIL
    return part


def hair():
    """A cap of combed locks over the skull, its rim turned in; the same rays as the head's."""
    bearing = np.degrees(np.abs(BEARINGS))
    rim = spline(
        [0, 18, 40, 60, 72, 80, 92, 106, 118, 128, 150, 180],
        [39, 37, 31, 27, 2, 4, 25, 27, 10, -26, -38, -40],
        bearing,
    )
    rows = 12
    cage = Cage()
    directions = []
    for k in range(1, rows + 2):
        e = np.radians(90 - (90 - rim) * min(k, rows) / rows)
        directions.append(
            np.column_stack([np.cos(e) * np.sin(BEARINGS), np.cos(e) * np.cos(BEARINGS), np.sin(e)])
        )
    directions = np.concatenate(directions)
    scalp = cast(bald, np.zeros_like(directions), directions, 0.2)
    k = np.repeat(np.arange(1, rows + 2), HEAD_COLUMNS)
    comb = np.tile(BEARINGS, rows + 1)
    locks = np.sin(15 * comb + 3.0 * rough(scalp, 9.0, 7) + 0.25 * k)
    lift = (
        0.013
        + 0.010 * bump(scalp[:, 2], 0.10, 0.05)
        + 0.0038 * locks * ramp(k, 1, 4)
        + 0.002 * rough(scalp, 25.0, 8)
    )
    lift = lift + 0.012 * bump(k / rows, 0.86, 0.16) * (np.cos(comb) > 0.55)  # a quiff
    lift = lift * np.where(k == rows, 0.80, 1.0)
    lift[k == rows + 1] = -0.003
    points = to_world(scalp + directions * lift[:, None])
    rings = [cage.add(ring) for ring in points.reshape(rows + 1, HEAD_COLUMNS, 3)]
    cage.tube(rings, seam=HEAD_COLUMNS // 2)
    cage.fan(rings[0], to_world(np.array([[0.0, 0.0, bald_height() + 0.020]]))[0])
    cage.harden(rings[-2])
    cage.cut(rings[-2])
    part = subdivide(cage, 0, LEATHER, HAIR)
    part.colours = part.colours * (1 + 0.35 * np.concatenate([locks, [0.0]])[:, None])
    return part


def bald(p):
    """The skull without ears and features, under the hair."""
    d = ellipsoid(p, (0, -0.016, 0.036), (0.074, 0.092, 0.084))
    d = blend(d, ellipsoid(p, (0, 0.030, -0.018), (0.062, 0.060, 0.080)), 0.03)
    return blend(d, capsule(p, (0, -0.022, -0.060), (0, -0.034, -0.20), 0.050, 0.056), 0.022)


def bald_height():
    return cast(bald, np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), 0.2)[0, 2]


def eyebrow():
    """The left brow: a tapering tube pressed on the face."""
    cage = Cage()
    steps = np.linspace(0, 1, 9)
    bearing, elevation = np.radians(9 + 33 * steps), np.radians(13 + 5 * steps - 7 * steps**3)
    directions = np.column_stack(
        [np.cos(elevation) * np.sin(bearing), np.cos(elevation) * np.cos(bearing), np.sin(elevation)]
    )
    path = cast(skull, np.zeros_like(directions), directions, 0.2)
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
    return subdivide(cage, 0, LEATHER, HAIR)
