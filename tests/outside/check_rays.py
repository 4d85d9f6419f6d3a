#!/usr/bin/env python3
"""Asks Embree what the camera sees in STL files, and holds Morion's witness against it.

usage: check_rays.py OUT NAME...

OUT/NAME.toml is the profile, OUT/NAME/mirror.stl the file that was built of it, and OUT/NAME/rays
what `cargo test --bench trace -- --profile OUT/NAME.toml --stl OUT/NAME/mirror.stl --dump
OUT/NAME/rays` wrote of the witness: a ray, a facet and a direction for each pixel.

The rays are made here again, from the profile's camera and the place of its entrance pupil in
OUT/NAME/report.json, which also has the size of the part; Embree finds their facets, in single
precision; the reflected directions follow from the facets' corners, in double. Where both find
different facets, the ray must pass both within single precision, and Morion's direction must be that
of its own facet. Prints one line per mirror; exits 1 if a direction is farther off than 1e-5 rad.

Before the first mirror it is proven that the check can fail: of a file turned by 1e-4 rad, and of
one with a corner that is 1 um higher, it must.
"""

import json
import math
import pathlib
import sys
import tomllib

import numpy as np
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh
from verdicts import told

NEAR = 1e-5  # rad, between directions
SHARE = 8 * 2.0**-24  # of the coordinates: single precision's rounding
SIZE = 0.02  # mm: facets cut corners off
RAY = 1e-9  # mm and rad, between the rays of both
REFLECTED, MISSED = 0, 1


def corners_of(path):
    """Three corners of each facet, in the file's order."""
    facet = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    facets = np.fromfile(path, facet, offset=84)
    (count,) = np.fromfile(path, "<u4", 1, offset=80)
    if count != len(facets):
        raise ValueError(f"{len(facets)} facets, not {count}")
    return facets["corners"].astype(float)


def camera_rays(profile, layout, corners):
    """Origin and unit direction of the ray through the middle of each pixel, row by row."""
    (kind, camera), *_ = profile["camera"].items()
    width, height = camera["pixels"]
    column, row = np.meshgrid(
        np.arange(width) + 0.5 - width / 2, height / 2 - np.arange(height) - 0.5
    )
    column, row = column.ravel(), row.ravel()
    zero = np.zeros_like(column)
    if kind == "orthographic":
        pixel = profile["part"]["width_mm"] / width
        above = 2 * np.abs(corners).max()
        origins = np.column_stack([column * pixel, row * pixel, zero + above])
        return origins, np.column_stack([zero, zero, zero - 1])
    if kind == "calibrated":
        directions = calibrated_directions(camera)
    else:
        directions = np.column_stack([column, row, zero - focal_px(camera)])
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    directions = turned(directions, layout.get("looks_along", [0, 0, -1]))
    return zero[:, None] + np.array(layout["pupil_mm"]), directions


def focal_px(camera):
    """Focal length of a pinhole camera in pixels."""
    if "lens_mm" in camera:
        return 1e3 * camera["lens_mm"] / camera["pixel_um"]
    half = math.radians(camera.get("hfov_deg", 0)) / 2
    return camera.get("focal_px") or camera["pixels"][0] / 2 / math.tan(half)


def calibrated_directions(camera):
    """Directions of the rays of a lens with OpenCV's distortion (k1, k2, p1, p2, k3), by fixed-point iteration."""
    width, height = camera["pixels"]
    k1, k2, p1, p2, k3 = camera["distortion"]
    (fx, fy), (cx, cy) = camera["focal_px"], camera["principal_px"]
    u, v = np.meshgrid((np.arange(width) - cx) / fx, (np.arange(height) - cy) / fy)
    u, v = u.ravel(), v.ravel()
    x, y = u, v
    for _ in range(200):
        square = x * x + y * y
        radial = 1 + square * (k1 + square * (k2 + square * k3))
        x, y = (
            (u - 2 * p1 * x * y - p2 * (square + 2 * x * x)) / radial,
            (v - p1 * (square + 2 * y * y) - 2 * p2 * x * y) / radial,
        )
    return np.column_stack([x, -y, np.full_like(x, -1.0)])


def turned(directions, along):
    """The directions after the shortest turn that carries -Z to `along`."""
    axis = np.cross([0, 0, -1], along)
    cosine = -along[2]
    across = np.cross(np.broadcast_to(axis, directions.shape), directions)
    return directions * cosine + across + np.outer(directions @ axis, axis) / (1 + cosine)


def seen_by_embree(corners, origins, directions):
    """The facet that each ray meets first, or -1."""
    scene = rtcore_scene.EmbreeScene()
    triangles = np.arange(3 * len(corners), dtype=np.int32).reshape(-1, 3)
    TriangleMesh(scene, corners.reshape(-1, 3).astype(np.float32), triangles)
    found = scene.run(origins.astype(np.float32), directions.astype(np.float32), query="INTERSECT")
    return np.asarray(found).astype(int)


def mirrored(corners, directions):
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    return directions - 2 * np.einsum("ij,ij->i", directions, normal)[:, None] * normal


def beside(corners, origins, directions):
    """How far each ray passes outside its facet, at most, mm; below zero within it."""
    at = corners - origins[:, None]
    ways = [np.cross(at[:, k - 2], at[:, k - 1]) for k in range(3)]
    sides = [np.einsum("ij,ij->i", directions, way) for way in ways]
    turn = np.sign(sum(sides))
    far = []
    for k in range(3):
        edge = at[:, k - 1] - at[:, k - 2]
        across = np.linalg.norm(np.cross(directions, edge), axis=1)
        far.append(-sides[k] * turn / np.maximum(across, 1e-300))
    return np.max(far, axis=0)


def compared(corners, rays, seen):
    """Figures in short, and what is wrong."""
    origins, directions = rays
    wrong = []
    outcome, facet, leaving = seen[:, 0], seen[:, 1].astype(int), seen[:, 3:]
    if ((outcome == MISSED) != (facet < 0)).any():
        wrong.append("rays that missed have facets")
    found = seen_by_embree(corners, origins, directions)
    other = found != facet
    rounding = SHARE * np.abs(corners).max()
    tie = other.copy()
    for which in (found, facet):
        met = other & (which >= 0)
        tie[met] &= np.abs(beside(corners[which[met]], origins[met], directions[met])) <= rounding
    different = int((other & ~tie).sum())
    # Of ties by Morion's own facet, which passes as near.
    by = np.where(tie, facet, found)
    hit = (by >= 0) & (facet >= 0)
    apart = mirrored(corners[by[hit]], directions[hit]) - leaving[hit]
    angle = 2 * np.arcsin(np.minimum(np.linalg.norm(apart, axis=1) / 2, 1)).max(initial=0.0)
    if different:
        wrong.append(f"{different} rays meet other facets")
    if not angle <= NEAR:
        wrong.append(f"directions {angle:.1e} rad apart")
    if not hit.any():
        wrong.append("no ray meets the mirror")
    figures = (
        f"{len(found)} rays, {int(hit.sum())} reflected, {int(tie.sum())} ties, "
        f"directions within {angle:.1e} rad"
    )
    return figures, wrong


def one(out, name):
    profile = tomllib.loads((out / f"{name}.toml").read_text())
    corners = corners_of(out / name / "mirror.stl")
    layout = json.loads((out / name / "report.json").read_text())["layout"]
    origins, directions = camera_rays(profile, layout, corners)
    theirs = np.fromfile(out / name / "rays" / "rays.f64").reshape(-1, 6)
    seen = np.fromfile(out / name / "rays" / "found.f64").reshape(-1, 6)
    # A ray may start anywhere on its line.
    apart = theirs[:, :3] - origins
    apart -= np.einsum("ij,ij->i", apart, directions)[:, None] * directions
    off = max(np.abs(apart).max(), np.abs(theirs[:, 3:] - directions).max())
    figures, wrong = compared(corners, (origins, directions), seen)
    if not off <= RAY:
        wrong.append(f"rays {off:.1e} from the profile's")
    size = np.ptp(corners.reshape(-1, 3), axis=0)
    if not np.abs(size - layout["size_mm"]).max() <= SIZE:
        wrong.append(f"{size} mm large, not {layout['size_mm']}")
    return corners, (origins, directions), seen, figures, wrong


def must_fail(corners, rays, seen):
    """Complaints, if altered files pass."""
    turn = 1e-4 * np.array([[0, 0, 0], [0, 0, -1], [0, 1, 0]]) + np.eye(3)
    raised = corners.copy()
    met = seen[seen[:, 0] == REFLECTED, 1].astype(int)
    raised[met[len(met) // 2], 0, 2] += 1e-3
    altered = {"turned by 1e-4 rad": corners @ turn.T, "with a corner 1 um higher": raised}
    return [
        f"a file {how} passes" for how, file in altered.items() if not compared(file, rays, seen)[1]
    ]


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    out, names = pathlib.Path(sys.argv[1]), sys.argv[2:]

    def complaints(name):
        corners, rays, seen, figures, wrong = one(out, name)
        if name == names[0]:
            blind = must_fail(corners, rays, seen)
            wrong += blind
            figures += "" if blind else ", altered files fail"
        return figures, wrong

    sys.exit(told("embree", names, complaints))


if __name__ == "__main__":
    main()
