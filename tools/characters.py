# SPDX-License-Identifier: MIT
"""Which characters there are to cook: for the scripts beside this file."""
import json
import pathlib

ROOT = pathlib.Path(__file__).resolve().parent.parent
KNOWN = json.loads((ROOT / "tools/characters.json").read_text())
SUFFIXES = tuple(KNOWN["suffixes"])
CLIPS = KNOWN["clips"]  # of characters whose clips are files of their own
AGAIN = KNOWN["again"]  # characters that stand here as another file too
DEFORMING = KNOWN["deforming"]  # those that bend everywhere; the others are near-rigid


def default_roots():
    """content/, and the folder of other people's characters where it lies beside the repository."""
    shared = ROOT.parent / "shared/characters"
    return [ROOT / "content"] + ([shared] if shared.is_dir() else [])


def characters(roots):
    """(name, options for `skinlod cook`) of every character in the folders and the folders in them."""
    clips = {file.split("/")[0] + "/" + clip for file, some in CLIPS.items() for clip in some}
    for root in roots:
        for file in sorted(root.rglob("*")):
            name = file.relative_to(root).as_posix()
            if file.is_file() and name.lower().endswith(SUFFIXES) and name not in clips:
                options = [str(file)]
                for clip in CLIPS.get(name, []):
                    options += ["--clips", str(file.parent / clip)]
                yield name, options
