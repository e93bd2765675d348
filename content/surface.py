# SPDX-License-Identifier: MIT
"""Surfaces for the content scripts: cages that are subdivided, and rays cast on blended shapes.

Blender's frame is used throughout: metres, Z up, characters look along -Y and their left is +X. The exporter
turns this into glTF's frame: Y up, front along +Z.
"""

import bmesh
import bpy
import numpy as np
from mathutils import Vector, noise


class Cage:
    """A polygon cage with marked edges: `seams` cut the texture map, `sharp` edges stay hard."""

    def __init__(self):
        self.points, self.faces = [], []
        self.seams, self.sharp = set(), set()

    def add(self, points):
        """Adds points and returns their indices."""
        first = len(self.points)
        self.points.extend(tuple(map(float, p)) for p in points)
        return list(range(first, len(self.points)))

    def bridge(self, a, b, seam=0):
        """Closes the strip between two rings of the same size; `seam` is the column that is cut, or None."""
        n = len(a)
        for k in range(n):
            self.faces.append((a[k], a[(k + 1) % n], b[(k + 1) % n], b[k]))
        if seam is not None:
            self.seams.add((a[seam], b[seam]))

    def tube(self, rings, seam=0):
        """Bridges each ring to the next."""
        for a, b in zip(rings, rings[1:]):
            self.bridge(a, b, seam)

    def cap(self, ring):
        """Closes a ring of even size with a ladder of quads between its first and its opposite point."""
        n = len(ring)
        half = n // 2
        if n == 4:
            self.faces.append(tuple(ring))
            return
        self.faces.append((ring[0], ring[1], ring[n - 1]))
        for k in range(1, half - 1):
            self.faces.append((ring[k], ring[k + 1], ring[n - k - 1], ring[n - k]))
        self.faces.append((ring[half - 1], ring[half], ring[half + 1]))

    def fan(self, ring, point):
        """Closes a ring with triangles to one point."""
        (tip,) = self.add([point])
        for k in range(len(ring)):
            self.faces.append((ring[k], ring[(k + 1) % len(ring)], tip))

    def cut(self, ring):
        """Makes a ring a seam."""
        self.seams.update(zip(ring, ring[1:] + ring[:1]))

    def harden(self, ring):
        """Makes a ring a hard edge."""
        self.sharp.update(zip(ring, ring[1:] + ring[:1]))


class Part:
    """A surface: points (n x 3), faces, marked edges, material, colours (n x 3), the joint it hangs on.

    Parts without a `joint` have smooth `weights` (n x joints).
    """

    def __init__(self, mesh, material, colour, joint=None):
        self.points = np.array([v.co for v in mesh.vertices])
        self.normals = np.array([v.normal for v in mesh.vertices])
        self.faces = [tuple(p.vertices) for p in mesh.polygons]
        self.seams = {tuple(sorted(e.vertices)) for e in mesh.edges if e.use_seam}
        self.sharp = {tuple(sorted(e.vertices)) for e in mesh.edges if e.use_edge_sharp}
        self.material, self.joint = material, joint
        self.colours = np.tile(np.array(colour, float), (len(self.points), 1))
        self.weights = None
        self.shape = None  # the points of the part's morph target

    def displace(self, offset):
        """Moves points along their normals; `offset` is one number per point."""
        self.points = self.points + self.normals * np.asarray(offset)[:, None]

    def mirrored(self):
        """The same part on the other side of the plane x = 0."""
        other = object.__new__(Part)
        other.__dict__.update(self.__dict__)
        flip = np.array([-1.0, 1.0, 1.0])
        other.points, other.normals = self.points * flip, self.normals * flip
        other.faces = [f[::-1] for f in self.faces]
        if self.joint:
            other.joint = self.joint.replace(".L", ".R")
        return other


def mesh_from(name, points, faces, seams=(), sharp=()):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([tuple(p) for p in points], [], faces)
    seams = {tuple(sorted(e)) for e in seams}
    sharp = {tuple(sorted(e)) for e in sharp}
    for edge in mesh.edges:
        ends = tuple(sorted(edge.vertices))
        edge.use_seam = ends in seams
        edge.use_edge_sharp = ends in sharp
        edge.crease = 1.0 if ends in sharp else 0.0
    mesh.validate()
    return mesh


def subdivide(cage, levels, material, colour, joint=None):
    """Turns a cage into a part by Catmull-Clark subdivision, faces outwards."""
    mesh = mesh_from("cage", cage.points, cage.faces, cage.seams, cage.sharp)
    bm = bmesh.new()
    bm.from_mesh(mesh)
    bmesh.ops.recalc_face_normals(bm, faces=bm.faces)
    bm.to_mesh(mesh)
    bm.free()
    body = bpy.data.objects.new("cage", mesh)
    bpy.context.collection.objects.link(body)
    if levels:
        modifier = body.modifiers.new("subdivision", "SUBSURF")
        modifier.levels, modifier.use_limit_surface, modifier.boundary_smooth = levels, False, "ALL"
    evaluated = body.evaluated_get(bpy.context.evaluated_depsgraph_get())
    part = Part(evaluated.to_mesh(), material, colour, joint)
    bpy.data.objects.remove(body)
    bpy.data.meshes.remove(mesh)
    return part


def cast(distance, origins, directions, reach):
    """The outermost points where rays meet the surface distance = 0, walking inwards from `reach`.

    distance: (n x 3) -> (n), a lower bound of the true distance up to a factor; origins, directions: n x 3.
    """
    travel = np.full(len(origins), float(reach))
    for _ in range(160):
        travel = np.maximum(travel - 0.6 * distance(origins + directions * travel[:, None]), 0.0)
    return origins + directions * travel[:, None]


def ellipsoid(points, centre, radii):
    q = (points - np.array(centre)) / np.array(radii)
    r = np.linalg.norm(q, axis=1)
    return (r - 1.0) * r / np.maximum(np.linalg.norm(q / np.array(radii), axis=1), 1e-9)


def capsule(points, a, b, radius_a, radius_b=None):
    a, b = np.array(a, float), np.array(b, float)
    radius_b = radius_a if radius_b is None else radius_b
    t = np.clip((points - a) @ (b - a) / max((b - a) @ (b - a), 1e-12), 0.0, 1.0)
    return np.linalg.norm(points - a - t[:, None] * (b - a), axis=1) - (radius_a + t * (radius_b - radius_a))


def blend(a, b, width):
    """The union of two distances with a fillet of about `width`."""
    h = np.clip(0.5 + 0.5 * (b - a) / width, 0.0, 1.0)
    return b + (a - b) * h - width * h * (1.0 - h)


def carve(a, b, width):
    """a without b, with a fillet of about `width`."""
    return -blend(-a, b, width)


def bump(x, centre, width):
    """A bell of height 1."""
    return np.exp(-(((x - centre) / width) ** 2))


def ramp(x, a, b):
    """0 at a, 1 at b, smooth between and beyond."""
    t = np.clip((x - a) / (b - a), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def rough(points, scale, seed):
    """Smooth noise in about -1..1 at each point; `seed` moves the pattern."""
    shift = Vector((17.3 * seed, -9.1 * seed, 4.7 * seed))
    return np.array([noise.noise(Vector(p) * scale + shift) for p in points])


def spline(keys, values, at):
    """A Catmull-Rom curve through (keys, values), keys ascending; values n or n x m."""
    keys, values = np.asarray(keys, float), np.asarray(values, float)
    at = np.clip(np.atleast_1d(np.asarray(at, float)), keys[0], keys[-1])
    slopes = np.gradient(values, keys, axis=0)
    i = np.clip(np.searchsorted(keys, at, side="right") - 1, 0, len(keys) - 2)
    h = keys[i + 1] - keys[i]
    t = (at - keys[i]) / h
    if values.ndim > 1:
        t, h = t[:, None], h[:, None]
    return (
        (1 + 2 * t) * (1 - t) ** 2 * values[i]
        + t * (1 - t) ** 2 * h * slopes[i]
        + t * t * (3 - 2 * t) * values[i + 1]
        - t * t * (1 - t) * h * slopes[i + 1]
    )
