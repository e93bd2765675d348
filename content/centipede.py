# SPDX-License-Identifier: MIT
"""Makes centipede.glb, a long-bodied many-legged creature like Figure 1 of Landreneau & Schaefer 2009.

18,464 triangles, 124 joints (16 body segments, 32 legs of three, antennae, fangs), at most four influences,
two materials, one UV set, vertex colours, hard rims on the plates; 1.2 m from antennae to tail legs. The
body, its legs, antennae and fangs are one closed surface. Four clips at 20 frames a second: crawl 1.2 s,
curl 2.4 s, rear_up 2.4 s, twist 2.2 s. On one thread (-t 1) the same Blender gives the same bytes each
time.

    blender -t 1 -b --factory-startup --python content/centipede.py -- content/centipede.glb
"""

import math
import os
import sys

import numpy as np

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from rig import (
    Pose,
    Skeleton,
    carry_weights,
    empty_scene,
    export,
    factors,
    heat_weights,
    join,
    make_clip,
    make_materials,
    output_path,
)
from surface import Cage, bump, ramp, rough, spline, subdivide

CHITIN, EYE = "chitin", "eye"
LOOKS = {CHITIN: (0.0, 0.35, False), EYE: (0.0, 0.15, False)}
PLATE, MEMBRANE, LEG, CLAW = (0.13, 0.018, 0.010), (0.42, 0.24, 0.11), (0.62, 0.26, 0.05), (0.05, 0.015, 0.01)

SEGMENTS = 16
LENGTH = 0.052  # of one segment
COLUMNS = 12
HEIGHT = 0.050  # of the body's axis above the floor
MIDDLE = SEGMENTS // 2  # segments before this one hang from it forwards, those after it backwards
LEG_JOINTS = ("coxa", "femur", "tibia")
LOW_SIDE = 10  # the column between the side and the belly, where legs grow


def front_of(segment):
    """Where a segment starts along Y; the head is before segment 0."""
    return (segment - SEGMENTS / 2) * LENGTH


def half_width(y):
    """The body's half width: slim behind the head, widest in its second quarter, slim at the tail."""
    at = (y - front_of(0)) / (SEGMENTS * LENGTH)
    return spline(
        [0.0, 0.08, 0.3, 0.6, 0.85, 1.0, 1.06], [0.028, 0.033, 0.040, 0.039, 0.033, 0.024, 0.013], at
    )[0]


def ring(y, width, swell=1.0, drop=0.0):
    """Twelve points about the axis, an arched back, a flat belly; the first is left, above the middle."""
    points = []
    for j in range(COLUMNS):
        a = 2 * math.pi * (j + 0.5) / COLUMNS
        c, s = math.cos(a), math.sin(a)
        z = (0.52 if s > 0 else 0.40) * math.copysign(abs(s) ** 0.85, s)
        points.append((width * swell * math.copysign(abs(c) ** 0.7, c), y, HEIGHT - drop + width * swell * z))
    return points


def leg_path(segment):
    """Hip, two knees and the tip of a left leg; legs lean forwards at the head and backwards at the tail."""
    along = segment / (SEGMENTS - 1)
    y = front_of(segment) + 0.5 * LENGTH
    width = half_width(y)
    lean = math.radians(-38 + 82 * along**1.3)
    reach = 1.0 + 0.12 * math.sin(math.pi * along) + (0.55 if segment == SEGMENTS - 1 else 0.0)
    out = np.array([math.cos(lean), math.sin(lean), 0.0])
    hip = np.array([0.86 * width, y, HEIGHT - 0.22 * width])
    knee = hip + 0.030 * reach * out + (0, 0, 0.004)
    ankle = hip + 0.082 * reach * out + (0, 0, 0.026)
    tip = hip + 0.150 * reach * out
    tip[2] = 0.0
    return [hip, knee, ankle, tip]


def antenna_path():
    start = np.array([0.014, front_of(0) - 0.050, HEIGHT + 0.004])
    steps = [(0.030, -0.050, 0.022), (0.034, -0.058, 0.010), (0.036, -0.058, -0.006), (0.034, -0.054, -0.018)]
    return [start + s for s in np.concatenate([[(0, 0, 0)], np.cumsum(steps, axis=0)])]


def fang_path():
    start = np.array([0.021, front_of(0) - 0.045, HEIGHT - 0.007])
    return [start, start + (0.020, -0.012, -0.008), start + (0.001, -0.044, -0.013)]


def skeleton():
    s = Skeleton()
    s.add("root", None, (0, 0, 0), (0, 0.1, 0))
    point = lambda k: (0, front_of(k), HEIGHT)
    parent = "root"
    for k in range(MIDDLE, SEGMENTS):
        s.add(f"body{k:02}", parent, point(k), point(k + 1))
        parent = f"body{k:02}"
    parent = "root"
    for k in range(MIDDLE - 1, -1, -1):
        s.add(f"body{k:02}", parent, point(k + 1), point(k))
        parent = f"body{k:02}"
    s.add("head", parent, point(0), (0, front_of(0) - 0.06, HEIGHT))
    for side, tag in ((1, ".L"), (-1, ".R")):
        at = lambda p: np.array(p) * (side, 1, 1)
        s.chain([f"antenna{i}{tag}" for i in range(4)], "head", [at(p) for p in antenna_path()])
        s.add("fang" + tag, "head", at(fang_path()[0]), at(fang_path()[2]))
        for k in range(SEGMENTS):
            s.chain(
                [f"{joint}{k:02}{tag}" for joint in LEG_JOINTS], f"body{k:02}", [at(p) for p in leg_path(k)]
            )
    return s


def grow(cage, base, path, stations, side):
    """Grows a limb of four columns from a face; stations are (share of the length, radius)."""
    lengths = np.cumsum([0.0] + [np.linalg.norm(b - a) for a, b in zip(path, path[1:])])
    share, path = lengths / lengths[-1], np.array(path)
    polyline = lambda s: np.array([np.interp(s, share, path[:, i]) for i in range(3)])
    rings = [base]
    for s, radius in stations:
        tangent = polyline(min(s + 0.03, 1.0)) - polyline(max(s - 0.03, 0.0))
        tangent /= np.linalg.norm(tangent)
        across = np.cross(tangent, (0.0, 0.0, 1.0))
        across /= np.linalg.norm(across)
        up = np.cross(across, tangent)
        at = polyline(s)
        corners = [at + radius * (a * across + b * up) for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
        rings.append(cage.add([p * (side, 1, 1) for p in corners]))
    rings[0] = closest_order(cage, base, rings[1])
    cage.tube(rings, seam=2)
    cage.cut(rings[1])
    cage.faces.append(tuple(rings[-1]))


def closest_order(cage, base, ring):
    """The rotation, forwards or backwards, of `base` that lies closest to `ring`."""
    points = [np.array(cage.points[i]) for i in ring]
    orders = [list(np.roll(way, k)) for way in (list(base), list(base)[::-1]) for k in range(4)]
    return [
        int(i)
        for i in min(
            orders, key=lambda o: sum(np.linalg.norm(np.array(cage.points[i]) - p) for i, p in zip(o, points))
        )
    ]


def surface():
    cage = Cage()
    levels = []
    y = front_of(0)
    for at, width, drop in (
        (-0.072, 0.010, 0.006),
        (-0.066, 0.018, 0.004),
        (-0.054, 0.026, 0.001),
        (-0.036, 0.032, 0.0),
        (-0.018, 0.031, 0.0),
        (-0.008, 0.027, 0.0),
    ):
        levels.append(ring(y + at, width, drop=drop))
    first = len(levels)
    for k in range(SEGMENTS):
        for share, swell in ((0.03, 0.80), (0.14, 0.97), (0.86, 1.05), (0.97, 1.06)):
            at = front_of(k) + share * LENGTH
            levels.append(ring(at, half_width(at), swell))
    end = front_of(SEGMENTS)
    levels += [ring(end + 0.004, 0.017), ring(end + 0.018, 0.014), ring(end + 0.030, 0.006)]
    rings = [cage.add(level) for level in levels]
    cage.tube(rings, seam=8)
    for tip in (rings[0], rings[-1]):
        cage.cap(tip)
    dorsal = range(0, COLUMNS // 2 - 1)
    for k in range(SEGMENTS):  # the plate's rear rim
        rim = rings[first + 4 * k + 3]
        cage.sharp.update((rim[j], rim[j + 1]) for j in dorsal)

    def take(level, column):
        """Removes one face and returns its corners."""
        a, b = rings[level], rings[level + 1]
        corners = [a[column], a[(column + 1) % COLUMNS], b[(column + 1) % COLUMNS], b[column]]
        cage.faces.remove(next(f for f in cage.faces if set(f) == set(corners)))
        return corners

    leg = [
        (0.085, 0.0100),
        (0.165, 0.0092),
        (0.215, 0.0098),
        (0.26, 0.0088),
        (0.42, 0.0075),
        (0.52, 0.0078),
        (0.57, 0.0082),
        (0.63, 0.0066),
        (0.80, 0.0044),
        (0.97, 0.0022),
    ]
    antenna = [
        (0.06, 0.0062),
        (0.20, 0.0050),
        (0.25, 0.0058),
        (0.30, 0.0048),
        (0.45, 0.0040),
        (0.50, 0.0047),
        (0.55, 0.0038),
        (0.72, 0.0031),
        (0.76, 0.0036),
        (0.80, 0.0027),
        (0.99, 0.0012),
    ]
    fang = [(0.20, 0.0080), (0.36, 0.0078), (0.54, 0.0068), (0.77, 0.0042), (0.98, 0.0008)]
    mirror = lambda column: (COLUMNS // 2 - 1 - column - 1) % COLUMNS
    for side in (1, -1):
        column = lambda c: c if side > 0 else mirror(c)
        for k in range(SEGMENTS):
            grow(cage, take(first + 4 * k + 1, column(LOW_SIDE)), leg_path(k), leg, side)
        grow(cage, take(1, column(1)), antenna_path(), antenna, side)
        grow(cage, take(2, column(LOW_SIDE)), fang_path(), fang, side)
    return subdivide(cage, 1, CHITIN, PLATE)


def paint(part, names):
    """Colours by the kind of joint followed, and relief on the plates; `names` are the weights' columns."""
    x, y, z = part.points.T
    of = lambda *kinds: part.weights[:, [i for i, n in enumerate(names) if n.startswith(kinds)]].sum(axis=1)
    legs, feelers, fangs = of(*LEG_JOINTS), of("antenna"), of("fang")
    within = ((y - front_of(0)) / LENGTH) % 1.0
    joint = np.where(
        (y > front_of(0)) & (y < front_of(SEGMENTS)),
        1 - ramp(np.minimum(within, 1 - within), 0.02, 0.09),
        0.0,
    )
    belly = ramp(HEIGHT - z, 0.004, 0.012)
    mix = lambda a, b, t: a + (np.array(b) - a) * np.clip(t, 0, 1)[:, None]
    colours = mix(part.colours, MEMBRANE, np.maximum(joint, 0.8 * belly))
    colours = mix(colours, LEG, ramp(np.maximum(legs, feelers), 0.45, 0.85))
    tips = np.array([p * (s, 1, 1) for k in range(SEGMENTS) for s in (1, -1) for p in leg_path(k)[3:]])
    to_tip = np.min(np.linalg.norm(part.points[:, None] - tips[None], axis=2), axis=1)
    colours = mix(colours, CLAW, 1 - ramp(to_tip, 0.012, 0.030))
    part.colours = mix(colours, CLAW, ramp(fangs, 0.5, 0.9) * ramp(front_of(0) - 0.035 - y, 0.0, 0.02))
    back = np.clip(1 - legs - feelers - fangs, 0, 1) * (1 - joint) * ramp(z - HEIGHT, 0.002, 0.008)
    grooves = -0.0012 * bump(np.abs(x), 0.015, 0.004)
    part.displace(back * (grooves + 0.0007 * rough(part.points, 60.0, 11)))


def eye():
    """The left eye, fixed to the head."""
    centre, radius, count = np.array([0.0245, front_of(0) - 0.046, HEIGHT + 0.0065]), 0.0048, 10
    cage = Cage()
    polar = np.pi * np.array([1, 2, 3, 4, 5]) / 6
    rings = [
        cage.add(
            [
                centre
                + radius * np.array([math.sin(a) * math.cos(k), math.sin(a) * math.sin(k), math.cos(a)])
                for k in 2 * math.pi * np.arange(count) / count
            ]
        )
        for a in polar
    ]
    cage.tube(rings)
    cage.fan(rings[0], centre + (0, 0, radius))
    cage.fan(rings[-1], centre - (0, 0, radius))
    cage.cut(rings[2])
    return subdivide(cage, 0, EYE, (0.01, 0.01, 0.012), joint="head")


def bend(pose, segment, pitch=0.0, yaw=0.0, roll=0.0):
    """Bends the body at a segment: pitch lifts the front, yaw turns it left, roll lowers the left side.

    The half behind the middle bends the other way about, so that equal bends make a circle.
    """
    way = 1 if segment < MIDDLE else -1
    pose.turn(f"body{segment:02}", x=-way * pitch, y=way * roll, z=way * yaw)


def step(pose, segment, tag, swing=0.0, lift=0.0, fold=0.0):
    """Swings a leg forwards, lifts it, and folds its two outer joints, in degrees."""
    side = 1 if tag == ".L" else -1
    pose.turn(f"coxa{segment:02}{tag}", y=-side * lift, z=-side * swing)
    pose.turn(f"femur{segment:02}{tag}", y=-side * 0.4 * fold)
    pose.turn(f"tibia{segment:02}{tag}", y=side * fold)


def feelers(pose, time):
    for side, tag in ((1, ".L"), (-1, ".R")):
        for i in range(4):
            beat = math.sin(2 * math.pi * (time - 0.12 * i) + side)
            pose.turn(f"antenna{i}{tag}", x=7 * beat, z=side * 9 * math.cos(2 * math.pi * (time - 0.15 * i)))
        pose.turn("fang" + tag, z=side * 12 * (1 + math.sin(2 * math.pi * time)))


def make_clips(rig, bones):
    wave = lambda turns: math.sin(2 * math.pi * turns)

    def crawl(time):
        pose = Pose(bones)
        beat = time / 1.2
        for k in range(SEGMENTS):
            bend(pose, k, yaw=15 * wave(beat - k / 9))
            for tag, shift in ((".L", 0.0), (".R", 0.5)):
                phase = beat * 2 - k / 5 + shift
                step(
                    pose,
                    k,
                    tag,
                    swing=26 * wave(phase),
                    lift=20 * max(0.0, wave(phase + 0.25)),
                    fold=18 * max(0.0, wave(phase + 0.25)),
                )
        feelers(pose, beat)
        return pose

    def curl(time):
        pose = Pose(bones)
        share = float(ramp(time, 0.0, 1.1) * ramp(time, 2.4, 1.5))
        for k in range(SEGMENTS):
            tight = 20 + 13 * (1 - k / (SEGMENTS - 1))
            bend(pose, k, yaw=tight * share, pitch=(3.2 if k < MIDDLE else 0.0) * share)
            step(pose, k, ".L", swing=-28 * share, lift=-8 * share, fold=55 * share)
            step(pose, k, ".R", swing=-12 * share, lift=4 * share, fold=25 * share)
        pose.turn("head", z=22 * share)
        feelers(pose, time / 2.4)
        return pose

    def rear_up(time):
        pose = Pose(bones)
        share = float(ramp(time, 0.0, 0.9) * ramp(time, 2.4, 1.7))
        sway = share * wave(time / 1.2)
        for k in range(SEGMENTS):
            raised = max(0, MIDDLE - k)
            bend(
                pose,
                k,
                pitch=share * (24 if 2 < raised < 7 else -16 if raised >= 7 else 6 if raised else 0),
                yaw=4 * sway,
                roll=2.5 * sway if raised else 0.0,
            )
            for tag, shift in ((".L", 0.0), (".R", 0.5)):
                clutch = share * raised / MIDDLE
                step(
                    pose,
                    k,
                    tag,
                    swing=clutch * (18 + 22 * wave(time / 0.6 - k / 4 + shift)),
                    lift=-14 * clutch,
                    fold=clutch * (38 + 25 * wave(time / 0.6 - k / 4 + shift)),
                )
        pose.turn("head", x=share * 38)
        feelers(pose, time / 1.2)
        return pose

    def twist(time):
        pose = Pose(bones)
        roll = float(ramp(time, 0.0, 0.6) - 2 * ramp(time, 0.7, 1.5) + ramp(time, 1.6, 2.2))
        for k in range(SEGMENTS):
            bend(pose, k, roll=11 * roll, pitch=2.0 * abs(roll), yaw=5 * roll)
            for tag in (".L", ".R"):
                step(pose, k, tag, lift=18 * abs(roll), fold=-12 * abs(roll))
        feelers(pose, time / 2.2)
        return pose

    for name, seconds, pose_at in (
        ("crawl", 1.2, crawl),
        ("curl", 2.4, curl),
        ("rear_up", 2.4, rear_up),
        ("twist", 2.2, twist),
    ):
        make_clip(rig, bones, name, seconds, pose_at)


def main():
    empty_scene()
    bones = skeleton()
    rig = bones.build("centipede")
    body, left_eye = surface(), eye()
    body.weights = carry_weights(heat_weights(rig, [body], ("root",)), body.points)
    paint(body, [b.name for b in rig.data.bones])
    parts = [body, left_eye, left_eye.mirrored()]
    colour_factors = factors(parts, LOOKS)
    join("centipede_mesh", rig, parts, make_materials(LOOKS, colour_factors), colour_factors, smoothing=1)
    make_clips(rig, bones)
    export(output_path("centipede.glb"))


main()
