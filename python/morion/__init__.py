"""Freeform panoramic mirrors: designed, meshed, built, verified and toleranced, with NumPy arrays.

Lengths are millimetres and angles radians unless a name says otherwise. The part frame has X to the right in the picture, Y up in it and
Z towards the camera, with the base of the part at Z = 0. Pixels are columns and rows from the frame's upper left corner; the first one's
centre is (0.5, 0.5). Where there is no mirror or no pixel, arrays hold NaN.
"""

from ._commands import (
    blur,
    build,
    frame,
    machining,
    program,
    render,
    replay,
    table,
    tolerance,
    verify,
)
from ._errors import Complaint, MorionError, ProfileError
from ._mirror import (
    Camera,
    Design,
    Mesh,
    Rays,
    Surface,
    design,
    mesh,
    project,
    unproject,
    unwrap_map,
)
from ._morion import Profile, shipped
from ._report import RenderReport, Report, ToleranceReport

__all__ = [
    "Camera",
    "Complaint",
    "Design",
    "Mesh",
    "MorionError",
    "Profile",
    "ProfileError",
    "Rays",
    "RenderReport",
    "Report",
    "Surface",
    "ToleranceReport",
    "blur",
    "build",
    "design",
    "frame",
    "machining",
    "mesh",
    "program",
    "project",
    "render",
    "replay",
    "shipped",
    "table",
    "tolerance",
    "unproject",
    "unwrap_map",
    "verify",
]
