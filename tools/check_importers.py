#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Gives skinlod one character in every format that Blender, Assimp or we can write, and demands the same geometry and
the same motion, to within 1e-4 of the diagonal: the largest distance between the two surfaces at rest, in frames of
the original's clips and in range-of-motion poses, and between the points of every joint under the clips of both.
Prints a table; exits with 1 where anything is not as it must be, 4 where a tool is missing or cannot be run.

FBX in centimetres with Z up, FBX in metres with Y up and Collada come from Blender (Debian's packages blender and
python3-numpy: tools/install.sh importers), more from assimp (assimp-utils); X and Ogre's XML from writers below, for
nothing in Debian writes them with a skin. The humanoid goes through all of them, a shared character through Blender's.

Before anything counts the measurement is measured: the character against itself must be the same, and one that is a
thousandth larger, one with a moved joint and one whose clip turns another joint must be found out.
"""
import argparse
import json
import math
import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile

from characters import ROOT
from small_glb import Glb, changed, multiplied, transform
from small_writers import write_ogre, write_x

SAME = 0.01  # % of the diagonal
PER_JOINT = 8  # points that are followed under the clips
SHARED = ROOT.parent / "shared/characters/fox/Fox.glb"

# A pose bone keeps the axes of its joint only under this heuristic. Frames fall on the keys, so that nothing is
# resampled; Collada's exporter writes the active action, over the scene's frames, and no other.
BLENDER = '''
import sys
import bpy
import numpy

# Blender 3.4's glTF importer says numpy.bool, which the numpy of the same Debian no longer has.
if "bool" not in vars(numpy):
    numpy.bool = bool
source, folder, frames_per_second = sys.argv[sys.argv.index("--") + 1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.fps = int(frames_per_second)
bpy.ops.import_scene.gltf(filepath=source, bone_heuristic="BLENDER")
armature = next(o for o in bpy.data.objects if o.type == "ARMATURE")
action = armature.animation_data.action
scene.frame_start, scene.frame_end = (round(f) for f in action.frame_range)

# Bones that a clip has no keys for would stay where the active action left them.
def rest():
    armature.animation_data.action = None
    for bone in armature.pose.bones:
        bone.matrix_basis.identity()

rest()
fbx = {"add_leaf_bones": False, "bake_anim_simplify_factor": 0, "bake_anim_use_all_bones": True,
       "bake_anim_use_nla_strips": False, "mesh_smooth_type": "OFF"}
bpy.ops.export_scene.fbx(filepath=folder + "/cm_z_up.fbx", apply_scale_options="FBX_SCALE_NONE", axis_up="Z",
                         axis_forward="Y", **fbx)
bpy.ops.export_scene.fbx(filepath=folder + "/m_y_up.fbx", apply_scale_options="FBX_SCALE_UNITS", axis_up="Y",
                         axis_forward="-Z", **fbx)
armature.animation_data.action = action
bpy.ops.wm.collada_export(filepath=folder + "/blender.dae", include_animations=True, sort_by_name=True,
                           keep_flat_curves=True)  # else a bone that keeps still away from its rest is lost
print("ACTIVE " + action.name)
'''


def run(command, what, env=None):
    """Runs a tool to its end; returns its standard output."""
    try:
        done = subprocess.run([str(c) for c in command], stdin=subprocess.DEVNULL, capture_output=True, text=True,
                              timeout=900, env=env)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise RuntimeError(f"{what}: cannot be run: {error}") from error
    if done.returncode:
        said = (done.stderr + done.stdout).strip().splitlines() or ["it says nothing"]
        raise RuntimeError(f"{what}: exit {done.returncode}: {said[-1]}")
    return done.stdout


def blender_variants(source, folder, frames_per_second):
    """Writes them; returns the name of the clip that the Collada file has."""
    script = folder / "variants.py"
    script.write_text(BLENDER)
    # Debian's Blender wants Debian's Python, also where another stands before it.
    told = run(["blender", "-b", "--factory-startup", "--python-exit-code", "1", "-P", script, "--", source, folder,
                frames_per_second], f"blender: {source.name}", dict(os.environ, PATH="/usr/bin:/bin"))
    return next(line.split(" ", 1)[1] for line in told.splitlines() if line.startswith("ACTIVE "))


class Check:
    """One character, against which its variants are held."""

    def __init__(self, skinlod, source, folder):
        self.skinlod, self.source, self.folder, self.wrong = skinlod, source, folder, 0
        self.original = self.imported(source, "original")
        told = json.loads(run([skinlod, "inspect", source, "--json"], source.name))
        self.diagonal = told["source"]["diagonal_metres"]
        self.points = self.original.points_of_joints(PER_JOINT)
        print(f"\n{source.stem}\n\n| variant | rest | clips | motion | its own clips | verdict |")
        print("|---|---:|---:|---:|---:|---|", flush=True)

    def imported(self, path, name):
        """What skinlod made of it: the level 0 that it writes."""
        run([self.skinlod, "cook", path, "-o", self.folder / f"{name}.slod", "--gltf", self.folder / "levels",
             "--lods", "50%", "--poses", 1, "--rom", 0, "--metric", "rest_pose", "--quiet"], path.name)
        return Glb(self.folder / "levels" / f"{name}_lod0.glb")

    def surfaces(self, variant):
        """The largest distance in % of the diagonal at rest, in clips and in motion, under the original's clips."""
        told = json.loads(run([self.skinlod, "evaluate", self.source, variant, "--frames", 8, "--rom", 4,
                               "--samples", 5000, "--json", "--quiet"], variant.name))
        level = told["levels"][0]
        if level["triangles"] != told["triangles"]:
            raise RuntimeError(f"has {level['triangles']} triangles and not {told['triangles']}")
        return [level[poses]["max_percent"] for poses in ("rest", "clips", "motion")]

    def clips(self, variant, only=None):
        """The largest distance between points of joints under clips of one name, at the original's keys."""
        theirs = {name.split("|")[-1]: tracks for name, tracks in variant.clips().items()}
        worst = 0
        for name, tracks in self.original.clips().items():
            if only and name != only:
                continue
            its = [clip for clip in theirs if clip == name or clip.startswith(name + "_")]
            if only and not its:
                its = list(theirs)  # Collada's exporter names the one clip after the object
            if len(its) != 1:
                raise RuntimeError(f"of clip {name} it has {len(its)}: its clips are {', '.join(theirs)}")
            for time in tracks.key_times(8):
                ours, other = self.original.palette(tracks, time), variant.palette(theirs[its[0]], time)
                for joint, points in self.points.items():
                    if joint not in other:
                        raise RuntimeError(f"has no joint {joint}")
                    apart = (math.dist(transform(ours[joint], x), transform(other[joint], x)) for x in points)
                    worst = max(worst, *apart)
        return 100 * worst / self.diagonal

    def hold(self, title, variant, same=True, only=None, lost=None):
        """Measures one variant, and counts it as wrong where it is not the same and must be, or the other way round;
        unless `lost` shows in the file itself that its exporter left something out."""
        numbers = []
        try:
            numbers = self.surfaces(variant)
            numbers.append(self.clips(self.imported(variant, variant.stem), only))
            is_same = max(numbers) <= SAME
            verdict = "the same" if is_same else "differs"
        except RuntimeError as error:
            is_same, verdict = False, str(error)
        if is_same != same:
            if proof := lost and lost(variant):
                verdict = f"lost by the exporter: {proof}"
            else:
                self.wrong += 1
                verdict = f"**{verdict}**"
        elif not same:
            verdict += ", as it must"
        cells = [f"{x:.2g} %" for x in numbers] + ["-"] * (4 - len(numbers))
        print(f"| {title} | {' | '.join(cells)} | {verdict} |", flush=True)


# ---- What Assimp's exporters leave out, as the files show; nothing where they do not

def weights_missing(glb):
    read = Glb(glb)
    short = [w for _, _, a, _ in read.primitives() for w in map(sum, read.rows(a["WEIGHTS_0"])) if abs(w - 1) > 1e-3]
    return short and f"weights of {len(short)} vertices do not sum to 1 but, for one, to {short[0]:.3f}"


def sources_missing(dae):
    text = dae.read_text()
    ids = set(re.findall(r'\bid="([^"]*)"', text))
    missing = [name for name in re.findall(r'\bsource="#([^"]*)"', text) if name not in ids]
    return missing and f"{len(missing)} of its sources are not there, '{missing[0]}' for one"


def skin_missing(x):
    return "SkinWeights" not in x.read_text() and "it holds no SkinWeights"


def unreadable(fbx):
    told = subprocess.run(["assimp", "info", fbx], capture_output=True, text=True)
    said = re.search("ERROR: (.*)", told.stdout + told.stderr)
    return told.returncode != 0 and said and f"Assimp cannot read it itself: {said[1]}"


ASSIMP = (("glTF (Assimp)", "assimp.glb", "glb2", weights_missing),
          ("Collada (Assimp)", "assimp.dae", "collada", sources_missing),
          ("FBX (Assimp)", "assimp.fbx", "fbx", unreadable), ("X (Assimp)", "assimp.x", "x", skin_missing))


def check_measurement(check, folder):
    check.hold("itself", check.source)
    controls = {"a thousandth larger": changed(check.source, folder / "larger.glb", multiplied(1.001)),
                "with a moved joint": changed(check.source, folder / "moved.glb", with_moved_joint),
                "with a clip on the wrong joint": changed(check.source, folder / "turned.glb", with_turned_joint)}
    for title, variant in controls.items():
        check.hold(title, variant, same=False)


def with_moved_joint(document, binary):
    """By a hundredth of its distance from the origin, or of a metre, in its bind."""
    skin = document["skins"][0]
    accessor = document["accessors"][skin["inverseBindMatrices"]]
    view = document["bufferViews"][accessor["bufferView"]]
    at = view.get("byteOffset", 0) + accessor.get("byteOffset", 0) + 64 * (len(skin["joints"]) // 2) + 4 * 12
    x, y, z = struct.unpack_from("<3f", binary, at)
    struct.pack_into("<f", binary, at, x + 0.01 * max(abs(x), abs(y), abs(z), 1))


def with_turned_joint(document, _):
    """Two joints have each other's turns."""
    turns = [c["target"] for c in document["animations"][0]["channels"] if c["target"]["path"] == "rotation"]
    turns[0]["node"], turns[1]["node"] = turns[1]["node"], turns[0]["node"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--skinlod", type=pathlib.Path, default=ROOT / "build/skinlod",
                        help="the program (default: %(default)s)")
    parser.add_argument("--keep", type=pathlib.Path, help="a folder that the variants are left in")
    args = parser.parse_args()
    for program, remedy in (("blender", "tools/install.sh importers installs it"), (args.skinlod, "build it"),
                            ("assimp", "tools/install.sh importers installs it")):
        if not shutil.which(program):
            print(f"{program}: is not there: {remedy}", file=sys.stderr)
            return 4
    wrong = 0
    with tempfile.TemporaryDirectory() as scratch:
        for source, frames_per_second in ((ROOT / "content/humanoid.glb", 20), (SHARED, 120)):
            if not source.exists():
                print(f"\n{source.stem}: is not on this machine: passed over")
                continue
            folder = (args.keep or pathlib.Path(scratch)) / source.stem
            folder.mkdir(parents=True, exist_ok=True)
            try:
                active = blender_variants(source, folder, frames_per_second)
                check = Check(args.skinlod, source, folder)
            except RuntimeError as error:
                print(error, file=sys.stderr)
                return 4
            check_measurement(check, folder)
            check.hold("FBX in centimetres, Z up (Blender)", folder / "cm_z_up.fbx")
            check.hold("FBX in metres, Y up (Blender)", folder / "m_y_up.fbx")
            clip = next(name for name in check.original.clips() if active.startswith(name))
            check.hold("Collada (Blender)", folder / "blender.dae", only=clip)
            if source != SHARED:
                glb = Glb(source)
                check.hold("X (ours)", write_x(glb, folder / "ours.x"))
                check.hold("Ogre XML (ours)", write_ogre(glb, folder / "ours.mesh.xml"))
                for title, name, kind, lost in ASSIMP:
                    run(["assimp", "export", source, folder / name, f"-f{kind}"], name)
                    check.hold(title, folder / name, lost=lost)
            wrong += check.wrong
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
