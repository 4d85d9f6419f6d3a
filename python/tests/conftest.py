"""What the tests share: a small profile, its design, and the program that their figures are held against."""

import os
import subprocess
from pathlib import Path
from typing import Any

import pytest

import morion

ROOT = Path(__file__).resolve().parents[2]
SMALL = ROOT / "examples" / "small.toml"


@pytest.fixture(scope="session")
def small() -> morion.Profile:
    """A panorama of 160 x 120 pixels, exact by the mercator law."""
    return morion.Profile.load(SMALL)


@pytest.fixture(scope="session")
def design(small: morion.Profile) -> morion.Design:
    """Its mirror."""
    return morion.design(small)


@pytest.fixture(scope="session")
def pose(small: morion.Profile, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A trial's pose, as the program writes it."""
    folder = tmp_path_factory.mktemp("pose")
    report = morion.replay(small, 3, folder)
    assert report.folder is not None
    return report.folder / "pose.json"


class Program:
    """The program `morion` that the variable MORION names."""

    def __init__(self) -> None:
        self.path = os.environ["MORION"]

    def run(self, folder: Path, *arguments: Any) -> None:
        """Runs it with its files in a folder."""
        words = [self.path, *map(str, arguments), "--quiet", "--out", str(folder)]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        assert done.returncode in (0, 1), done.stderr


@pytest.fixture(scope="session")
def program() -> Program:
    """The program: without it these tests fail."""
    return Program()
