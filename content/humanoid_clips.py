# SPDX-License-Identifier: MIT
"""The humanoid's clips: walk, crouch, reach and wave, twist and bow, kick."""

import math

import numpy as np
from humanoid_measures import ABOVE, ANKLE, BALL, FINGERS, FRONT
from rig import Pose, between, make_clip
from mathutils import Quaternion, Vector


def grounded(pose):
    """Lifts or lowers a pose until its lowest sole is on the floor."""
    soles = []
    for tag in (".L", ".R"):
        heel = pose.tip("foot" + tag, end=False) + pose.world("foot" + tag) @ Vector((0, 0.06, -0.095))
        ball = pose.tip("toe" + tag, end=False) + pose.world("foot" + tag) @ Vector((0, 0, -0.035))
        toe = pose.tip("toe" + tag) + pose.world("toe" + tag) @ Vector((0, 0, -0.030))
        soles += [heel.z, ball.z, toe.z]
    pose.shift.z -= min(soles)
    return pose


def legs(pose, tag, thigh, shin, out=0.0, foot=0.0):
    """Thigh and shin by angles from straight down, forwards positive; the foot by its pitch, toes up."""
    side = 1 if tag == ".L" else -1
    down = lambda a: (
        side * math.sin(math.radians(out)),
        -math.sin(math.radians(a)),
        -math.cos(math.radians(a)),
    )
    pose.aim("thigh" + tag, down(thigh)).aim("shin" + tag, down(shin))
    x, y, z = BALL - ANKLE
    pitch = math.radians(foot)
    return pose.aim("foot" + tag, (side * x, math.cos(pitch) * y, z - math.sin(pitch) * y))


def fist(pose, tag, amount):
    """Curls fingers and thumb; 1 is a fist."""
    side = 1 if tag == ".L" else -1
    axis = Vector(FRONT)
    for finger in FINGERS:
        for i, most in ((1, 70), (2, 95), (3, 55)):
            pose.turns[f"{finger}{i}{tag}"] = Quaternion(axis, -side * math.radians(most * amount))
    fold = Vector((side * ABOVE[0], 0, ABOVE[2]))
    for i, most in ((1, 25), (2, 40), (3, 45)):
        pose.turns[f"thumb{i}{tag}"] = Quaternion(fold, side * math.radians(most * amount))
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
    def bent(**turns):
        """A pose with joints turned about the world's axes: x alone (forwards), or x, y and z."""
        pose = Pose(bones)
        for joint, angles in turns.items():
            pose.turn(joint, *np.atleast_1d(angles))
        return pose

    def standing():
        pose = bent()
        for tag in (".L", ".R"):
            legs(pose, tag, 2, -2, out=2)
            arms(pose, tag, (0.28, 0.0, -1), (0.2, 0.18, -1))
        return pose

    def clip(name, seconds, keys):
        make_clip(rig, bones, name, seconds, lambda t: grounded(between(keys, t)))

    def stride(front, back, thigh_f, shin_f, foot_f, thigh_b, shin_b, foot_b, twist):
        pose = bent(
            hips=(4, 0, -7 * twist),
            spine2=(0, 0, 9 * twist),
            chest=(0, 0, 9 * twist),
            head=(0, 0, -8 * twist),
        )
        legs(pose, front, thigh_f, shin_f, out=1, foot=foot_f)
        legs(pose, back, thigh_b, shin_b, out=1, foot=foot_b)
        swing = 0.75 * abs(twist)
        arms(pose, back, (0.25, swing, -1), (0.05, swing + 0.75, -0.75), curl=0.45)
        arms(pose, front, (0.3, -swing, -1), (0.2, 0.25 - 0.4 * swing, -1), curl=0.45)
        return pose

    walk = []
    for half, (front, back, sign) in enumerate(((".L", ".R", 1), (".R", ".L", -1))):
        at = 0.5 * half
        walk += [
            (at, stride(front, back, 30, 22, 16, -20, -38, -32, sign)),
            (at + 0.12, stride(front, back, 24, 2, 0, -10, -72, -55, 0.5 * sign)),
            (at + 0.30, stride(front, back, 2, -4, 0, 28, -52, -12, -0.3 * sign)),
        ]
    walk.append((1.0, walk[0][1]))
    clip("walk", 1.0, walk)

    low = bent(hips=22, spine1=16, spine2=16, chest=10, neck=-22, head=-18)
    for tag in (".L", ".R"):
        legs(low, tag, 98, -48, out=22, foot=-4)
        arms(low, tag, (0.45, 0.75, -0.7), (-0.25, 0.7, 0.75), curl=0.6)
    clip("crouch", 1.8, [(0.0, standing()), (0.75, low), (1.05, low), (1.8, standing())])

    reach = bent(
        hips=(0, -3, 0), spine1=(-6, -6, 0), spine2=(-8, -8, 0), chest=(-8, -6, 0), neck=-14, head=-14
    )
    legs(reach, ".L", 2, -3, out=3, foot=-30)
    legs(reach, ".R", 2, -3, out=3, foot=-30)
    arms(reach, ".L", (0.05, 0.12, 1), (-0.08, 0.15, 1), curl=0.0)
    arms(reach, ".R", (0.6, 0.05, -1), (0.45, 0.3, -0.9), curl=0.3)
    wave = [Pose(bones, reach) for _ in range(2)]
    for pose, lean in zip(wave, (0.95, -0.55)):
        pose.aim("upper_arm.L", (0.55, -0.1, 0.7)).aim("forearm.L", (lean, -0.1, 0.9)).aim(
            "hand.L", (1.5 * lean, -0.1, 0.8)
        )
    clip(
        "reach_and_wave",
        2.4,
        [
            (0.0, standing()),
            (0.6, reach),
            (0.8, reach),
            (1.1, wave[0]),
            (1.35, wave[1]),
            (1.6, wave[0]),
            (1.85, wave[1]),
            (2.4, standing()),
        ],
    )

    turned_out = bent(
        hips=(0, 0, 18),
        spine1=(0, 0, 20),
        spine2=(0, 0, 22),
        chest=(0, 0, 22),
        neck=(0, 0, 14),
        head=(0, 0, 14),
    )
    legs(turned_out, ".L", 4, -8, out=9)
    legs(turned_out, ".R", 10, -12, out=9)
    for tag, forwards in ((".L", -0.7), (".R", 0.7)):
        arms(turned_out, tag, (1, forwards, 0.1), (0.5 if forwards > 0 else 0.9, forwards + 0.5, 0.25))
    bow = bent(hips=38, spine1=26, spine2=26, chest=(22, 0, -18), neck=12, head=12)
    for tag in (".L", ".R"):
        legs(bow, tag, 6, -4, out=4)
    bow.move(y=0.18)
    arms(bow, ".L", (0.15, 0.55, -0.9), (-0.3, 0.1, -1))
    arms(bow, ".R", (0.8, -0.6, 0.35), (0.75, -0.75, 0.6), curl=0.1)
    clip(
        "twist_and_bow",
        2.4,
        [
            (0.0, standing()),
            (0.6, turned_out),
            (0.85, turned_out),
            (1.55, bow),
            (1.8, bow),
            (2.4, standing()),
        ],
    )

    chamber = bent(hips=-6, spine1=8, spine2=6)
    legs(chamber, ".R", 12, -18, out=3)
    legs(chamber, ".L", 108, -30, out=4, foot=-50)
    kick = bent(hips=(-20, 4, 0), spine1=10, spine2=6, neck=8)
    legs(kick, ".R", 4, -6, out=3)
    legs(kick, ".L", 92, 84, out=6, foot=62)
    for pose, high in ((chamber, 0.55), (kick, 0.2)):
        arms(pose, ".L", (0.55, -0.25, -0.8), (0.1, 0.9, 0.35), curl=1.0)
        arms(pose, ".R", (0.6, 0.3, -0.7), (-0.45, 0.75, high), curl=1.0)
    clip(
        "kick",
        1.4,
        [(0.0, standing()), (0.4, chamber), (0.58, kick), (0.72, kick), (0.92, chamber), (1.4, standing())],
    )
