# SPDX-License-Identifier: MIT
"""From surfaces to an animated GLB: skeletons, smooth weights, skinned meshes, clips and the export."""

import math
import sys

import bmesh
import bpy
import numpy as np
from mathutils import Quaternion, Vector
from mathutils.bvhtree import BVHTree
from mathutils.interpolate import poly_3d_calc
from surface import mesh_from, ramp

FRAMES_PER_SECOND = 20
MAX_INFLUENCES = 4


class Skeleton:
    """Joints in order, parents first: name -> (parent or None, head, tail)."""

    def __init__(self):
        self.joints = {}

    def add(self, name, parent, head, tail):
        self.joints[name] = (parent, Vector(head), Vector(tail))

    def chain(self, names, parent, points):
        for name, head, tail in zip(names, points, points[1:]):
            self.add(name, parent, head, tail)
            parent = name

    def build(self, name):
        """The armature object; rolls are fixed by the world's axes, so they never depend on build order."""
        armature = bpy.data.armatures.new(name)
        rig = bpy.data.objects.new(name, armature)
        bpy.context.collection.objects.link(rig)
        bpy.context.view_layer.objects.active = rig
        bpy.ops.object.mode_set(mode="EDIT")
        for joint, (parent, head, tail) in self.joints.items():
            bone = armature.edit_bones.new(joint)
            bone.head, bone.tail = head, tail
            bone.align_roll(
                Vector((0, -1, 0)) if abs((tail - head).normalized().y) < 0.8 else Vector((0, 0, 1))
            )
            if parent:
                bone.parent = armature.edit_bones[parent]
        bpy.ops.object.mode_set(mode="OBJECT")
        return rig


def select_only(*objects):
    for other in bpy.context.scene.objects:
        other.select_set(other in objects)
    bpy.context.view_layer.objects.active = objects[-1]


def heat_weights(rig, parts, unweighted, voxel=None):
    """Blender's heat weights on the closed surface around some parts, but for the joints in `unweighted`.

    Clothes over skin over clothes are no closed surface, and heat flows badly on them. With a `voxel` size
    (metres) the hull of their union is used instead, and layers that lie over each other then move together.
    Returns (points n x 3, triangles, weights n x joints).
    """
    starts = np.cumsum([0] + [len(p.points) for p in parts])
    mesh = mesh_from(
        "hull",
        np.concatenate([p.points for p in parts]),
        [tuple(i + o for i in f) for p, o in zip(parts, starts) for f in p.faces],
    )
    bm = bmesh.new()
    bm.from_mesh(mesh)
    bmesh.ops.holes_fill(bm, edges=[e for e in bm.edges if e.is_boundary], sides=0)
    bm.to_mesh(mesh)
    bm.free()
    hull = bpy.data.objects.new("hull", mesh)
    bpy.context.collection.objects.link(hull)
    if voxel:
        remesh = hull.modifiers.new("hull", "REMESH")
        remesh.mode, remesh.voxel_size, remesh.adaptivity = "VOXEL", voxel, 0.0
        select_only(hull)
        bpy.ops.object.modifier_apply(modifier="hull")
        keep_largest(hull.data)
    for bone in rig.data.bones:
        bone.use_deform = bone.name not in unweighted
    select_only(hull, rig)
    bpy.ops.object.parent_set(type="ARMATURE_AUTO")
    for bone in rig.data.bones:
        bone.use_deform = True
    names = [b.name for b in rig.data.bones]
    column = {g.index: names.index(g.name) for g in hull.vertex_groups}
    weights = np.zeros((len(hull.data.vertices), len(names)))
    for v in hull.data.vertices:
        for g in v.groups:
            weights[v.index, column[g.group]] = g.weight
    if not weights.any():
        raise RuntimeError("heat weights: Blender found no solution on the hull")
    hull.data.calc_loop_triangles()
    result = (
        np.array([v.co for v in hull.data.vertices]),
        [tuple(t.vertices) for t in hull.data.loop_triangles],
        weights,
    )
    bpy.data.objects.remove(hull)
    return result


def keep_largest(mesh):
    """Drops all but the largest connected piece: remeshing leaves specks, for which heat has no solution."""
    bm = bmesh.new()
    bm.from_mesh(mesh)
    pieces, seen = [], set()
    for start in bm.verts:
        if start in seen:
            continue
        piece, front = [], [start]
        seen.add(start)
        while front:
            v = front.pop()
            piece.append(v)
            fresh = [w for w in (e.other_vert(v) for e in v.link_edges) if w not in seen]
            seen.update(fresh)
            front.extend(fresh)
        pieces.append(piece)
    largest = max(pieces, key=len)
    bmesh.ops.delete(bm, geom=[v for p in pieces if p is not largest for v in p], context="VERTS")
    bm.to_mesh(mesh)
    bm.free()


def carry_weights(hull, points):
    """Takes weights from the nearest point of the hull."""
    hull_points, triangles, weights = hull
    tree = BVHTree.FromPolygons([Vector(p) for p in hull_points], triangles)
    result = np.zeros((len(points), weights.shape[1]))
    for i, p in enumerate(points):
        where, _, t, _ = tree.find_nearest(Vector(p))
        corners = list(triangles[t])
        share = poly_3d_calc([Vector(hull_points[c]) for c in corners], where)
        result[i] = np.array(share) @ weights[corners]
    return result


def smooth_weights(weights, faces, rounds):
    """Averages each vertex's weights half-way with its neighbours'."""
    edges = np.array(sorted({tuple(sorted(e)) for f in faces for e in zip(f, f[1:] + f[:1])}))
    degree = np.bincount(edges.ravel(), minlength=len(weights))[:, None]
    for _ in range(rounds):
        total = np.zeros_like(weights)
        np.add.at(total, edges[:, 0], weights[edges[:, 1]])
        np.add.at(total, edges[:, 1], weights[edges[:, 0]])
        weights = 0.5 * weights + 0.5 * total / np.maximum(degree, 1)
    return weights


def cap_weights(weights):
    """Keeps the largest MAX_INFLUENCES of each vertex, drops those below 1 %, and makes the sum 1."""
    largest = np.argsort(-weights, axis=1, kind="stable")[:, :MAX_INFLUENCES]
    kept = np.zeros_like(weights)
    np.put_along_axis(kept, largest, np.take_along_axis(weights, largest, axis=1), axis=1)
    kept[weights < 0.01 * weights.sum(axis=1, keepdims=True)] = 0.0
    if not kept.any(axis=1).all():
        raise RuntimeError("weights: a vertex follows no joint")
    return kept / kept.sum(axis=1, keepdims=True)


def factors(parts, materials):
    """Each material's colour factor: its brightest in each channel; vertex colours are shares of it."""
    return {m: np.max([p.colours.max(axis=0) for p in parts if p.material == m], axis=0) for m in materials}


def make_materials(looks, colour_factors):
    """looks: name -> (metallic, roughness, whether both sides of a face are seen)."""
    made = {}
    for name, (metallic, roughness, both_sides) in looks.items():
        material = made[name] = bpy.data.materials.new(name)
        material.use_nodes = True
        shader = material.node_tree.nodes["Principled BSDF"]
        shader.inputs["Base Color"].default_value = (*colour_factors[name], 1.0)
        shader.inputs["Metallic"].default_value = metallic
        shader.inputs["Roughness"].default_value = roughness
        shader.inputs["Specular"].default_value = 0.5
        material.use_backface_culling = not both_sides
    return made


def join(name, rig, parts, materials, colour_factors, morph=None, smoothing=2):
    """One skinned mesh object out of parts: UVs unwrapped along seams, colours, weights and hard edges."""
    offsets = np.cumsum([0] + [len(p.points) for p in parts])
    points = np.concatenate([p.points for p in parts])
    faces = [tuple(i + o for i in f) for p, o in zip(parts, offsets) for f in p.faces]
    shifted = lambda key: [(a + o, b + o) for p, o in zip(parts, offsets) for a, b in getattr(p, key)]
    mesh = mesh_from(name, points, faces, shifted("seams"), shifted("sharp"))
    body = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(body)

    used = [m for m in materials if any(p.material == m for p in parts)]
    for m in used:
        mesh.materials.append(materials[m])
    mesh.polygons.foreach_set("material_index", [used.index(p.material) for p in parts for _ in p.faces])
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    mesh.use_auto_smooth, mesh.auto_smooth_angle = True, math.pi

    colours = np.ones((len(points), 4))
    colours[:, :3] = np.concatenate([p.colours / colour_factors[p.material] for p in parts])
    attribute = mesh.color_attributes.new("Color", "BYTE_COLOR", "POINT")
    attribute.data.foreach_set("color", colours.ravel())
    mesh.color_attributes.render_color_index = mesh.color_attributes.active_color_index = 0

    unwrap(body)
    names = [b.name for b in rig.data.bones]
    weights = smooth_weights(np.concatenate([part_weights(p, names) for p in parts]), faces, smoothing)
    weights = cap_weights(weights)
    for j, joint in enumerate(names):
        group = body.vertex_groups.new(name=joint)
        for v in np.nonzero(weights[:, j])[0]:
            group.add([int(v)], float(weights[v, j]), "REPLACE")

    if morph:
        body.shape_key_add(name="Basis", from_mix=False)
        key = body.shape_key_add(name=morph, from_mix=False)
        moved = np.concatenate([p.points if p.shape is None else p.shape for p in parts])
        key.data.foreach_set("co", moved.ravel())
        key.value = 0.0
    body.modifiers.new("skin", "ARMATURE").object = rig
    return body


def part_weights(part, names):
    if part.joint:
        return np.tile(np.eye(len(names))[names.index(part.joint)], (len(part.points), 1))
    return part.weights


def unwrap(body):
    mesh = body.data
    mesh.uv_layers.new(name="UVMap")
    select_only(body)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.uv.unwrap(method="ANGLE_BASED", fill_holes=True, correct_aspect=False, margin=0.004)
    bpy.ops.uv.average_islands_scale()
    bpy.ops.uv.pack_islands(rotate=False, margin=0.004)
    bpy.ops.object.mode_set(mode="OBJECT")


class Pose:
    """Rotations of joints in the axes of the rest pose, each relative to its parent.

    With W the turn of a joint since rest, W(joint) = W(parent) * turn(joint): bone rolls play no part.
    """

    def __init__(self, skeleton, start=None):
        self.joints = skeleton.joints
        self.turns = dict(start.turns) if start else {}
        self.shift = start.shift.copy() if start else Vector()

    def world(self, joint):
        if joint is None:
            return Quaternion()
        return self.world(self.joints[joint][0]) @ self.turns.get(joint, Quaternion())

    def turn(self, joint, x=0, y=0, z=0):
        """Adds turns about the world's axes, in degrees: x, then y, then z."""
        for axis, angle in zip(((1, 0, 0), (0, 1, 0), (0, 0, 1)), (x, y, z)):
            self.turns[joint] = Quaternion(axis, math.radians(angle)) @ self.turns.get(joint, Quaternion())
        return self

    def aim(self, joint, direction):
        """Swings a joint until it points along `direction`. Aim parents first."""
        parent, head, tail = self.joints[joint]
        wanted = self.world(parent).inverted() @ Vector(direction).normalized()
        self.turns[joint] = (tail - head).normalized().rotation_difference(wanted)
        return self

    def move(self, x=0, y=0, z=0):
        self.shift += Vector((x, y, z))
        return self

    def tip(self, joint, end=True):
        """Where a joint's tail (or head) is in this pose."""
        parent, head, tail = self.joints[joint]
        at = self.world(joint) @ (tail - head) if end else Vector()
        while parent:
            grand, parent_head, _ = self.joints[parent]
            at += self.world(parent) @ (head - parent_head)
            head, parent = parent_head, grand
        return at + head + self.shift

    def mixed(self, other, share):
        mixed = Pose.__new__(Pose)
        mixed.joints = self.joints
        mixed.shift = self.shift.lerp(other.shift, share)
        mixed.turns = {
            j: self.turns.get(j, Quaternion()).slerp(other.turns.get(j, Quaternion()), share)
            for j in self.joints
            if j in self.turns or j in other.turns
        }
        return mixed


def between(keys, time):
    """The pose at a time, eased between (time, pose) keys."""
    for (t0, a), (t1, b) in zip(keys, keys[1:]):
        if time <= t1:
            return a.mixed(b, float(ramp(time, t0, t1)))
    return keys[-1][1]


def make_clip(rig, skeleton, name, seconds, pose_at):
    """Bakes pose_at(time) to one action on its own NLA track, which the exporter writes as one animation.

    Joints that never turn get no curve; only the first joint moves.
    """
    frames = round(seconds * FRAMES_PER_SECOND)
    poses = [pose_at(f / FRAMES_PER_SECOND) for f in range(frames + 1)]
    action = bpy.data.actions.new(name)
    action.id_root = "OBJECT"
    for joint in skeleton.joints:
        if not any(joint in p.turns for p in poses):
            continue
        rest = rig.data.bones[joint].matrix_local.to_quaternion()
        turns = [rest.inverted() @ p.turns.get(joint, Quaternion()) @ rest for p in poses]
        for a, b in zip(turns, turns[1:]):
            if a.dot(b) < 0:
                b.negate()
        write_curves(action, joint, "rotation_quaternion", [tuple(q) for q in turns])
    root = next(iter(skeleton.joints))
    frame = rig.data.bones[root].matrix_local.to_3x3().inverted()
    write_curves(action, root, "location", [tuple(frame @ p.shift) for p in poses])
    rig.animation_data_create()
    track = rig.animation_data.nla_tracks.new()
    track.name = name
    track.strips.new(name, 0, action)
    track.mute = True


def write_curves(action, joint, channel, values):
    for i, column in enumerate(zip(*values)):
        curve = action.fcurves.new(f'pose.bones["{joint}"].{channel}', index=i, action_group=joint)
        curve.keyframe_points.add(len(column))
        curve.keyframe_points.foreach_set("co", [x for f, v in enumerate(column) for x in (f, v)])
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
        curve.update()


def empty_scene():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.fps = FRAMES_PER_SECOND
    bpy.context.preferences.filepaths.save_version = 0


def output_path(default):
    return sys.argv[sys.argv.index("--") + 1] if "--" in sys.argv else default


def export(path):
    bpy.context.scene.frame_set(0)
    bpy.ops.export_scene.gltf(
        filepath=path,
        export_format="GLB",
        export_yup=True,
        export_apply=False,
        export_texcoords=True,
        export_normals=True,
        export_colors=True,
        export_tangents=False,
        export_materials="EXPORT",
        export_cameras=False,
        export_lights=False,
        export_extras=False,
        export_skins=True,
        export_all_influences=False,
        export_def_bones=False,
        export_animations=True,
        export_nla_strips=True,
        export_force_sampling=True,
        export_frame_range=False,
        export_optimize_animation_size=True,
        export_current_frame=False,
        export_morph=True,
        export_morph_normal=True,
        export_morph_tangent=False,
    )
