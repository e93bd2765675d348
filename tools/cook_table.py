#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Cooks every character it finds with both metrics and prints what came of it, as a Markdown table.

Errors are posed surface distances in percent of the rest pose's diagonal, articulated / rest_pose, over clip
frames and range-of-motion poses that were not used for solving. Exits with 1 where a cook fails or leaves a
level out without stating a reason, or where --at-least is not met.
"""
import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import time

from characters import AGAIN, DEFORMING, ROOT, characters, default_roots

class Cook:
    """One run of `skinlod cook` and its report; `fault` says what went wrong, or nothing."""

    def __init__(self, args, options, metric):
        with tempfile.TemporaryDirectory() as folder:
            report, out = pathlib.Path(folder, "report.json"), pathlib.Path(folder, "out.slod")
            command = [args.skinlod, "cook", *options, "-o", out, "--report", report, "--metric", metric,
                       "--lods", args.lods, *(["--threads", str(args.threads)] if args.threads else [])]
            start = time.monotonic()
            done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
            self.seconds = time.monotonic() - start
            self.report = json.loads(report.read_text()) if report.exists() else None
        self.fault = ""
        if done.returncode not in (0, 1) or not self.report:
            self.fault = f"{metric}: exit {done.returncode}: {done.stderr.strip()[-300:]}"
            return
        self.levels = [level for level in self.report["levels"] if level["lod"] > 0]
        if len(self.levels) != len(args.lods.split(",")):
            self.fault = f"{metric}: {len(self.levels)} levels"
        for level in self.levels:
            if level["reached"] != (level["triangles"] <= level["asked_triangles"]):
                self.fault = f"{metric}: LOD{level['lod']} is said to be reached, or not, and is not so"
            if not level["reached"] and not level["reason"]:
                self.fault = f"{metric}: LOD{level['lod']} is too large without a reason"

    def error(self, k, poses, what):
        error = self.levels[k]["error"][poses]
        return error[what + "_percent"] if error else None


def pair(a, b):
    return "-" if a is None else f"{a:.3f} / {b:.3f}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("roots", nargs="*", type=pathlib.Path,
                        help="folders of characters (default: content/, and ../shared/characters if it is there)")
    parser.add_argument("--skinlod", default=ROOT / "build/skinlod", help="the program (default: %(default)s)")
    parser.add_argument("--lods", default="50%,25%,10%,5%", help="default: %(default)s")
    parser.add_argument("--threads", type=int, default=0, help="default: as skinlod does")
    parser.add_argument("--only", default="", help="only characters with this in their name")
    parser.add_argument("--at-least", type=float, default=0, metavar="RATIO",
                        help="fail unless articulated is better at every level of the characters named, and by "
                             "this ratio of RMS on unseen clip frames as their geometric mean")
    args = parser.parse_args()

    print("| character | level | triangles asked | got | influences | clip RMS | clip max | motion RMS "
          "| motion max | seconds | bytes |")
    print("|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|")
    faults, unreached, ratios = [], [], {}
    found = [c for c in characters(args.roots or default_roots()) if args.only in c[0]]
    for name, options in found:
        a, b = (Cook(args, options, metric) for metric in ("articulated", "rest_pose"))
        if a.fault or b.fault:
            faults.append(f"{name}: {a.fault or b.fault}")
            print(f"| {name} | **failed** |", flush=True)
            continue
        source = a.report["source"]
        print(f"| {name} | source | | {source['triangles']} | {source['max_influences']} | | | | "
              f"| {a.seconds:.1f} / {b.seconds:.1f} | {a.report['bytes']} / {b.report['bytes']} |")
        for k, level in enumerate(a.levels):
            errors = [pair(a.error(k, poses, what), b.error(k, poses, what))
                      for poses in ("unseen_clip", "unseen_motion") for what in ("rms", "max")]
            print(f"| | {level['target']} | {level['asked_triangles']} "
                  f"| {level['triangles']} / {b.levels[k]['triangles']} | {level['max_influences']} "
                  f"| {' | '.join(errors)} | | {level['bytes']} / {b.levels[k]['bytes']} |", flush=True)
            for metric, cook in (("articulated", a), ("rest_pose", b)):
                if not cook.levels[k]["reached"]:
                    unreached.append(f"{name}, {level['target']}, {metric}: {cook.levels[k]['reason']}")
            if name in DEFORMING and name not in AGAIN and (ours := a.error(k, "unseen_clip", "rms")):
                ratios[name, level["target"]] = b.error(k, "unseen_clip", "rms") / ours

    for title, lines in (("Targets not reached", unreached), ("Failed", faults)):
        if lines:
            print(f"\n{title}:\n" + "\n".join(f"- {line}" for line in lines))
    print(f"\n{len(found)} characters, {len(faults)} failed.")
    good = bool(found) and not faults
    if ratios:
        mean = math.exp(sum(map(math.log, ratios.values())) / len(ratios))
        worse = [f"{name} {level}" for (name, level), ratio in ratios.items() if ratio <= 1]
        print(f"rest_pose / articulated, RMS on unseen clip frames, geometric mean over {len(ratios)} levels of "
              f"{len({name for name, _ in ratios})} deforming characters: {mean:.2f}; articulated is lower at "
              f"{len(ratios) - len(worse)} of them{': not at ' + ', '.join(worse) if worse else ''}.")
        good = good and (not args.at_least or (mean >= args.at_least and not worse))
    elif args.at_least:
        good = False
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
