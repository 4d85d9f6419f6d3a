"""The mirror on arrays, against closed forms."""

import numpy as np
import pytest

import morion

RADIUS_MM = 40.0
PARABOLOID = f"""
camera.orthographic.pixels = [640, 480]
part = {{ width_mm = 30, height_mm = 20, base_mm = 5 }}
mirror.polynomial = {{ radius_mm = -{RADIUS_MM}, conic = -1 }}
mesh.chord_um = 2
export.formats = ["stl"]
"""


@pytest.fixture(scope="module")
def paraboloid() -> morion.Design:
    """Z = top - (X^2 + Y^2) / 2 R."""
    return morion.design(morion.Profile.parse("paraboloid", PARABOLOID))


def test_surface_of_a_paraboloid(paraboloid: morion.Design) -> None:
    x, y = np.linspace(-14.0, 14.0, 29), np.linspace(-9.0, 9.0, 19)[:, None]
    sag, normals, hessian = paraboloid.surface(x, y)
    assert sag.shape == (19, 29) and sag.flags.c_contiguous and sag.dtype == np.float64
    assert normals.shape == (19, 29, 3) and hessian.shape == (19, 29, 2, 2)
    drop = (x**2 + y**2) / (2.0 * RADIUS_MM)
    assert np.abs(sag - (sag[9, 14] - drop)).max() < 1e-12
    expected = np.stack(np.broadcast_arrays(x / RADIUS_MM, y / RADIUS_MM, 1.0), -1)
    expected /= np.linalg.norm(expected, axis=-1, keepdims=True)
    assert np.abs(normals - expected).max() < 1e-13
    assert np.abs(hessian + np.eye(2) / RADIUS_MM).max() < 1e-13
    assert np.array_equal(paraboloid.sag(x, y), sag)
    assert np.array_equal(paraboloid.normals(x, y), normals)
    assert np.array_equal(paraboloid.hessian(x, y), hessian)


def test_there_is_no_sag_beside_the_mirror(paraboloid: morion.Design) -> None:
    sag, normals, hessian = paraboloid.surface([0.0, 15.5, 0.0, np.nan], [0.0, 0.0, 10.5, 0.0])
    assert np.isnan(sag).tolist() == [False, True, True, True]
    assert np.isnan(normals[1:]).all() and np.isnan(hessian[1:]).all()
    assert np.isnan(paraboloid.sag(99.0, 0.0)) and paraboloid.sag(0.0, 0.0).shape == ()


def test_mesh_keeps_its_bounds(paraboloid: morion.Design) -> None:
    mesh = morion.mesh(paraboloid)
    vertices, triangles = mesh.vertices, mesh.triangles
    assert vertices.dtype == np.float64 and vertices.flags.c_contiguous
    assert triangles.dtype == np.uint32 and triangles.shape[1] == 3
    # All corners are on the mirror, and middles of facets are within the bound of it.
    assert np.nanmax(np.abs(paraboloid.sag(vertices[:, 0], vertices[:, 1]) - vertices[:, 2])) < 1e-5
    middle = vertices[triangles].mean(axis=1)
    chord_um = 1e3 * np.abs(paraboloid.sag(middle[:, 0], middle[:, 1]) - middle[:, 2])
    assert chord_um.max() <= mesh.bounds["chord_um"] <= 2.0
    assert chord_um.max() > 0.3
    # The facets cover the plan once.
    along, across = (vertices[triangles[:, k]] - vertices[triangles[:, 0]] for k in (1, 2))
    area = 0.5 * (along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0])
    assert (area > 0.0).all() and abs(area.sum() - 600.0) < 1e-3


def test_figures_of_the_design_are_those_of_the_report(design: morion.Design) -> None:
    report = morion.build(design.profile)
    assert design.facts == report["design"]
    size = design.plan_bounds[1] - design.plan_bounds[0]
    assert np.abs(size[0] - 60.0) < 1e-6 and design.pixel_mm == 60.0 / 160.0


def test_a_mirror_is_shown_in_notebooks(design: morion.Design) -> None:
    html = design._repr_html_()
    assert "data:image/png;base64," in html and "A small panorama" in html and "px RMS" in html
