#!/usr/bin/env python3
"""Asks OpenCASCADE whether STEP files are solids as they should be.

usage: check_step.py FILE.step...
Beside each file, FILE.step.json may say {"volume_mm3": ..., "faces": ...}, or the report.json of its
build the volume, the holes, and the datum features and tolerance of an AP242 file.
Prints one line per file; exits 1 if any of them is not one valid closed solid in millimetres whose
edges lie on their faces within 1e-7 mm, does not intersect itself, or has another volume or number
of faces than is wanted, or, as XCAF reads them, other names and colours of faces than docs/files.md has, or other holes, datum
features and tolerances than the report.
"""

import json
import os
import sys

from OCP.BOPAlgo import BOPAlgo_ArgumentAnalyzer
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Curve2d, BRepAdaptor_Surface
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.STEPControl import STEPControl_Reader
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE, TopAbs_SHELL, TopAbs_SOLID, TopAbs_VERTEX
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS
import step_faces
import step_pmi
from verdicts import told

VOLUME = 1e-7  # relative
GAP = 1.0000001e-7  # mm
PLACES = 1009  # on an edge, where it is compared with its face


def parts(shape, kind):
    """Each part of this kind once for every part that it belongs to."""
    explorer = TopExp_Explorer(shape, kind)
    while explorer.More():
        yield explorer.Current()
        explorer.Next()


def cast(kind, part):
    """The part as what it is: newer bindings have another name for the cast."""
    for name in (kind + "_s", kind):
        if hasattr(TopoDS, name):
            return getattr(TopoDS, name)(part)
    raise AttributeError(f"TopoDS.{kind}")


def static(kind, name):
    """A static method, under the older or the newer bindings' name."""
    return getattr(kind, name + "_s", None) or getattr(kind, name)


def deviation(face):
    """The largest distance of the face's edges from what they are in its parameters."""
    surface = BRepAdaptor_Surface(face, False)
    worst = 0.0
    for edge in parts(face, TopAbs_EDGE):
        edge = cast("Edge", edge)
        if static(BRep_Tool, "Degenerated")(edge):
            continue
        curve, flat = BRepAdaptor_Curve(edge), BRepAdaptor_Curve2d(edge, face)
        first, last = curve.FirstParameter(), curve.LastParameter()
        for k in range(PLACES + 1):
            t = first + (last - first) * k / PLACES
            q = flat.Value(t)
            worst = max(worst, curve.Value(t).Distance(surface.Value(q.X(), q.Y())))
    return worst


def volume(shape):
    found = GProp_GProps()
    # Gauss and Kronrod's rule: the plain adaptive one loses digits on faces with long spline edges.
    static(BRepGProp, "VolumePropertiesGK")(shape, found, 0.1 * VOLUME)
    return found.Mass()


def beside(path):
    """What is wanted of the file."""
    report = os.path.join(os.path.dirname(path), "report.json")
    if os.path.exists(path + ".json"):
        with open(path + ".json", encoding="utf-8") as file:
            return json.load(file)
    if os.path.exists(report):
        with open(report, encoding="utf-8") as file:
            found = json.load(file)
        wanted = {"pmi": found["step"].get("pmi"), "holes": found.get("holes", [])}
        if found.get("solid"):
            wanted["volume_mm3"] = found["solid"]["volume_expected_mm3"]
        return wanted
    return {}


def complaints(path):
    """The file's figures in short, and what is wrong with it."""
    reader = STEPControl_Reader()
    if reader.ReadFile(path) != IFSelect_ReturnStatus.IFSelect_RetDone:
        return "unreadable", ["OpenCASCADE cannot read it"]
    reader.TransferRoots()
    shape = reader.OneShape()
    wanted = beside(path)
    count = {
        name: len(list(parts(shape, kind)))
        for name, kind in (("solids", TopAbs_SOLID), ("shells", TopAbs_SHELL), ("faces", TopAbs_FACE))
    }
    tolerance = static(BRep_Tool, "Tolerance")
    gap = max(tolerance(cast("Edge", edge)) for edge in parts(shape, TopAbs_EDGE))
    apart = max(deviation(cast("Face", face)) for face in parts(shape, TopAbs_FACE))
    at_vertices = max(tolerance(cast("Vertex", v)) for v in parts(shape, TopAbs_VERTEX))
    analyzer = BOPAlgo_ArgumentAnalyzer()
    analyzer.SetShape1(shape)
    analyzer.ArgumentTypeMode = True
    analyzer.SelfInterMode = True
    analyzer.SmallEdgeMode = True
    analyzer.Perform()
    found = {
        "solids": (count["solids"], 1),
        "shells": (count["shells"], 1),
        "faces": (count["faces"], wanted.get("faces", count["faces"])),
        "valid": (BRepCheck_Analyzer(shape).IsValid(), True),
        "closed": (all(static(BRep_Tool, "IsClosed")(shell) for shell in parts(shape, TopAbs_SHELL)), True),
        "edges within 1e-7 mm": (gap <= GAP, True),
        "curves within 1e-7 mm of their faces": (apart <= GAP, True),
        "vertices within 1e-7 mm": (at_vertices <= GAP, True),
        "fit for booleans": (not analyzer.HasFaulty(), True),
    }
    wrong = [f"{name} {got}, not {want}" for name, (got, want) in found.items() if got != want]
    wrong += step_faces.complaints(path, wanted.get("holes"))
    if wanted.get("pmi"):
        with open(path, encoding="ascii") as file:
            optical = file.read().count("ADVANCED_FACE('OPTICAL'")
        wrong += step_pmi.complaints(path, wanted["pmi"], optical)
    holds = volume(shape)
    figures = f"{count['faces']} faces, {holds:.6f} mm3, gaps {apart:.1e} mm"
    if "volume_mm3" in wanted:
        off = holds / wanted["volume_mm3"] - 1.0
        figures += f", volume off by {off:.1e}"
        if not abs(off) <= VOLUME:
            wrong.append(f"volume {holds}, not {wanted['volume_mm3']}")
    return figures, wrong


def main():
    if not sys.argv[1:]:
        sys.exit(__doc__)
    sys.exit(told("opencascade", sys.argv[1:], complaints))


if __name__ == "__main__":
    main()
