#!/usr/bin/env python3
"""Asks strangers about the files of a build.

STL, OBJ  trimesh: one closed body without handles, as it loads by default; STL: Manifold too
3MF       lib3mf, in its strict mode: no warning, a manifold and oriented mesh, our metadata; at most
          30 % of the bytes of the STL beside it
GLB       trimesh: the same body, in metres with Y up, as the STL beside it
CSV       numpy: unit normals, square to the steps from row to row

How many holes a part has is what the report.json beside its files says; none without one.

usage: check_files.py FILE...
Prints one line per file; exits 1 if any of them is not as it should be.
"""

import json
import pathlib
import sys

import lib3mf
import manifold3d
import numpy as np
import trimesh
from verdicts import told

# Share of the STL's bytes that a 3MF may take.
PACKED = 0.3


def euler_number(path):
    report = path.with_name("report.json")
    return json.loads(report.read_text())["solid"]["euler"] if report.exists() else 2


def of_mesh(path):
    mesh = trimesh.load_mesh(path)
    euler = euler_number(path)
    found = {
        "watertight": (mesh.is_watertight, True),
        "volume": (mesh.is_volume, True),
        "euler number": (mesh.euler_number, euler),
        "bodies": (mesh.body_count, 1),
        "positive volume": (mesh.volume > 0, True),
    }
    if path.suffix == ".stl":
        body = manifold3d.Manifold(
            manifold3d.Mesh(
                vert_properties=np.asarray(mesh.vertices, dtype=np.float32),
                tri_verts=np.asarray(mesh.faces, dtype=np.uint32),
            )
        )
        found["manifold status"] = (body.status().name, manifold3d.Error.NoError.name)
        found["genus"] = (body.genus(), 1 - euler // 2)
    wrong = [f"{name} {got}, not {want}" for name, (got, want) in found.items() if got != want]
    return f"{len(mesh.faces)} facets, {mesh.volume:.3f} mm3", wrong


def of_3mf(path):
    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(str(path))
    wrong = [f"warning: {reader.GetWarning(k)}" for k in range(reader.GetWarningCount())]
    objects = model.GetMeshObjects()
    count = objects.Count()
    facets = 0
    while objects.MoveNext():
        mesh = objects.GetCurrentMeshObject()
        facets += mesh.GetTriangleCount()
        if not mesh.IsManifoldAndOriented():
            wrong.append("not manifold and oriented")
    if (count, model.GetUnit()) != (1, lib3mf.ModelUnit.MilliMeter):
        wrong.append(f"{count} objects in {model.GetUnit()}")
    group = model.GetMetaDataGroup()
    data = [group.GetMetaData(k) for k in range(group.GetMetaDataCount())]
    data = {entry.GetName(): entry.GetValue() for entry in data}
    if "sha256 " not in data.get("Description", "") or data.get("Application") != "Morion":
        wrong.append(f"metadata {data}")
    share = path.stat().st_size / path.with_suffix(".stl").stat().st_size
    if share > PACKED:
        wrong.append(f"{share:.3f} of the STL's bytes, over {PACKED}")
    return f"{facets} facets, {100 * share:.1f} % of the STL", wrong


def of_glb(path):
    # Metres with Y up: back to the frame of the STL.
    scene = trimesh.load_scene(path)
    mesh = scene.to_mesh()
    mesh.apply_transform([[1000, 0, 0, 0], [0, 0, -1000, 0], [0, 1000, 0, 0], [0, 0, 0, 1]])
    # The primitives share their vertices, which trimesh takes apart.
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    stl = trimesh.load_mesh(path.with_suffix(".stl"))
    found = {
        "geometries": (len(scene.geometry), 2),
        "facets": (len(mesh.faces), len(stl.faces)),
        "watertight": (mesh.is_watertight, True),
        "volume": (mesh.is_volume, True),
        "euler number": (mesh.euler_number, euler_number(path)),
        "bodies": (mesh.body_count, 1),
    }
    wrong = [f"{name} {got}, not {want}" for name, (got, want) in found.items() if got != want]
    # Trimesh multiplies by the node's matrix and back in double precision.
    share = abs(mesh.volume / stl.volume - 1)
    off = np.abs(mesh.bounds - stl.bounds).max()
    if not (share <= 1e-12 and off <= 1e-12 * np.abs(stl.bounds).max()):
        wrong.append(f"volume {share:.1e} and bounds {off:.1e} mm off the STL's")
    return f"{len(mesh.faces)} facets, volume within {share:.1e} of the STL's", wrong


def of_table(path):
    text = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    rows = np.loadtxt(text[1:], delimiter=",")
    wrong = []
    if text[0] not in ("X_mm,Y_mm,Z_mm,NX,NY,NZ", "X_mm,Y_mm,Z_mm,NX,NY,NZ,panel"):
        wrong.append(f"titles {text[0]}")
    # Panels with steps between them are smooth each by itself.
    panel, rows = rows[:, 6:], rows[:, :6]
    off = np.abs(np.linalg.norm(rows[:, 3:], axis=1) - 1).max()
    if off > 2e-9:
        wrong.append(f"normals {off:.1e} from unit length")
    # Of a smooth curve the chord between neighbours is square to the mean of their normals, but for
    # a third of an order in the step.
    chord, mean = rows[1:, :3] - rows[:-1, :3], (rows[1:, 3:] + rows[:-1, 3:]) / 2
    same = (panel[1:] == panel[:-1]).all(axis=1)
    along = same & (rows[1:, 1] == rows[:-1, 1]) & (np.abs(chord[:, 0]) < 1.01 * np.abs(chord[0, 0]))
    lean = np.abs((chord * mean).sum(axis=1) / np.linalg.norm(chord, axis=1))[along].max()
    if lean > 1e-3:
        wrong.append(f"a normal leans by {lean:.1e}")
    return f"{len(rows)} rows, normals square to them within {lean:.1e}", wrong


def complaints(path):
    """The file's figures in short, and what is wrong with it."""
    kinds = {".3mf": of_3mf, ".glb": of_glb, ".csv": of_table}
    return kinds.get(path.suffix.lower(), of_mesh)(path)


def main():
    if not sys.argv[1:]:
        sys.exit(__doc__)
    sys.exit(told("python", map(pathlib.Path, sys.argv[1:]), complaints))


if __name__ == "__main__":
    main()
