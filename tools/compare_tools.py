#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Measures skinlod against the simplifiers that people use, at equal triangle counts and with one evaluator,
`skinlod evaluate`, and prints Markdown: every cell, who wins where, and a summary.

Installs gltfpack and glTF-Transform from npm at pinned versions, outside the tree; uses Blender where it is there
(Debian's packages blender and python3-numpy). A tool that is not there is said so, or is an error with --require.

All tools get the same GLB: the source itself, or, where that is no GLB or has nodes without names (joints are matched
by name), the level 0 that skinlod writes, with names added. A tool is given the ratio that makes the count; its error
cap is raised until the count is within 2 %, and only then its last resort tried. What never comes that near is shown
with the closest count, and counts nowhere. Range-of-motion poses are ones that skinlod did not solve for; some clip
frames may lie near those that it did.

Before anything counts, the measurement is measured: the original against itself, and the source through each tool
without simplifying, must be next to no error; a level of skinlod passed off as a much finer one must be found out.

Exits with 1 where that fails or a tool that is there cannot be used, 2 for a wrong command line, 4 for what cannot
be read, written or run.
"""
import argparse
import concurrent.futures
import csv
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

from characters import CLIPS, ROOT

PINNED = {"gltfpack": "1.3.0", "@gltf-transform/cli": "4.5.1"}
CHARACTERS = ["humanoid.glb", "cesium_man/CesiumMan.gltf", "mannequiny/mannequiny.glb",
              "rocketbox_female/Female_Adult_01_facial.fbx"]
BAND = 0.02        # of the target: how near a count must be
STEPS = 7          # of each bisection
ITSELF = 1e-6      # % of the diagonal: the largest error of the original against itself
UNTOUCHED = 0.01   # % of the diagonal: of the source through a tool that does not simplify (8-bit weights: 0.002)
FOUND_OUT = 3      # times: how much worse a level must be that is passed off as one ten times finer
# Title, where `skinlod evaluate` has it, digits.
MEASURES = [("rest RMS", ("rest", "rms_percent"), 4), ("clip RMS", ("clips", "rms_percent"), 4),
            ("clip max", ("clips", "max_percent"), 2), ("motion RMS", ("motion", "rms_percent"), 4),
            ("normal RMS", ("normal_degrees", "rms"), 1), ("uv RMS", ("uv", "rms"), 4)]

BLENDER = '''
import sys
import bpy
import numpy

# Blender 3.4's glTF importer says numpy.bool, which the numpy of the same Debian no longer has.
if "bool" not in vars(numpy):
    numpy.bool = bool
source, output, triangles = sys.argv[sys.argv.index("--") + 1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
# The default heuristic turns bones, so that no clip but the re-exported one would fit them.
bpy.ops.import_scene.gltf(filepath=source, bone_heuristic="BLENDER")
meshes = [o for o in bpy.data.objects if o.type == "MESH" and o.vertex_groups]
for o in meshes:
    bpy.context.view_layer.objects.active = o
    if o.data.shape_keys:
        o.shape_key_clear()  # no modifier can be applied to a mesh that has them
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.remove_doubles(threshold=1e-6 * max(o.dimensions))
    bpy.ops.object.mode_set(mode="OBJECT")
ratio = int(triangles) / sum(len(o.data.polygons) for o in meshes)
for o in meshes:
    if ratio < 1:
        bpy.context.view_layer.objects.active = o
        decimate = o.modifiers.new("decimate", "DECIMATE")
        decimate.ratio = ratio
        bpy.ops.object.modifier_move_to_index(modifier="decimate", index=0)  # before the armature
        bpy.ops.object.modifier_apply(modifier="decimate")
bpy.ops.export_scene.gltf(filepath=output, export_format="GLB", export_skins=True, export_animations=True)
'''


class Fault(Exception):
    """file: part: fact: remedy, and the exit code."""

    def __init__(self, code, message):
        super().__init__(message)
        self.code = code


def run(command, what, env=None):
    """Runs a tool; returns its standard output."""
    try:
        done = subprocess.run([str(c) for c in command], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, text=True, timeout=1800, env=env)
    except (OSError, subprocess.TimeoutExpired) as e:
        raise Fault(4, f"{command[0]}: {what}: cannot be run: {e}") from e
    if done.returncode:
        lines = (done.stderr + done.stdout).strip().splitlines() or ["it says nothing"]
        said = next((line for line in lines if re.match(r"\w+Error: ", line)), lines[-1])  # of Python in Blender
        raise Fault(4, f"{command[0]}: {what}: exit {done.returncode}: {said}")
    return done.stdout


# ---- The others

class Gltfpack:
    caps = (0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.15, 0.2, 0.3, 0.5, 0.7, 1)
    last_resort = "-sa"

    def __init__(self, program, *flags):
        self.program, self.flags, self.name = program, flags, " ".join(["gltfpack", *flags])

    def make(self, source, output, triangles, of, cap, last_resort=False):
        # Unquantised, and with all names, attributes and materials: the triangles alone are to differ.
        keep = ["-noq", "-kn", "-km", "-kv", "-ke"]
        if cap is None:
            run([self.program, "-i", source, "-o", output, *keep], self.name)
        else:
            run([self.program, "-i", source, "-o", output, *keep, *self.flags, "-si", f"{triangles / of:.6f}",
                 "-se", cap, *(["-sa"] if last_resort else [])], self.name)


class GltfTransform:
    name = "gltf-transform"
    caps = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1)
    last_resort = None

    def __init__(self, program):
        self.program = program

    def make(self, source, output, triangles, of, cap, last_resort=False):
        # Its manual asks for welding first; simplify alone leaves indexed meshes unwelded.
        welded = output if cap is None else output.with_suffix(".welded.glb")
        run([self.program, "weld", source, welded], self.name)
        if cap is not None:
            run([self.program, "simplify", welded, output, "--ratio", f"{triangles / of:.6f}", "--error", cap],
                self.name)


class Blender:
    name = "Blender Decimate"
    caps = (1,)  # it has none
    last_resort = None

    def __init__(self, program, work):
        self.program, self.script = program, work / "decimate.py"
        self.script.write_text(BLENDER)

    def make(self, source, output, triangles, of, cap, last_resort=False):
        # Debian's Blender takes the first Python of PATH for its own: its neighbour is the one with numpy.
        env = os.environ | {"PATH": f"{pathlib.Path(self.program).parent}{os.pathsep}{os.environ['PATH']}"}
        run([self.program, "-b", "--factory-startup", "--python-exit-code", "9", "--python", self.script, "--",
             source, output, of * 2 if cap is None else round(triangles)], self.name, env)
        if not output.exists():  # a Blender without its glTF add-on says so and exits with 0
            raise Fault(4, f"{self.program}: {self.name}: wrote nothing: does it have its glTF add-on, and numpy?")


def install(folder):
    """The npm packages, at their pinned versions, into `folder`. Returns why not, or nothing."""
    def there(package):
        file = folder / "node_modules" / package / "package.json"
        return file.exists() and json.loads(file.read_text())["version"] == PINNED[package]

    if all(map(there, PINNED)):
        return ""
    npm = shutil.which("npm")
    if not npm:
        return "npm is not there: install Debian's packages nodejs and npm"
    try:
        run([npm, "install", "--prefix", folder, "--no-audit", "--no-fund", "--silent",
             *(f"{package}@{version}" for package, version in PINNED.items())], "install")
    except Fault as e:
        return str(e)
    return "" if all(map(there, PINNED)) else f"npm did not install {PINNED}"


def find_tools(args, work):
    """Returns the tools that are there, what they are, and what is missing: name -> why."""
    tools, versions, missing = [], [], {}
    folder = (args.npm or work / "npm").resolve()
    if why := install(folder):
        missing = {"gltfpack": why, "gltf-transform": why}
    else:
        programs = folder / "node_modules/.bin"
        tools += [Gltfpack(programs / "gltfpack", *f) for f in ((), ("-sv",), ("-sv", "-sp"))]
        tools.append(GltfTransform(programs / "gltf-transform"))
        versions += [f"gltfpack {PINNED['gltfpack']}", f"glTF-Transform {PINNED['@gltf-transform/cli']}"]
    if program := shutil.which(args.blender):
        tools.append(Blender(program, work))
        versions.append(run([program, "-b", "--version"], "version").splitlines()[0])
    else:
        missing["blender"] = f"no command {args.blender}: install Debian's packages blender and python3-numpy"
    for name in args.require:
        if name in missing:
            raise Fault(4, f"{name}: --require: is not there: {missing[name]}")
    return tools, versions, missing


# ---- The common input

def with_names(glb):
    """The GLB with a name for every node that has none, or nothing where all have one."""
    length = struct.unpack_from("<I", glb, 12)[0]
    document = json.loads(glb[20:20 + length])
    nodes = document["nodes"]
    if all(node.get("name") for node in nodes):
        return None
    for i, node in enumerate(nodes):
        node["name"] = node.get("name") or f"node_{i}"
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    rest = glb[20 + length:]
    return struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text) + len(rest), len(text), b"JSON") + text + rest


def common_input(skinlod, file, known, folder):
    """A GLB that every tool can read, and what was done to get it."""
    done = []
    if file.suffix == ".glb":
        glb = file.read_bytes()
    else:
        clips = [word for clip in CLIPS.get(known, []) for word in ("--clips", file.parent / clip)]
        cook(skinlod, [file, *clips, "--lods", "50%"], folder / "level0")
        glb = (folder / "level0/level_lod0.glb").read_bytes()
        done.append("as skinlod's level 0")
    if named := with_names(glb):
        glb = named
        done.append("nodes named")
    path = folder / "source.glb"
    path.write_bytes(glb)
    return path, ", ".join(done) or "as it is"


# ---- Measuring

def cook(skinlod, options, folder):
    folder.mkdir()
    run([skinlod, "cook", *options, "-q", "-o", folder / "level.slod", "--gltf", folder, "--threads", "1"], "cook")


class Case:
    """A character, its levels asked for and the measuring of candidates."""

    def __init__(self, args, known, file, work):
        self.args, self.name = args, (file.parent.name if "/" in known else file.stem)
        self.folder = work / self.name
        self.folder.mkdir()
        self.source, self.note = common_input(args.skinlod, file, known, self.folder)
        self.triangles = self.count(self.source)
        self.targets = [int(self.triangles * share / 100) for share in args.lods]
        cook(args.skinlod, [self.source, "--lods", ",".join(map(str, self.targets))], self.folder / "skinlod")

    def ours(self, k):
        return self.folder / f"skinlod/level_lod{k + 1}.glb"

    def count(self, glb):
        """Triangles; 0 where there is nothing that can be read as a character."""
        try:
            return json.loads(run([self.args.skinlod, "inspect", glb, "--json"], "inspect"))["source"]["triangles"]
        except Fault:
            if glb == self.source:
                raise
            return 0

    def measure(self, glb):
        """The measures by title; a Fault where the evaluator refuses."""
        report = json.loads(run([self.args.skinlod, "evaluate", self.source, glb, "--json", "-q", "--threads", "1",
                                 "--frames", self.args.frames, "--rom", self.args.rom, "--samples",
                                 self.args.samples], "evaluate"))
        if not report["poses"]["clips"] or not report["poses"]["motion"]:
            raise Fault(4, f"{self.name}: poses: there are none, so nothing was measured: give a character with clips")
        level = report["levels"][0]
        return {title: level[kind][what] if level[kind] else None for title, (kind, what), _ in MEASURES}


def off(count, target):
    return abs(math.log(count / target)) if count else math.inf


def reached(count, target):
    return (1 - BAND) * target <= count <= (1 + BAND) * target


def make_level(case, tool, target):
    """The tool's level nearest to `target` triangles: file, count, how."""
    best = {"count": 0, "file": None, "how": "", "off": math.inf}
    folder = case.folder / tool.name.replace(" ", "_") / str(target)
    folder.mkdir(parents=True)
    tries = 0

    def attempt(asked, cap, last_resort=False):
        nonlocal tries
        tries += 1
        output = folder / f"{tries}.glb"
        tool.make(case.source, output, asked, case.triangles, cap, last_resort)
        count = case.count(output)
        if off(count, target) < best["off"]:
            how = (f"cap {cap:.3g}" if len(tool.caps) > 1 else "") + (f", {tool.last_resort}" if last_resort else "")
            best.update(count=count, file=output, how=how, off=off(count, target))
        else:
            output.unlink(missing_ok=True)
        return count

    def bisect(low, high, count_at):
        """Between a value that gives too few triangles and one that gives too many."""
        for _ in range(STEPS):
            middle = math.sqrt(low * high)
            count = count_at(middle)
            if reached(count, target):
                return True
            low, high = (middle, high) if count < target else (low, middle)
        return False

    def down(caps, last_resort):
        too_many = None
        for cap in caps:
            count = attempt(target, cap, last_resort)
            if reached(count, target):
                return True
            if count < target:  # it went past it: ask for more, or allow less error
                return bisect(target, min(4 * target, case.triangles), lambda t: attempt(t, cap, last_resort)) or (
                    too_many and bisect(cap, too_many, lambda c: attempt(target, c, last_resort)))
            too_many = cap
        return False

    if not down(tool.caps, False) and tool.last_resort:
        down(tool.caps[-1:], True)
    return best


def level_row(case, tool, k):
    target = case.targets[k]
    row = {"character": case.name, "level": f"{case.args.lods[k]:g} %", "target": target, "refused": ""}
    if tool is None:
        made = {"count": case.count(case.ours(k)), "file": case.ours(k), "how": ""}
    else:
        try:
            made = make_level(case, tool, target)
        except Fault as e:
            made = {"count": 0, "file": None, "how": ""}
            row["refused"] = str(e).replace(str(case.folder) + os.sep, "").split(": ", 1)[-1]
    row |= {"tool": tool.name if tool else "skinlod", "triangles": made["count"], "how": made["how"],
            "reached": reached(made["count"], target), "errors": {}}
    if made["count"]:
        try:
            row["errors"] = case.measure(made["file"])
        except Fault as e:
            if tool is None:
                raise
            row["refused"] = str(e).split(".glb: ")[-1]
    return row


# ---- The measurement measured

def control(case, tool):
    """Returns (what, figures, whether it holds)."""
    try:
        if tool is None:
            errors = case.measure(case.source)
            return "original against itself", f"clip RMS {errors['clip RMS']:.1g} %", all(
                errors[m] <= ITSELF for m in ("rest RMS", "clip RMS", "motion RMS", "clip max"))
        if tool == "wrong":
            fine, coarse = case.measure(case.ours(0)), case.measure(case.ours(len(case.targets) - 1))
            worse = {m: coarse[m] / fine[m] for m in ("clip RMS", "motion RMS")}
            counted = case.count(case.ours(len(case.targets) - 1))
            enough = min(FOUND_OUT, math.sqrt(case.targets[0] / case.targets[-1]))
            return ("the coarsest level passed off as the finest", f"{worse['clip RMS']:.0f} times the clip RMS, "
                    f"{counted:,} triangles for {case.targets[0]:,}",
                    min(worse.values()) >= enough and not reached(counted, case.targets[0]))
        output = case.folder / f"{tool.name}_untouched.glb".replace(" ", "_")
        tool.make(case.source, output, case.triangles, case.triangles, None)
        errors = case.measure(output)
        return (f"through {tool.name}, not simplified", f"clip RMS {errors['clip RMS']:.4f} %, normals "
                f"{errors['normal RMS']:.1f}°", max(errors["clip RMS"], errors["motion RMS"]) <= UNTOUCHED)
    except Fault as e:
        return getattr(tool, "name", tool or "itself"), str(e).replace(str(case.folder) + os.sep, ""), False


# ---- What is printed

def number(value, digits):
    return "-" if value is None else f"{value:.{digits}f}"


def ratio(row, ours, title):
    a, b = row["errors"].get(title), ours["errors"].get(title)
    return a / b if a and b else None


def mean(ratios):
    return math.exp(sum(map(math.log, ratios)) / len(ratios)) if ratios else None


def summary(rows):
    """Per tool: cells reached, the geometric means of its errors over skinlod's, and the cells it wins."""
    ours = {(r["character"], r["level"]): r for r in rows if r["tool"] == "skinlod"}
    result = []
    for tool in dict.fromkeys(r["tool"] for r in rows if r["tool"] != "skinlod"):
        cells = [r for r in rows if r["tool"] == tool]
        good = [r for r in cells if r["reached"] and r["errors"]]
        entry = {"tool": tool, "cells": len(cells), "reached": len(good), "ratio": {}, "won": {}}
        for title, _, _ in MEASURES:
            ratios = [(r, x) for r in good if (x := ratio(r, ours[r["character"], r["level"]], title))]
            entry["ratio"][title] = mean([x for _, x in ratios])
            entry["won"][title] = [f"{r['character']} {r['level']}" for r, x in ratios if x < 1]
        result.append(entry)
    return result


def markdown(result):
    lines = ["Tools: " + ", ".join(result["tools"]) + ".", ""]
    lines += [f"**NOT MEASURED: {name}: {why}**" for name, why in result["missing"].items()]
    lines += ["", "Inputs: " + "; ".join(f"{c['name']}, {c['triangles']:,} triangles, {c['input']}"
                                         for c in result["characters"]) + ".", "",
              "| the measurement measured | | | |", "|---|---|---|---|"]
    lines += [f"| {c['character']} | {c['what']} | {c['figures']} | {'holds' if c['holds'] else '**FAILED**'} |"
              for c in result["controls"]]
    titles = [m[0] for m in MEASURES]
    lines += ["", "Errors in % of the rest diagonal, normals in degrees, uvs in their unit. In italics: not "
              f"within {BAND:.0%} of the target. In bold: lower than skinlod's.", "",
              "| character | level | tool | triangles | " + " | ".join(titles) + " | clip RMS / skinlod's | how |",
              "|---|---|---|---:|" + "---:|" * len(titles) + "---:|---|"]
    ours = {(r["character"], r["level"]): r for r in result["rows"] if r["tool"] == "skinlod"}
    for r in result["rows"]:
        mine = ours[r["character"], r["level"]]
        cells = []
        for title, _, digits in MEASURES:
            text, x = number(r["errors"].get(title), digits), ratio(r, mine, title)
            cells.append(text if r is mine or not x else f"*{text}*" if not r["reached"] else
                         f"**{text}**" if x < 1 else text)
        x = ratio(r, mine, "clip RMS")
        how = [r["how"]] if r["how"] else []
        if not r["reached"]:
            how.append(f"target {r['target']:,} missed" if r["triangles"] else
                       "no level" if r["refused"] else "only empty scenes")
        how += [f"**{r['refused']}**"] if r["refused"] else []
        lines.append(f"| {r['character']} | {r['level']} | {r['tool']} | {r['triangles']:,} | " + " | ".join(cells) +
                     f" | {'' if r is mine else number(x, 2) if r['reached'] else '-'} | {'; '.join(how)} |")
    lines += ["", "Geometric mean of a tool's error over skinlod's, in the cells where it reached the target; in "
              "brackets, in how many of them it is lower.", "",
              "| tool | cells reached | " + " | ".join(titles) + " |", "|---|---:|" + "---:|" * len(titles)]
    for s in result["summary"]:
        lines.append(f"| {s['tool']} | {s['reached']} of {s['cells']} | " + " | ".join(
            f"{number(s['ratio'][t], 2)} ({len(s['won'][t])})" for t in titles) + " |")
    for s in result["summary"]:
        for t in titles:
            if s["won"][t]:
                lines.append(f"\n{s['tool']} is lower in {t}: {', '.join(s['won'][t])}.")
    return "\n".join(lines)


def write_csv(file, rows):
    try:
        with open(file, "w", newline="", encoding="utf-8") as out:
            table = csv.writer(out)
            keys = ["character", "level", "tool", "target", "triangles", "reached", "how", "refused"]
            table.writerow(keys + [m[0] for m in MEASURES])
            table.writerows([r[k] for k in keys] + [r["errors"].get(m[0]) for m in MEASURES] for r in rows)
    except OSError as e:
        raise Fault(4, f"{file}: cannot be written: {e.strerror}: check the path and its permissions") from e


def shares(text):
    try:
        found = [float(word.rstrip("%")) for word in text.split(",")]
    except ValueError:
        found = []
    if len(found) < 2 or any(not 0 < x < 100 for x in found) or sorted(found, reverse=True) != found:
        raise argparse.ArgumentTypeError(f"{text}: not two or more shares, fine to coarse: such as 50%,25%")
    return found


def positive(text):
    if not text.isdigit() or not int(text):
        raise argparse.ArgumentTypeError(f"{text}: not a number above 0")
    return int(text)


def compare(args):
    if not args.skinlod.exists():
        raise Fault(4, f"{args.skinlod}: --skinlod: no such file: build skinlod, or say where it is")
    if args.csv and not args.csv.absolute().parent.is_dir():  # said now, not after a quarter of an hour
        raise Fault(4, f"{args.csv}: --csv: no such folder: make it first")
    roots = [ROOT / "content", args.characters]
    files = {known: file for known in CHARACTERS if args.only in known for root in roots
             if (file := root / known).is_file()}
    absent = [known for known in CHARACTERS if args.only in known and known not in files]
    if not files:
        raise Fault(2, f"--only: {args.only}: none of {', '.join(CHARACTERS)} that is there: give another")
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        work = pathlib.Path(folder)
        tools, versions, missing = find_tools(args, work)
        missing |= {known: f"not in {args.characters.name}/" for known in absent}
        for name, why in missing.items():
            print(f"compare_tools: NOT MEASURED: {name}: {why}", file=sys.stderr)
        if not tools:
            raise Fault(4, "tools: none of the others is there: install npm or Blender")
        cases = list(pool.map(lambda item: Case(args, *item, work), files.items()))
        controls = [(case, pool.submit(control, case, tool)) for case in cases for tool in (
            None, "wrong", *(t for t in tools if t.name != "gltfpack -sv" and t.name != "gltfpack -sv -sp"))]
        futures = [pool.submit(level_row, case, tool, k) for case in cases for k in range(len(case.targets))
                   for tool in (None, *tools)]
        controls = [dict(zip(("character", "what", "figures", "holds"), (case.name, *future.result())))
                    for case, future in controls]
        for c in controls:
            if not c["holds"]:
                print(f"compare_tools: {c['character']}: {c['what']}: {c['figures']}: the comparison does not hold",
                      file=sys.stderr)
        rows = [future.result() for future in futures]
        names = [{"name": case.name, "triangles": case.triangles, "input": case.note} for case in cases]
    result = {"tools": versions, "missing": missing, "characters": names, "controls": controls, "rows": rows,
              "summary": summary(rows)}
    if args.csv:
        write_csv(args.csv, rows)
    print(json.dumps(result, indent=2) if args.json else markdown(result))
    return 0 if all(c["holds"] for c in controls) else 1


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--skinlod", type=pathlib.Path, default=ROOT / "build/skinlod",
                        help="the program (default: %(default)s)")
    parser.add_argument("--characters", type=pathlib.Path, default=ROOT.parent / "shared/characters",
                        help="the folder of other people's characters (default: %(default)s)")
    parser.add_argument("--only", default="", help="only characters with this in their name")
    parser.add_argument("--lods", type=shares, default="50%,25%,10%,5%", help="default: %(default)s")
    parser.add_argument("--npm", type=pathlib.Path,
                        help="a folder to keep the npm packages in (default: a temporary one)")
    parser.add_argument("--blender", default="blender", help="the command (default: %(default)s)")
    parser.add_argument("--require", action="append", default=[], choices=["gltfpack", "gltf-transform", "blender"],
                        help="fail where this is not there; may be repeated")
    parser.add_argument("--frames", type=positive, default=20, help="of the clips (default: %(default)s)")
    parser.add_argument("--rom", type=positive, default=8, help="range-of-motion poses (default: %(default)s)")
    parser.add_argument("--samples", type=positive, default=20000,
                        help="on each surface in each pose (default: %(default)s)")
    parser.add_argument("--jobs", type=positive, default=os.cpu_count(), help="at a time (default: %(default)s)")
    parser.add_argument("--csv", type=pathlib.Path, metavar="FILE", help="also the rows as CSV")
    parser.add_argument("--json", action="store_true", help="all of it as JSON, in place of the tables")
    args = parser.parse_args()
    try:
        return compare(args)
    except Fault as e:
        print(f"compare_tools: {e}", file=sys.stderr)
        return e.code
    except OSError as e:
        print(f"compare_tools: {e.filename}: {e.strerror}: check the path and its permissions", file=sys.stderr)
        return 4


if __name__ == "__main__":
    sys.exit(main())
