#!/usr/bin/env python3
"""Asks LinuxCNC and opencamlib about programs that mill a mirror: the interpreter comes to the same places, and a
drop cutter on the mirror's mesh finds no place of the tip that cuts into it.

usage: check_programs.py OUT NAME...       of OUT/NAME/program/*.ngc, OUT/NAME/mirror.obj and report.json

Places of the tip are random ones of all along the cutting moves. From each the cutter is dropped onto the mirror's facets: a larger one
about the same middle, which leaves the allowance. The finishing ball must nowhere be deeper than DEEP, and where it comes to rest
inside the mirror, on no rim and no ridge, nowhere higher; chords of the other programs are longer, and levels of roughing touch
nothing.

Before the first mirror it is proven that the check can fail: of a tip that is 2 um lower, and of one 2 um higher, it must.
"""

import json
import pathlib
import sys

import numpy as np
import opencamlib as ocl
from mirror_obj import mirror_of
from ngc import interpreted, moves, written

# Places of each program that a ball is dropped over.
PLACES = {"roughing": 500, "semi-finishing": 1_000, "finishing": 10_000}
DEEP = 1.0  # um along the normal, and what the mesh is off
ROUGH = {"roughing": 50.0, "semi-finishing": 20.0, "finishing": 0.0}  # um deeper for each mm of allowance
SAME = 1e-4  # mm, between ends of moves
BESIDE = 1e-3  # mm from rims and ridges
RIDGE = 0.1  # rad between facets
OFF = -900.0  # mm: Z where a ball comes to rest on nothing
failed = 0


def tell(what, is_good):
    global failed
    print(f"programs: {what}: {'ok' if is_good else 'FAILED'}", flush=True)
    failed |= not is_good


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
    tell(f"{path.parent.parent.name}/{path.name}: {len(ends)} moves, places within {off:.1e} mm of rs274's", alike and off <= SAME)


class Face:
    """A mirror's mesh, and its rims and ridges."""

    def __init__(self, path):
        corners, _ = mirror_of(path)
        self.surface = ocl.STLSurf()
        for three in corners:
            self.surface.addTriangle(ocl.Triangle(*(ocl.Point(*map(float, corner)) for corner in three)))
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self.edges = edges_of(corners, normals / np.linalg.norm(normals, axis=1)[:, None])

    def rest(self, places, radius, corner):
        """Z of the tip of a cutter at rest over places, where it touches, and the Z of the unit normal there."""
        drop = ocl.BatchDropCutter()
        # (opencamlib keeps no cutter alive.)
        cutter = ocl.BallCutter(2.0 * radius, 200.0) if corner == radius else ocl.BullCutter(2.0 * radius, corner, 200.0)
        drop.setSTL(self.surface)
        drop.setCutter(cutter)
        for x, y, _ in places:
            drop.appendPoint(ocl.CLPoint(float(x), float(y), -1000.0))
        drop.run()
        found = drop.getCLPoints()
        z = np.array([point.z for point in found])
        touched = np.array([[point.getCC().x, point.getCC().y, point.getCC().z] for point in found])
        return z, touched, (z + corner - touched[:, 2]) / corner

    def inside(self, place):
        """Whether a place is on no rim and no ridge."""
        a, b = self.edges
        way = b - a
        t = np.clip(np.einsum("ij,ij->i", place - a, way) / np.einsum("ij,ij->i", way, way), 0, 1)
        return np.linalg.norm(place - a - t[:, None] * way, axis=1).min() > BESIDE


def edges_of(corners, normals):
    """Both ends of the edges that one facet alone has, or two that meet at a ridge."""
    places, at = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    facets = at.reshape(-1, 3)
    sides = np.sort(np.concatenate([facets[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1)
    owner = np.tile(np.arange(len(facets)), 3)
    order = np.lexsort((sides[:, 1], sides[:, 0]))
    sides, owner = sides[order], owner[order]
    both = (sides[:-1] == sides[1:]).all(axis=1)
    alone = np.append(~both, True) & np.append(True, ~both)
    cosine = np.einsum("ij,ij->i", normals[owner[:-1]], normals[owner[1:]])
    ridge = np.append(both & (cosine < np.cos(RIDGE)), False)
    return places[sides[alone | ridge].T]


def along(folder, operation):
    """Random places of the tip along the cutting moves, all as likely; those straight up or down are to touch nothing."""
    ends, feed = moves(folder / "program" / operation["file"])
    ends = np.array(ends)[feed]
    ends = ends[(ends[:, 0, :2] != ends[:, 1, :2]).any(axis=1)]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    r = np.random.default_rng(1)
    chosen = r.choice(len(ends), PLACES[operation["operation"]], p=length / length.sum())
    return ends[chosen, 0] + r.random(len(chosen))[:, None] * (ends[chosen, 1] - ends[chosen, 0])


def cut(folder, operation, face, chord_um, is_first):
    """Places of the tip over the mirror against the height at which a ball comes to rest on the mesh."""
    name, asked = operation["operation"], operation["allowance_mm"]
    tips = along(folder, operation)
    radius = operation.get("ball_mm") or operation["radius_mm"]
    z, touched, lean = face.rest(tips, radius + asked, operation.get("corner_mm", radius) + asked)
    on = z > OFF
    above = 1e3 * ((tips[:, 2] - asked - z) * lean)[on]
    limit = DEEP + chord_um + ROUGH[name] * asked
    tell(f"{folder.name}: {name}: {on.sum()} places, {above.min():.3f} um above rest at least, {-limit:.2f} allowed", above.min() >= -limit)
    if name == "finishing":
        inside = np.array([face.inside(place) for place in touched[on]])
        high, share = above[inside].max(), float(np.mean(np.abs(above[inside]) <= DEEP))
        figures = f"{inside.sum()} of the places touch the mirror inside, {high:.3f} um above rest at most"
        tell(f"{folder.name}: {figures}, {share:.4f} within {DEEP} um", high <= limit and inside.mean() > 0.8)
        if is_first:
            tell(f"{folder.name}: a tip 2 um lower fails", above.min() - 2.0 < -limit)
            tell(f"{folder.name}: a tip 2 um higher fails", high + 2.0 > limit)


def main(out, *names):
    for name in names:
        folder = pathlib.Path(out) / name
        report = json.loads((folder / "program" / "program.json").read_text())
        chord_um = json.loads((folder / "report.json").read_text())["mesh"]["chord_um"]["bound"]
        for operation in report["operations"]:
            same_places(folder / "program" / operation["file"])
        face = Face(folder / "mirror.obj")
        for operation in report["operations"]:
            cut(folder, operation, face, chord_um, name == names[0])


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
    sys.exit(failed)
