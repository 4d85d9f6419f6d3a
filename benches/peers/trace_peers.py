#!/usr/bin/env python3
"""Traces the rays of FOLDER with Embree on one core and holds every hit against Morion's.

FOLDER is what `cargo bench --bench trace -- --dump FOLDER` makes. Embree traces in single
precision through embreex, a ray at a time as its interface has it: first the camera rays
(INTERSECT), then from Morion's hits the reflected rays (OCCLUDED). A pair is one of each. The
fastest of some runs counts, for Morion as for Embree.

Two facets for one ray are a tie where the ray passes both within Embree's rounding. Exit code 1
when any ray differs otherwise.
"""

import argparse
import os
import sys
import time
from pathlib import Path

import numpy as np

# Embree's rounding, as a share of the coordinates: single precision has 24 bits.
SHARE = 8 * 2.0**-24
# Shadow rays start this share of the mesh's size ahead, or they meet the facet they leave.
AHEAD = 1e-6
SHADOWED = 2


def read(folder):
    def numbers(name, columns):
        return np.fromfile(folder / name).reshape(-1, columns)

    triangles = np.fromfile(folder / "triangles.u32", dtype=np.uint32).reshape(-1, 3)
    return numbers("vertices.f64", 3), triangles, numbers("rays.f64", 6), numbers("found.f64", 6)


def beside(corners, origins, directions):
    """How far each ray passes outside its facet, at most; zero within it."""
    at = corners - origins[:, None, :]
    sides = [
        np.einsum("ij,ij->i", directions, np.cross(at[:, (k + 1) % 3], at[:, (k + 2) % 3]))
        for k in range(3)
    ]
    turn = np.sign(sum(sides))
    far = np.zeros(len(at))
    for k in range(3):
        edge = at[:, (k + 2) % 3] - at[:, (k + 1) % 3]
        across = np.linalg.norm(np.cross(directions, edge), axis=1)
        far = np.maximum(far, -sides[k] * turn / np.maximum(across, 1e-300))
    return far


def least(runs, run):
    best, result = np.inf, None
    for _ in range(runs):
        start = time.perf_counter()
        result = run()
        best = min(best, time.perf_counter() - start)
    return best, result


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--runs", type=int, default=9)
    args = parser.parse_args()
    ours = dict(line.split(" ", 1) for line in (args.folder / "morion.txt").read_text().splitlines())
    try:
        from embreex import rtcore_scene
        from embreex.mesh_construction import TriangleMesh
    except ImportError:
        print("embree: not installed, skipped")
        return 0
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})

    vertices, triangles, rays, found = read(args.folder)
    origins, directions = rays[:, :3], rays[:, 3:]
    outcome, facet, distance, leaving = found[:, 0], found[:, 1].astype(int), found[:, 2], found[:, 3:]
    size = np.abs(vertices).max()

    def build():
        scene = rtcore_scene.EmbreeScene()
        TriangleMesh(scene, vertices.astype(np.float32), triangles.astype(np.int32))
        # The tree is built by the first call.
        scene.run(origins[:1].astype(np.float32), directions[:1].astype(np.float32))
        return scene

    built, scene = least(3, build)
    o, d = origins.astype(np.float32), directions.astype(np.float32)
    primary, hits = least(args.runs, lambda: scene.run(o, d, query="INTERSECT"))
    hits = np.asarray(hits).astype(int)

    reflected = (outcome == 0) | (outcome == SHADOWED)
    starts = origins[reflected] + directions[reflected] * distance[reflected, None]
    along = leaving[reflected]
    so = (starts + along * AHEAD * size).astype(np.float32)
    sd = along.astype(np.float32)
    shadow, blocked = least(args.runs, lambda: scene.run(so, sd, query="OCCLUDED"))
    blocked = np.asarray(blocked) >= 0
    ends = outcome[reflected] == SHADOWED

    different = hits != facet
    both = different & (hits >= 0) & (facet >= 0)
    tie = np.zeros(len(hits), bool)
    for which in (hits, facet):
        corners = vertices[triangles[which[both]]]
        near = beside(corners, origins[both], directions[both])
        tie[both] = (near <= SHARE * size) & (tie[both] | (which is hits))
    wrong = int((different & ~tie).sum())
    print(f"facets: {len(hits)} rays, {int(tie.sum())} ties, {wrong} otherwise different")
    print(f"shadow: {len(ends)} rays, {int(ends.sum())} shadowed, {int((blocked != ends).sum())} different")

    pairs = len(hits) / (primary + shadow) * 1e-6
    morion = float(ours["pairs_1"].split()[0])
    seconds = len(hits) / morion * 1e-6
    tables = sum(float(ours[f"build_{what}_1"].split()[0]) for what in ("general", "proofs")) * 1e-3
    print(f"embree: {len(hits) / primary * 1e-6:.2f} M camera rays/s, {pairs:.2f} M pairs/s, built in {built * 1e3:.0f} ms")
    print(f"morion: {morion:.2f} M pairs/s, tables in {tables * 1e3:.0f} ms")
    print(f"ratio: {morion / pairs:.1f}; building included {(primary + shadow + built) / (seconds + tables):.1f}")
    return 0 if wrong == 0 and (blocked == ends).all() else 1


if __name__ == "__main__":
    sys.exit(main())
