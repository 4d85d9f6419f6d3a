"""What OpenCASCADE's XCAF reads of an AP242 file: datum features and the mirror's profile tolerance."""

from OCP.Bnd import Bnd_Box
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepBndLib import BRepBndLib
from OCP.GeomAbs import GeomAbs_Cylinder, GeomAbs_Plane
from OCP.STEPCAFControl import STEPCAFControl_Reader
from OCP.TCollection import TCollection_ExtendedString
from OCP.TDocStd import TDocStd_Document
from OCP.TopAbs import TopAbs_FACE
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS
from OCP.XCAFDimTolObjects import XCAFDimTolObjects_GeomToleranceType
from OCP.XCAFDoc import (
    XCAFDoc_Datum,
    XCAFDoc_DimTolTool,
    XCAFDoc_DocumentTool,
    XCAFDoc_GeomTolerance,
    XCAFDoc_ShapeTool,
)

try:
    from OCP.TDF import TDF_LabelSequence as Labels
except ImportError:  # newer bindings
    from OCP.collections import Sequence_TDF_Label as Labels

PROFILE = XCAFDimTolObjects_GeomToleranceType.XCAFDimTolObjects_GeomToleranceType_ProfileOfSurface
PLACE = 1e-6  # mm


def static(kind, name):
    """A static method, under the older or the newer bindings' name."""
    return getattr(kind, name + "_s", None) or getattr(kind, name)


def listed(sequence):
    return [sequence.Value(k) for k in range(1, sequence.Length() + 1)]


def faces_of(label):
    """The faces that a datum or a tolerance is said of."""
    first, second = Labels(), Labels()
    static(XCAFDoc_DimTolTool, "GetRefShapeLabel")(label, first, second)
    return [static(XCAFDoc_ShapeTool, "GetShape")(shape) for shape in listed(first)]


def box(shape):
    """Least and largest X, Y and Z."""
    found = Bnd_Box()
    static(BRepBndLib, "AddOptimal")(shape, found, False, False)
    low, high = found.CornerMin(), found.CornerMax()
    return [(low.X(), high.X()), (low.Y(), high.Y()), (low.Z(), high.Z())]


def is_feature(face, words, whole):
    """Whether the face is the feature that the report names."""
    cast = getattr(TopoDS, "Face_s", None) or TopoDS.Face
    surface = BRepAdaptor_Surface(cast(face)).GetType()
    (x, y, z), (wide, high, _) = box(face), whole
    lies = lambda pair, at: all(abs(end - at) < PLACE for end in pair)
    if words == "base":
        return surface == GeomAbs_Plane and lies(z, 0.0)
    if words == "side towards -X":
        return surface == GeomAbs_Plane and lies(x, wide[0])
    if words == "side towards -Y":
        return surface == GeomAbs_Plane and lies(y, high[0])
    is_whole = abs(x[1] - x[0] - (wide[1] - wide[0])) < PLACE
    return surface == GeomAbs_Cylinder and is_whole == (words == "round outside")


def complaints(path, pmi, optical):
    """What XCAF reads otherwise than the report of the build has it; `optical`: number of the mirror's faces."""
    document = TDocStd_Document(TCollection_ExtendedString("part"))
    reader = STEPCAFControl_Reader()
    reader.SetGDTMode(True)
    reader.ReadFile(path)
    reader.Transfer(document)
    shapes = static(XCAFDoc_DocumentTool, "ShapeTool")(document.Main())
    whole = box(static(type(shapes), "GetShape")(shapes.Label().FindChild(1, False)))
    tool = static(XCAFDoc_DocumentTool, "DimTolTool")(document.Main())
    labels = Labels()
    tool.GetGeomToleranceLabels(labels)
    wanted = pmi.get("surface_profile_mm")
    if labels.Length() != (wanted is not None):
        return [f"{labels.Length()} tolerances for {wanted} mm"]
    bad, named = [], []
    for label in listed(labels):
        found = static(XCAFDoc_GeomTolerance, "Set")(label).GetObject()
        if found.GetType() != PROFILE or abs(found.GetValue() - wanted) > 1e-12:
            bad.append(f"tolerance {found.GetType()} {found.GetValue()} mm for {wanted}")
        if len(faces_of(label)) != optical:
            bad.append(f"tolerance of {len(faces_of(label))} faces for {optical}")
        references = Labels()
        static(XCAFDoc_DimTolTool, "GetDatumWithObjectOfTolerLabels")(label, references)
        for reference in listed(references):
            datum = static(XCAFDoc_Datum, "Set")(reference).GetObject()
            named.append((datum.GetPosition(), datum.GetName().ToCString(), faces_of(reference)))
    datums = [words.split(" ", 1) for words in pmi["datums"]]
    named.sort(key=lambda entry: entry[0])
    if [entry[1] for entry in named] != [letter for letter, _ in datums]:
        return bad + [f"datums {[entry[1] for entry in named]} for {datums}"]
    for (_, letter, faces), (_, words) in zip(named, datums):
        if len(faces) != 1 or not is_feature(faces[0], words, whole):
            bad.append(f"datum {letter} is not the {words}")
    return bad
