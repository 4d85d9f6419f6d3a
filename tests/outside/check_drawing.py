#!/usr/bin/env python3
"""Holds the drawing of a part against its STEP file, measured by OpenCASCADE, and against its own figures.

usage: check_drawing.py FOLDER...
A FOLDER has report.json, mirror.step, drawing.pdf and drawing.dxf of a build.
qpdf finds the PDF sound, its font is embedded, and pdftotext finds every figure; ezdxf audits the DXF without an error. Sizes and
holes are those of the STEP file to a micrometre, and those of the DXF's plan, which has the part's size.
Prints a line a folder; exits 1 where something is off.
"""

import json
import math
import pathlib
import re
import subprocess
import sys

import ezdxf
from OCP.Bnd import Bnd_Box
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepBndLib import BRepBndLib
from OCP.GeomAbs import GeomAbs_Cylinder
from OCP.gp import gp_Dir, gp_Lin, gp_Pnt
from OCP.IntCurvesFace import IntCurvesFace_ShapeIntersector
from OCP.STEPControl import STEPControl_Reader
from OCP.TopAbs import TopAbs_FACE
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS

MICROMETRE = 1e-3  # mm


def static(kind, name):
    """A static method, under the older or the newer bindings' name."""
    return getattr(kind, name + "_s", None) or getattr(kind, name)


def said(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def mm(value):
    """Millimetres as the drawing has them: to a thousandth, without zeros that say nothing."""
    return f"{round(value, 3) + 0.0:.3f}".rstrip("0").rstrip(".")


def pdf(path, facts, profile):
    checked = subprocess.run(["qpdf", "--check", path], capture_output=True, text=True, check=False)
    bad = [] if checked.returncode == 0 else [f"qpdf: {checked.stderr.strip()}"]
    # The columns are counted from the right: emb, sub, uni and the object's two numbers.
    bad += [f"font {font}" for font in said("pdffonts", path).splitlines()[2:] if font.split()[-5] != "yes"]
    text = re.sub(r"\s+", " ", said("pdftotext", "-raw", path, "-"))
    x, y, z = facts["size_mm"]
    figures = [mm(x), mm(z), facts["scale"], facts["paper"], profile["name"], profile["sha256"][:16]]
    figures += [] if facts["is_round"] else [mm(y)]
    figures += [mm(facts["lowest_mm"]), mm(facts["sphere_departure_mm"]), *facts["datums"], facts["camera"]]
    lengths = ("rim_mm", "corner_radius_mm", "surface_profile_mm")
    figures += [mm(facts[key]) for key in lengths if key in facts]
    figures += [f"edges {mm(facts['edge_chamfer_mm'])} x 45\u00b0"] if "edge_chamfer_mm" in facts else []
    figures += [mm(facts["slope_error_mrad"])] if "slope_error_mrad" in facts else []
    figures += [mm(abs(facts["sphere_radius_mm"]))] if "sphere_radius_mm" in facts else []
    figures += [f"{place[2]:.4f}" for place in facts["sag_mm"]] + [str(facts["inspection_points"])]
    figures += [mm(side) for side in facts["mirror_mm"]] if "rim_mm" in facts and not facts["is_round"] else []
    mirror = zip(facts["mirror_least_mm"], facts["mirror_mm"])
    aside = [mm(-least) for least, size in mirror if abs(2 * least + size) > MICROMETRE]
    figures += aside if "rim_mm" in facts and not facts["is_round"] else []
    for feature in facts.get("features", []):
        figures += [feature["name"], *map(mm, feature["at_mm"]), mm(feature["diameter_mm"]), feature["what"]]
    return bad + [f"{figure} is not in the text" for figure in figures if figure not in text]


def faces(shape):
    found = TopExp_Explorer(shape, TopAbs_FACE)
    cast = getattr(TopoDS, "Face_s", None) or TopoDS.Face
    while found.More():
        yield BRepAdaptor_Surface(cast(found.Current()))
        found.Next()


def step(path, facts):
    reader = STEPControl_Reader()
    reader.ReadFile(str(path))
    reader.TransferRoots()
    shape, found = reader.OneShape(), Bnd_Box()
    static(BRepBndLib, "AddOptimal")(shape, found, False, False)
    low, high = found.CornerMin(), found.CornerMax()
    bad, lost, above = [], 0, high.Z() + 1.0
    searched = IntCurvesFace_ShapeIntersector()
    searched.Load(shape, 1e-9)
    for x, y, z in facts["sag_mm"]:
        heights = []
        # (A rim is met from within, a step between panels from either side, and the axis beside the faces' edges.)
        for u, v in [(1e-5, 2e-5), (-1e-5, 2e-5), (1e-5, -2e-5), (-1e-5, -2e-5)]:
            line = gp_Lin(gp_Pnt(x * (1 - 1e-6) + u, y * (1 - 1e-6) + v, above), gp_Dir(0, 0, -1))
            searched.Perform(line, 0.0, 2 * above)
            heights += [searched.Pnt(k).Z() for k in range(1, searched.NbPnt() + 1)]
        if all(height < MICROMETRE for height in heights):
            lost += 1
        elif not any(abs(height - z) < MICROMETRE for height in heights):
            bad.append(f"sag at {x}, {y}: {z}, {heights} in the STEP file")
    # (Near a rim it loses some lines, as it loses some rays.)
    if lost > 1 + len(facts["sag_mm"]) // 20:
        bad.append(f"{lost} of {len(facts['sag_mm'])} places of the sag table are not in the STEP file")
    # (Its box is sampled, and may be some micrometres too low.)
    top = max([high.Z(), *(place[2] for place in facts["sag_mm"])])
    sizes = [high.X() - low.X(), high.Y() - low.Y(), top - low.Z()]
    for axis, (size, drawn) in enumerate(zip(sizes, facts["size_mm"])):
        if abs(size - drawn) > MICROMETRE:
            bad.append(f"size along {'XYZ'[axis]} {drawn} mm, {size} in the STEP file")
    walls = [face.Cylinder() for face in faces(shape) if face.GetType() == GeomAbs_Cylinder]
    walls = [(w.Location().X(), w.Location().Y(), 2 * w.Radius()) for w in walls]
    for feature in facts.get("features", []):
        if not feature["name"].startswith("H"):
            continue
        wanted = (*feature["at_mm"], feature["diameter_mm"])
        if not any(math.dist(wall, wanted) < MICROMETRE for wall in walls):
            bad.append(f"hole {feature['name']} is not in the STEP file")
    return bad


def dxf(path, facts):
    document = ezdxf.readfile(path)
    audit = document.audit()
    bad = [f"ezdxf: {error.message}" for error in [*audit.errors, *audit.fixes]]
    model = document.modelspace()
    # The plan's axes cross at the part's origin, which its holes are measured from.
    wide = [entity for entity in model if entity.dxf.layer in ("OUTLINE", "HIDDEN")]
    circles = [(c.dxf.center.x, c.dxf.center.y, 2 * c.dxf.radius) for c in wide if c.dxftype() == "CIRCLE"]
    features = facts.get("features", [])
    if features:
        first = features[0]
        near = lambda circle, feature, origin: math.dist(
            circle, (origin[0] + feature["at_mm"][0], origin[1] + feature["at_mm"][1], feature["diameter_mm"])
        ) < MICROMETRE
        origins = [(x - first["at_mm"][0], y - first["at_mm"][1]) for x, y, _ in circles]
        fits = lambda origin: all(any(near(c, f, origin) for c in circles) for f in features)
        if not any(fits(origin) for origin in origins):
            bad.append("holes and marks are not in the plan")
    width, height, _ = facts["size_mm"]
    if facts["is_round"]:
        if not any(abs(diameter - width) < MICROMETRE for *_, diameter in circles):
            bad.append("the plan has no circle of the part's diameter")
        return bad
    # A line or a closed line as wide as the part and, of the plan, as high.
    spans = []
    for entity in wide:
        places = []
        if entity.dxftype() == "LINE":
            places = [entity.dxf.start, entity.dxf.end]
        elif entity.dxftype() == "POLYLINE":
            places = [vertex.dxf.location for vertex in entity.vertices]
        if places:
            xs, ys = [p.x for p in places], [p.y for p in places]
            spans.append((max(xs) - min(xs), max(ys) - min(ys)))
    if not any(abs(x - width) < MICROMETRE and abs(y - height) < MICROMETRE for x, y in spans):
        straight = lambda axis, size: any(abs(span[axis] - size) < MICROMETRE for span in spans)
        if not (straight(0, width) and straight(1, height)):
            bad.append(f"the plan is not {width} x {height} mm")
    return bad


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    failed = False
    for folder in map(pathlib.Path, sys.argv[1:]):
        report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
        facts = report["drawing"]
        bad = pdf(folder / "drawing.pdf", facts, report["profile"])
        bad += step(folder / "mirror.step", facts) + dxf(folder / "drawing.dxf", facts)
        print(f"drawing: {folder}: {'FAILED; ' + '; '.join(bad) if bad else 'ok'}")
        failed |= bool(bad)
    sys.exit(failed)


if __name__ == "__main__":
    main()
