#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Makes the table and figures of Landreneau and Schaefer, Simplification of Articulated Meshes (2009), again.

Runs `skinlod_bench papers`, or reads what an earlier run left, and writes into --output
    docs/paper.md      the paper's tables beside ours, with plots and pictures, and where they differ and why
    *.csv              every number in them
    measurements.jsonl what the bench printed: --measurements FILE makes the pages again from it
All that the page claims is computed from the numbers. Needs gnuplot. Exit codes are those of skinlod: 3 where
measurements are broken or a part of them is missing, 4 where a file cannot be read or written.
"""
import argparse
import collections
import csv
import io
import itertools
import json
import math
import operator
import pathlib
import shutil
import subprocess
import sys
import tempfile

import shaded

ROOT = pathlib.Path(__file__).resolve().parent.parent
BROKEN, UNREACHABLE = 3, 4  # skinlod's exit codes

MOHR, DECORO, PRINTED, UNCAPPED, OURS, FRAME = (
    "endpoint", "pose_independent", "articulated_printed", "articulated_uncapped", "articulated", "per_frame")
NAMES = {MOHR: "Mohr–Gleicher", DECORO: "DeCoro–Rusinkiewicz", PRINTED: "as printed", UNCAPPED: "ours",
         OURS: "ours, cap 4", FRAME: "each frame alone"}
SHORT = NAMES | {MOHR: "Mohr", DECORO: "DeCoro"}  # as the paper's table has it
COLOURS = {MOHR: "#D55E00", DECORO: "#E69F00", PRINTED: "#56B4E9", UNCAPPED: "#0072B2", OURS: "#009E73",
           FRAME: "#999999"}
COMPARED = [MOHR, DECORO, PRINTED, UNCAPPED, OURS]

# The paper's table 1: polygons, poses, and seconds of Mohr et al., DeCoro et al. and "our method".
PAPER = {"Centipede": (206672, 5, 6.769, 5.180, 22.727), "Cheb": (13334, 27, 2.025, 0.536, 5.806),
         "Lion": (35152, 33, 6.733, 1.704, 13.720), "Square Column": (114688, 4, 1.927, 2.221, 19.580),
         "Human": (240448, 9, 12.066, 6.123, 24.452)}
POLYGONS = 70  # what a hierarchy goes down to

ALIKE = 1.1  # ratios within this of each other are called alike
WASHBOARDS = 1.25  # so many times our angles between normals are called washboarding

# The fields of a line of each part, beside those of every line.
NUMBER = (int, float)
EVERY_LINE = {"model": str, "paper_model": str, "source_triangles": int, "poses": int, "method": str,
              "triangles": int}
FIELDS = {
    "table1": {"examples": int, "pieces": int, "cpu_seconds": NUMBER},
    "figure2": {"cap": int, "examples": int, "source_influences": int, "most_influences": int,
                "mean_influences": NUMBER, "rms_percent": NUMBER, "max_percent": NUMBER},
    "figure4": {"pose": str, "example": bool, "points": list, "faces": list},
    "figure5": {"examples": int, "frame": int, "clip": str, "seconds": NUMBER, "example": bool,
                "rms_percent": NUMBER}}
MEASURED_COLUMN = {key: NUMBER for key in (
    "measured_poses", "rms_percent", "max_percent", "normal_rms_degrees", "normal_mean_degrees",
    "normal_p99_degrees", "normal_beyond_45_percent", "normal_within_45_rms_degrees", "shown_rms_percent",
    "shown_normal_within_45_rms_degrees")}
WAYS = {"articulated_signed": [0, 5], "articulated": [0, 5, 4]}  # figure 2: caps, 0 is none


class Fault(Exception):
    """What is told to the user, and the exit code."""

    def __init__(self, code, message):
        super().__init__(message)
        self.code = code


# ---- Measurements

def measured(args):
    """Runs the bench and returns the file that holds what it printed."""
    path, beside = args.output / "measurements.jsonl", args.output / "measurements.jsonl.part"
    if not shutil.which(args.bench):
        raise Fault(UNREACHABLE, f"{args.bench}: is no program: cmake --build build --target skinlod_bench makes it")
    command = [str(args.bench), "papers", "--runs", str(args.runs),
               *(["--characters", str(args.characters)] if args.characters else [])]
    try:
        args.output.mkdir(parents=True, exist_ok=True)
        with beside.open("w") as out:
            done = subprocess.run(command, stdout=out)
        if done.returncode:
            raise Fault(BROKEN, f"{args.bench}: exit code {done.returncode}: see what it says above")
        beside.replace(path)
    except OSError as error:
        raise Fault(UNREACHABLE, f"{error.filename}: {error.strerror}") from error
    finally:
        beside.unlink(missing_ok=True)
    return path


def checked(line, where):
    """The line of the bench as a dictionary, with all that its part must have."""
    try:
        row = json.loads(line)
    except ValueError as error:
        raise Fault(BROKEN, f"{where}: no JSON ({error}): measure again") from error
    if not isinstance(row, dict) or row.get("bench") != "papers" or row.get("part") not in FIELDS:
        raise Fault(BROKEN, f"{where}: not a line of `skinlod_bench papers`")
    wanted = EVERY_LINE | FIELDS[row["part"]]
    if row["part"] == "figure4" and row.get("method") != "original":
        wanted |= MEASURED_COLUMN
    for field, kind in wanted.items():
        value = row.get(field)
        if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
            raise Fault(BROKEN, f"{where}: {row['part']}: '{field}' is {value!r}: measure again with the bench of "
                                "this version")
        if kind in (int, NUMBER) and not (math.isfinite(value) and value >= 0):
            raise Fault(BROKEN, f"{where}: {row['part']}: '{field}' is {value!r}, which nothing measures")
    return row


def parts_of(path):
    """The lines of every part. All are there, and each model of a part has all of its methods once."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except UnicodeDecodeError as error:
        raise Fault(BROKEN, f"{path}: no text: measure again") from error
    except OSError as error:
        raise Fault(UNREACHABLE, f"{path}: {error.strerror}") from error
    parts = {part: [] for part in FIELDS}
    for number, line in enumerate(lines, 1):
        row = checked(line, f"{path}:{number}")
        parts[row["part"]].append(row)

    def demand(truth, part, what):
        if not truth:
            raise Fault(BROKEN, f"{path}: {part}: {what}: measure again with skinlod_bench papers, all parts")

    for part, rows in parts.items():
        demand(rows, part, "is missing")
        for model, of_model in by(rows, "model").items():
            demand(all(row["paper_model"] in PAPER for row in of_model), part, f"{model} stands for no model")
            if part == "figure2":
                got = collections.Counter((row["method"], row["cap"]) for row in of_model)
                expected = [(method, cap) for method, caps in WAYS.items() for cap in caps]
            elif part == "figure5":
                got = collections.Counter((row["method"], row["frame"]) for row in of_model)
                frames = sorted({row["frame"] for row in of_model})
                expected = list(itertools.product([*COMPARED, FRAME], frames))
            else:
                got = collections.Counter(row["method"] for row in of_model)
                expected = COMPARED + (["original"] if part == "figure4" else [])
            demand(got == collections.Counter(expected), part, f"{model} has not each method once")
    for row in parts["table1"]:
        demand(row["cpu_seconds"] > 0, "table1", f"{row['model']} took no time")
    for row in parts["figure4"]:
        demand(is_surface(row["points"], row["faces"]), "figure4", f"{row['method']} is no surface")
    demand(len(by(parts["figure4"], "model")) == 1, "figure4", "more than one model")
    return parts


def is_surface(points, faces):
    def triples(lists, holds):
        return lists and all(isinstance(some, list) and len(some) == 3 and all(map(holds, some)) for some in lists)

    return (triples(points, lambda x: isinstance(x, NUMBER) and math.isfinite(x))
            and triples(faces, lambda v: isinstance(v, int) and 0 <= v < len(points)))


def by(rows, key):
    """The rows in lists by what they have for `key`, in the order of the first of each."""
    lists = {}
    for row in rows:
        lists.setdefault(row[key], []).append(row)
    return lists


# ---- Words and numbers

def sig(x, digits=3):
    """So many significant digits, never as a power of ten."""
    x = float(f"{x:.{digits - 1}e}")  # 0.9996 is 1.00
    return f"{x:,.{max(0, digits - 1 - math.floor(math.log10(abs(x))))}f}" if x else "0"


def listed(words):
    words = list(words)
    return words[0] if len(words) == 1 else ", ".join(words[:-1]) + " and " + words[-1]


def spread(ratios):
    ratios = list(ratios)
    low, high = sig(min(ratios)), sig(max(ratios))
    return low if low == high else f"{low} to {high}"


def mean(values):
    values = list(values)
    return sum(values) / len(values)


def geometric_mean(values):
    return math.exp(mean(map(math.log, values)))


def against(here, there):
    """`here` as a difference from `there`, in words."""
    ratio = here / there
    if abs(ratio - 1) < 0.005:
        return "the same as"
    if ratio > 1.995:
        return f"{sig(ratio)} times"
    return f"{sig(100 * abs(ratio - 1), 2)} % {'above' if ratio > 1 else 'below'}"


def as_long(ratio):
    """A ratio of times, in words that go before whose time it is."""
    if abs(ratio - 1) < 0.005:
        return "as long as"
    if ratio > 1.995:
        return f"{sig(ratio)} times as long as"
    return f"{sig(100 * abs(ratio - 1), 2)} % {'longer' if ratio > 1 else 'less time'} than"


def spread_of_counts(counts):
    counts = sorted(set(counts))
    return f"{counts[0]:,}" if len(counts) == 1 else f"{counts[0]:,} to {counts[-1]:,}"


def counted(n, of):
    return f"all {of}" if n == of and of > 1 else f"{'none' if n == 0 else n} of {of}"


def table(head, rows):
    """Markdown; a column of numbers is set to the right."""
    numbers = [all(set(r[i]) <= set("0123456789,. /()–") for r in rows) for i in range(len(head))]
    lines = [head, ["---:" if number else "---" for number in numbers], *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


class Page:
    """What is written: text by paragraphs, and files by their place under the output folder."""

    def __init__(self):
        self.text = []
        self.files = {}

    def say(self, *paragraphs):
        self.text += [" ".join(paragraph.split()) if not paragraph.startswith("|") else paragraph
                      for paragraph in paragraphs if paragraph]

    def csv(self, name, head, rows):
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(head)
        writer.writerows(rows)
        self.files[name] = out.getvalue().encode()

    def plot(self, name, title, script, width=860, height=400):
        """Runs gnuplot on `script` after the look that all plots share."""
        look = (f"set terminal svg size {width},{height} font 'sans-serif,12' background 'white'\n"
                "set encoding utf8\nset border 3 lc '#444444'\nset tics nomirror out\n"
                "set grid ytics lc '#dddddd' lt 1\n")
        try:
            done = subprocess.run(["gnuplot"], input=(look + script).encode(), stdout=subprocess.PIPE,
                                  stderr=subprocess.PIPE)
        except OSError as error:
            raise Fault(UNREACHABLE, f"gnuplot: {error.strerror}: tools/install.sh checks installs it") from error
        if done.returncode or done.stderr or not done.stdout.rstrip().endswith(b"</svg>"):
            raise Fault(BROKEN, f"gnuplot: {name}: {done.stderr.decode().strip()[-300:]}")
        self.files["docs/" + name] = done.stdout
        self.text.append(f"![{title}]({name})")


def bars(labels, series, ylabel):
    """A gnuplot script of clustered bars; `series` are (title, colour, values)."""
    data = "\n".join(" ".join(['"' + label.replace("_", "\\n") + '"', *(repr(values[i]) for _, _, values in series)])
                     for i, label in enumerate(labels))
    plots = ", ".join(f"$data using {k + 2}:xtic(1) title '{title}' lc rgb '{colour}'"
                      for k, (title, colour, _) in enumerate(series))
    return (f"$data << END\n{data}\nEND\nset style data histograms\nset style histogram clustered gap 1.5\n"
            f"set style fill solid 0.9 noborder\nset key outside top center horizontal\nset yrange [0:*]\n"
            f"set ylabel '{ylabel}'\nset xtics scale 0 noenhanced font 'sans-serif,10'\n"
            f"set xrange [-0.6:{len(labels) - 0.4}]\nset bmargin 4\nplot {plots}\n")


# ---- The models

def models(page, parts):
    page.say("## What stands in for the paper's models")
    rows, absent = [], []
    for name, (polygons, poses, *_) in PAPER.items():
        here = by([row for row in parts["table1"] if row["paper_model"] == name], "model")
        for model, (row, *_) in here.items():
            rows.append([name, f"{polygons:,}", str(poses), model, f"{row['source_triangles']:,}",
                         str(row["examples"])])
        if not here:
            absent.append(name)
            rows.append([name, f"{polygons:,}", str(poses), "nothing here", "–", "–"])
    page.say(
        "The paper's own models are not to be had. These take their places in Table 1, with the paper's numbers of "
        "example poses, of which the bind pose is one here:",
        table(["the paper's model", "polygons", "poses", "here", "triangles", "poses"], rows),
        "The square column has the paper's triangles to the last one; its proportions, its joints, its weights and "
        "how it bends and twists are ours. The centipede and the humanoid are `content/`'s. Where a character had "
        "too few triangles, each was cut into n × n and then the longest edges halved until the count was the "
        "paper's; what was flat stays flat, so that the first collapses of such a model cost nothing in any "
        "method. The other characters are whole ones of about the paper's size.",
        f"The folder of other people's characters is not there, so nothing stands in for {listed(absent)}, and "
        "the figures have fewer models." if absent else "")


# ---- Table 1

class Times:
    """Seconds by model and method, here and in the paper."""
    THEIRS = {MOHR: 2, DECORO: 3, UNCAPPED: 4}  # columns of PAPER

    def __init__(self, rows):
        self.here = {(row["model"], row["method"]): row["cpu_seconds"] for row in rows}
        self.stands_for = {row["model"]: row["paper_model"] for row in rows}
        self.models = list(self.stands_for)

    def paper_seconds(self, model, method):
        return PAPER[self.stands_for[model]][self.THEIRS[method]]

    def ratio(self, model, a, b):
        return self.here[model, a] / self.here[model, b]

    def paper_ratio(self, model, a, b):
        return self.paper_seconds(model, a) / self.paper_seconds(model, b)

    def mean_ratio(self, a, b, models=None):
        return geometric_mean(self.ratio(m, a, b) for m in models or self.models)

    def paper_mean_ratio(self, a, b, models=None):
        return geometric_mean(self.paper_ratio(m, a, b) for m in models or self.models)


def table1(page, rows):
    times, of_model = Times(rows), by(rows, "model")
    page.say(f"## Table 1: time to the hierarchy of {POLYGONS} polygons",
             "Seconds of one thread, with all that it takes to begin:")
    page.say(table(["the paper's model", "here", "down to", *(NAMES[m] for m in COMPARED)],
                   [[times.stands_for[model], model, spread_of_counts(r["triangles"] for r in of),
                     *(sig(times.here[model, m]) for m in COMPARED)] for model, of in of_model.items()]))
    page.say("The paper's seconds are of a processor of 2006, so ratios within one run are what compares, each the "
             "paper's / here. The paper does not say whether its table is with a cap; its ratios stand beside "
             "those of ours without one.")
    pairs = [(DECORO, MOHR), (UNCAPPED, MOHR), (UNCAPPED, DECORO)]
    more = [(PRINTED, MOHR), (PRINTED, DECORO), (OURS, MOHR), (OURS, DECORO)]
    page.say(table(["the paper's model", "here", *(f"{SHORT[a]} ÷ {SHORT[b]}" for a, b in pairs + more)],
                   [[times.stands_for[m], m,
                     *(f"{sig(times.paper_ratio(m, *pair))} / {sig(times.ratio(m, *pair))}" for pair in pairs),
                     *(sig(times.ratio(m, *pair)) for pair in more)] for m in times.models]))
    pale = {MOHR: "#F0B68F", DECORO: "#FADFA6"}
    page.plot("table1.svg", "Our time as a multiple of Mohr–Gleicher's and of DeCoro–Rusinkiewicz's", bars(
        [f"{times.stands_for[m]}\\n{m}" for m in times.models],
        [(f"ours ÷ {SHORT[other]}, {where}", colour, [ratio(m, UNCAPPED, other) for m in times.models])
         for other in (MOHR, DECORO)
         for where, colour, ratio in (("the paper", pale[other], times.paper_ratio),
                                      ("here", COLOURS[other], times.ratio))],
        "times as long"))
    say_how_long(page, times)
    say_where_it_stops(page, of_model)
    page.csv("table1.csv",
             ["paper_model", "model", "paper_polygons", "triangles", "paper_poses", "poses", "pieces", "method",
              "down_to", "cpu_seconds", "times_mohr", "times_decoro", "paper_seconds", "paper_times_mohr",
              "paper_times_decoro"], [table1_line(times, row) for row in rows])


def table1_line(times, row):
    model, method = row["model"], row["method"]
    polygons, poses = PAPER[row["paper_model"]][:2]
    theirs = ["", "", ""]
    if method in Times.THEIRS:
        theirs = [times.paper_seconds(model, method), times.paper_ratio(model, method, MOHR),
                  times.paper_ratio(model, method, DECORO)]
    return [row["paper_model"], model, polygons, row["source_triangles"], poses, row["examples"], row["pieces"],
            method, row["triangles"], row["cpu_seconds"], times.ratio(model, method, MOHR),
            times.ratio(model, method, DECORO), *theirs]


def say_how_long(page, times):
    models = times.models
    slowest = sum(all(times.ratio(m, UNCAPPED, b) > 1 for b in (MOHR, DECORO)) for m in models)
    page.say(f"Ours takes the longest of the three for {counted(slowest, len(models))} models, as for all 5 of the "
             "paper's." if slowest else "Ours takes the longest of the three for no model, unlike in the paper.")
    for other in (MOHR, DECORO):
        def factor(m):
            return times.ratio(m, UNCAPPED, other) / times.paper_ratio(m, UNCAPPED, other)

        here, there = times.mean_ratio(UNCAPPED, other), times.paper_mean_ratio(UNCAPPED, other)
        apart = max(models, key=lambda m: abs(math.log(factor(m))))
        text = (f"**Beside {NAMES[other]}** ours takes {spread(times.ratio(m, UNCAPPED, other) for m in models)} "
                f"times as long, {sig(here)} as the geometric mean, where the paper's ratios are "
                f"{spread(times.paper_ratio(m, UNCAPPED, other) for m in models)}, {sig(there)} as the mean over "
                f"the same rows. Farthest apart is {times.stands_for[apart]}: "
                f"{sig(times.paper_ratio(apart, UNCAPPED, other))} in the paper, "
                f"{sig(times.ratio(apart, UNCAPPED, other))} here. ")
        if here * ALIKE < there:
            text += ("So the solve costs less beside the others here. Likely reasons: two rounds of the "
                     "alternation from the best of both ends and the midpoint, where the paper repeats them to a "
                     "minimum; and work that all methods here share (no face may turn over in any example pose, "
                     "borders have planes, the same queue and legality), which brings any two of them nearer to "
                     "each other.")
        elif here > ALIKE * there:
            text += ("So the solve costs more beside the others here. Likely reasons: weights that may not be "
                     "negative, solved for by an active set; three starts for each edge; and costs of the others "
                     "that are smaller here than in the paper's code.")
        else:
            text += "On the whole that is what the paper found."
        page.say(text)

    text = (f"**DeCoro–Rusinkiewicz beside Mohr–Gleicher** takes "
            f"{spread(times.ratio(m, DECORO, MOHR) for m in models)} of its time (the paper: "
            f"{spread(times.paper_ratio(m, DECORO, MOHR) for m in models)}). ")
    many = [m for m in models if PAPER[times.stands_for[m]][1] > 20]
    if many:
        here, there = times.mean_ratio(DECORO, MOHR, many), times.paper_mean_ratio(DECORO, MOHR, many)
        text += f"With 27 and more poses ({listed(many)}) it is {sig(here)} here and {sig(there)} in the paper. "
        text += "Its one quadric makes a price independent of the number of poses, "
        if here > ALIKE * there:
            text += ("which is what the paper's figures show; here the number comes back, likely because every "
                     "method must look whether a face turns over in any of the poses.")
        elif here * ALIKE < there:
            text += "which gains more here than in the paper."
        else:
            text += "here as in the paper."
    page.say(text)
    page.say(f"*As printed*, with weights of either sign, takes {as_long(times.mean_ratio(PRINTED, UNCAPPED))} "
             f"ours, whose weights are held non-negative, and *cap 4* takes "
             f"{as_long(times.mean_ratio(OURS, UNCAPPED))} ours without a cap (geometric means).")


def say_where_it_stops(page, of_model):
    short = {m: of for m, of in of_model.items() if any(r["triangles"] > POLYGONS for r in of)}
    for model, of in short.items():
        pieces = of[0]["pieces"]
        text = f"**{model} stops at {spread_of_counts(r['triangles'] for r in of)} triangles**, not at {POLYGONS}. "
        if 4 * pieces > POLYGONS:
            text += (f"It is made of {pieces} separate pieces. A collapse takes no piece away, and one that is "
                     f"closed keeps 4 triangles (an open one, 1): {4 * pieces} if all are closed. ")
        else:
            text += f"Its {pieces} {'piece' if pieces == 1 else 'separate pieces'} alone would not ask for so many. "
        if min(r["triangles"] for r in of) > 4 * pieces:
            text += ("The rest is edges that may not go: their faces would turn over in an example pose, or the "
                     "surface fold. ")
        page.say(text + "Up to there the time counts.")
    if not short:
        page.say(f"Every hierarchy goes down to {POLYGONS} triangles.")
    fewer = [m for m, of in of_model.items() if of[0]["examples"] < of[0]["poses"]]
    if fewer:
        page.say(f"{listed(fewer).capitalize()} had fewer example poses than the paper's model: the clips hold no "
                 "more that differ.")


# ---- Figure 2

def way(row):
    return ("as printed" if row["method"] == "articulated_signed" else "ours") + (
        f", cap {row['cap']}" if row["cap"] else ", no cap")


def figure2(page, rows):
    of_model = by(rows, "model")
    page.say("## Figure 2: a cap against none",
             "The paper simplifies a character of 13,334 polygons and at most 5 influences to 3,000: without a cap "
             "some vertices end with 11 influences, with a cap of 5 the shapes are “almost identical”. (Its "
             "caption says lion; 13,334 is Cheb's count in its table.) Here: the same share of the triangles, "
             "errors over clip frames that were not solved for, in percent of the rest pose's diagonal.")
    page.say(table(
        ["model", "triangles", "most influences in source", "way", "most influences", "mean", "RMS", "max"],
        [[model if i == 0 else "", f"{r['source_triangles']:,} / {r['triangles']:,}", str(r["source_influences"]),
          way(r), str(r["most_influences"]), f"{r['mean_influences']:.2f}", f"{r['rms_percent']:.4f}",
          f"{r['max_percent']:.3f}"] for model, of in of_model.items() for i, r in enumerate(of)]))
    some = next(iter(of_model.values()))
    colours = {"articulated_signed": ["#BBDDF3", COLOURS[PRINTED]],
               "articulated": ["#7FB2D8", COLOURS[UNCAPPED], COLOURS[OURS]]}
    used = {method: iter(shades) for method, shades in colours.items()}
    page.plot("figure2.svg", "RMS with and without a cap", bars(
        list(of_model), [(way(r), next(used[r["method"]]), [of[i]["rms_percent"] for of in of_model.values()])
                         for i, r in enumerate(some)], "RMS, % of the diagonal"))

    for method, what in (("articulated", "Ours"), ("articulated_signed", "As printed")):
        page.say(f"**{what}**: " + figure2_words(
            {model: {r["cap"]: r for r in of if r["method"] == method} for model, of in of_model.items()}))
    keys = ["model", *(k for k in EVERY_LINE if k in ("source_triangles", "method", "triangles")),
            *FIELDS["figure2"]]
    page.csv("figure2.csv", keys, [[r[key] for key in keys] for r in rows])


def figure2_words(at):
    """Of one kind of weights: rows by model and cap."""
    most = max(at, key=lambda model: at[model][0]["most_influences"])
    dearer = {m: caps for m, caps in at.items() if caps[5]["rms_percent"] > ALIKE * caps[0]["rms_percent"]}
    text = (f"without a cap up to {at[most][0]['most_influences']} influences at a vertex ({most}; the paper: 11). "
            f"A cap of 5 costs no more than {sig(100 * (ALIKE - 1), 2)} % of RMS for "
            f"{counted(len(at) - len(dearer), len(at))} models. ")
    for m, caps in dearer.items():
        text += f"For {m} its RMS is {against(caps[5]['rms_percent'], caps[0]['rms_percent'])} that without a cap"
        if caps[0]["source_influences"] > 5:
            text += (f", likely because the source itself has up to {caps[0]['source_influences']} influences, so "
                     "that the cap takes from what was there and not only from what collapses added; the paper's "
                     "source kept to its cap")
        text += ". "
    untouched = [m for m, caps in at.items() if caps[0]["most_influences"] <= 5]
    if untouched:
        text += f"For {listed(untouched)} the cap has nothing to do: no vertex comes to more than 5 without it. "
    if at[most][0]["most_influences"] < 11:
        text += ("No model comes to the paper's 11 influences, likely because fewer joints meet near a vertex than "
                 "in the paper's.")
    return text


# ---- Figure 4

def figure4(page, rows):
    at = {row["method"]: row for row in rows}
    order = ["original", DECORO, MOHR, PRINTED, UNCAPPED, OURS]
    page.say("## Figure 4: the column at 3,000 triangles",
             f"From {at['original']['source_triangles']:,} triangles and {at['original']['poses']} example poses, "
             "in the paper's order. Shown bent and twisted at once, which "
             f"{'is one of' if at['original']['example'] else 'is none of'} the example poses; every triangle in "
             "one shade, so that nothing is smoothed over.")
    view = shaded.View(towards=(0.9, 0.35, 0.75), light=(0.1, 0.9, 0.75))
    frame = shaded.frame_of(view.seen(at["original"]["points"]), 0.02)
    left, bottom, right, top = frame
    closer = (left + 0.45 * (right - left), bottom + 0.42 * (top - bottom),
              left + 0.85 * (right - left), bottom + 0.76 * (top - bottom))
    for name, window, height, edges in (("column", frame, 400, False), ("detail", closer, 320, True)):
        for method in order:
            row = at[method]
            page.files[f"docs/figure4_{name}_{method}.png"] = shaded.picture(
                view, row["points"], row["faces"], window, height, edges)
    titles = [("original" if m == "original" else NAMES[m]) for m in order]
    page.say(table(
        titles, [[f"![{title}, {name}](figure4_{name}_{method}.png)" for title, method in zip(titles, order)]
                 for name in ("column", "detail")]))
    page.say(
        f"Over {at[OURS]['measured_poses']} clip frames that were not solved for, and over the pose shown: "
        "distances in percent of the diagonal, and the angles in degrees between a sample's normal and that of the "
        "closest point. An angle beyond 45° is the next side's, met beside an edge of the column; what a side does "
        "among itself, washboarding, is in the angles within 45°.",
        table(["method", "triangles", "RMS", "max", "angle: mean", "99 of 100", "RMS", "beyond 45°, %",
               "RMS within 45°", "shown: RMS", "angle RMS within 45°"],
              [[NAMES[m], f"{at[m]['triangles']:,}", *(sig(at[m][key]) for key in (
                  "rms_percent", "max_percent", "normal_mean_degrees", "normal_p99_degrees", "normal_rms_degrees",
                  "normal_beyond_45_percent", "normal_within_45_rms_degrees", "shown_rms_percent",
                  "shown_normal_within_45_rms_degrees"))] for m in order[1:]]))

    say_how_near(page, at)
    say_how_smooth(page, at)
    same = [NAMES[m] for m in (PRINTED, OURS) if all(at[m][k] == at[UNCAPPED][k] for k in ("points", "faces"))]
    if same:
        page.say(f"{listed(same).capitalize()}: the same surface as ours without a cap.")
    keys = ["triangles", *MEASURED_COLUMN]
    page.csv("figure4.csv", ["method", *keys], [[m, *(at[m][key] for key in keys)] for m in order[1:]])


def beside(at, key):
    return listed(f"{NAMES[m]}'s is {against(at[m][key], at[UNCAPPED][key])} it" for m in (MOHR, DECORO))


def say_how_near(page, at):
    key = "rms_percent"
    text = f"The RMS distance of ours is {sig(at[UNCAPPED][key])} %; {beside(at, key)}. "
    nearer = [NAMES[m] for m in (MOHR, DECORO) if at[m][key] < at[UNCAPPED][key]]
    page.say(text + (f"The paper prints no distance for the column, where {listed(nearer)} is the nearer one here, "
                     "likely because the column's own points and weights already fit its few poses." if nearer else
                     "Ours is the nearest."))


def say_how_smooth(page, at):
    key, crease = "normal_within_45_rms_degrees", "normal_beyond_45_percent"
    ratio = {m: at[m][key] / at[UNCAPPED][key] for m in (MOHR, DECORO)}
    guards = ("planes are weighted by area, no face may turn over in an example pose, and the paper's own column and "
              "poses, which may bend harder, are not to be had. ")
    text = f"The RMS angle within 45° of ours is {sig(at[UNCAPPED][key])}°; {beside(at, key)}. "
    if ratio[DECORO] > WASHBOARDS:
        text += ("The washboarding that the paper sees in DeCoro–Rusinkiewicz is there: the ridges in its pictures. "
                 "Likely reason: two ends' quadrics, turned back by the transforms of their own weights, do not say "
                 "together along which lines the surface bends. ")
    else:
        text += ("The washboarding that the paper sees in DeCoro–Rusinkiewicz is not there. "
                 f"Likely reasons: {guards}")
    text += "Of Mohr–Gleicher the paper says that its triangles are poor where the column bends. "
    if ratio[MOHR] > WASHBOARDS:
        text += "Its normals here say so too: points that no one moves do not line up with how the surface bends. "
    elif ratio[MOHR] > 1:
        text += f"Its normals here are worse than ours, but not by much. Likely reasons: {guards}"
    else:
        text += f"Its normals here are no worse than ours. Likely reasons: {guards}"
    page.say(text)
    page.say(f"Beyond 45°, where a sample's closest point is across an edge of the column, are "
             f"{sig(at[UNCAPPED][crease])} % of the samples for ours, {sig(at[MOHR][crease])} % for {NAMES[MOHR]}, "
             f"whose points are the column's own, and {sig(at[DECORO][crease])} % for {NAMES[DECORO]}.")


# ---- Figure 5

class Curves:
    """RMS by model, method and frame, and what the frames are."""

    def __init__(self, rows):
        self.of_model = by(rows, "model")
        self.rms, self.frames, self.unseen, self.mean = {}, {}, {}, {}
        for model, of in self.of_model.items():
            of_method = {m: sorted(its, key=lambda r: r["frame"]) for m, its in by(of, "method").items()}
            self.rms[model] = {m: [r["rms_percent"] for r in its] for m, its in of_method.items()}
            self.frames[model] = of_method[MOHR]
            self.unseen[model] = [i for i, f in enumerate(of_method[MOHR]) if not f["example"]]
            if not self.unseen[model]:
                raise Fault(BROKEN, f"figure5: {model}: every frame is an example pose: nothing is left to compare")
            for m, values in self.rms[model].items():
                self.mean[model, m] = mean(values[i] for i in self.unseen[model])
        self.models = list(self.of_model)
        self.total = sum(map(len, self.unseen.values()))

    def ratio(self, model, a, b):
        """Of the means over the frames that are no examples."""
        return self.mean[model, a] / self.mean[model, b]

    def ratios(self, a, b):
        return {model: self.ratio(model, a, b) for model in self.models}

    def count(self, holds, a, b):
        """By model, the frames that are no examples where `holds` is true of the two methods' errors."""
        return {model: sum(holds(self.rms[model][a][i], self.rms[model][b][i]) for i in self.unseen[model])
                for model in self.models}


def figure5(page, rows):
    page.say("## Figure 5: RMS over the frames of an animation",
             "All clips of a character one after the other, thinned evenly; distances both ways in percent of the "
             "rest pose's diagonal (Metro, as in the paper). *Each frame alone* is Garland and Heckbert's static "
             "simplification of that frame by itself, which no level of detail can be: the quality that the paper "
             "says it comes “much closer” to. Ticks below mark frames that are example poses. The paper does not "
             "print how many polygons its curves are of; here they are 5 % of the source's.")
    curves, everyone = Curves(rows), [*COMPARED, FRAME]
    page.say("Means over the frames that are no examples, and in brackets as multiples of *each frame alone*:", table(
        ["model", "stands for", "triangles", "frames (examples)", *(NAMES[m] for m in everyone)],
        [[model, of[0]["paper_model"], f"{of[0]['source_triangles']:,} to {of[0]['triangles']:,}",
          f"{len(curves.frames[model])} ({len(curves.frames[model]) - len(curves.unseen[model])})",
          *(f"{sig(curves.mean[model, m])} ({curves.ratio(model, m, FRAME):.2f})" for m in everyone)]
         for model, of in curves.of_model.items()]))
    for model in curves.models:
        page.plot(f"figure5_{model.replace(' ', '_')}.svg", f"RMS over the frames: {model}",
                  lines(curves.rms[model], curves.frames[model]), height=360)
    for other in (MOHR, DECORO):
        page.say(beside_ours(curves, other))
    lower, same = (sum(curves.count(holds, OURS, UNCAPPED).values()) for holds in (operator.lt, operator.eq))
    page.say(f"**The cap** of 4: its mean is {spread(curves.ratios(OURS, UNCAPPED).values())} times that without "
             f"one; it is lower at {lower} of {curves.total} frames and the same at {same}. The paper, too, finds "
             "that the capped level is at times the better one." if lower else
             f"**The cap** of 4 is lower at no frame, where the paper's is at times; its mean is "
             f"{spread(curves.ratios(OURS, UNCAPPED).values())} times that without one.")
    signed = curves.ratios(PRINTED, UNCAPPED)
    text = f"**As printed**, with weights of either sign, the mean is {spread(signed.values())} times that of ours. "
    lower, higher = [m for m, r in signed.items() if r < 0.99], [m for m, r in signed.items() if r > 1.01]
    if lower:
        text += f"For {listed(lower)} it is lower, which is what holding weights at 0 or above costs. "
    if higher:
        text += (f"For {listed(higher)} it is higher, likely because between example poses nothing holds what large "
                 "weights of opposite signs do. ")
    if not lower and not higher:
        text += "Holding weights at 0 or above costs nothing here."
    page.say(text)
    page.say("**Each frame alone**: " + ", ".join(
        f"{NAMES[m]} is at {spread(curves.ratios(m, FRAME).values())} times it"
        for m in (UNCAPPED, DECORO, MOHR)) + ".")
    for model in curves.models:
        if curves.of_model[model][0]["paper_model"] == "Human":
            page.say(crouching(curves, model))
    keys = ["model", "paper_model", "source_triangles", "method", "triangles", "frame", "clip", "seconds", "example",
            "rms_percent"]
    page.csv("figure5.csv", keys, [[int(r[key]) if key == "example" else r[key] for key in keys] for r in rows])


def beside_ours(curves, other):
    gaps, won = curves.ratios(other, UNCAPPED), curves.count(operator.lt, UNCAPPED, other)
    worse = [model for model, gap in gaps.items() if gap < 1]
    alike = [model for model, gap in gaps.items() if 1 <= gap < 1.05]
    little = [model for model in worse + alike if curves.ratio(model, other, FRAME) < ALIKE]
    text = (f"**{NAMES[other]}** has {spread(gaps.values())} times the mean RMS of ours without a cap, which is "
            f"lower at {sum(won.values())} of the {curves.total} frames that are no examples ("
            + ", ".join(f"{model} {n} of {len(curves.unseen[model])}" for model, n in won.items()) + "). ")
    if alike:
        text += f"The two are within 5 % of each other for {listed(alike)}. "
    if worse:
        more = spread(100 * (1 / gaps[m] - 1) for m in worse)
        text += f"Ours is the higher one for {listed(worse)} (by {more} %). "
    if little:
        most = max(curves.ratio(m, other, FRAME) for m in little) - 1
        text += (f"Likely reason: for {listed(little)} {NAMES[other]} is itself "
                 + (f"within {sig(100 * most, 2)} % of" if most > 0 else "no worse than")
                 + " each frame alone, so that little is left to gain. ")
    if sum(won.values()) >= 0.9 * curves.total:
        return text + "So it is in the paper, “with few exceptions”."
    return text + ("The paper has fewer exceptions: our implementation of the method weights planes by area and "
                   "lets no face turn over in an example pose, which likely makes it better than the paper's was, "
                   "and the models are others.")


def crouching(curves, model):
    gap = {clip: mean(curves.rms[model][DECORO][f["frame"]] for f in frames)
           / mean(curves.rms[model][UNCAPPED][f["frame"]] for f in frames)
           for clip, frames in by(curves.frames[model], "clip").items()}
    far, near = max(gap, key=gap.get), min(gap, key=gap.get)
    text = ("The paper's human crouches first, where DeCoro–Rusinkiewicz is poor, and is alike for both "
            f"afterwards. {model.capitalize()}: DeCoro–Rusinkiewicz has {sig(gap[far])} times the RMS of ours in "
            f"clip *{far}*, the most, and {sig(gap[near])} in *{near}*, the least. ")
    if "crouch" in gap:
        text += ("So crouching sets them apart here too." if far == "crouch" else
                 f"In *crouch* it is {sig(gap['crouch'])}.")
    return text


def lines(curves, frames):
    """A gnuplot script of one model's curves, clips told apart and examples marked."""
    order = [m for m in (FRAME, MOHR, DECORO, PRINTED, UNCAPPED, OURS)]
    data = "\n".join(" ".join([str(i), *(repr(curves[m][i]) for m in order)]) for i in range(len(frames)))
    top = 1.1 * max(max(values) for values in curves.values())
    script = f"$data << END\n{data}\nEND\n"
    begins = [i for i, f in enumerate(frames) if i == 0 or f["clip"] != frames[i - 1]["clip"]]
    for begin, end in zip(begins, [*begins[1:], len(frames)]):
        if begin:
            script += f"set arrow from {begin - 0.5},graph 0 to {begin - 0.5},graph 1 nohead lc '#cccccc'\n"
        clip = "".join(c if c.isalnum() or c in " -" else " " for c in frames[begin]["clip"])[:24]
        script += (f"set label '{clip}' at {(begin + end - 1) / 2},graph 0.05 left rotate by 90 "
                   "font 'sans-serif,9' tc '#777777' noenhanced\n")
    for i, f in enumerate(frames):
        if f["example"]:
            script += f"set arrow from {i},graph 0 to {i},graph 0.03 nohead lw 3 lc '#000000' front\n"
    styles = {FRAME: "dt 2 lw 1.5", OURS: "dt 4 lw 2", PRINTED: "lw 1.5"}
    plots = ", ".join(f"$data using 1:{k + 2} with lines {styles.get(m, 'lw 2')} lc rgb '{COLOURS[m]}' "
                      f"title '{NAMES[m]}'" for k, m in enumerate(order))
    return (script + f"set key outside top center horizontal\nset xrange [-0.5:{len(frames) - 0.5}]\n"
            f"set yrange [0:{top!r}]\nset xlabel 'frame'\nset ylabel 'RMS, % of the diagonal'\nplot {plots}\n")


# ---- The page

def pages(parts):
    page = Page()
    page.say(
        "# Landreneau and Schaefer 2009, measured again",
        "E. Landreneau and S. Schaefer, *Simplification of Articulated Meshes*, Computer Graphics Forum 28(2), "
        "Eurographics 2009: its table and its figures of numbers, made again by `tools/paper_tables.py`. The "
        "paper's results stand beside ours, all methods run in one program, and every claim below is computed from "
        "the numbers of this run. “Likely” marks a reason that was not measured.",
        "The methods: **Mohr–Gleicher** (2003) keeps an end point, by the error summed over poses; "
        "**DeCoro–Rusinkiewicz** (2005) has one quadric over all poses and blends weights; **as printed** is the "
        "paper's own method, positions and weights solved, weights of either sign and no cap; **ours** is the same "
        "with weights that engines take, never negative, no cap; **ours, cap 4** is what skinlod collapses with by default "
        "(it fits each level to the source after that, which is left out here). "
        "In all of them planes are weighted by area, borders have planes of their own, and no face may turn over "
        "in any example pose: three things that the paper does not do or does not say. The first two methods are "
        "written from what the paper tells of them.")
    models(page, parts)
    table1(page, parts["table1"])
    figure2(page, parts["figure2"])
    figure4(page, parts["figure4"])
    figure5(page, parts["figure5"])
    page.files["docs/paper.md"] = ("\n\n".join(page.text) + "\n").encode()
    return page.files


def written(files, folder):
    """Writes all files, each renamed into place; returns their paths."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder, prefix=".paper_tables-") as beside:
            for name, content in files.items():
                path = pathlib.Path(beside, name)
                path.parent.mkdir(exist_ok=True)
                path.write_bytes(content)
            for name in files:
                (folder / name).parent.mkdir(exist_ok=True)
                shutil.move(pathlib.Path(beside, name), folder / name)
    except OSError as error:
        raise Fault(UNREACHABLE, f"{folder}: {error.strerror}") from error
    return [folder / name for name in files]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bench", type=pathlib.Path, default=ROOT / "build/tests/skinlod_bench",
                        help="the program that measures (default: %(default)s)")
    parser.add_argument("--output", type=pathlib.Path, required=True, metavar="DIR", help="the folder to write")
    parser.add_argument("--measurements", type=pathlib.Path, metavar="FILE",
                        help="make the pages of these and measure nothing")
    parser.add_argument("--characters", type=pathlib.Path, metavar="DIR",
                        help="other people's characters (default: where the bench looks)")
    parser.add_argument("--runs", type=int, default=3, metavar="COUNT",
                        help="of which the median time counts (default: %(default)s)")
    args = parser.parse_args()
    if args.output.exists() and not args.output.is_dir():
        parser.error(f"--output: {args.output} is a file: give a folder")
    try:
        path = args.measurements or measured(args)
        for file in written(pages(parts_of(path)), args.output):
            if not file.name.startswith("figure4_"):
                print(file)
    except Fault as fault:
        print(f"paper_tables.py: {fault}", file=sys.stderr)
        return fault.code
    return 0


if __name__ == "__main__":
    sys.exit(main())
