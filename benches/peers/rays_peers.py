#!/usr/bin/env python3
"""Traces the rays of FOLDER with Embree or Mitsuba 3 on one core and holds every hit against Morion's.

usage: rays_peers.py FOLDER embree|mitsuba RUNS

FOLDER is what `cargo bench --bench trace -- --dump FOLDER` makes. First come the camera rays, then
from Morion's hits the reflected rays, which ask only whether anything is in the way; the fastest of
RUNS counts. Both trace in single precision.

- Embree through embreex: all rays in one call, which traces a ray at a time.
- Mitsuba: a wavefront of an LLVM variant, whose code is compiled before the clock starts, or where
  there is no LLVM library a ray at a time of scalar_rgb. It traces by its own Embree.

Two facets for one ray are a tie where the ray passes both within single precision.
"""

import json
import os
import sys
import time
from pathlib import Path

import numpy as np

# Single precision's rounding, as a share of the coordinates: it has 24 bits.
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


class Embree:
    def __init__(self, vertices, triangles):
        from embreex import rtcore_scene
        from embreex.mesh_construction import TriangleMesh

        self.name = "embreex"
        self.scene = rtcore_scene.EmbreeScene()
        TriangleMesh(self.scene, vertices.astype(np.float32), triangles.astype(np.int32))
        # The tree is built by the first call.
        self.scene.run(np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32))

    def prepared(self, origins, directions):
        return origins.astype(np.float32), directions.astype(np.float32)

    def first(self, rays):
        return np.asarray(self.scene.run(*rays, query="INTERSECT")).astype(int)

    def blocked(self, rays):
        return np.asarray(self.scene.run(*rays, query="OCCLUDED")) >= 0


class Mitsuba:
    def __init__(self, vertices, triangles):
        import drjit
        import mitsuba

        if not (mitsuba.variant() or "").startswith(("llvm", "scalar")):
            try:
                mitsuba.set_variant("llvm_ad_rgb")
                drjit.set_thread_count(1)
                drjit.eval(mitsuba.Float(0) + 1)
            except Exception as error:
                print(
                    f"no LLVM for Mitsuba (Debian: apt-get install libllvm15): {error}",
                    file=sys.stderr,
                )
                mitsuba.set_variant("scalar_rgb")
        self.name, self.mi, self.dr = mitsuba.variant(), mitsuba, drjit
        mesh = mitsuba.Mesh("part", len(vertices), len(triangles))
        given = mitsuba.traverse(mesh)
        given["vertex_positions"] = vertices.astype(np.float32).ravel()
        given["faces"] = triangles.ravel()
        given.update()
        self.scene = mitsuba.load_dict({"type": "scene", "part": mesh})

    def prepared(self, origins, directions):
        ray = self.mi.Ray3f
        if self.name.startswith("scalar"):
            return [ray(o, d) for o, d in zip(origins.tolist(), directions.tolist(), strict=True)]
        rays = ray(
            *(self.mi.Point3f(np.ascontiguousarray(v.T, np.float32)) for v in (origins, directions))
        )
        self.dr.eval(rays)
        self.dr.sync_thread()
        return rays

    def first(self, rays):
        if isinstance(rays, list):
            found = (self.scene.ray_intersect_preliminary(ray) for ray in rays)
            return np.array([hit.prim_index if hit.is_valid() else -1 for hit in found])
        found = self.scene.ray_intersect_preliminary(rays)
        facets = self.dr.select(found.is_valid(), self.mi.Int32(found.prim_index), -1)
        return np.asarray(facets.numpy()).astype(int)

    def blocked(self, rays):
        if isinstance(rays, list):
            return np.array([self.scene.ray_test(ray) for ray in rays])
        return np.asarray(self.scene.ray_test(rays).numpy()).astype(bool)


def least(runs, run):
    best, result = np.inf, None
    for _ in range(runs):
        start = time.perf_counter()
        result = run()
        best = min(best, time.perf_counter() - start)
    return best, result


def main():
    folder, program, runs = Path(sys.argv[1]), sys.argv[2], int(sys.argv[3])
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    vertices, triangles, rays, found = read(folder)
    origins, directions = rays[:, :3], rays[:, 3:]
    outcome, facet, distance, leaving = (
        found[:, 0],
        found[:, 1].astype(int),
        found[:, 2],
        found[:, 3:],
    )
    size = np.abs(vertices).max()

    kind = {"embree": Embree, "mitsuba": Mitsuba}[program]
    # The first builds hold what is loaded but once.
    built, scene = least(3, lambda: kind(vertices, triangles))
    camera = scene.prepared(origins, directions)
    scene.first(camera)
    primary, hits = least(runs, lambda: scene.first(camera))

    reflected = (outcome == 0) | (outcome == SHADOWED)
    starts = origins[reflected] + directions[reflected] * distance[reflected, None]
    along = leaving[reflected]
    onwards = scene.prepared(starts + along * AHEAD * size, along)
    scene.blocked(onwards)
    shadow, blocked = least(runs, lambda: scene.blocked(onwards))
    ends = outcome[reflected] == SHADOWED

    different = hits != facet
    both = different & (hits >= 0) & (facet >= 0)
    tie = both.copy()
    for which in (hits, facet):
        corners = vertices[triangles[which[both]]]
        tie[both] &= beside(corners, origins[both], directions[both]) <= SHARE * size
    result = {
        "name": scene.name,
        "seconds": primary + shadow,
        "camera_seconds": primary,
        "built_seconds": built,
        "triangles": len(triangles),
        "rays": len(hits),
        "ties": int(tie.sum()),
        "facets_different": int((different & ~tie).sum()),
        "shadows_different": int((blocked != ends).sum()),
    }
    print(json.dumps(result))


if __name__ == "__main__":
    main()
