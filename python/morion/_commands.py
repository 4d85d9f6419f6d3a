"""The program's commands: files go into a folder, or stay in memory where none is named."""

from __future__ import annotations

from collections.abc import Iterable
from os import PathLike
from typing import Optional, Union

from . import _morion
from ._morion import Profile
from ._progress import Progress, watched
from ._report import RenderReport, Report, ToleranceReport

Path = Union[str, "PathLike[str]"]
"""A file or a folder."""

Wanted = Union[Profile, Path]
"""A profile, or what `Profile.load` takes."""


def as_profile(profile: Wanted) -> Profile:
    """The profile itself, or that of a file or a shipped name."""
    return profile if isinstance(profile, Profile) else Profile.load(profile)


def build(
    profile: Wanted, folder: Optional[Path] = None, *, afresh: bool = False, progress: Progress = None
) -> Report:
    """Builds the part, reads each file back, traces it, and says whether it does its job: `morion build`.

    Files go into `folder/NAME`, or into `Report.files`. A part that fails is a report with the verdict `fail`. Where nothing has changed
    since the last build in the folder nothing is done, unless `afresh`.
    """
    with watched(progress, "build") as watch:
        return Report(_morion.build(as_profile(profile), (folder, watch), afresh))


def verify(
    profile: Wanted,
    path: Path,
    folder: Optional[Path] = None,
    *,
    align: bool = False,
    probe_mm: Optional[float] = None,
    ball_mm: Optional[float] = None,
    cutter_mm: Optional[float] = None,
    corner_mm: Optional[float] = None,
    nose_mm: Optional[float] = None,
    progress: Progress = None,
) -> Report:
    """Checks and traces a file of any making as a part of the profile: `morion verify`.

    `align` fits the pose of a measured part first. `probe_mm` is the radius of the ball whose centres a list of points holds, `ball_mm`
    that of the ball cutter that a program moves, `cutter_mm` that of a flat or bull-nosed cutter, whose rounded edge has the radius `corner_mm`,
    and `nose_mm` that of the nose of a lathe's tool.
    """
    radii_mm = [probe_mm, ball_mm, cutter_mm, corner_mm, nose_mm]
    with watched(progress, "verify") as watch:
        place = (folder, watch)
        return Report(_morion.verify(as_profile(profile), place, path, align, radii_mm))


def tolerance(
    profile: Wanted,
    folder: Optional[Path] = None,
    *,
    trials: Union[int, tuple[int, int]] = 2000,
    seed: int = 1,
    until: Optional[float] = None,
    progress: Progress = None,
) -> ToleranceReport:
    """Studies the errors of making and mounting that the profile names: `morion tolerance`.

    `trials` is their number, or the first and the one after the last. With `until` they end when the yield's 95 % interval is no wider.
    """
    span = (0, trials) if isinstance(trials, int) else trials
    with watched(progress, "tolerance") as watch:
        place = (folder, watch)
        return ToleranceReport(_morion.tolerance(as_profile(profile), place, span, seed, until))


def replay(
    profile: Wanted,
    trial: int,
    folder: Optional[Path] = None,
    *,
    seed: int = 1,
    without: Iterable[str] = (),
    progress: Progress = None,
) -> Report:
    """Makes a trial a part, with the `pose.json` that `unproject` and others take: `morion tolerance --replay`.

    `without` names errors, by their keys, that are left out.
    """
    with watched(progress, "replay") as watch:
        place = (folder, watch)
        return Report(_morion.replay(as_profile(profile), place, trial, seed, list(without)))


def render(
    profile: Wanted,
    scene: Path = "grid",
    folder: Optional[Path] = None,
    *,
    smooth: bool = False,
    square_mm: Optional[float] = None,
    unit_mm: Optional[float] = None,
    allow_outside: bool = False,
    progress: Progress = None,
) -> RenderReport:
    """Renders what the camera sees of a scene in the mirror: `morion render`.

    `scene` is `grid`, `chessboard`, `errors`, `views` or `cylinder`, or a panorama or a model as a file.
    """
    sizes = [square_mm, unit_mm]
    with watched(progress, "render") as watch:
        place = (folder, watch)
        outcome = _morion.render(
            as_profile(profile), place, str(scene), smooth, sizes, allow_outside
        )
    return RenderReport(outcome)


def frame(
    profile: Wanted,
    folder: Optional[Path] = None,
    *,
    least: Optional[float] = None,
    progress: Progress = None,
) -> Report:
    """Checks how well the sensor is filled, at least by the share `least`: `morion frame`."""
    with watched(progress, "frame") as watch:
        return Report(_morion.frame(as_profile(profile), (folder, watch), least))


def blur(
    profile: Wanted,
    folder: Optional[Path] = None,
    *,
    focus_mm: Optional[float] = None,
    progress: Progress = None,
) -> Report:
    """Computes the spot that each pixel sees through the profile's aperture: `morion blur`."""
    with watched(progress, "blur") as watch:
        return Report(_morion.blur(as_profile(profile), (folder, watch), focus_mm))


def machining(
    profile: Wanted,
    folder: Optional[Path] = None,
    *,
    ball_mm: float = 3.0,
    stepover_mm: Optional[float] = None,
    progress: Progress = None,
) -> Report:
    """Surveys the cut by a ball cutter of radius `ball_mm`: `morion machining`."""
    with watched(progress, "machining") as watch:
        place = (folder, watch)
        return Report(_morion.machining(as_profile(profile), place, ball_mm, stepover_mm))


def program(
    profile: Wanted, folder: Optional[Path] = None, *, progress: Progress = None
) -> Report:
    """Writes programs that mill or turn the mirror as `[program]` of the profile asks, and cuts and traces it: `morion program`."""
    with watched(progress, "program") as watch:
        return Report(_morion.program(as_profile(profile), (folder, watch)))


def table(
    profile: Wanted,
    folder: Optional[Path] = None,
    *,
    every: int = 4,
    floor_mm: Optional[float] = None,
    range_mm: Optional[float] = None,
    pose: Optional[Path] = None,
    progress: Progress = None,
) -> Report:
    """Makes tables of what each pixel looks at, for other programs: `morion table`."""
    with watched(progress, "table") as watch:
        place = (folder, watch)
        outcome = _morion.table(as_profile(profile), place, every, floor_mm, range_mm, pose)
    return Report(outcome)
