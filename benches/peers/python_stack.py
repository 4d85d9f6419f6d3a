#!/usr/bin/env python3
"""The conquistador job as a user would write it today in Python.

numpy designs the mirror (cylindrical law, orthographic camera, target at infinity), scipy's
Delaunay meshes it, trimesh closes it, writes the STL and reads it back, Embree traces a 640 x 480
frame against what was read, one shadow ray for each ray that hits.

Prints one JSON object: seconds a stage, triangles, and the error of the file read back.
`triangles` counts every facet: the optical ones, as many on the underside, and the skirt.
"""

import argparse
import json
import time

import numpy as np
import trimesh
from numpy.polynomial import legendre
from scipy.spatial import Delaunay
from trimesh.ray.ray_pyembree import RayMeshIntersector

# Paper units are radians: the panel spans |y| <= HALF_Y, |z| <= HALF_Z.
HALF_Y, HALF_Z = np.pi / 2, 3 * np.pi / 16
COLUMNS, ROWS = 640, 480
WIDTH_MM, BASE_MM = 60.0, 5.0
SCALE = WIDTH_MM / (2 * HALF_Y)
DEGREE = 12
LARGEST_CURVATURE = 1.85


def design():
    """Legendre coefficients of the f that minimises the integral of |grad f - s|^2."""
    nodes, weights = legendre.leggauss(3 * DEGREE)
    u, v = (a.ravel() for a in np.meshgrid(nodes, nodes, indexing="ij"))
    w = np.sqrt(np.outer(weights, weights).ravel())

    identity = np.eye(DEGREE + 1)
    slope = [legendre.legder(row) for row in identity]
    pu, pv = legendre.legvander(u, DEGREE), legendre.legvander(v, DEGREE)
    du = np.stack([legendre.legval(u, c) for c in slope], -1) / HALF_Y
    dv = np.stack([legendre.legval(v, c) for c in slope], -1) / HALF_Z

    i, j = (k.ravel()[1:] for k in np.indices((DEGREE + 1, DEGREE + 1)))  # all but the constant
    rows = np.concatenate([du[:, i] * pv[:, j], pu[:, i] * dv[:, j]])
    y, e = u * HALF_Y, np.exp(-np.arcsinh(v * HALF_Z))
    wanted = np.concatenate([-np.sin(y) * e, -np.cos(y) * e])
    w = np.concatenate([w, w])
    solution = np.linalg.lstsq(rows * w[:, None], wanted * w, rcond=None)[0]

    coefficients = np.zeros((DEGREE + 1, DEGREE + 1))
    coefficients[i, j] = solution
    return coefficients


def grid_for_tolerance(mrad):
    """Points a side, so that facet normals hold the tolerance at the largest curvature."""
    h = mrad * 1e-3 / LARGEST_CURVATURE * np.sqrt(3)
    return int(2 * HALF_Y / h) + 2, int(2 * HALF_Z / h) + 2


def grid_for_triangles(count):
    """Points a side of a square grid with about `count` triangles over both panels."""
    h = 4 * np.sqrt(HALF_Y * HALF_Z / count)
    cells_y = max(1, round(2 * HALF_Y / h))
    cells_z = max(1, round(count / (4 * cells_y)))
    return cells_y + 1, cells_z + 1


def mesh(coefficients, points_y, points_z):
    """Vertices (mm) and triangles of both panels, the second mirrored in the first one's edge."""
    y = np.linspace(-HALF_Y, HALF_Y, points_y)
    z = np.linspace(-HALF_Z, HALF_Z, points_z)
    sag = legendre.leggrid2d(y / HALF_Y, z / HALF_Z, coefficients)
    flat = np.stack(np.meshgrid(y, z, indexing="ij"), -1).reshape(-1, 2)
    triangles = Delaunay(flat).simplices
    upper = np.column_stack([flat, sag.ravel()])
    lower = upper * [1, -1, 1] - [0, 2 * HALF_Z, 0]
    vertices = np.concatenate([upper, lower]) * SCALE
    return vertices, np.concatenate([triangles, triangles[:, ::-1] + len(upper)])


def close(vertices, triangles):
    """The optical face, the same face flat on the base plane, and a skirt between them."""
    face = trimesh.Trimesh(vertices, triangles, process=True)
    if face.face_normals[:, 2].sum() < 0:
        face.invert()
    rim = face.edges[trimesh.grouping.group_rows(face.edges_sorted, require_count=1)]
    base = face.vertices.copy()
    base[:, 2] = face.vertices[:, 2].min() - BASE_MM
    n, a, b = len(base), rim[:, 0], rim[:, 1]
    faces = np.concatenate(
        [
            face.faces,
            face.faces[:, ::-1] + n,
            np.column_stack([b, a, a + n]),
            np.column_stack([b, a + n, b + n]),
        ]
    )
    return trimesh.Trimesh(np.concatenate([face.vertices, base]), faces, process=False)


def trace(solid):
    """One ray through each pixel's centre; the world it sees against the world it should see."""
    y = (np.arange(COLUMNS) + 0.5) / COLUMNS * 2 * HALF_Y - HALF_Y
    z = HALF_Z - (np.arange(ROWS) + 0.5) / ROWS * 4 * HALF_Z
    q = np.stack(np.meshgrid(y, z), -1).reshape(-1, 2)
    origins = np.column_stack([q * SCALE, np.full(len(q), solid.bounds[1, 2] + 100.0)])
    down = np.tile([0.0, 0.0, -1.0], (len(q), 1))

    rays = RayMeshIntersector(solid)
    hit = rays.intersects_first(origins, down)
    seen = hit >= 0
    q, origins, down, hit = q[seen], origins[seen], down[seen], hit[seen]
    normals = solid.face_normals[hit]
    into = (down * normals).sum(1)
    away = down - 2 * into[:, None] * normals
    depth = ((solid.triangles[hit, 0] - origins) * normals).sum(1) / into
    points = origins + depth[:, None] * down
    shadowed = rays.intersects_any(points + 1e-3 * away, away)

    # The lower panel sees the world reflected; its rows count downward from the crest.
    is_lower = q[:, 1] < -HALF_Z
    side = np.where(is_lower, -1.0, 1.0)
    wanted_z = np.where(is_lower, -2 * HALF_Z - q[:, 1], q[:, 1])
    wanted = np.column_stack([np.sin(q[:, 0]), side * np.cos(q[:, 0]), wanted_z])
    wanted /= np.sqrt(1 + wanted_z**2)[:, None]
    angle = np.arcsin(np.minimum(np.linalg.norm(np.cross(away, wanted), axis=1), 1))

    azimuth = np.arctan2(away[:, 0], side * away[:, 1])
    height = away[:, 2] / np.hypot(away[:, 0], away[:, 1])
    pixel = 2 * HALF_Y / COLUMNS
    error = np.hypot(azimuth - q[:, 0], height - wanted_z) / pixel
    return {
        "rays": int(len(seen)),
        "hit": int(seen.sum()),
        "shadowed": int(shadowed.sum()),
        "ray_error_mrad": summary(angle * 1e3),
        "pixel_error_px": summary(error),
    }


def summary(values):
    return {"rms": float(np.sqrt((values**2).mean())), "max": float(values.max())}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("out", metavar="OUT.stl")
    size = parser.add_mutually_exclusive_group()
    size.add_argument("tolerance_mrad", nargs="?", type=float, default=2.5, help="of facet normals")
    size.add_argument("--optical-triangles", type=int, metavar="N", help="about N, both panels")
    args = parser.parse_args()

    seconds = {}
    last = time.perf_counter()

    def lap(stage):
        nonlocal last
        now = time.perf_counter()
        seconds[stage] = round(now - last, 3)
        last = now

    coefficients = design()
    lap("design")
    if args.optical_triangles:
        grid = grid_for_triangles(args.optical_triangles)
    else:
        grid = grid_for_tolerance(args.tolerance_mrad)
    vertices, triangles = mesh(coefficients, *grid)
    lap("mesh")
    solid = close(vertices, triangles)
    watertight = bool(solid.is_watertight)
    lap("solid")
    solid.export(args.out)
    lap("export")
    back = trimesh.load(args.out)
    lap("read back")
    traced = trace(back)
    lap("trace")

    result = {
        "seconds": seconds,
        "total_seconds": round(sum(seconds.values()), 3),
        "optical_triangles": len(triangles),
        "triangles": len(solid.faces),
        "watertight": watertight,
    }
    print(json.dumps(result | traced))


if __name__ == "__main__":
    main()
