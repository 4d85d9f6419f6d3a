"""What OpenCASCADE's XCAF reads of the faces of a STEP file: their names and colours, as docs/files.md has them."""

from OCP.Interface import Interface_Static
from OCP.Quantity import Quantity_Color
from OCP.STEPCAFControl import STEPCAFControl_Reader
from OCP.TCollection import TCollection_ExtendedString
from OCP.TDataStd import TDataStd_Name
from OCP.TDF import TDF_Label
from OCP.TDocStd import TDocStd_Document
from OCP.TopAbs import TopAbs_FACE
from OCP.TopExp import TopExp_Explorer
from OCP.XCAFDoc import XCAFDoc_ColorType, XCAFDoc_DocumentTool

COLOURS = {
    "OPTICAL": (0.55, 0.75, 0.95),
    "WALL": (0.8, 0.8, 0.8),
    "LAND": (0.8, 0.8, 0.8),
    "RIM": (0.8, 0.8, 0.8),
    "SIDE": (0.8, 0.8, 0.8),
    "CHAMFER": (0.6, 0.65, 0.65),
    "BASE": (0.5, 0.75, 0.5),
    "MARK": (0.7, 0.5, 0.8),
    "CAVITY": (0.55, 0.55, 0.5),
    "DRAIN": (0.55, 0.55, 0.5),
}
THREAD, DOWEL, HOLE = (0.95, 0.6, 0.25), (0.85, 0.3, 0.3), (0.9, 0.85, 0.4)
SINGLE = 1e-6  # XCAF keeps colours in single precision


def static(kind, name):
    """A static method, under the older or the newer bindings' name."""
    return getattr(kind, name + "_s", None) or getattr(kind, name)


def wanted(name):
    """The colour of a face of this name; none for a name that no face has."""
    kind, _, words = name.partition(" ")
    kind, _, number = kind.partition("_")
    if bool(number) != (kind in ("HOLE", "MARK", "DRAIN")) or number and not number.isdigit():
        return None
    if kind == "HOLE":
        return THREAD if words.startswith("M") else DOWEL if " H7 " in words else HOLE
    return COLOURS.get(kind)


def encoded(linear):
    """A share of light as sRGB (IEC 61966-2-1)."""
    return 12.92 * linear if linear <= 0.0031308 else 1.055 * linear ** (1 / 2.4) - 0.055


def faces(path):
    """Name and colour of each face; none where it has none."""
    document = TDocStd_Document(TCollection_ExtendedString("part"))
    reader = STEPCAFControl_Reader()
    reader.SetColorMode(True)
    reader.SetNameMode(True)
    static(Interface_Static, "SetIVal")("read.stepcaf.subshapes.name", 1)
    reader.ReadFile(path)
    reader.Transfer(document)
    shapes = static(XCAFDoc_DocumentTool, "ShapeTool")(document.Main())
    colours = static(XCAFDoc_DocumentTool, "ColorTool")(document.Main())
    whole = shapes.Label().FindChild(1, False)
    explorer = TopExp_Explorer(static(type(shapes), "GetShape")(whole), TopAbs_FACE)
    while explorer.More():
        label, name, colour = TDF_Label(), TDataStd_Name(), Quantity_Color()
        is_known = shapes.FindSubShape(whole, explorer.Current(), label)
        is_named = is_known and label.FindAttribute(static(TDataStd_Name, "GetID")(), name)
        surface = XCAFDoc_ColorType.XCAFDoc_ColorSurf
        is_coloured = colours.GetColor(explorer.Current(), surface, colour)
        rgb = tuple(encoded(part) for part in (colour.Red(), colour.Green(), colour.Blue()))
        yield name.Get().ToExtString() if is_named else None, rgb if is_coloured else None
        explorer.Next()


def complaints(path, holes):
    """Faces without a name of docs/files.md or with another colour; `holes`: those of the build's report, if there is one."""
    bad, numbered = [], {}
    for name, rgb in faces(path):
        want = wanted(name or "")
        if want is None or rgb is None or max(abs(a - b) for a, b in zip(rgb, want)) > SINGLE:
            bad.append(f"face {name} has colour {rgb}, not {want}")
        elif name.startswith("HOLE_"):
            number, _, words = name.removeprefix("HOLE_").partition(" ")
            numbered.setdefault(int(number), set()).add(words)
    if holes is not None:
        is_plain = lambda hole: hole["words"] == f"diameter {hole['diameter_mm']:.10g}, through"
        want = {hole["number"]: {"" if is_plain(hole) else hole["words"]} for hole in holes}
        bad += [f"holes {numbered}, not {want}"] if numbered != want else []
    return bad
