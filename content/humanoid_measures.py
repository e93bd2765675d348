# SPDX-License-Identifier: MIT
"""The humanoid's looks, measures and skeleton."""

import math

import numpy as np
from rig import Skeleton

SKIN, CLOTH, LEATHER = "skin", "cloth", "leather"
LOOKS = {SKIN: (0.0, 0.55, False), CLOTH: (0.0, 0.85, True), LEATHER: (0.15, 0.50, True)}

FLESH = (0.72, 0.42, 0.30)
LIP = (0.55, 0.22, 0.18)
EYE_WHITE = (0.85, 0.84, 0.80)
IRIS = (0.08, 0.20, 0.22)
PUPIL = (0.01, 0.01, 0.01)
TUNIC = (0.10, 0.24, 0.22)
TUNIC_HEM = (0.45, 0.34, 0.14)
TROUSERS = (0.16, 0.13, 0.11)
BOOT = (0.17, 0.07, 0.03)
SOLE = (0.05, 0.03, 0.02)
BELT = (0.22, 0.10, 0.04)
BUCKLE = (0.75, 0.58, 0.25)
HAIR = (0.10, 0.045, 0.02)

# Measures of the left side; the right side is its mirror image.

ARM_DROP = math.radians(42)
ARM = np.array([math.cos(ARM_DROP), 0.0, -math.sin(ARM_DROP)])  # along the arm, away from the body
ABOVE = np.array([math.sin(ARM_DROP), 0.0, math.cos(ARM_DROP)])  # off the arm's upper side
FRONT = np.array([0.0, -1.0, 0.0])
SHOULDER = np.array([0.178, 0.012, 1.425])
ELBOW_AT, WRIST_AT, KNUCKLES_AT = 0.275, 0.525, 0.612  # along the arm from the shoulder
HIP = np.array([0.092, 0.005, 0.905])
KNEE = np.array([0.100, -0.012, 0.495])
ANKLE = np.array([0.105, 0.022, 0.095])
BALL = np.array([0.112, -0.105, 0.035])
TOE = np.array([0.114, -0.185, 0.030])
HEAD = np.array([0.0, -0.012, 1.625])  # the middle of the skull
EYE = HEAD + np.array([0.033, -0.0735, 0.0])
EYE_RADIUS = 0.0185

# Fingers: place across the palm, length, and how far the knuckle stands ahead of or behind the row.
FINGERS = {
    "index": (0.031, 0.078, 0.0),
    "middle": (0.0105, 0.087, 0.004),
    "ring": (-0.0105, 0.080, 0.001),
    "pinky": (-0.030, 0.063, -0.007),
}
PHALANGES = (0.0, 0.44, 0.73, 1.0)
FINGER_CURL = 9.0  # degrees at each joint at rest


def along_arm(t, above=0.0, front=0.0):
    return SHOULDER + t * ARM + above * ABOVE + front * FRONT


def arm_coordinates(points):
    """How far along and above the nearer arm points lie."""
    sideways, up = np.abs(points[:, 0]) - SHOULDER[0], points[:, 2] - SHOULDER[2]
    return sideways * ARM[0] + up * ARM[2], sideways * ABOVE[0] + up * ABOVE[2]


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
    s.chain(
        ["spine1", "spine2", "chest"],
        "hips",
        [(0, 0.004, 1.03), (0, 0.006, 1.14), (0, 0.012, 1.25), (0, 0.018, 1.445)],
    )
    s.chain(["neck", "head"], "chest", [(0, 0.022, 1.460), (0, 0.004, 1.550), (0, -0.004, 1.755)])
    for side, tag in ((1, ".L"), (-1, ".R")):
        at = lambda p: np.array(p) * (side, 1, 1)
        s.add("eye" + tag, "head", at(EYE), at(EYE + 0.03 * FRONT))
        s.add("clavicle" + tag, "chest", at((0.022, -0.005, 1.440)), at(SHOULDER))
        s.chain(
            [n + tag for n in ("upper_arm", "forearm", "hand")],
            "clavicle" + tag,
            [
                at(along_arm(t, 0, b))
                for t, b in ((0, 0), (ELBOW_AT, -0.006), (WRIST_AT, 0), (KNUCKLES_AT, 0))
            ],
        )
        s.chain([f"thumb{i}{tag}" for i in (1, 2, 3)], "hand" + tag, [at(p) for p in thumb_path()])
        for finger in FINGERS:
            s.chain(
                [f"{finger}{i}{tag}" for i in (1, 2, 3)], "hand" + tag, [at(p) for p in finger_path(finger)]
            )
        s.chain(
            [n + tag for n in ("thigh", "shin", "foot", "toe")],
            "hips",
            [at(p) for p in (HIP, KNEE, ANKLE, BALL, TOE)],
        )
    return s
