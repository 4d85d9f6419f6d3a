"""Writes fuzz/seeds/step: bodies of OpenCASCADE as STEP in other schemas and units than Morion's own.

usage: step_fixtures.py FOLDER, with the packages of requirements-older.txt
"""

import sys
from pathlib import Path

from OCP.BRepAlgoAPI import BRepAlgoAPI_Common, BRepAlgoAPI_Cut
from OCP.BRepBuilderAPI import (BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeWire,
                                BRepBuilderAPI_NurbsConvert)
from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
from OCP.BRepPrimAPI import (BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCone, BRepPrimAPI_MakeCylinder, BRepPrimAPI_MakePrism,
                             BRepPrimAPI_MakeRevol, BRepPrimAPI_MakeSphere, BRepPrimAPI_MakeTorus)
from OCP.Geom import Geom_BSplineCurve
from OCP.gp import gp_Ax1, gp_Ax2, gp_Dir, gp_Elips, gp_Pnt, gp_Vec
from OCP.Interface import Interface_Static
from OCP.STEPControl import STEPControl_AsIs, STEPControl_Writer
from OCP.TColgp import TColgp_Array1OfPnt
from OCP.TColStd import TColStd_Array1OfInteger, TColStd_Array1OfReal
from OCP.TopAbs import TopAbs_EDGE
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS


def axes(at=(0, 0, 0), along=(0, 0, 1)):
    return gp_Ax2(gp_Pnt(*at), gp_Dir(*along))


def cut(body, tool):
    return BRepAlgoAPI_Cut(body, tool).Shape()


def rounded(body, radius):
    fillet = BRepFilletAPI_MakeFillet(body)
    edges = TopExp_Explorer(body, TopAbs_EDGE)
    while edges.More():
        fillet.Add(radius, TopoDS.Edge_s(edges.Current()))
        edges.Next()
    return fillet.Shape()


def wavy_face():
    """A face in Y = 0 between X = 2 and a cubic spline."""
    points = TColgp_Array1OfPnt(1, 6)
    for k, (x, z) in enumerate([(5, 0), (6, 1), (5, 3), (7, 4), (6, 6), (5, 7)], 1):
        points.SetValue(k, gp_Pnt(x, 0, z))
    knots, multiplicities = TColStd_Array1OfReal(1, 4), TColStd_Array1OfInteger(1, 4)
    for k, (knot, multiplicity) in enumerate([(0, 4), (1, 1), (2, 1), (3, 4)], 1):
        knots.SetValue(k, knot)
        multiplicities.SetValue(k, multiplicity)
    corners = [gp_Pnt(2, 0, 0), gp_Pnt(5, 0, 0), gp_Pnt(5, 0, 7), gp_Pnt(2, 0, 7)]
    edge = BRepBuilderAPI_MakeEdge
    wire = BRepBuilderAPI_MakeWire(
        edge(corners[0], corners[1]).Edge(),
        edge(Geom_BSplineCurve(points, knots, multiplicities, 3)).Edge(),
        edge(corners[2], corners[3]).Edge(),
        edge(corners[3], corners[0]).Edge(),
    ).Wire()
    return BRepBuilderAPI_MakeFace(wire).Face()


def oblique():
    """A cylinder between two planes that are oblique to its axis."""
    normal, along = gp_Dir(-0.5, 0, 1), gp_Dir(1, 0, 0.5)
    corner = gp_Pnt(0, 0, 8)
    for side in (along, normal.Crossed(along)):
        corner = corner.Translated(gp_Vec(side) * -30)
    slab = BRepPrimAPI_MakeBox(gp_Ax2(corner, normal, along), 60, 60, 4).Shape()
    return BRepAlgoAPI_Common(BRepPrimAPI_MakeCylinder(axes(), 4, 20).Shape(), slab).Shape()


def bodies():
    box = BRepPrimAPI_MakeBox(gp_Pnt(-10, -8, 0), gp_Pnt(10, 8, 5)).Shape()
    dimpled = cut(box, BRepPrimAPI_MakeSphere(axes((0, 0, 5)), 4).Shape())
    torus = BRepPrimAPI_MakeTorus(axes((1, 2, 3), (0, 1, 1)), 7, 2).Shape()
    face, axis = wavy_face(), gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1))
    ellipse = BRepBuilderAPI_MakeEdge(gp_Elips(axes(), 5, 3)).Edge()
    ellipse = BRepBuilderAPI_MakeFace(BRepBuilderAPI_MakeWire(ellipse).Wire()).Face()
    nurbs = lambda body: BRepBuilderAPI_NurbsConvert(body).Shape()
    yield "box", box
    yield "drilled", cut(box, BRepPrimAPI_MakeCylinder(axes((2, 1, -1)), 3, 10).Shape())
    yield "cylinder", BRepPrimAPI_MakeCylinder(axes((1, 2, 3), (1, 1, 1)), 4, 7).Shape()
    yield "cone", BRepPrimAPI_MakeCone(axes((1, 2, 3), (1, -1, 2)), 5, 2, 6).Shape()
    yield "pointed", BRepPrimAPI_MakeCone(axes(), 5, 0, 6).Shape()
    yield "sphere", BRepPrimAPI_MakeSphere(axes((1, 2, 3)), 5).Shape()
    yield "torus", torus
    yield "countersunk", cut(box, BRepPrimAPI_MakeCone(axes((0, 0, 2)), 0, 3, 3).Shape())
    yield "dimpled", dimpled
    yield "rounded", rounded(box, 1.5)
    yield "extruded", BRepPrimAPI_MakePrism(face, gp_Vec(0.5, 4, 0.25)).Shape()
    yield "turned", BRepPrimAPI_MakeRevol(face, axis).Shape()
    yield "sector", BRepPrimAPI_MakeRevol(face, axis, 1.9).Shape()
    yield "elliptic", BRepPrimAPI_MakePrism(ellipse, gp_Vec(0, 0, 6)).Shape()
    yield "oblique", oblique()
    yield "nurbs", nurbs(dimpled)
    yield "nurbs-torus", nurbs(torus)
    yield "nurbs-rounded", nurbs(rounded(box, 1.5))


def write(body, file, schema="AP214IS", inch=False):
    Interface_Static.SetCVal_s("write.step.schema", schema)
    Interface_Static.SetCVal_s("write.step.unit", "INCH" if inch else "MM")
    writer = STEPControl_Writer()
    if inch:
        writer.Model(False).SetWriteLengthUnit(25.4)
    writer.Transfer(body, STEPControl_AsIs)
    writer.Write(str(file))


folder = Path(sys.argv[1])
STEPControl_Writer()  # (Before it there is no such setting.)
for name, body in bodies():
    write(body, folder / f"{name}.step")
    if name == "dimpled":
        write(body, folder / "dimpled-AP203.step", "AP203")
        write(body, folder / "dimpled-AP242DIS.step", "AP242DIS")
        write(body, folder / "dimpled-inch.step", inch=True)
