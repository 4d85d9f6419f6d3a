"""The mirror on arrays: its surface, its mesh, and the camera with it."""

from __future__ import annotations

import json
import warnings
from typing import Any, NamedTuple, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _html
from ._commands import Path, Wanted, as_profile
from ._morion import NativeCamera, NativeDesign, NativeMesh, Profile
from ._progress import Progress, watched

Floats = NDArray[np.float64]


class Surface(NamedTuple):
    """A mirror over places of its plan, as the graph Z(X, Y)."""

    sag: Floats
    """Z over the plane of the base, mm."""
    normals: Floats
    """Unit normals towards +Z, shape (..., 3)."""
    hessian: Floats
    """Second derivatives, 1/mm: [[Z_XX, Z_XY], [Z_XY, Z_YY]], shape (..., 2, 2)."""


class Rays(NamedTuple):
    """Rays that leave the mirror towards what pixels see."""

    origins: Floats
    """Places on the mirror, mm, shape (..., 3)."""
    directions: Floats
    """Unit directions, shape (..., 3)."""

    def at_z(self, z_mm: float) -> Floats:
        """The points of the plane at height `z_mm`, mm, shape (..., 3); NaN where a ray does not meet it."""
        with np.errstate(divide="ignore", invalid="ignore"):
            way = (z_mm - self.origins[..., 2]) / self.directions[..., 2]
            points = self.origins + self.directions * way[..., None]
        points[~(way > 0.0)] = np.nan
        points[..., 2] = np.where(way > 0.0, z_mm, np.nan)
        return np.asarray(points)


class Mesh:
    """The optical face: triangles within the profile's limits."""

    def __init__(self, native: NativeMesh) -> None:
        self.vertices: Floats = native.vertices
        """Positions, mm, shape (n, 3)."""
        self.triangles: NDArray[np.uint32] = native.triangles
        """Numbers of vertices, counter-clockwise seen from outside, shape (m, 3)."""
        self.bounds: dict[str, float] = dict(native.bounds)
        """Bounds that are proven over every facet: `chord_um` between facet and mirror, `facet_px` of the picture's displacement, and
        `rounding_px` of that by rounding to single precision."""

    def __repr__(self) -> str:
        return f"<morion.Mesh {len(self.vertices)} vertices, {len(self.triangles)} triangles>"


class Camera:
    """A camera with the mirror that it looks into, as designed or as mounted.

    Shadows are not looked for: a pixel shows what it would without other panels and bodies in the way.
    """

    def __init__(self, native: NativeCamera) -> None:
        self._native = native
        if native.warning is not None:
            warnings.warn(native.warning, stacklevel=3)

    def unproject(self, pixels: ArrayLike) -> Rays:
        """The rays that pixels see, shape (..., 2): those of `morion table`. NaN beyond the frame and where there is no mirror."""
        flat, shape = _flat(pixels, 2)
        origins, directions = self._native.unproject(flat)
        return Rays(origins.reshape(*shape, 3), directions.reshape(*shape, 3))

    def project(self, points: ArrayLike, *, at_infinity: bool = False) -> Floats:
        """The pixels that show points of the world, mm, shape (..., 3), or what is far away in these directions; shape (..., 2).

        Off by less than 1e-6 px. NaN where no pixel does; one of them where several do.
        """
        flat, shape = _flat(points, 3)
        return self._native.project(flat, at_infinity).reshape(*shape, 2)


class Design:
    """A designed or given mirror, with the camera that looks into it."""

    def __init__(self, profile: Wanted, *, progress: Progress = None) -> None:
        self.profile: Profile = as_profile(profile)
        with watched(progress, "design") as watch:
            self._native = NativeDesign(self.profile, watch)
        self._camera: Optional[Camera] = None

    @property
    def facts(self) -> dict[str, Any]:
        """Figures of merit: the table `design` of `report.json`."""
        facts: dict[str, Any] = json.loads(self._native.facts)
        return facts

    @property
    def plan_bounds(self) -> Floats:
        """Least and largest X and Y of the part, mm: [[X, Y], [X, Y]]."""
        return np.array(self._native.plan_bounds)

    @property
    def pixel_mm(self) -> float:
        """Side of a pixel on the reference plane, mm."""
        return self._native.pixel_mm

    @property
    def volume_mm3(self) -> float:
        """Volume of the part without its cavity, mm^3."""
        return self._native.volume_mm3

    def surface(self, x: ArrayLike, y: ArrayLike) -> Surface:
        """The mirror over X and Y, mm, which are broadcast; NaN where it is not."""
        across, up = np.broadcast_arrays(np.asarray(x, np.float64), np.asarray(y, np.float64))
        shape = across.shape
        sag, normals, second = self._native.surface(np.stack([across.ravel(), up.ravel()], -1))
        hessian = second[:, [0, 1, 1, 2]].reshape(*shape, 2, 2)
        return Surface(sag.reshape(shape), normals.reshape(*shape, 3), hessian)

    def sag(self, x: ArrayLike, y: ArrayLike) -> Floats:
        """Z of the mirror over X and Y, mm over the plane of the base."""
        return self.surface(x, y).sag

    def normals(self, x: ArrayLike, y: ArrayLike) -> Floats:
        """Unit normals towards +Z, shape (..., 3)."""
        return self.surface(x, y).normals

    def hessian(self, x: ArrayLike, y: ArrayLike) -> Floats:
        """Second derivatives [[Z_XX, Z_XY], [Z_XY, Z_YY]], 1/mm, shape (..., 2, 2)."""
        return self.surface(x, y).hessian

    def mesh(self, *, progress: Progress = None) -> Mesh:
        """The optical face within the profile's limits."""
        with watched(progress, "mesh") as watch:
            return Mesh(self._native.mesh(watch))

    def camera(self, pose: Optional[Path] = None) -> Camera:
        """The camera with the mirror as designed, or as mounted by a `pose.json` of `replay`."""
        if pose is not None:
            return Camera(self._native.mounted(pose))
        if self._camera is None:
            self._camera = Camera(self._native.mounted(None))
        return self._camera

    def __repr__(self) -> str:
        return f"<morion.Design of {self.profile.name}>"

    def _repr_html_(self) -> str:
        low, high = self.plan_bounds
        columns = 320
        rows = max(1, round(columns * (high[1] - low[1]) / (high[0] - low[0])))
        x = low[0] + (np.arange(columns) + 0.5) * (high[0] - low[0]) / columns
        y = high[1] - (np.arange(rows) + 0.5) * (high[1] - low[1]) / rows
        surface = self.surface(x, y[:, None])
        light = np.array([-0.4, 0.5, 0.77]) / np.sqrt(0.16 + 0.25 + 0.77**2)
        shade = np.nan_to_num(np.clip(surface.normals @ light, 0.0, 1.0), nan=1.0)
        image = _html.png(np.asarray(255.0 * shade, np.uint8))
        size = " x ".join(f"{length:.2f}" for length in high - low)
        facts: list[tuple[str, str]] = [("part", f"{size} mm"), ("purpose", self.profile.summary)]
        for name, key in (("pixel error", "pixel_error_px"), ("ray error", "ray_error_mrad")):
            figure = self.facts.get(key)
            if figure and figure.get("rms") is not None:
                unit = key.rsplit("_", 1)[1]
                text = f"{figure['rms']:.3g} {unit} RMS, {figure['max']:.3g} at most"
                facts.append((name, text))
        return _html.table(self.profile.name, facts, image)


def design(profile: Wanted, *, progress: Progress = None) -> Design:
    """Designs the mirror that a profile asks for, or makes the one that it gives."""
    return Design(profile, progress=progress)


def mesh(mirror: Union[Design, Wanted], *, progress: Progress = None) -> Mesh:
    """The optical face of a design, or of a profile's."""
    return _design(mirror).mesh(progress=progress)


def project(
    mirror: Union[Design, Camera, Wanted],
    points: ArrayLike,
    *,
    pose: Optional[Path] = None,
    at_infinity: bool = False,
) -> Floats:
    """`Camera.project` of a camera, or of a design with its `pose.json` where it has one."""
    return _camera(mirror, pose).project(points, at_infinity=at_infinity)


def unproject(
    mirror: Union[Design, Camera, Wanted], pixels: ArrayLike, *, pose: Optional[Path] = None
) -> Rays:
    """`Camera.unproject` of a camera, or of a design with its `pose.json` where it has one."""
    return _camera(mirror, pose).unproject(pixels)


def unwrap_map(
    mirror: Union[Design, Wanted],
    photo: Optional[tuple[int, int]] = None,
    *,
    projection: Optional[str] = None,
    view: Optional[tuple[float, float, float]] = None,
    ground_mm: Optional[float] = None,
    width: Optional[int] = None,
    height: Optional[int] = None,
    range_mm: Optional[float] = None,
    mm_per_px: Optional[float] = None,
    pose: Optional[Path] = None,
) -> NDArray[np.float32]:
    """The map of OpenCV's `remap` from photos to a panorama, shape (rows, columns, 2): that of `morion unwrap --map`.

    `photo` are columns and rows of the photos; without it those of the camera. `projection` is the law of the panorama's rows:
    `cylindrical`, `equirectangular` or `mercator`, without it the profile's. With `view` (azimuth, elevation, field; degrees) the picture
    is a perspective view, with `ground_mm` (Z of a floor) a plan. Entries are columns and rows of the photo with the first pixel's centre
    at (0, 0), as OpenCV has them; -1 where nothing is seen.
    """
    if view is not None and ground_mm is not None:
        raise ValueError("a picture is a view or a plan, not both: leave view or ground_mm out")
    found = _design(mirror)
    return found._native.unwrap_map(
        {
            "projection": projection,
            "view": view,
            "ground_mm": ground_mm,
            "width": width,
            "height": height,
            "range_mm": range_mm,
            "mm_per_px": mm_per_px,
        },
        found.profile.pixels if photo is None else photo,
        pose,
    )


def _design(mirror: Union[Design, Wanted]) -> Design:
    return mirror if isinstance(mirror, Design) else Design(mirror)


def _camera(mirror: Union[Design, Camera, Wanted], pose: Optional[Path]) -> Camera:
    if isinstance(mirror, Camera):
        if pose is not None:
            raise ValueError("a camera is mounted already: leave pose out, or give the design")
        return mirror
    return _design(mirror).camera(pose)


def _flat(vectors: ArrayLike, length: int) -> tuple[Floats, tuple[int, ...]]:
    array = np.ascontiguousarray(vectors, np.float64)
    if array.ndim == 0 or array.shape[-1] != length:
        raise ValueError(f"the last axis must have {length} entries, found shape {array.shape}")
    return array.reshape(-1, length), array.shape[:-1]
