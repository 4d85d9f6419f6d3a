"""Moulds, mandrels and hollow parts by Manifold, Embree and OpenCASCADE.

usage: check_tools.py DIR

DIR holds the builds fold-part, fold-mould, fold-mandrel, fold-hollow, dome-part, dome-mould, dome-mandrel and dome-hollow of the profiles of
tests/fixtures/tools, with their profiles beside them. A part and its mould have the same facets (the part's chord limit is
the share of the mould's), so they share no volume; mould and mandrel, closed, leave a gap of the sheet's thickness; and the
STEP file of the dome's mandrel is a sphere of a radius smaller by it. Of hollow parts the volume is the report's in both
formats, and material is no thinner than asked: along 2000 normals into the walls, and around 2000 places of the roof.
"""

import json
import math
import sys
import tomllib
from pathlib import Path

import numpy as np
import trimesh
from manifold3d import Manifold, Mesh64
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps
from OCP.STEPControl import STEPControl_Reader
from OCP.TopAbs import TopAbs_FACE
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS

here = Path(sys.argv[1])
failed = False


def tell(what, ok):
    global failed
    failed |= not ok
    print(f"tools: {what}: {'ok' if ok else 'FAILED'}")


def read(name):
    """The report and the profile of a build."""
    report = json.loads((here / name / "report.json").read_text())
    tell(f"{name} passes", report["verdict"] == "pass")
    return report, tomllib.loads((here / f"{name}.toml").read_text())


def solid(name):
    """The body of an OBJ in the part's frame: shrunk, and a mould turned back, as its report says."""
    report, profile = read(name)
    mesh = trimesh.load(here / name / "mirror.obj", process=False)
    vertices = np.asarray(mesh.vertices, dtype=np.float64)
    if tool := report.get("tool"):
        vertices = vertices - [0.0, 0.0, tool["flange_mm"]]
        if tool["form"] == "mould":
            vertices = vertices * [1.0, -1.0, -1.0]
        vertices = vertices * (1.0 - tool["shrinkage_ppm"] * 1e-6)
        vertices = vertices + [0.0, 0.0, profile["part"]["rim_mm"]]
    faces = np.asarray(mesh.faces, dtype=np.uint64)
    body = Manifold(Mesh64(vertices, faces))
    return body, report


def optical(path):
    """The faces of a STEP file, and its volume."""
    reader = STEPControl_Reader()
    reader.ReadFile(str(path))
    reader.TransferRoots()
    shape = reader.OneShape()
    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties, 1e-12)
    # (Newer bindings have dropped the ending.)
    cast = getattr(TopoDS, "Face_s", None) or TopoDS.Face
    explorer, faces = TopExp_Explorer(shape, TopAbs_FACE), []
    while explorer.More():
        faces.append(BRepAdaptor_Surface(cast(explorer.Current()), True))
        explorer.Next()
    return faces, properties.Mass()


for kind in ["fold", "dome"]:
    part, _ = solid(f"{kind}-part")
    mould, mould_report = solid(f"{kind}-mould")
    common = part ^ mould
    share = common.volume() / part.volume()
    tell(f"{kind}: part and mould share {share:.1e} of the part", share <= 1e-6)
    # Together with the gap of the draft they fill the block: the part reaches up to the mould's face.
    lifted = mould ^ part.translate((0.0, 0.0, 0.1))
    area = common.volume() if lifted.is_empty() else lifted.volume() / 0.1
    tell(f"{kind}: the part lifted by 0.1 mm cuts {area:.0f} mm2 of the mould", area > 2000.0)

    body, report = solid(f"{kind}-hollow")
    cavity, wanted = report["cavity"], report["solid"]["volume_expected_mm3"]
    wall = cavity["wall_mm"]
    off = body.volume() / wanted - 1.0
    tell(f"{kind}: a hollow part of {body.genus()} ways through, its volume off by {off:.1e}", abs(off) < 1e-3)
    tell(f"{kind}: with two drains, beside its holes", body.genus() == 1 + len(report.get("holes", [])))
    _, volume = optical(here / f"{kind}-hollow" / "mirror.step")
    off = volume / wanted - 1.0
    tell(f"{kind}: as STEP off by {off:.1e}", abs(off) < 1e-7)
    mesh = trimesh.load(here / f"{kind}-hollow" / "mirror.obj", process=False)
    up = mesh.face_normals[:, 2]
    beside = mesh.submesh([np.abs(up) < 1e-3], append=True)
    points, facets = trimesh.sample.sample_surface(beside, 2000, seed=1)
    inward = -beside.face_normals[facets]
    hits, rays, _ = mesh.ray.intersects_location(points + 1e-4 * inward, inward, multiple_hits=False)
    thick = np.linalg.norm(hits - points[rays], axis=1).min()
    tell(f"{kind}: walls {thick:.4f} mm thick or more, {wall} asked", len(rays) == 2000 and thick > wall - 1e-3)
    is_low = mesh.triangles_center[:, 2] < 1e-6
    roof, seen = (mesh.submesh([kept], append=True) for kept in [(up < -1e-3) & ~is_low, up > 1e-3])
    points, _ = trimesh.sample.sample_surface(roof, 300, seed=1)
    thick = trimesh.proximity.closest_point_naive(seen, points)[1].min()
    tell(f"{kind}: roof {thick:.4f} mm thick or more", thick > wall - 1e-3)
    light = body.volume() / (cavity["volume_mm3"] + wanted)
    tell(f"{kind}: {light:.3f} of the material", abs(light - cavity["material_share"]) < 1e-3)

mandrel, report = solid("dome-mandrel")
mould, _ = solid("dome-mould")
thick = report["tool"]["sheet_mm"]
# Its face alone, farther from the walls of the mould than a sheet is thick.
above = mandrel.trim_by_plane((0.0, 0.0, 1.0), 7.1)
gap = mould.min_gap(above, 3.0 * thick)
tell(f"dome: mould and mandrel are {gap:.5f} mm apart, a sheet of {thick}", abs(gap - thick) < 5e-3)

for name, radius in [("dome-mandrel", 80.0 - thick), ("dome-mould", 80.0)]:
    report = json.loads((here / name / "report.json").read_text())
    tool, growth = report["tool"], 1.0 / (1.0 - report["tool"]["shrinkage_ppm"] * 1e-6)
    faces, volume = optical(here / name / "mirror.step")
    tell(
        f"{name}: volume {volume:.6f} mm3, off by {volume / tool['volume_mm3'] - 1:.1e}",
        abs(volume / tool["volume_mm3"] - 1.0) < 1e-6,
    )
    # The sphere's centre in the tool's frame.
    height = 8.0 - 80.0 * math.sqrt(1.0 - (30.0 / 80.0) ** 2) - 4.0
    up = -1.0 if tool["form"] == "mould" else 1.0
    centre = np.array([0.0, 0.0, tool["flange_mm"] + up * growth * height])
    best = math.inf
    for face in faces:
        us = np.linspace(face.FirstUParameter(), face.LastUParameter(), 40)
        vs = np.linspace(face.FirstVParameter(), face.LastVParameter(), 40)
        points = [face.Value(u, v) for u in us for v in vs]
        points = np.array([[p.X(), p.Y(), p.Z()] for p in points])
        off = np.abs(np.linalg.norm(points - centre, axis=1) - growth * radius).max()
        best = min(best, off)
    tell(f"{name}: a face is a sphere of {growth * radius:.3f} mm within {best:.1e} mm", best < 3e-6)

sys.exit(failed)
