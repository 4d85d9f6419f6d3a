"""Exceptions of the package."""

from __future__ import annotations

from typing import NamedTuple, Optional


class Complaint(NamedTuple):
    """One thing that is wrong with a profile."""

    file: str
    """The file, as it was named."""
    line: int
    """Line, from 1."""
    column: int
    """Column in characters, from 1."""
    message: str
    """The key, what it must be and what was found."""
    hint: Optional[str]
    """A text that would be right, where one is known."""


class MorionError(Exception):
    """Why something could not be done: a mirror that cannot be designed, a file that cannot be read."""


class ProfileError(MorionError, ValueError):
    """Everything that is wrong with a profile. `line`, `column`, `message` and `hint` are those of the first complaint."""

    def __init__(
        self, text: str, complaints: list[tuple[str, int, int, str, Optional[str]]]
    ) -> None:
        super().__init__(text)
        self.complaints: list[Complaint] = [Complaint(*complaint) for complaint in complaints]
        """Every complaint, in the order of the file."""

    @property
    def line(self) -> int:
        """Line, from 1."""
        return self.complaints[0].line

    @property
    def column(self) -> int:
        """Column in characters, from 1."""
        return self.complaints[0].column

    @property
    def message(self) -> str:
        """The key, what it must be and what was found."""
        return self.complaints[0].message

    @property
    def hint(self) -> Optional[str]:
        """A text that would be right, where one is known."""
        return self.complaints[0].hint

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), (str(self), [tuple(complaint) for complaint in self.complaints])
