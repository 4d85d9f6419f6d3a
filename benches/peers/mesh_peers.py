#!/usr/bin/env python3
"""Meshes surfaces with pydelatin, gmsh and OpenCASCADE and measures every mesh, Morion's too.

FOLDER is what `cargo bench --bench mesh -- --write FOLDER` makes: surfaces.json and one PLY a
surface. The chord error is sampled on every triangle against the formula, along Z.

- pydelatin: greedy insertion on a grid of heights, so fine that the grid's own error is a
  hundredth of the tolerance.
- gmsh: the flat rectangle meshed with a background field sized for the tolerance and then lifted:
  "isotropic" by the largest curvature (Frontal-Delaunay), "metric" by the Hessian (BAMG).
- OpenCASCADE: the exact Bezier surface and BRepMesh_IncrementalMesh with that linear deflection.

Seconds are those of the mesher's own call; grids, fields and surfaces are made before the clock
starts. The fastest of some runs counts. Morion's seconds hold everything.
"""

import argparse
import json
import math
import time
from pathlib import Path

import numpy as np
from numpy.polynomial import legendre

# The given surfaces by their formulas, the shipped ones by their series.
FORMULAS = {
    "bowl": lambda x, y: (x * x + y * y) / 1000,
    "saddle": lambda x, y: (x * x - y * y) / 1000,
    "bowl-16-to-1": lambda x, y: x * x / 250 + y * y / 4000,
    "mixed": lambda x, y: x * x / 600
    - y * y / 1500
    + 3e-6 * x**3
    + 2e-6 * x * y * y
    + 0.02 * np.sin(x / 8) * np.cos(y / 11),
}
GRID_SHARE = 0.01
SAMPLES = 12
BLOCK = 20_000
# Repeating a mesh ends after this many seconds.
PATIENCE = 10
# Nodes a side of gmsh's background field.
FIELD = 201


class Surface:
    """Heights and Hessians of one of Morion's sheets."""

    def __init__(self, given):
        self.name = given["name"]
        self.low, self.high = (np.array(corner) for corner in given["rect"])
        self.centre, self.half = np.array(given["centre"]), np.array(given["half"])
        self.scale, self.z = given["scale_mm"], given["z_mm"]
        self.coefficients = np.array(given["coefficients"])
        self.limit, self.least = given["limit_mm"], given["least"]

    def height(self, x, y):
        if self.name in FORMULAS:
            return FORMULAS[self.name](x, y)
        u, v = (x - self.centre[0]) / self.half[0], (y - self.centre[1]) / self.half[1]
        return self.scale * legendre.legval2d(u, v, self.coefficients) + self.z

    def hessian(self, x, y):
        """f_xx, f_xy, f_yy on the grid of the given x and y."""
        u, v = (x - self.centre[0]) / self.half[0], (y - self.centre[1]) / self.half[1]

        def derivative(i, j):
            c = legendre.legder(legendre.legder(self.coefficients, i, axis=0), j, axis=1)
            scale = self.scale / (self.half[0] ** i * self.half[1] ** j)
            return scale * legendre.leggrid2d(u, v, c)

        return derivative(2, 0), derivative(1, 1), derivative(0, 2)

    def axes(self, counts):
        return [np.linspace(self.low[k], self.high[k], counts[k]) for k in (0, 1)]

    def bezier(self):
        """Control points of the surface as one Bezier patch."""

        def nodes(count):
            return 0.5 - 0.5 * np.cos(np.pi * (np.arange(count) + 0.5) / count)

        def bernstein(t, degree):
            k = np.arange(degree + 1)
            choose = np.array([math.comb(degree, i) for i in k])
            return choose * t[:, None] ** k * (1 - t[:, None]) ** (degree - k)

        counts = self.coefficients.shape
        t = [nodes(count) for count in counts]
        x, y = (self.low[k] + t[k] * (self.high[k] - self.low[k]) for k in (0, 1))
        heights = self.height(*np.meshgrid(x, y, indexing="ij"))
        a, b = (bernstein(t[k], counts[k] - 1) for k in (0, 1))
        poles = np.linalg.solve(b, np.linalg.solve(a, heights).T).T
        return *self.axes(counts), poles


def chord_error(surface, vertices, triangles):
    """Largest height between a triangle and the surface, sampled on every triangle."""
    i, j = np.meshgrid(np.arange(SAMPLES + 1), np.arange(SAMPLES + 1))
    i, j = i[i + j <= SAMPLES], j[i + j <= SAMPLES]
    weights = np.stack([i, j, SAMPLES - i - j], -1) / SAMPLES
    worst = 0.0
    for start in range(0, len(triangles), BLOCK):
        corners = vertices[triangles[start : start + BLOCK]]
        points = np.einsum("sk,tkc->tsc", weights, corners)
        height = surface.height(points[..., 0], points[..., 1])
        worst = max(worst, float(np.abs(points[..., 2] - height).max()))
    return worst


def best_of(runs, make):
    """The least seconds of some runs, and the last one's vertices and triangles."""
    seconds = []
    while len(seconds) < runs and sum(seconds) < PATIENCE:
        taken, made = make()
        seconds.append(taken)
    return min(seconds), *made


def lifted(surface, flat):
    return np.column_stack([flat, surface.height(flat[:, 0], flat[:, 1])])


def morion(_, given, folder, __):
    with open(folder / f"{given['name']}.ply", "rb") as file:
        count = {}
        while (line := file.readline().split()) != [b"end_header"]:
            if line[0] == b"element":
                count[line[1]] = int(line[2])
        vertices = np.fromfile(file, "<f8", 3 * count[b"vertex"]).reshape(-1, 3)
        face = np.dtype([("corners", "u1"), ("vertices", "<u4", 3)])
        triangles = np.fromfile(file, face, count[b"face"])["vertices"]
    return given["seconds"], vertices, triangles


def pydelatin(surface, _, __, runs):
    from pydelatin import Delatin

    size = surface.high - surface.low
    bend = max(np.abs(h).max() for h in surface.hessian(*surface.axes((FIELD, FIELD))))
    step = math.sqrt(4 * GRID_SHARE * surface.limit / bend)
    x, y = surface.axes([math.ceil(side / step) + 1 for side in size])
    heights = surface.height(*np.meshgrid(x, y)).astype(np.float32)

    def make():
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
        return taken, (lifted(surface, flat), np.asarray(triangles).reshape(-1, 3))

    return best_of(runs, make)


def gmsh_with(surface, runs, metric):
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

    def make():
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
            return taken, (lifted(surface, places.reshape(-1, 3)[:, :2]), triangles)
        finally:
            gmsh.finalize()

    return best_of(runs, make)


def gmsh_isotropic(surface, _, __, runs):
    return gmsh_with(surface, runs, metric=False)


def gmsh_metric(surface, _, __, runs):
    return gmsh_with(surface, runs, metric=True)


def opencascade(surface, _, __, runs):
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

    def make():
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
        return taken, (vertices, triangles)

    return best_of(runs, make)


PROGRAMS = {
    "morion": morion,
    "pydelatin": pydelatin,
    "gmsh isotropic": gmsh_isotropic,
    "gmsh metric": gmsh_metric,
    "opencascade": opencascade,
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder", type=Path, metavar="FOLDER")
    parser.add_argument("--runs", type=int, default=3, help="of each program")
    args = parser.parse_args()

    columns = "program", "triangles", "over least", "asked um", "true max um", "over least at true"
    print("| surface | " + " | ".join(columns) + " | s |")
    print("|---|---|---|---|---|---|---|---|")
    missing = {}
    for given in json.loads((args.folder / "surfaces.json").read_text()):
        surface = Surface(given)
        for name, mesh in PROGRAMS.items():
            try:
                seconds, vertices, triangles = mesh(surface, given, args.folder, args.runs)
            except ImportError as error:
                missing[name] = error
                continue
            except Exception as error:  # A peer that gives up is a row of its own.
                print(f"| {surface.name} | {name} | {error} | | | | | |", flush=True)
                continue
            error = chord_error(surface, vertices, triangles)
            over = len(triangles) / surface.least
            print(
                f"| {surface.name} | {name} | {len(triangles)} | {over:.2f} "
                f"| {1e3 * surface.limit:g} | {1e3 * error:.3f} "
                f"| {over * error / surface.limit:.2f} | {seconds:.3f} |",
                flush=True,
            )
    for name, error in missing.items():
        print(f"\nskipped {name}: {error} (pip install -r requirements-mesh.txt)")


if __name__ == "__main__":
    main()
