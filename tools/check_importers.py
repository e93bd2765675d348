#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Gives skinlod one character in every format that Blender, Assimp or we can write, and demands the same geometry and
the same motion: the largest distance between the posed surfaces, and between the joints in every clip, must be within
1e-4 of the diagonal. Prints a table; exits with 1 where anything is not as it must be.

Run by hand: it takes some minutes, and Debian's packages blender, python3-numpy and assimp-utils.

FBX and Collada come from Blender's exporters, X from Assimp's, Ogre's XML from a writer below, for nothing in Debian
writes it. Before anything counts the measurement is measured: the character against itself must be next to no error,
and one a thousandth larger, and one with a turned joint, must be found out.
"""
import argparse
import json
import math
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
SAME = 0.01  # % of the diagonal

BLENDER = '''
import sys
import bpy
import numpy

# Blender 3.4's glTF importer says numpy.bool, which the numpy of the same Debian no longer has.
if "bool" not in vars(numpy):
    numpy.bool = bool
source, folder = sys.argv[sys.argv.index("--") + 1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
# The default heuristic turns bones, so that no joint would be what it was.
bpy.ops.import_scene.gltf(filepath=source, bone_heuristic="BLENDER")
fbx = {"add_leaf_bones": False, "bake_anim_simplify_factor": 0, "bake_anim_use_all_bones": True,
       "bake_anim_use_nla_strips": False, "mesh_smooth_type": "OFF"}
bpy.ops.export_scene.fbx(filepath=folder + "/cm_z_up.fbx", apply_scale_options="FBX_SCALE_NONE", axis_up="Z",
                         axis_forward="Y", **fbx)
bpy.ops.export_scene.fbx(filepath=folder + "/m_y_up.fbx", apply_scale_options="FBX_SCALE_UNITS", axis_up="Y",
                         axis_forward="-Z", **fbx)
bpy.ops.wm.collada_export(filepath=folder + "/collada.dae", include_animations=True, sort_by_name=True)
'''


# ---- glTF, as much of it as our own characters have

class Glb:
    SIZES = {5121: ("B", 1), 5123: ("H", 2), 5125: ("I", 4), 5126: ("f", 4)}
    COUNTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}

    def __init__(self, path):
        data = pathlib.Path(path).read_bytes()
        size = struct.unpack_from("<I", data, 12)[0]
        self.json = json.loads(data[20:20 + size])
        self.binary = data[28 + size:]
        self.nodes = self.json["nodes"]
        self.parent = [-1] * len(self.nodes)
        for n, node in enumerate(self.nodes):
            for child in node.get("children", []):
                self.parent[child] = n

    def rows(self, accessor):
        accessor = self.json["accessors"][accessor]
        width = self.COUNTS[accessor["type"]]
        if "bufferView" not in accessor:
            return [(0.0,) * width] * accessor["count"]
        view = self.json["bufferViews"][accessor["bufferView"]]
        code, size = self.SIZES[accessor["componentType"]]
        begin = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        stride = view.get("byteStride", size * width)
        scale = {5121: 255, 5123: 65535}.get(accessor["componentType"], 1) if accessor.get("normalized") else 1
        rows = [struct.unpack_from(f"<{width}{code}", self.binary, begin + i * stride) for i in range(accessor["count"])]
        return rows if scale == 1 else [tuple(x / scale for x in row) for row in rows]

    def tracks(self, animation):
        """(node, path) to key times and values."""
        out = {}
        for channel in animation["channels"]:
            sampler = animation["samplers"][channel["sampler"]]
            values = self.rows(sampler["output"])
            if sampler.get("interpolation") == "CUBICSPLINE":
                values = values[1::3]
            times = [t for (t,) in self.rows(sampler["input"])]
            out[channel["target"]["node"], channel["target"]["path"]] = times, values
        return out

    def rest(self, n):
        node = self.nodes[n]
        if "matrix" in node:
            m = node["matrix"]
            return [[m[4 * c + r] for c in range(4)] for r in range(3)]
        return trs(node.get("translation", (0, 0, 0)), node.get("rotation", (0, 0, 0, 1)), node.get("scale", (1, 1, 1)))

    def joints_at(self, tracks, time):
        """Name to the global matrix of each joint's node in a clip."""
        known = {}

        def matrix(n):
            if n < 0:
                return IDENTITY
            if n not in known:
                node = self.nodes[n]
                keyed = [p for p in ("translation", "rotation", "scale") if (n, p) in tracks]
                local = self.rest(n)
                if keyed:
                    local = trs(*(sampled(tracks[n, p], time) if (n, p) in tracks else node.get(p, other) for p, other in
                                  (("translation", (0, 0, 0)), ("rotation", (0, 0, 0, 1)), ("scale", (1, 1, 1)))))
                known[n] = times(matrix(self.parent[n]), local)
            return known[n]

        return {self.nodes[n].get("name"): matrix(n) for skin in self.json["skins"] for n in skin["joints"]}


IDENTITY = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]


def times(a, b):
    return [[sum(a[r][k] * b[k][c] for k in range(3)) + (a[r][3] if c == 3 else 0) for c in range(4)] for r in range(3)]


def trs(t, q, s):
    length = math.sqrt(sum(x * x for x in q)) or 1
    x, y, z, w = (v / length for v in q)
    r = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
         [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
         [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    return [[r[i][j] * s[j] for j in range(3)] + [t[i]] for i in range(3)]


def sampled(track, time):
    keys, values = track
    if time <= keys[0] or len(keys) == 1:
        return values[0]
    k = next((i for i, t in enumerate(keys) if t >= time), None)
    if k is None:
        return values[-1]
    share = (time - keys[k - 1]) / (keys[k] - keys[k - 1])
    a, b = values[k - 1], values[k]
    if len(a) == 4 and sum(p * q for p, q in zip(a, b)) < 0:
        b = tuple(-x for x in b)  # the short way; keys are so near that a chord is an arc
    return tuple(p + share * (q - p) for p, q in zip(a, b))


# ---- Variants

def quaternion_product(a, b):
    (x, y, z, w), (p, q, r, s) = a, b
    return (w * p + x * s + y * r - z * q, w * q - x * r + y * s + z * p, w * r + x * q - y * p + z * s,
            w * s - x * p - y * q - z * r)


def turned(q, v):
    inverse = (-q[0], -q[1], -q[2], q[3])
    return quaternion_product(quaternion_product(q, (*v, 0)), inverse)[:3]


def xyz(tag, v):
    return f'<{tag} x="{v[0]:.9g}" y="{v[1]:.9g}" z="{v[2]:.9g}"/>'


def angle_axis(tag, q):
    length = math.sqrt(sum(x * x for x in q[:3]))
    axis = tuple(x / length for x in q[:3]) if length else (1, 0, 0)
    return f'<{tag} angle="{2 * math.atan2(length, q[3]):.9g}">{xyz("axis", axis)}</{tag}>'


def write_ogre(source, folder):
    """Ogre's XML of a character whose joints stand in the rest pose as they are bound."""
    skin = source.json["skins"][0]
    bone = {n: i for i, n in enumerate(skin["joints"])}
    bones, hierarchy, submeshes, animations = [], [], [], []
    for n, i in bone.items():
        node = source.nodes[n]
        bones.append(f'<bone id="{i}" name="{node["name"]}">{xyz("position", node.get("translation", (0, 0, 0)))}'
                     f'{angle_axis("rotation", node.get("rotation", (0, 0, 0, 1)))}</bone>')
        if source.parent[n] in bone:
            hierarchy.append(f'<boneparent bone="{node["name"]}" parent="{source.nodes[source.parent[n]]["name"]}"/>')
    for animation in source.json.get("animations", []):
        tracks = source.tracks(animation)
        end = max(t[-1] for t, _ in tracks.values())
        xml = []
        for n in bone:
            keys = sorted({t for p in ("translation", "rotation") if (n, p) in tracks for t in tracks[n, p][0]})
            if not keys:
                continue
            at, by = source.nodes[n].get("translation", (0, 0, 0)), source.nodes[n].get("rotation", (0, 0, 0, 1))
            back = (-by[0], -by[1], -by[2], by[3])
            frames = ""
            for time in keys:
                to = sampled(tracks[n, "translation"], time) if (n, "translation") in tracks else at
                turn = sampled(tracks[n, "rotation"], time) if (n, "rotation") in tracks else by
                frames += (f'<keyframe time="{time:.9g}">{xyz("translate", tuple(a - b for a, b in zip(to, at)))}'
                           f'{angle_axis("rotate", quaternion_product(back, turn))}</keyframe>')
            xml.append(f'<track bone="{source.nodes[n]["name"]}"><keyframes>{frames}</keyframes></track>')
        animations.append(f'<animation name="{animation["name"]}" length="{end:.9g}"><tracks>{"".join(xml)}</tracks></animation>')
    for mesh in source.json["meshes"]:
        for primitive in mesh["primitives"]:
            a = primitive["attributes"]
            points, normals = source.rows(a["POSITION"]), source.rows(a["NORMAL"])
            vertices = "".join(f'<vertex>{xyz("position", p)}{xyz("normal", n)}</vertex>' for p, n in zip(points, normals))
            corners = [i for (i,) in source.rows(primitive["indices"])]
            faces = "".join(f'<face v1="{x}" v2="{y}" v3="{z}"/>' for x, y, z in zip(*[iter(corners)] * 3))
            weights = "".join(
                f'<vertexboneassignment vertexindex="{v}" boneindex="{j}" weight="{w:.9g}"/>'
                for v, (js, ws) in enumerate(zip(source.rows(a["JOINTS_0"]), source.rows(a["WEIGHTS_0"])))
                for j, w in zip(js, ws) if w > 0)
            submeshes.append(
                f'<submesh material="m" usesharedvertices="false" use32bitindexes="true" operationtype="triangle_list">'
                f'<faces count="{len(corners) // 3}">{faces}</faces><geometry vertexcount="{len(points)}">'
                f'<vertexbuffer positions="true" normals="true">{vertices}</vertexbuffer></geometry>'
                f'<boneassignments>{weights}</boneassignments></submesh>')
    (folder / "ogre.mesh.xml").write_text(
        f'<mesh><submeshes>{"".join(submeshes)}</submeshes><skeletonlink name="ogre.skeleton"/></mesh>')
    (folder / "ogre.skeleton.xml").write_text(
        f'<skeleton><bones>{"".join(bones)}</bones><bonehierarchy>{"".join(hierarchy)}</bonehierarchy>'
        f'<animations>{"".join(animations)}</animations></skeleton>')


def changed_glb(source, path, change):
    """The character with something changed in its JSON, or in the bytes of its positions."""
    data = bytearray(pathlib.Path(source).read_bytes())
    size = struct.unpack_from("<I", data, 12)[0]
    document = json.loads(data[20:20 + size])
    binary = bytearray(data[28 + size:])
    change(document, binary)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    path.write_bytes(struct.pack("<4sIII4s", b"glTF", 2, 28 + len(text) + len(binary), len(text), b"JSON") + text +
                     struct.pack("<I4s", len(binary), b"BIN\0") + binary)


def larger(document, binary):
    for mesh in document["meshes"]:
        for primitive in mesh["primitives"]:
            accessor = document["accessors"][primitive["attributes"]["POSITION"]]
            view = document["bufferViews"][accessor["bufferView"]]
            begin = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
            stride = view.get("byteStride", 12)
            for i in range(accessor["count"]):
                at = begin + i * stride
                struct.pack_into("<3f", binary, at, *(1.001 * x for x in struct.unpack_from("<3f", binary, at)))


def with_turned_joint(document, binary):
    joint = document["skins"][0]["joints"][-1]
    for animation in document["animations"]:
        for channel in animation["channels"]:
            if channel["target"] == {"node": joint, "path": "rotation"}:
                channel["target"]["node"] = document["skins"][0]["joints"][0]


# ---- Measuring

class Check:
    def __init__(self, skinlod, source, scratch):
        self.skinlod, self.source, self.scratch, self.failed = skinlod, source, scratch, 0
        self.levels = scratch / "levels"
        self.original = self.cooked(source)
        print("| variant | rest max | clips max | its clips max | joints max | verdict |\n|---|---:|---:|---:|---:|---|")

    def run(self, *args):
        done = subprocess.run([self.skinlod, *map(str, args)], capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(done.stderr.strip().splitlines()[-1] if done.stderr.strip() else f"exit {done.returncode}")
        return done.stdout

    def cooked(self, variant):
        """The path of the variant's level 0 as GLB."""
        self.run("cook", variant, "-o", self.scratch / "cooked.slod", "--gltf", self.levels, "--lods", "50%", "--poses", 1,
                 "--rom", 0, "--refine", 0, "--quiet")
        return self.levels / (variant.name.split(".")[0] + "_lod0.glb")

    def distances(self, original, candidate):
        report = json.loads(self.run("evaluate", original, candidate, "--rom", 0, "--frames", 12, "--json", "--quiet"))
        level = report["candidates"][0]["levels"][0]
        return level["rest"]["max_percent"], level["clips"]["max_percent"]

    def joints(self, variant):
        """The largest distance, in % of the diagonal, between joints of one name at one time of one clip, and between
        points a tenth of the diagonal from them."""
        ours, theirs = Glb(self.original), Glb(variant)
        diagonal = json.loads(self.run("inspect", self.original, "--json"))["diagonal"]
        worst = 0
        clips = {a["name"].split("|")[-1]: a for a in theirs.json.get("animations", [])}
        for animation in ours.json["animations"]:
            if animation["name"] not in clips:
                raise RuntimeError(f"has no clip {animation['name']}, but {', '.join(clips)}")
            a, b = ours.tracks(animation), theirs.tracks(clips[animation["name"]])
            end = max(t[-1] for t, _ in a.values())
            for time in (end * i / 7 for i in range(8)):
                x, y = ours.joints_at(a, time), theirs.joints_at(b, time)
                for name in x.keys() & y.keys():
                    for axis in ((0, 0, 0), (.1, 0, 0), (0, .1, 0), (0, 0, .1)):
                        worst = max(worst, self.moved_apart(x[name], y[name], [diagonal * c for c in axis]))
                if not x.keys() <= y.keys():
                    raise RuntimeError(f"has no joint {sorted(x.keys() - y.keys())[0]}")
        return 100 * worst / diagonal

    @staticmethod
    def moved_apart(a, b, p):
        return math.dist(*([sum(m[r][c] * p[c] for c in range(3)) + m[r][3] for r in range(3)] for m in (a, b)))

    def measure(self, title, variant, same=True):
        try:
            cooked = self.cooked(variant)
            rest, clips = self.distances(self.original, cooked)
            _, its_clips = self.distances(cooked, self.original)
            joints = self.joints(cooked)
            numbers = [rest, clips, its_clips, joints]
            is_same = max(numbers) <= SAME
            verdict = "the same" if is_same else "differs"
        except RuntimeError as error:
            numbers, is_same, verdict = [], False, str(error)
        wrong = is_same != same
        self.failed += wrong
        cells = " | ".join([f"{x:.2g} %" for x in numbers] or ["-"] * 4)
        print(f"| {title} | {cells} | {'**' if wrong else ''}{verdict}{'**' if wrong else ''} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--skinlod", type=pathlib.Path, default=ROOT / "build/skinlod", help="the program (default: %(default)s)")
    parser.add_argument("--keep", type=pathlib.Path, help="a folder that the variants are left in")
    args = parser.parse_args()
    for tool in ("blender", "assimp"):
        if not shutil.which(tool):
            sys.exit(f"{tool} is not there: apt-get install blender python3-numpy assimp-utils")
    source = ROOT / "content/humanoid.glb"
    with tempfile.TemporaryDirectory() as scratch:
        folder = args.keep or pathlib.Path(scratch) / "variants"
        folder.mkdir(parents=True, exist_ok=True)
        script = pathlib.Path(scratch) / "variants.py"
        script.write_text(BLENDER)
        made = subprocess.run(["blender", "-b", "--factory-startup", "--python-exit-code", "1", "-P", script, "--", source, folder],
                              capture_output=True, text=True)
        if made.returncode:
            sys.exit("Blender made no variants:\n" + made.stdout[-2000:] + made.stderr[-2000:])
        subprocess.run(["assimp", "export", source, folder / "assimp.x"], capture_output=True)
        write_ogre(Glb(source), folder)
        changed_glb(source, folder / "larger.glb", larger)
        changed_glb(source, folder / "turned.glb", with_turned_joint)

        check = Check(args.skinlod, source, pathlib.Path(scratch))
        check.measure("itself", source)
        check.measure("a thousandth larger", folder / "larger.glb", same=False)
        check.measure("with a turned joint", folder / "turned.glb", same=False)
        for title, name in (("FBX in centimetres, Z up (Blender)", "cm_z_up.fbx"), ("FBX in metres, Y up (Blender)", "m_y_up.fbx"),
                            ("Collada (Blender)", "collada.dae"), ("X (Assimp)", "assimp.x"), ("Ogre XML", "ogre.mesh.xml")):
            if (folder / name).is_file():
                check.measure(title, folder / name)
            else:
                print(f"| {title} | - | - | - | - | **was not written** |")
                check.failed += 1
    return 1 if check.failed else 0


if __name__ == "__main__":
    sys.exit(main())
