#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Gives skinlod bad input of every kind and demands the documented exit code, a message that names the file or
option, the fact and the remedy, nothing on standard output, and the file that was there before untouched.

Prints a table; exits with 1 where anything is not as it must be. The inputs are made here.
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

ROOT = pathlib.Path(__file__).resolve().parent.parent
EARLIER = b"what an earlier cook left"


# ---- Inputs

def glb(lie=lambda document: None):
    """A bending tube on two joints, 2,048 triangles. `lie` may change the document."""
    around, rings = 32, 33
    points, weights, faces = b"", b"", b""
    for r in range(rings):
        for a in range(around):
            angle, bend = 2 * math.pi * a / around, r / (rings - 1)
            points += struct.pack("<3f", math.cos(angle), 4 * bend, math.sin(angle))
            weights += struct.pack("<4f", 1 - bend, bend, 0, 0)
    for r in range(rings - 1):
        for a in range(around):
            b, c, d = (a + 1) % around, a + around, (a + 1) % around + around
            faces += struct.pack("<6H", *(r * around + i for i in (a, c, b, b, c, d)))
    count = around * rings
    streams = [points, bytes((0, 1, 0, 0)) * count, weights, faces]
    kinds = [(5126, "VEC3", count), (5121, "VEC4", count), (5126, "VEC4", count), (5123, "SCALAR", len(faces) // 2)]
    views = [{"buffer": 0, "byteOffset": sum(map(len, streams[:i])), "byteLength": len(s)}
             for i, s in enumerate(streams)]
    accessors = [{"bufferView": i, "componentType": c, "type": t, "count": n} for i, (c, t, n) in enumerate(kinds)]
    accessors[0] |= {"min": [-1, 0, -1], "max": [1, 4, 1]}
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"name": "tube", "mesh": 0, "skin": 0}, {"name": "root", "children": [2]},
                  {"name": "tip", "translation": [0, 2, 0]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2}, "indices": 3}]}],
        "skins": [{"joints": [1, 2]}], "accessors": accessors, "bufferViews": views,
        "buffers": [{"byteLength": sum(map(len, streams))}]}
    lie(document)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    binary = b"".join(streams)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def past_its_buffer(document):
    document["accessors"][0]["count"] *= 1000


OBJ = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"

FBX_WITHOUT_SKIN = b"""; FBX 7.4.0 project file
FBXHeaderExtension:  {
  FBXHeaderVersion: 1003
  FBXVersion: 7400
}
Objects:  {
  Geometry: 1, "Geometry::plate", "Mesh" {
    Vertices: *9 {
      a: 0,0,0,1,0,0,0,1,0
    }
    PolygonVertexIndex: *3 {
      a: 0,1,-3
    }
    GeometryVersion: 124
  }
  Model: 2, "Model::plate", "Mesh" {
    Version: 232
  }
}
Connections:  {
  C: "OO",1,2
  C: "OO",2,0
}
"""

# Each of the next three makes Assimp 5.2 crash: a mesh that ends inside its triangles, and nodes nested so
# deep that the reader runs out of stack.
MD5 = b"""MD5Version 10
commandline ""
numJoints 1
numMeshes 1
joints {
 "origin" -1 ( 0 0 0 ) ( 0 0 0 )
}
mesh {
 shader "s"
 numverts 3
 vert 0 ( 0 0 ) 0 1
 vert 1 ( 1 0 ) 1 1
 vert 2 ( 0 1 ) 2 1
 numtris 1
"""


def nested_x():
    return b"xof 0303txt 0032\n" + b"Frame a {\n" * 100000 + b"}\n" * 100000


def nested_b3d():
    node = b"n\0" + struct.pack("<10f", 0, 0, 0, 1, 1, 1, 1, 0, 0, 0)
    depth = 60000
    sizes = [len(node) * (n + 1) + 8 * n for n in range(depth)]
    nodes = b"".join(b"NODE" + struct.pack("<i", size) + node for size in reversed(sizes))
    return b"BB3D" + struct.pack("<ii", 4 + len(nodes), 1) + nodes


# ---- Trials

class Trial:
    """Runs skinlod on inputs in a folder of its own, where out/out.slod is there before, and judges it."""

    def __init__(self, skinlod, scratch):
        self.skinlod, self.scratch, self.failed, self.count = skinlod, scratch, 0, 0
        self.out = scratch / "out"
        self.out.mkdir(mode=0o777)

    def file(self, name, content):
        path = self.scratch / name
        path.write_bytes(content)
        return path

    def run(self, what, args, exit_code, names, says, out=None, locked=False, stdout=subprocess.PIPE):
        out = out or self.out / "out.slod"
        if out.parent.is_dir() and str(out) != "-":
            out.write_bytes(EARLIER)
        before = sorted(p.name for p in out.parent.iterdir()) if out.parent.is_dir() else []
        if locked:
            out.parent.chmod(0o555)
        done = subprocess.run([self.skinlod, "cook", *args, *([] if "-o" in args else ["-o", out])],
                              stdin=subprocess.DEVNULL, stdout=stdout, stderr=subprocess.PIPE, timeout=120,
                              user=65534 if locked and os.getuid() == 0 else None)  # root may write anywhere
        if locked:
            out.parent.chmod(0o755)
        message = done.stderr.decode(errors="replace").strip()
        line = message.splitlines()[-1] if message else ""
        wrong = []
        if done.returncode != exit_code:
            wrong.append(f"exit {done.returncode}, not {exit_code}")
        if names not in line:
            wrong.append(f"does not name {names}")
        if not re.search(says, line, re.IGNORECASE):
            wrong.append(f"does not say {says}")
        if exit_code and not re.match(r"skinlod: .+: .+: .+", line):
            wrong.append("has no three parts: file, fact, remedy")
        if exit_code and done.stdout:
            wrong.append("prints results")
        if exit_code and out.parent.is_dir():
            if out.read_bytes() != EARLIER:
                wrong.append("the earlier output is changed")
            if sorted(p.name for p in out.parent.iterdir()) != before:
                wrong.append("leaves files behind")
        if not exit_code and out.read_bytes()[:4] != b"SLOD":
            wrong.append("wrote no .slod")
        self.count += 1
        self.failed += bool(wrong)
        shown = line.replace(str(self.scratch) + "/", "").replace("|", "\\|")[:150]
        print(f"| {what} | {done.returncode} | {shown} | {'**' + '; '.join(wrong) + '**' if wrong else 'as it must be'} |",
              flush=True)


def small_disk(folder):
    """Mounts a file system of 8 KiB there. False where that is not permitted."""
    folder.mkdir()
    return subprocess.run(["mount", "-t", "tmpfs", "-o", "size=8k", "skinlod-check", folder],
                          stderr=subprocess.DEVNULL).returncode == 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--skinlod", type=pathlib.Path, default=ROOT / "build/skinlod",
                        help="the program (default: %(default)s)")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        scratch = pathlib.Path(folder)
        scratch.chmod(0o755)  # for the trial that runs as somebody else
        trial = Trial(shutil.copy(args.skinlod, scratch), scratch)
        good = trial.file("good.glb", glb())
        print("| input | exit | message | verdict |\n|---|---:|---|---|")
        trial.run("a good file, to prove these trials", [good], 0, "", "")
        trial.run("no such file", [scratch / "gone.glb"], 4, "gone.glb", "no such file|not there|does not exist")
        (scratch / "folder.glb").mkdir()
        trial.run("a directory", [scratch / "folder.glb"], 4, "folder.glb", "directory|folder")
        trial.run("an empty file", [trial.file("empty.glb", b"")], 3, "empty.glb", "empty")
        for part in (8, 15, 500, len(glb()) // 2, len(glb()) - 1):
            trial.run(f"a GLB cut after {part} bytes", [trial.file("cut.glb", glb()[:part])], 3, "cut.glb", ":")
        trial.run("a GLB whose accessor runs past its buffer",
                  [trial.file("lies.glb", glb(past_its_buffer))], 3, "lies.glb", "accessor|buffer|file of this size")
        trial.run("an OBJ, which has no skeleton", [trial.file("plate.obj", OBJ)], 3, "plate.obj", "skin|skelet|joint")
        trial.run("an FBX without a skin", [trial.file("plate.fbx", FBX_WITHOUT_SKIN)], 3, "plate.fbx",
                  "skin|skelet|joint")
        trial.run("an MD5 that crashes Assimp", [trial.file("cut.md5mesh", MD5)], 3, "cut.md5mesh", ":")
        trial.run("an X that crashes Assimp", [trial.file("deep.x", nested_x())], 3, "deep.x", ":")
        trial.run("a B3D that crashes Assimp", [trial.file("deep.b3d", nested_b3d())], 3, "deep.b3d", ":")
        trial.run("an unknown option", [good, "--lod", "50%"], 2, "--lod", "option")
        trial.run("--lods 0%", [good, "--lods", "0%"], 2, "--lods", "0")
        locked = scratch / "locked"
        locked.mkdir()
        trial.run("a folder that cannot be written", [good], 4, "out.slod", "permission denied|cannot",
                  out=locked / "out.slod", locked=True)
        trial.run("an output below a file", [good], 4, "out.slod", "no folder",
                  out=good / "out.slod")
        with open("/dev/full", "wb") as full:
            trial.run("standard output on a full disk", [good, "-o", "-"], 75, "standard output", "space|full",
                      stdout=full)
        disk = scratch / "disk"
        if small_disk(disk):
            try:
                trial.run("a full disk", [good], 75, "out.slod", "space|full", out=disk / "out.slod")
            finally:
                subprocess.run(["umount", disk], check=True)
        else:
            print("| a full disk | | **NOT RUN: mounting a small file system is not permitted here** | |")
        print(f"\n{trial.count} trials, {trial.failed} failed.")
    return 1 if trial.failed else 0


if __name__ == "__main__":
    sys.exit(main())
