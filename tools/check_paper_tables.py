#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Gives paper_tables.py measurements made here, good and broken, and demands the right pages or the right refusal.

Measures nothing itself, so it takes seconds. Prints a line per check; exits with 1 where anything is not as it
must be.
"""
import csv
import json
import math
import pathlib
import re
import struct
import subprocess
import sys
import tempfile
import zlib

from paper_tables import COMPARED, FRAME, MEASURED_COLUMN, ROOT, WAYS
import shaded

FILES = {"docs/paper.md", "docs/table1.svg", "docs/figure2.svg", "docs/figure5_block.svg", "table1.csv",
         "figure2.csv", "figure4.csv", "figure5.csv"}
SECONDS = dict(zip(COMPARED, (2, 4, 9, 10, 12)))


def block():
    """A box of 1 x 4 x 1 as points and 12 faces that look outwards."""
    points = [[x, y, z] for x in (0, 1) for y in (0, 4) for z in (0, 1)]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return points, [list(f) for a, b, c, d in quads for f in ((a, b, c), (a, c, d))]


def measurements():
    """One model in every part: Mohr-Gleicher takes 2 s, ours 10 s; every error is 0.1 but DeCoro's, 0.3."""
    def line(part, method, **more):
        return {"bench": "papers", "part": part, "model": "block", "paper_model": "Square Column",
                "source_triangles": 114688, "poses": 4, "method": method, "triangles": 70, **more}

    points, faces = block()
    rows = [line("table1", m, examples=4, pieces=1, cpu_seconds=SECONDS[m]) for m in COMPARED]
    rows += [line("figure2", m, cap=cap, examples=4, source_influences=4, most_influences=cap or 7,
                  mean_influences=2.5, rms_percent=0.1, max_percent=0.5) for m, caps in WAYS.items() for cap in caps]
    for m in ["original", *COMPARED]:
        errors = {} if m == "original" else {key: 0.3 if m == "pose_independent" else 0.1 for key in MEASURED_COLUMN}
        rows.append(line("figure4", m, pose="bent", example=False, points=points, faces=faces, **errors))
    rows += [line("figure5", m, examples=4, frame=k, clip="walk 'n' run", seconds=k / 30, example=k == 0,
                  rms_percent=0.3 if m == "pose_independent" else 0.1) for m in [*COMPARED, FRAME] for k in range(3)]
    return rows


class Checks:
    def __init__(self, folder):
        self.folder, self.count, self.faults = folder, 0, 0

    def check(self, truth, what):
        self.count += 1
        self.faults += not truth
        print(f"{'ok    ' if truth else 'FAILED'}  {what}", flush=True)

    def run(self, *options):
        return subprocess.run([sys.executable, ROOT / "tools/paper_tables.py", *map(str, options)],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def pages(self, rows):
        """What is made of the rows, and where."""
        self.folder.mkdir(exist_ok=True)
        given, out = self.folder / "given.jsonl", self.folder / f"out{self.count}"
        given.write_text("".join((row if isinstance(row, str) else json.dumps(row)) + "\n" for row in rows))
        return self.run("--measurements", given, "--output", out), out

    def refused(self, rows, words, what):
        done, out = self.pages(rows)
        told = all(word in done.stderr for word in words) and "Traceback" not in done.stderr
        self.check(done.returncode == 3 and told and not done.stdout and not out.exists(),
                   f"{what}: exit 3, '{done.stderr.strip()[-160:]}'")


def brightest_and_darkest(png):
    """Of the pixels' first channel, and the size: by another way than shaded.py wrote them."""
    width, height = struct.unpack(">II", png[16:24])
    data, at = b"", 8
    while at < len(png):
        size, kind = struct.unpack(">I4s", png[at:at + 8])
        data += png[at + 8:at + 8 + size] if kind == b"IDAT" else b""
        at += 12 + size
    raw = zlib.decompress(data)
    assert len(raw) == height * (1 + 3 * width)
    red = [raw[y * (1 + 3 * width) + 1 + 3 * x] for y in range(height) for x in range(width)]
    return max(red), min(red), (width, height), sum(value < 255 for value in red) / len(red)


def check_pages(checks):
    rows = measurements()
    done, out = checks.pages(rows)
    checks.check(done.returncode == 0 and not done.stderr, f"good measurements: exit 0 {done.stderr[-300:]}")
    if done.returncode:
        return
    made = {f.relative_to(out).as_posix() for f in out.rglob("*") if f.is_file()}
    pictures = {f"docs/figure4_{name}_{m}.png" for name in ("column", "detail") for m in ["original", *COMPARED]}
    checks.check(made == FILES | pictures, "every page, table, plot and picture is there and nothing else")
    text = (out / "docs/paper.md").read_text()
    links = set(re.findall(r"\]\(([^)]+)\)", text))
    checks.check({"docs/" + link for link in links} == {f for f in made if f.endswith((".svg", ".png"))},
                 "the page shows every picture, and no other")
    # The paper: 2.221 / 1.927, 19.580 / 1.927 and 19.580 / 2.221.
    checks.check("| block | 1.15 / 2.00 | 10.2 / 5.00 | 8.82 / 2.50 | 4.50 | 2.25 | 6.00 | 3.00 |" in text,
                 "table 1 has the paper's ratios beside those measured")
    checks.check("nothing stands in for Centipede, Cheb, Lion and Human" in text, "what is absent is told")
    checks.check("**DeCoro–Rusinkiewicz** has 3.00 times the mean RMS of ours" in text
                 and "washboarding that the paper sees in DeCoro–Rusinkiewicz is there:" in text,
                 "the paragraphs say what the numbers do")
    with (out / "table1.csv").open() as file:
        first = next(csv.DictReader(file))
    checks.check(first["method"] == "endpoint" and float(first["cpu_seconds"]) == 2 and
                 math.isclose(float(first["paper_times_decoro"]), 1.927 / 2.221), "table1.csv has the same numbers")

    again, twin = checks.pages(rows)
    checks.check(again.returncode == 0 and all((out / f).read_bytes() == (twin / f).read_bytes() for f in made),
                 "the same measurements make the same bytes")

    for row in rows:  # ours is quick, and the others are near
        if row["part"] == "table1":
            row["cpu_seconds"], row["triangles"] = 10 - SECONDS[row["method"]] / 2, 90
        if row["part"] in ("figure4", "figure5") and row["method"] == "pose_independent":
            row |= {key: 0.09 for key in row if key == "rms_percent" or key in MEASURED_COLUMN}
    done, out = checks.pages(rows)
    text = (out / "docs/paper.md").read_text() if done.returncode == 0 else done.stderr
    checks.check("longest of the three for no model" in text and "**block stops at 90 triangles**" in text
                 and "Ours is the higher one for block" in text and "DeCoro–Rusinkiewicz is not there." in text,
                 "other numbers are told in other words")


def check_refusals(checks):
    rows = measurements()

    def without(wanted):
        return [row for row in rows if not wanted(row)]

    def with_one(part, **fields):
        changed = json.loads(json.dumps(rows))
        next(row for row in changed if row["part"] == part and row["method"] != "original").update(fields)
        return changed

    checks.refused([], ["table1", "is missing"], "no measurements")
    for part in ("table1", "figure2", "figure4", "figure5"):
        checks.refused(without(lambda row: row["part"] == part), [part, "is missing"], f"no {part}")
    checks.refused(without(lambda row: row["part"] == "table1" and row["method"] == "endpoint"), ["table1", "block"],
                   "a method is missing")
    checks.refused(without(lambda row: row["part"] == "figure5" and row["method"] == FRAME and row["frame"] == 1),
                   ["figure5", "block"], "a frame is missing")
    checks.refused(without(lambda row: row["part"] == "figure4" and row["method"] == "original"), ["figure4"],
                   "the original column is missing")
    checks.refused([*rows, rows[0]], ["table1", "block"], "a line stands there twice")
    cut = [*rows[:3], json.dumps(rows[3])[:50]]
    checks.refused(cut, ["given.jsonl:4", "no JSON"], "cut off in a line")
    checks.refused([{"bench": "quality"}], ["given.jsonl:1"], "lines of another command")
    checks.refused(with_one("table1", cpu_seconds=None), ["given.jsonl:1", "cpu_seconds"], "no number")
    checks.refused(with_one("table1", cpu_seconds=float("nan")), ["cpu_seconds"], "not a number")
    checks.refused(with_one("table1", cpu_seconds=0), ["took no time"], "no time")
    checks.refused(with_one("table1", paper_model="Bunny"), ["stands for no model"],
                   "a model that the paper has not")
    checks.refused(with_one("figure4", faces=[[0, 1, 8]]), ["figure4", "no surface"], "a face without its point")
    examples_alone = [row | {"example": True} if row["part"] == "figure5" else row for row in rows]
    checks.refused(examples_alone, ["figure5", "every frame is an example"], "no frame but examples")

    done = checks.run("--measurements", checks.folder / "none.jsonl", "--output", checks.folder / "none")
    checks.check(done.returncode == 4 and "none.jsonl" in done.stderr, "measurements that are not there: exit 4")
    done = checks.run("--bench", checks.folder / "none", "--output", checks.folder / "none")
    checks.check(done.returncode == 4 and "skinlod_bench" in done.stderr, "a bench that is not there: exit 4")
    done = checks.run("--bench", "false", "--output", checks.folder / "none")
    left = list((checks.folder / "none").iterdir())
    checks.check(done.returncode == 3 and "exit code 1" in done.stderr and not left,
                 "a bench that fails: exit 3, nothing left")


def check_pictures(checks):
    points, faces = block()
    view = shaded.View(towards=(1, 1, 1), light=(0, 1, 0))
    frame = shaded.frame_of(view.seen(points), 0.1)
    high, low, size, covered = brightest_and_darkest(shaded.picture(view, points, faces, frame, 60, False))
    checks.check(size[1] == 60 and high == 255 and low == 47 and 0.3 < covered < 0.9,
                 "a picture of a block shows its sides, lit by their normals, on white")
    high, low, _, _ = brightest_and_darkest(shaded.picture(view, points, faces, frame, 60, True))
    checks.check(high == 255 and low < 47, "with edges they are darker than the sides")
    inside_out = [face[::-1] for face in faces[2:4] + faces[6:8] + faces[10:]]
    _, _, _, covered = brightest_and_darkest(shaded.picture(view, points, inside_out, frame, 60, False))
    checks.check(covered == 0, "what is turned away is not seen")


def main():
    with tempfile.TemporaryDirectory() as folder:
        checks = Checks(pathlib.Path(folder))
        check_pages(checks)
        check_refusals(checks)
        check_pictures(checks)
    print(f"{checks.count} checks, {checks.faults} failed")
    return 0 if checks.count and not checks.faults else 1


if __name__ == "__main__":
    sys.exit(main())
