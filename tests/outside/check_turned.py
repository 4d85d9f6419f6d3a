#!/usr/bin/env python3
"""Asks LinuxCNC about programs that turn a mirror: its interpreter comes to the same places by a feed in a turn, and by words of its own the
centre of the nose stays its radius off the mirror's mesh. Of programs of a slow tool servo it comes to the same X, Z and C.

usage: check_turned.py OUT NAME...       of OUT/NAME/program/*.ngc, OUT/NAME/mirror.obj and report.json

Before the first mirror it is proven that the check can fail: of a nose that is 2 um larger it must.
"""

import json
import pathlib
import sys

import numpy as np
from mirror_obj import mirror_of
from ngc import interpreted, moves, written

SAME = 1e-4  # mm, between ends of moves
DEEP = 1.0  # um, and what the mesh is off
failed = 0


def tell(what, is_good):
    global failed
    print(f"turned: {what}: {'ok' if is_good else 'FAILED'}", flush=True)
    failed |= not is_good


def same_places(path):
    ends, said = interpreted(path)
    wanted = [end for end in written(path) if None not in end[1]]
    ends = ends[len(ends) - len(wanted) :]
    if len(ends) != len(wanted) or not wanted:
        tell(f"{path}: {len(ends)} moves by rs274, {len(wanted)} written; {said}", False)
        return
    off = max(max(abs(a - b) for a, b in zip(x[1], y[1])) for x, y in zip(ends, wanted))
    alike = all(x[0] == y[0] for x, y in zip(ends, wanted))
    tell(f"{path.parent.parent.name}/{path.name}: {len(ends)} moves, places within {off:.1e} mm of rs274's", alike and off <= SAME)


def nearest(places, corners):
    """Distances of places (x, z) from the vertices of a round mirror, as a curve over their distance from the axis."""
    vertices = np.unique(corners.reshape(-1, 3), axis=0)
    radius = np.hypot(vertices[:, 0], vertices[:, 1])
    order = np.argsort(radius)
    curve = np.stack([radius[order], vertices[order, 2]], axis=1)
    return np.array([np.hypot(*(curve - place).T).min() for place in places]), radius.max()


def finishing(folder, operation, corners, chord_um, is_first):
    ends, feed = moves(folder / "program" / operation["file"])
    ends = np.array(ends)[feed][:, :, [0, 2]]
    nose = operation["nose_mm"]
    share = np.linspace(0.0, 1.0, 5)[:, None, None]
    centres = (ends[None, :, 0] + share * (ends[None, :, 1] - ends[None, :, 0])).reshape(-1, 2) + nose
    off, rim = nearest(centres, corners)
    # Beside the rim the nose touches nothing.
    off = off[centres[:, 0] < rim - 2.0 * nose]
    least = 1e3 * (off.min() - nose)
    limit = DEEP + chord_um
    tell(f"{folder.name}: {len(off)} places of the nose, {least:.3f} um off its radius at least, {-limit:.2f} allowed", least >= -limit)
    if is_first:
        tell(f"{folder.name}: a nose 3 um larger fails", least - 3.0 < -limit)


def main(out, *names):
    for name in names:
        folder = pathlib.Path(out) / name
        report = json.loads((folder / "program" / "program.json").read_text())
        chord_um = json.loads((folder / "report.json").read_text())["mesh"]["chord_um"]["bound"]
        corners, _ = mirror_of(folder / "mirror.obj")
        for operation in report["operations"]:
            same_places(folder / "program" / operation["file"])
        # (Mirrors of a slow tool servo are not round.)
        if "servo" in report["operations"][-1]:
            continue
        finishing(folder, report["operations"][-1], corners, chord_um, name == names[0])


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
    sys.exit(failed)
