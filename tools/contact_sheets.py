#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Cooks every character it finds and draws a contact sheet of each: a column for the source and for each level, a row
for each of three bent poses, as FOLDER/NAME.png. Exits with 1 where a cook or a drawing fails.

With --errors also FOLDER/NAME_error.png, coloured by the distance between the level and the source, for the
characters and levels that are farthest from their source in clip frames that were not used for solving.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

from characters import ROOT, characters, default_roots


def run(command):
    """What went wrong, or nothing."""
    done = subprocess.run([str(word) for word in command], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    return "" if done.returncode in (0, 1) else f"exit {done.returncode}: {done.stderr.strip()[-300:]}"


def errors(report):
    """(RMS in % of the diagonal, level) of every level that was measured."""
    found = json.loads(report.read_text())["levels"]
    return [((level["error"]["unseen_clip"] or level["error"]["unseen_motion"])["rms_percent"], level["lod"])
            for level in found if level["lod"] > 0]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("roots", nargs="*", type=pathlib.Path,
                        help="folders of characters (default: content/, and ../shared/characters if it is there)")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build",
                        help="where skinlod and skinlod_sheet are (default: %(default)s)")
    parser.add_argument("-o", "--output", type=pathlib.Path, default=ROOT / "build/sheets", metavar="FOLDER",
                        help="default: %(default)s")
    parser.add_argument("--only", default="", help="only characters with this in their name")
    parser.add_argument("--errors", type=int, default=0, metavar="COUNT",
                        help="how many characters to draw with their distances too, the worst first")
    parser.add_argument("--sheet", nargs=argparse.REMAINDER, default=[], help="what follows goes to skinlod_sheet")
    args = parser.parse_args()

    args.output.mkdir(parents=True, exist_ok=True)
    faults, worst = [], []
    found = [c for c in characters(args.roots or default_roots()) if args.only in c[0]]
    with tempfile.TemporaryDirectory() as folder:
        for name, (source, *clips) in found:
            file = name.replace("/", "_")
            slod, report = pathlib.Path(folder, file + ".slod"), pathlib.Path(folder, file + ".json")
            draw = [args.build / "skinlod_sheet", slod, "--source", source, *clips, *args.sheet]
            fault = (run([args.build / "skinlod", "cook", source, *clips, "-o", slod, "--report", report])
                     or run([*draw, "-o", args.output / f"{file}.png"]))
            print(f"{name}: {fault or args.output / f'{file}.png'}", flush=True)
            faults += [name] if fault else []
            if not fault:
                worst.append((*max(errors(report)), name, draw, args.output / f"{file}_error.png"))
        for error, lod, name, draw, png in sorted(worst, reverse=True)[:args.errors]:
            fault = run([*draw, "--error", "-o", png])
            print(f"{name}: LOD{lod} is at {error:.3f} %: {fault or png}", flush=True)
            faults += [name] if fault else []
    return 0 if found and not faults else 1


if __name__ == "__main__":
    sys.exit(main())
