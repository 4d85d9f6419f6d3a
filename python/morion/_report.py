"""Reports of commands: mappings with the keys of the JSON that the program writes."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from . import _html
from ._morion import decode_png


class Report(Mapping[str, Any]):
    """What a command found: a mapping with the keys of its JSON report."""

    def __init__(self, outcome: tuple[str, str, dict[str, bytes], Optional[Any]]) -> None:
        self.json, self.text, self.files, folder = outcome
        self.folder: Optional[Path] = None if folder is None else Path(folder)
        """Folder of the published files; `None` of files in memory."""
        self._keys: dict[str, Any] = json.loads(self.json)

    json: str
    """The report as JSON, byte for byte the program's."""
    text: str
    """The summary that the program prints."""
    files: dict[str, bytes]
    """Bytes of each file by its name; empty where they were published in a folder."""

    def __getitem__(self, key: str) -> Any:
        return self._keys[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._keys)

    def __len__(self) -> int:
        return len(self._keys)

    @property
    def verdict(self) -> Optional[str]:
        """`pass` or `fail`; `None` of a command that judges nothing."""
        return self._keys.get("verdict")

    @property
    def reasons(self) -> list[str]:
        """Reasons of a fail in words, each with figures."""
        return list(self._keys.get("reasons", []))

    @property
    def warnings(self) -> list[str]:
        """Nuisances to come, and what to do about them."""
        return list(self._keys.get("warnings", []))

    def file(self, name: str) -> bytes:
        """Bytes of a file of the command, from memory or from its folder."""
        if self.folder is None:
            return self.files[name]
        return (self.folder / name).read_bytes()

    def __repr__(self) -> str:
        verdict = f", {self.verdict}" if self.verdict else ""
        return f"<morion.{type(self).__name__} {self['profile']['name']}{verdict}>"

    def __str__(self) -> str:
        return self.text

    def _picture(self) -> Optional[str]:
        """Name of the file that shows the result."""
        names = ("preview.png", "frame.png", "blur.png")
        return next((name for name in names if self._has(name)), None)

    def _has(self, name: str) -> bool:
        return name in self.files or (self.folder is not None and (self.folder / name).exists())

    def _repr_html_(self) -> str:
        name = self._picture()
        picture = None if name is None else self.file(name)
        return _html.report(self.text, self.verdict, picture)


class RenderReport(Report):
    """A picture of a scene in the mirror."""

    def _picture(self) -> str:
        return Path(self["file"]).name

    @property
    def picture(self) -> NDArray[np.uint8]:
        """sRGB values of the picture, shape (rows, columns, channels)."""
        return decode_png(self.file(self._picture()))


class ToleranceReport(Report):
    """A tolerance study."""

    @property
    def trials(self) -> NDArray[np.void]:
        """A structured array with an entry a trial: its number, its figures as made and after adjustment (px), each adjustment
        (`adjustment_...`), and each error that was drawn, by its key. NaN where rays are lost. These are the numbers of `trials.csv`."""
        lines = self.file("trials.csv").decode().splitlines()
        lines = [line for line in lines if not line.startswith("#")]
        names = [_column(name) for name in lines[0].split(",")]
        types = [(name, np.int64 if k == 0 else np.float64) for k, name in enumerate(names)]
        rows = [_row(line) for line in lines[1:]]
        return np.array(rows, dtype=np.dtype(types))


def _column(name: str) -> str:
    """Name of a column; those of adjustments have spaces, and may be those of errors otherwise."""
    return "adjustment_" + name.replace(" ", "_") if " " in name else name


def _row(line: str) -> tuple[float, ...]:
    number, *values = line.split(",")
    return (int(number), *(float("nan") if value == "lost" else float(value) for value in values))
