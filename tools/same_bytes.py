#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Cooks every character it finds in several ways and demands the same bytes of every file that comes out.

A way is the beginning of a command line:
    tools/same_bytes.py "gcc/skinlod cook --threads 1" "env GLIBC_TUNABLES=... clang/skinlod cook --threads 2"
Prints a line per character; exits with 1 where bytes differ, a cook fails, or nothing was cooked.
"""
import argparse
import concurrent.futures
import hashlib
import os
import pathlib
import shlex
import subprocess
import sys
import tempfile

from characters import characters, default_roots


def cook(way, options, folder):
    """Cooks into `folder`. Returns the digest of every file by its name, and a fault or nothing."""
    folder.mkdir(parents=True)
    done = subprocess.run([*shlex.split(way), *options, "-o", folder / "out.slod", "--report",
                           folder / "report.json", "--gltf", folder], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True)
    if done.returncode not in (0, 1) or not (folder / "out.slod").exists():
        return {}, f"exit {done.returncode}: {done.stderr.strip()[-300:]}"
    files = {f.name: hashlib.sha256(f.read_bytes()).hexdigest() for f in sorted(folder.iterdir())}
    # What is printed is a result like the files, but for the folder it may name.
    printed = done.stdout.replace(str(folder), "")
    return files | {"stdout": hashlib.sha256(printed.encode()).hexdigest()}, ""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("ways", nargs="+", metavar="WAY")
    parser.add_argument("--roots", nargs="+", type=pathlib.Path, default=default_roots(),
                        help="folders of characters (default: content/, and ../shared/characters if it is there)")
    parser.add_argument("--only", default="", help="only characters with this in their name")
    parser.add_argument("--keep", type=pathlib.Path, help="an empty folder for the files of the first way")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="cooks at a time (default: %(default)s)")
    args = parser.parse_args()

    good = True
    count = 0
    with tempfile.TemporaryDirectory() as scratch, concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        def start(name, options):
            folders = [pathlib.Path(scratch, str(i), name) for i in range(len(args.ways))]
            if args.keep:
                folders[0] = args.keep / name
            return [pool.submit(cook, way, options, folder) for way, folder in zip(args.ways, folders)]

        cooks = {n: start(n, o) for n, o in characters(args.roots) if args.only in n}
        for name, futures in cooks.items():
            results = [future.result() for future in futures]
            count += 1
            expected = results[0][0]
            lines = []
            for way, (files, fault) in zip(args.ways, results):
                differing = sorted(f for f in expected.keys() | files.keys() if expected.get(f) != files.get(f))
                if fault or differing:
                    lines.append(f"    {way}: {fault or 'differs: ' + ', '.join(differing)}")
            print(f"{'FAILED' if lines else 'same'}  {expected.get('out.slod', '-')[:16]}  {name}", *lines,
                  sep="\n" if lines else "", flush=True)
            good = good and not lines
    print(f"{count} characters, {len(args.ways)} ways each")
    return 0 if good and count else 1


if __name__ == "__main__":
    sys.exit(main())
