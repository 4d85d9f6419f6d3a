#!/usr/bin/env python3
"""Has OpenCASCADE write Morion's STEP files anew, in other schemas and in inches, and compares what rays meet of them.

usage: check_step_exports.py write OUT NAME...
       check_step_exports.py check OUT NAME...

OUT/NAME/mirror.step is Morion's file; `write` makes OUT/NAME/KIND.step of it for the KINDs below. OUT/NAME/curved and
OUT/NAME/KIND are what `cargo test --bench trace -- --profile OUT/NAME.toml --step OUT/NAME/KIND.step --dump OUT/NAME/KIND`
wrote of each. Exits 1 if a ray ends otherwise, or a distance differs by more than 1e-9 mm.
"""

import pathlib
import sys

import numpy as np
from OCP.Interface import Interface_Static
from OCP.STEPControl import STEPControl_AsIs, STEPControl_Reader, STEPControl_Writer
from verdicts import told

KINDS = {"ap203": ("AP203", 1), "ap214": ("AP214IS", 1), "ap242": ("AP242DIS", 1), "inch": ("AP214IS", 25.4)}
EXPORTS = [*KINDS, *(f"freecad-{kind}" for kind in KINDS)]
FAR = 1e-9  # mm


def write(folder):
    reader = STEPControl_Reader()
    reader.ReadFile(str(folder / "mirror.step"))
    reader.TransferRoots()
    STEPControl_Writer()  # (Before it there is no such setting.)
    for kind, (schema, unit_mm) in KINDS.items():
        Interface_Static.SetCVal_s("write.step.schema", schema)
        Interface_Static.SetCVal_s("write.step.unit", "MM" if unit_mm == 1 else "INCH")
        writer = STEPControl_Writer()
        writer.Model(False).SetWriteLengthUnit(unit_mm)
        writer.Transfer(reader.OneShape(), STEPControl_AsIs)
        writer.Write(str(folder / f"{kind}.step"))


def ends(folder):
    """Outcomes of all rays, and where those that do not miss meet the body."""
    rays = np.fromfile(folder / "rays.f64").reshape(-1, 6)
    found = np.fromfile(folder / "found.f64").reshape(-1, 6)
    met = found[:, 0] != 1
    return found[:, 0], rays[met, :3] + rays[met, 3:] * found[met, 2:3]


def main(what, out, *names):
    out = pathlib.Path(out)
    if what == "write":
        for name in names:
            write(out / name)
        return 0

    def complaints(name):
        own, far, wrong = ends(out / name / "curved"), 0, []
        for kind in EXPORTS:
            other = ends(out / name / kind)
            differ = int((own[0] != other[0]).sum())
            if differ:
                wrong.append(f"{kind}: {differ} rays end otherwise")
            else:
                far = max(far, np.abs(own[1] - other[1]).max())
        wrong += [f"{far:.1e} mm apart"] if not far <= FAR else []
        return f"{len(EXPORTS)} files, {far:.1e} mm", wrong

    return told("exported steps", names, complaints)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
