# SPDX-License-Identifier: MIT
"""Makes humanoid.glb, a clothed stylised human.

24,984 triangles in two skinned meshes (body, face), 55 joints with three in every finger and thumb, at most
four influences, three materials (skin, cloth, leather), one UV set, vertex colours, hard edges at hems,
belt, boots and buckle, open borders at the trousers' waist and inside every hem, and the morph target
`smile` on the face; 1.77 m tall with hair, arms at rest 42 degrees below level. Five clips at 20 frames a
second: walk 1.0 s, crouch 1.8 s, reach_and_wave 2.4 s, twist_and_bow 2.4 s, kick 1.4 s. On one thread (-t
1) the same Blender gives the same bytes each time.

    blender -t 1 -b --factory-startup --python content/humanoid.py -- content/humanoid.glb
"""

import os
import sys

import numpy as np

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from humanoid_clips import make_clips
from humanoid_clothes import belt, boot, buckle, pouch, sole, trousers, tunic
from humanoid_measures import LOOKS, arm_coordinates, skeleton
from humanoid_skin import arm, eye, eyebrow, hair, head
from rig import carry_weights, empty_scene, export, factors, heat_weights, join, make_materials, output_path
from surface import ramp


def follow_thighs(rig, part, floor=None):
    """Weights for the skirt, and the trousers under it down to `floor`: the lower, the more thigh."""
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


def weigh(rig, parts, skirt, breeches, hands):
    """Smooth weights from the hull of all layers; hands from their own: fingers melt in the hull."""
    stiff = ("root", "eye.L", "eye.R")
    soft = [p for p in parts if p.joint is None]
    hull = heat_weights(rig, soft, stiff, voxel=0.008)
    for part in soft:
        part.weights = carry_weights(hull, part.points)
    skirt.weights = follow_thighs(rig, skirt)
    breeches.weights = follow_thighs(rig, breeches, floor=0.84)
    for part in hands:
        own = carry_weights(heat_weights(rig, [part], stiff), part.points)
        along = arm_coordinates(part.points)[0]
        share = ramp(along, 0.41, 0.47)[:, None]
        part.weights = share * own + (1 - share) * part.weights


def main():
    empty_scene()
    bones = skeleton()
    rig = bones.build("humanoid")
    both = lambda part: [part, part.mirrored()]
    skirt, breeches, hands = tunic(), trousers(), both(arm())
    body = [skirt, breeches, *hands, *both(boot()), *both(sole()), belt(), buckle(), pouch()]
    face = [head(), hair(), *both(eye()), *both(eyebrow())]
    weigh(rig, body + face, skirt, breeches, hands)
    colour_factors = factors(body + face, LOOKS)
    materials = make_materials(LOOKS, colour_factors)
    join("body", rig, body, materials, colour_factors)
    join("face", rig, face, materials, colour_factors, morph="smile")
    make_clips(rig, bones)
    export(output_path("humanoid.glb"))


main()
