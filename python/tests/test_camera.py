"""Pixels to rays and back, and maps of photos: against the program's own files."""

from pathlib import Path
from typing import Optional

import numpy as np
import pytest
from conftest import SMALL, Program

import morion


def pixels(design: morion.Design) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Centres of some of the frame's pixels."""
    columns, rows = design.profile.pixels
    x, y = np.arange(0.5, columns, 3.0), np.arange(0.5, rows, 3.0)
    return np.stack(np.meshgrid(x, y), -1)


@pytest.mark.parametrize("mounted", [False, True])
def test_points_of_a_pixel_s_ray_are_shown_by_it(
    design: morion.Design, pose: Path, mounted: bool
) -> None:
    camera = design.camera(pose if mounted else None)
    asked = pixels(design)
    rays = camera.unproject(asked)
    assert rays.origins.shape == (*asked.shape[:-1], 3)
    seen = ~np.isnan(rays.origins[..., 0])
    assert seen.mean() > 0.2
    assert np.abs(np.linalg.norm(rays.directions[seen], axis=-1) - 1.0).max() < 1e-15
    far = camera.project(rays.directions, at_infinity=True)
    assert np.array_equal(~np.isnan(far[..., 0]), seen)
    assert np.abs(far - asked)[seen].max() < 1e-6
    for distance_mm in (50.0, 1e3, 1e6):
        back = camera.project(rays.origins + distance_mm * rays.directions)
        assert np.array_equal(~np.isnan(back[..., 0]), seen), distance_mm
        assert np.abs(back - asked)[seen].max() < 1e-6, distance_mm


def test_what_nobody_sees_has_no_pixel(design: morion.Design) -> None:
    assert np.isnan(morion.project(design, [0.0, 0.0, -1.0], at_infinity=True)).all()
    assert np.isnan(morion.project(design, [[np.nan, 0.0, 0.0], [0.0, 0.0, 0.0]])[0]).all()
    rays = morion.unproject(design, [[-1.0, 60.5], [160.5, 60.5], [np.nan, 0.0]])
    assert np.isnan(rays.origins).all() and np.isnan(rays.directions).all()
    with pytest.raises(ValueError, match="the last axis must have 2 entries"):
        morion.unproject(design, [1.0, 2.0, 3.0])


@pytest.mark.parametrize("mounted", [False, True])
def test_rays_are_those_of_the_program_s_table(
    design: morion.Design, pose: Path, program: Program, tmp_path: Path, mounted: bool
) -> None:
    words = ["--pose", pose] if mounted else []
    program.run(tmp_path, "table", SMALL, "--every", 2, "--floor-mm", -300, *words)
    table = np.load(tmp_path / "small" / "table" / "table.npy")
    columns, rows = design.profile.pixels
    places = np.stack(np.meshgrid(np.arange(1.0, columns, 2.0), np.arange(1.0, rows, 2.0)), -1)
    rays = morion.unproject(design, places, pose=pose if mounted else None)
    x, y, z = np.moveaxis(rays.directions, -1, 0)
    azimuth, elevation = np.degrees(np.arctan2(x, y)), np.degrees(np.arcsin(z))
    found = np.stack([azimuth, elevation], -1).astype(np.float32)
    assert np.array_equal(np.isnan(found), np.isnan(table[..., :2]))
    assert np.nanmax(np.abs(found - table[..., :2])) < 4e-5
    floor = rays.at_z(-300.0)
    near = ~np.isnan(table[..., 4])
    assert near.any() and (floor[near][:, 2] == -300.0).all()
    assert np.abs(floor[near][:, :2] - table[near][:, 4:6]).max() < 1e-3


@pytest.mark.parametrize(
    ("words", "name"),
    [
        ([], "map.npy"),
        (["--projection", "equirectangular", "--width", "200"], "map.npy"),
        (["--view", "10,-5,40", "--width", "80"], "view-map.npy"),
        (["--ground", "-300", "--range-mm", "900", "--mm-per-px", "9"], "ground-map.npy"),
        (["--pose"], "map.npy"),
    ],
)
def test_maps_are_the_program_s(
    design: morion.Design,
    pose: Path,
    program: Program,
    tmp_path: Path,
    words: list[str],
    name: str,
) -> None:
    report = morion.render(design.profile, "grid", tmp_path, smooth=True)
    assert report.folder is not None
    photo = report.folder / "render-grid.png"
    mounted: Optional[Path] = pose if words == ["--pose"] else None
    asked = [*words, *([str(pose)] if mounted else [])]
    program.run(tmp_path, "unwrap", photo, "--profile", SMALL, "--map", "npy", *asked)
    expected = np.load(tmp_path / "small" / f"render-grid-{name}")
    options = dict(zip(words[::2], words[1::2]))
    found = morion.unwrap_map(
        design,
        (160, 120),
        projection=options.get("--projection"),
        view=(10.0, -5.0, 40.0) if "--view" in options else None,
        ground_mm=-300.0 if "--ground" in options else None,
        width=int(options["--width"]) if "--width" in options else None,
        range_mm=900.0 if "--ground" in options else None,
        mm_per_px=9.0 if "--ground" in options else None,
        pose=mounted,
    )
    assert found.dtype == np.float32 and found.tobytes() == expected.tobytes()
    assert found.shape == expected.shape and (found >= 0.0).mean() > 0.2


def test_arguments_of_a_map_that_mean_nothing_are_refused(design: morion.Design) -> None:
    with pytest.raises(ValueError, match="projection must be cylindrical"):
        morion.unwrap_map(design, projection="polar")
    with pytest.raises(ValueError, match="a view or a plan"):
        morion.unwrap_map(design, view=(0.0, 0.0, 40.0), ground_mm=-300.0)
    with pytest.raises(morion.MorionError, match="not the shape of the sensor"):
        morion.unwrap_map(design, (100, 100))
