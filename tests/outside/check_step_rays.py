#!/usr/bin/env python3
"""Asks OpenCASCADE where the camera's rays meet the curved faces of STEP files, and holds Morion's witness against it.

usage: check_step_rays.py OUT RAYS NAME...

OUT/NAME/mirror.step is the file that was built of OUT/NAME.toml, and OUT/NAME/curved what `cargo test --bench trace --
--profile OUT/NAME.toml --step OUT/NAME/mirror.step --dump OUT/NAME/curved` wrote of the witness. Of so many RAYS, spread
over the frame, OpenCASCADE's own intersection finds the first face and its normal. Prints one line per mirror; exits 1 if a
distance differs by more than 1e-8 mm or a reflected direction by more than 1e-8 rad, or one of both misses. Rays of which
OpenCASCADE finds an odd number of crossings of the closed body are left out; they may be one in a hundred.

Before the first mirror it is proven that the check can fail: of rays that are moved by 1e-6 mm it must.
"""

import pathlib
import sys

import numpy as np
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepLProp import BRepLProp_SLProps
from OCP.gp import gp_Dir, gp_Lin, gp_Pnt
from OCP.IntCurvesFace import IntCurvesFace_ShapeIntersector
from OCP.STEPControl import STEPControl_Reader
from verdicts import told

FAR = 1e-8  # mm, between distances along a ray
TURNED = 1e-8  # rad, between directions
TOLERANCE = 1e-10  # mm, of OpenCASCADE's search
LOST = 0.01  # of the rays, by OpenCASCADE alone
MISSED = 1


class Lost(Exception):
    """OpenCASCADE meets a closed body an odd number of times: it lost a face beside an edge."""


def shape_of(path):
    reader = STEPControl_Reader()
    reader.ReadFile(str(path))
    reader.TransferRoots()
    return reader.OneShape()


def first_hit(search, origin, along):
    """Distance to the first face and the direction of the reflected ray; none where there is no face."""
    search.Perform(gp_Lin(gp_Pnt(*origin), gp_Dir(*along)), 0.0, 1e6)
    hits = [(search.WParameter(k), k) for k in range(1, search.NbPnt() + 1)]
    if not hits:
        return None
    if len(hits) % 2:
        raise Lost
    distance, k = min(hits)
    surface = BRepAdaptor_Surface(search.Face(k))
    u, v = search.UParameter(k), search.VParameter(k)
    normal = BRepLProp_SLProps(surface, u, v, 1, 1e-12).Normal()
    normal = np.array([normal.X(), normal.Y(), normal.Z()])
    return distance, along - 2 * normal * (along @ normal)


def compared(search, rays, found):
    """Largest differences of distances and of directions, and the numbers of rays that one of both misses and that
    OpenCASCADE lost."""
    far = turned = missed = lost = 0
    for (*origin, x, y, z), (outcome, _, distance, *direction) in zip(rays, found):
        try:
            met = first_hit(search, origin, np.array([x, y, z]))
        except Lost:
            lost += 1
            continue
        if met is None or outcome == MISSED:
            missed += (met is None) != (outcome == MISSED)
            continue
        far = max(far, abs(met[0] - distance))
        if any(direction):
            turned = max(turned, np.linalg.norm(met[1] - direction))
    return far, turned, missed, lost


def main(out, count, *names):
    out = pathlib.Path(out)

    def complaints(name, moved=0.0):
        folder = out / name
        rays = np.fromfile(folder / "curved" / "rays.f64").reshape(-1, 6)
        found = np.fromfile(folder / "curved" / "found.f64").reshape(-1, 6)
        # Spread over rows and columns alike: a step that shares no factor with most frames.
        step = max(1, len(rays) // int(count)) | 1
        rays, found = rays[::step].copy(), found[::step]
        rays[:, 2] += moved
        search = IntCurvesFace_ShapeIntersector()
        search.Load(shape_of(folder / "mirror.step"), TOLERANCE)
        far, turned, missed, lost = compared(search, rays, found)
        wrong = [f"{missed} rays are missed by one alone"] if missed else []
        wrong += [f"OpenCASCADE lost {lost} rays"] if lost > LOST * len(rays) else []
        wrong += [f"{far:.1e} mm apart"] if not far <= FAR else []
        wrong += [f"{turned:.1e} rad apart"] if not turned <= TURNED else []
        return f"{len(rays)} rays ({lost} lost), {far:.1e} mm, {turned:.1e} rad", wrong

    if not complaints(names[0], 1e-6)[1]:
        print("rays that were moved are not noticed")
        return 1
    return told("opencascade rays", names, complaints)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
