#!/usr/bin/env python3
"""Prints a shipped profile of a mirror that is to be milled along lines 0.3 mm apart, with a mesh finer than what it is held to.

usage: milled_profile.py PROFILE.toml [LINES...]      LINES of the table [program], as path = "spiral"

Wide mirrors are printed at a smaller scale: camera, world and mirror alike, so that the picture stays the same. Lines 0.3 mm apart on
the whole would take more facets than are made of a face as it is cut.
"""

import pathlib
import re
import sys
import tomllib

STEPOVER_MM = 0.3
CHORD_UM = 0.15  # of the mesh
WIDE_MM = 110.0


def scaled(line, scale):
    key, value = line.split(" = ", 1)
    value = re.sub(r"-?\d+(\.\d+)?", lambda number: f"{float(number[0]) * scale:.9g}", value.split("#")[0].strip())
    return f"{key} = {value}"


def main(path, *more):
    text = pathlib.Path(path).read_text()
    wide_mm = tomllib.loads(text)["part"]["width_mm"]
    scale = min(1.0, round(WIDE_MM / wide_mm, 1))
    for line in text.splitlines():
        if line.startswith(("chord_um", "facet_px", "pitch_mm")):
            continue
        if line.startswith("[mesh]"):
            line = f"[mesh]\nchord_um = {CHORD_UM}"
        if line.startswith("formats"):
            line = 'formats = ["stl", "obj"]'
        if scale < 1 and re.match(r"\w+_mm = ", line) and not line.startswith("base_mm"):
            line = scaled(line, scale)
        print(line)
    print(f"\n[program]\nstepover_mm = {STEPOVER_MM}", *more, sep="\n")


if __name__ == "__main__":
    main(*sys.argv[1:]) if len(sys.argv) >= 2 else sys.exit(__doc__)
