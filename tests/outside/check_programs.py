"""Programs that mill a mirror, before a control and a library of tool paths: LinuxCNC's interpreter comes to the same places, and a
drop cutter on the mirror's mesh finds no place of a tip that cuts into it.

    check_programs.py OUT NAME...       of OUT/NAME/program/*.ngc, OUT/NAME/mirror.stl and report.json
"""

import json
import pathlib
import random
import re
import subprocess
import sys

import numpy as np
import opencamlib as ocl
import trimesh

# Places of each program that a ball is dropped over.
PLACES = {"roughing": 2_000, "semi-finishing": 2_000, "finishing": 10_000}
NUMBER = r"(-?\d+\.\d+)"
CANON = re.compile(rf"STRAIGHT_(FEED|TRAVERSE)\({NUMBER}, {NUMBER}, {NUMBER}")
WORD = re.compile(r"([GXYZ])(-?\d*\.?\d+|-?\d+\.)")
failed = 0


def tell(what, is_good):
    global failed
    print(f"programs: {what}: {'ok' if is_good else 'FAILED'}")
    failed |= not is_good


def interpreted(path):
    """Ends of the moves by LinuxCNC's interpreter, mm: whether each is a feed move, and its place."""
    said = subprocess.run(["rs274", "-g", str(path)], input="", capture_output=True, text=True, timeout=600)
    ends = [(found[1] == "FEED", tuple(float(found[k]) for k in (2, 3, 4))) for found in CANON.finditer(said.stdout)]
    return ends, said.stdout[-300:] + said.stderr[-300:]


def written(path):
    """The same by the words of the program alone: places that are told, and last."""
    place, mode, ends = [None] * 3, None, []
    for line in path.read_text().splitlines():
        if line.startswith("("):
            continue
        words = WORD.findall(line)
        for letter, value in words:
            if letter == "G" and float(value) in (0, 1):
                mode = int(value)
            elif letter in "XYZ":
                place["XYZ".index(letter)] = float(value)
        if any(letter in "XYZ" for letter, _ in words):
            ends.append((mode == 1, tuple(place)))
    return ends


def same_places(path):
    ends, said = interpreted(path)
    wanted = [end for end in written(path) if None not in end[1]]
    # (A move to where the tip already is, is none to some.)
    ends = ends[len(ends) - len(wanted) :]
    if len(ends) != len(wanted):
        tell(f"{path}: {len(ends)} moves by rs274, {len(wanted)} written; {said}", False)
        return
    off = max(max(abs(a - b) for a, b in zip(x[1], y[1])) for x, y in zip(ends, wanted))
    alike = all(x[0] == y[0] for x, y in zip(ends, wanted))
    tell(f"{path.parent.parent.name}/{path.name}: {len(ends)} moves, places within {off:.1e} mm of rs274's", alike and off <= 1e-4)


def no_gouge(folder, operation, mesh, chord_mm):
    """Places of the tip over the mirror against the height at which a ball comes to rest on the mesh."""
    name, ball, asked = operation["operation"], operation["ball_mm"], operation["allowance_mm"]
    moves = written(folder / "program" / operation["file"])
    cuts = [b[1] for a, b in zip(moves, moves[1:]) if b[0] and None not in a[1]]
    random.Random(1).shuffle(cuts)
    surface = ocl.STLSurf()
    for corners in mesh.triangles:
        surface.addTriangle(ocl.Triangle(*(ocl.Point(*map(float, corner)) for corner in corners)))
    drop = ocl.BatchDropCutter()
    drop.setSTL(surface)
    # A larger ball of the same centre leaves the allowance.
    drop.setCutter(ocl.BallCutter(2.0 * (ball + asked), 200.0))
    chosen = cuts[: PLACES[name]]
    for x, y, _ in chosen:
        drop.appendPoint(ocl.CLPoint(x, y, -1000.0))
    drop.run()
    rest = np.array([point.z for point in drop.getCLPoints()])
    tips = np.array([z for _, _, z in chosen]) - asked
    on = rest > -900.0
    above = 1e3 * (tips - rest)[on]
    lowest = above.min()
    limit = -1.0 - 1e3 * chord_mm * (1.0 + 2.0) - (50.0 * asked if name == "roughing" else 20.0 * asked)
    tell(f"{folder.name}: {name}: {on.sum()} places, the ball is {lowest:.3f} um above rest at least, {limit:.2f} allowed", lowest >= limit)
    if name == "finishing":
        # Lines touch the mirror but beside rims and over ridges.
        share = float(np.mean(np.abs(above) <= 1.0 + 3e3 * chord_mm))
        tell(f"{folder.name}: {share:.3f} of the places are within {1.0 + 3e3 * chord_mm:.2f} um of rest", share > 0.85)


out = pathlib.Path(sys.argv[1])
for name in sys.argv[2:]:
    folder = out / name
    report = json.loads((folder / "program" / "program.json").read_text())
    chord_mm = json.loads((folder / "report.json").read_text())["mesh"]["chord_um"]["bound"] * 1e-3
    for operation in report["operations"]:
        same_places(folder / "program" / operation["file"])
    mesh = trimesh.load(folder / "mirror.stl")
    for operation in report["operations"]:
        no_gouge(folder, operation, mesh, chord_mm)

sys.exit(failed)
