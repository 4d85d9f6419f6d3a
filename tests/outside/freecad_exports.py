#!/usr/bin/python3
"""Has FreeCAD open Morion's STEP files and export them anew, in other schemas and in inches.

usage: freecad_exports.py OUT NAME...

OUT/NAME/mirror.step is Morion's file; OUT/NAME/freecad-KIND.step is made of it for the KINDS below, as the program's "Export" does. To be
run by the Python that Debian's freecad-python3 is for. Exits 1 if FreeCAD finds no solid in a file.
"""

import pathlib
import subprocess
import sys

KINDS = {"ap203": ("AP203", 0), "ap214": ("AP214IS", 0), "ap242": ("AP242DIS", 0), "inch": ("AP214IS", 2)}


def export(source, target, schema, unit):
    """One export; FreeCAD reads its preferences when its modules are loaded, so each takes a process."""
    sys.path.append("/usr/lib/freecad-python3/lib")
    import FreeCAD

    preferences = FreeCAD.ParamGet("User parameter:BaseApp/Preferences/Mod/Part/STEP")
    preferences.SetString("Scheme", schema)
    preferences.SetInt("Unit", int(unit))
    import Import

    document = FreeCAD.newDocument("exported")
    Import.insert(source, document.Name)
    solids = [thing for thing in document.Objects if thing.isDerivedFrom("Part::Feature") and thing.Shape.Solids]
    if len(solids) != 1:
        sys.exit(f"{source}: FreeCAD finds {len(solids)} solids, not one")
    Import.export(solids, target)


def main(out, *names):
    for name in names:
        folder = pathlib.Path(out) / name
        for kind, (schema, unit) in KINDS.items():
            one = [__file__, "--one", folder / "mirror.step", folder / f"freecad-{kind}.step", schema, unit]
            subprocess.run([sys.executable, *map(str, one)], check=True)


if __name__ == "__main__":
    if sys.argv[1] == "--one":
        export(*sys.argv[2:])
    else:
        main(*sys.argv[1:])
