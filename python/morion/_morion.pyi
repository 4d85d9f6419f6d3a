"""Native part of the package: `morion` has what users need."""

from os import PathLike
from typing import Any, Callable, Optional, Sequence, TypedDict, Union, final

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "NativeCamera",
    "NativeDesign",
    "NativeMesh",
    "Profile",
    "blur",
    "build",
    "decode_png",
    "frame",
    "machining",
    "program",
    "render",
    "replay",
    "shipped",
    "table",
    "tolerance",
    "verify",
]

_Path = Union[str, PathLike[str]]
_Progress = Optional[Callable[[str, Optional[float], str], object]]
_Place = tuple[Optional[_Path], _Progress]
_Outcome = tuple[str, str, dict[str, bytes], Optional[Any]]

class _Picture(TypedDict):
    projection: Optional[str]
    view: Optional[tuple[float, float, float]]
    ground_mm: Optional[float]
    width: Optional[int]
    height: Optional[int]
    range_mm: Optional[float]
    mm_per_px: Optional[float]

@final
class Profile:
    """A checked profile: what is wanted of a mirror."""

    @staticmethod
    def load(named: _Path) -> Profile:
        """The profile of a file, or the shipped one of that name, with the files that it names from its own folder."""
    @staticmethod
    def parse(name: str, text: str) -> Profile:
        """The profile of a text that names no files; `name` is what output goes under."""
    @property
    def name(self) -> str:
        """Name that output goes under."""
    @property
    def sha256(self) -> str:
        """SHA-256 of the profile's bytes, in hexadecimal."""
    @property
    def summary(self) -> str:
        """Purpose of the mirror in the author's words."""
    @property
    def pixels(self) -> tuple[int, int]:
        """Columns and rows of the camera's frame."""
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...

@final
class NativeDesign:
    def __new__(cls, profile: Profile, progress: _Progress = None) -> NativeDesign: ...
    @property
    def facts(self) -> str: ...
    @property
    def plan_bounds(self) -> list[list[float]]: ...
    @property
    def pixel_mm(self) -> float: ...
    @property
    def volume_mm3(self) -> float: ...
    def surface(
        self, places: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]: ...
    def mesh(self, progress: _Progress = None) -> NativeMesh: ...
    def mounted(self, pose: Optional[_Path]) -> NativeCamera: ...
    def unwrap_map(
        self, picture: _Picture, photo: tuple[int, int], pose: Optional[_Path]
    ) -> NDArray[np.float32]: ...

@final
class NativeMesh:
    @property
    def vertices(self) -> NDArray[np.float64]: ...
    @property
    def triangles(self) -> NDArray[np.uint32]: ...
    @property
    def bounds(self) -> list[tuple[str, float]]: ...

@final
class NativeCamera:
    @property
    def warning(self) -> Optional[str]: ...
    def project(
        self, points: NDArray[np.float64], at_infinity: bool
    ) -> NDArray[np.float64]: ...
    def unproject(
        self, pixels: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...

def shipped() -> list[tuple[str, str]]: ...
def decode_png(bytes: bytes) -> NDArray[np.uint8]: ...
def build(profile: Profile, place: _Place, afresh: bool) -> _Outcome: ...
def verify(
    profile: Profile,
    place: _Place,
    path: _Path,
    align: bool,
    radii_mm: Sequence[Optional[float]],
) -> _Outcome: ...
def tolerance(
    profile: Profile, place: _Place, range: Sequence[int], seed: int, until: Optional[float]
) -> _Outcome: ...
def replay(
    profile: Profile, place: _Place, trial: int, seed: int, without: Sequence[str]
) -> _Outcome: ...
def render(
    profile: Profile,
    place: _Place,
    scene: str,
    smooth: bool,
    sizes_mm: Sequence[Optional[float]],
    allow_outside: bool,
) -> _Outcome: ...
def frame(profile: Profile, place: _Place, min: Optional[float]) -> _Outcome: ...
def blur(profile: Profile, place: _Place, focus_mm: Optional[float]) -> _Outcome: ...
def machining(
    profile: Profile, place: _Place, ball_mm: float, stepover_mm: Optional[float]
) -> _Outcome: ...
def program(profile: Profile, place: _Place) -> _Outcome: ...
def table(
    profile: Profile,
    place: _Place,
    every: int,
    floor_mm: Optional[float],
    range_mm: Optional[float],
    pose: Optional[_Path],
) -> _Outcome: ...
