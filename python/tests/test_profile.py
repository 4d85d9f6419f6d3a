"""Profiles, and what is wrong with them."""

import pickle

import pytest

import morion

FAULTY = """
camera.orthographic.pixels = [640, 480]
part = { width_mm = 0, height_mm = 20, base_mm = 5 }
mirror.polynomial.radius_mm = -40
mesh.chrd_um = 2
export.formats = ["stl"]
"""


def test_shipped_profiles_are_found_by_their_names() -> None:
    names = [name for name, _ in morion.shipped()]
    assert "conquistador" in names
    profile = morion.Profile.load("conquistador")
    assert (profile.name, profile.pixels) == ("conquistador", (640, 480))
    text = dict(morion.shipped())["conquistador"]
    assert morion.Profile.parse("conquistador", text).sha256 == profile.sha256


def test_complaints_have_their_lines() -> None:
    with pytest.raises(morion.ProfileError) as caught:
        morion.Profile.parse("faulty", FAULTY)
    error = caught.value
    assert isinstance(error, ValueError) and isinstance(error, morion.MorionError)
    assert error.line == 3 and error.message.startswith("part.width_mm must be")
    assert error.complaints[0].file == "faulty.toml"
    other = [complaint for complaint in error.complaints if complaint.line == 5]
    assert len(other) == 1 and "chrd_um" in other[0].message
    assert str(error).startswith(f"faulty.toml:{error.line}:{error.column}: ")
    again = pickle.loads(pickle.dumps(error))
    assert (again.complaints, str(again)) == (error.complaints, str(error))


def test_a_name_that_is_none_is_an_error() -> None:
    with pytest.raises(morion.MorionError, match="did you mean conquistador") as caught:
        morion.Profile.load("conquistator")
    assert not isinstance(caught.value, morion.ProfileError)
