#!/usr/bin/env python3
"""Meshes a surface once with pydelatin, gmsh or OpenCASCADE.

usage: mesh_peers.py FOLDER SURFACE PROGRAM

FOLDER is what `cargo bench --bench mesh -- --write FOLDER` makes; the mesh goes there as
SURFACE-PROGRAM.npz. Prints the seconds of the mesher's own call: grids, fields and surfaces are made
before the clock starts.

- pydelatin: greedy insertion on a grid of heights, so fine that the grid's own error is a
  hundredth of the tolerance.
- gmsh: the flat rectangle meshed with a background field sized for the tolerance and then lifted:
  "isotropic" by the largest curvature (Frontal-Delaunay), "metric" by the Hessian (BAMG).
- OpenCASCADE: the exact Bezier surface and BRepMesh_IncrementalMesh with that linear deflection.
"""

import json
import math
import sys
import time
from pathlib import Path

import numpy as np

from surfaces import Surface

GRID_SHARE = 0.01
# Nodes a side of gmsh's background field.
FIELD = 201


def lifted(surface, flat):
    return np.column_stack([flat, surface.height(flat[:, 0], flat[:, 1])])


def pydelatin(surface):
    from pydelatin import Delatin

    size = surface.high - surface.low
    bend = max(np.abs(h).max() for h in surface.hessian(*surface.axes((FIELD, FIELD))))
    step = math.sqrt(4 * GRID_SHARE * surface.limit / bend)
    x, y = surface.axes([math.ceil(side / step) + 1 for side in size])
    heights = surface.height(*np.meshgrid(x, y)).astype(np.float32)

    start = time.perf_counter()
    made = Delatin(heights, max_error=surface.limit)
    triangles, corners = made.triangles, made.vertices
    taken = time.perf_counter() - start
    # Its rows may count from the other side.
    place = np.rint(corners[:, :2]).astype(int)
    row = place[:, 1]
    if not np.allclose(heights[row, place[:, 0]], corners[:, 2], atol=1e-6):
        row = len(y) - 1 - row
    flat = np.column_stack([x[place[:, 0]], y[row]])
    return taken, lifted(surface, flat), np.asarray(triangles).reshape(-1, 3)


def gmsh_with(surface, metric):
    import gmsh

    x, y = surface.axes((FIELD, FIELD))
    xx, xy, yy = surface.hessian(x, y)
    hessian = np.moveaxis(np.array([[xx, xy], [xy, yy]]), (0, 1), (2, 3))
    bends, ways = np.linalg.eigh(hessian)
    bends = np.abs(bends)
    # No longer than the part; an equilateral triangle of side l deviates by bend l^2 / 6.
    side = max(surface.high - surface.low)
    bends = np.maximum(bends, 6 * surface.limit / side**2)
    if metric:
        values = np.einsum("xyik,xyk,xyjk->xyij", ways, bends / (6 * surface.limit), ways)
        tensor = np.zeros((FIELD, FIELD, 3, 3))
        tensor[..., :2, :2], tensor[..., 2, 2] = values, 1.0
        values, kind = tensor.reshape(FIELD, FIELD, 9), "TT"
    else:
        values, kind = np.sqrt(6 * surface.limit / bends.max(-1))[..., None], "ST"

    grid = np.moveaxis(np.array(np.meshgrid(x, y, indexing="ij")), 0, -1)
    elements = []
    for corners in [((0, 0), (1, 0), (1, 1)), ((0, 0), (1, 1), (0, 1))]:
        parts = [slice(k, FIELD - 1 + k) for k in (0, 1)]
        places = [grid[parts[i], parts[j]] for i, j in corners]
        sizes = [values[parts[i], parts[j]].reshape((FIELD - 1) ** 2, -1) for i, j in corners]
        xs, ys = ([p[..., k].ravel() for p in places] for k in (0, 1))
        zeros = [np.zeros_like(column) for column in xs]
        elements.append(np.column_stack([*xs, *ys, *zeros, *sizes]))
    elements = np.concatenate(elements)

    gmsh.initialize(["-noenv", "-v", "0"], readConfigFiles=False)
    try:
        for option, value in {
            "General.Terminal": 0,
            "Mesh.Algorithm": 7 if metric else 6,
            "Mesh.MeshSizeExtendFromBoundary": 0,
            "Mesh.MeshSizeFromPoints": 0,
            "Mesh.MeshSizeFromCurvature": 0,
        }.items():
            gmsh.option.setNumber(option, value)
        view = gmsh.view.add("size")
        gmsh.view.addListData(view, kind, len(elements), elements.ravel())
        field = gmsh.model.mesh.field.add("PostView")
        gmsh.model.mesh.field.setNumber(field, "ViewTag", view)
        gmsh.model.mesh.field.setAsBackgroundMesh(field)
        gmsh.model.occ.addRectangle(*surface.low, 0, *(surface.high - surface.low))
        gmsh.model.occ.synchronize()
        start = time.perf_counter()
        gmsh.model.mesh.generate(2)
        taken = time.perf_counter() - start
        tags, places, _ = gmsh.model.mesh.getNodes()
        number = np.zeros(int(tags.max()) + 1, int)
        number[tags.astype(int)] = np.arange(len(tags))
        _, corners = gmsh.model.mesh.getElementsByType(2)
        triangles = number[corners.astype(int)].reshape(-1, 3)
        return taken, lifted(surface, places.reshape(-1, 3)[:, :2]), triangles
    finally:
        gmsh.finalize()


def gmsh_isotropic(surface):
    return gmsh_with(surface, metric=False)


def gmsh_metric(surface):
    return gmsh_with(surface, metric=True)


def opencascade(surface):
    from OCP.BRep import BRep_Tool
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.collections import Array2_gp_Pnt
    from OCP.Geom import Geom_BezierSurface
    from OCP.gp import gp_Pnt
    from OCP.TopLoc import TopLoc_Location

    x, y, heights = surface.bezier()
    poles = Array2_gp_Pnt(1, len(x), 1, len(y))
    for i, j in np.ndindex(heights.shape):
        poles.SetValue(i + 1, j + 1, gp_Pnt(float(x[i]), float(y[j]), float(heights[i, j])))

    face = BRepBuilderAPI_MakeFace(Geom_BezierSurface(poles), 1e-7).Face()
    start = time.perf_counter()
    # The angle is no limit, and the deflection is absolute.
    BRepMesh_IncrementalMesh(face, surface.limit, False, 3.0, True)
    taken = time.perf_counter() - start
    mesh = BRep_Tool.Triangulation_s(face, TopLoc_Location())
    nodes = (mesh.Node(k) for k in range(1, mesh.NbNodes() + 1))
    vertices = np.array([(p.X(), p.Y(), p.Z()) for p in nodes])
    faces = (mesh.Triangle(k) for k in range(1, mesh.NbTriangles() + 1))
    triangles = np.array([[t.Value(k) for k in (1, 2, 3)] for t in faces]) - 1
    return taken, vertices, triangles


PROGRAMS = {
    "pydelatin": pydelatin,
    "gmsh-isotropic": gmsh_isotropic,
    "gmsh-metric": gmsh_metric,
    "opencascade": opencascade,
}


def main():
    folder, name, program = Path(sys.argv[1]), sys.argv[2], sys.argv[3]
    given = json.loads((folder / "surfaces.json").read_text())
    surface = next(Surface(one) for one in given if one["name"] == name)
    seconds, vertices, triangles = PROGRAMS[program](surface)
    np.savez(folder / f"{name}-{program}.npz", vertices=vertices, triangles=triangles)
    print(json.dumps({"seconds": seconds}))


if __name__ == "__main__":
    main()
