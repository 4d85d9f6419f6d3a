"""Commands: reports and files are the program's, and long calls can be watched and ended."""

import _thread
import threading
import time
from pathlib import Path
from typing import Optional

import numpy as np
import pytest
from conftest import SMALL, Program

import morion


def test_a_build_in_memory_is_that_of_the_program(
    small: morion.Profile, program: Program, tmp_path: Path
) -> None:
    report = morion.build(small)
    assert report.verdict == "pass" and report.reasons == [] and report.folder is None
    program.run(tmp_path, "build", SMALL)
    written = {path.name: path.read_bytes() for path in (tmp_path / "small").iterdir()}
    assert set(written) == set(report.files)
    # (Pages name the folder, and timings are no two times the same.)
    for name in ("mirror.stl", "report.json", "preview.png", "design_error.png"):
        assert written[name] == report.files[name], name
    assert report.json.encode() == written["report.json"]
    assert report["profile"]["sha256"] == small.sha256 and "mesh" in report
    html = report._repr_html_()
    assert "pass" in html and "data:image/png;base64," in html and "<pre>small" in html


def test_a_build_in_a_folder_is_verified(small: morion.Profile, tmp_path: Path) -> None:
    report = morion.build(small, tmp_path)
    assert report.folder == tmp_path / "small" and report.files == {}
    assert report.file("mirror.stl") == (tmp_path / "small" / "mirror.stl").read_bytes()
    assert morion.verify(small, report.folder / "mirror.stl").verdict == "pass"
    damaged = tmp_path / "damaged.stl"
    damaged.write_bytes(report.file("mirror.stl")[:-500])
    failed = morion.verify(small, damaged)
    assert failed.verdict == "fail" and len(failed.reasons) > 0
    with pytest.raises(morion.MorionError, match="no-such.stl"):
        morion.verify(small, tmp_path / "no-such.stl")


def test_a_program_is_verified_with_the_tool_that_it_moves(
    small: morion.Profile, tmp_path: Path
) -> None:
    report = morion.program(small, tmp_path)
    assert report.folder == tmp_path / "small" / "program"
    finishing = report.folder / "finishing.ngc"
    foreseen = report["as_cut"]["trace"]["facet_error_px"]["rms"]
    found = morion.verify(small, finishing, ball_mm=report["program"]["ball_mm"])
    cut = found["trace"][0]["facet_error_px"]["rms"]
    assert abs(cut / foreseen - 1.0) < 0.01
    bull = morion.verify(small, finishing, cutter_mm=3.0, corner_mm=1.0)
    assert bull["program"]["corner_mm"] == 1.0 and bull.verdict == "fail"
    with pytest.raises(morion.MorionError, match="corner-mm must be no more than"):
        morion.verify(small, finishing, cutter_mm=1.0, corner_mm=2.0)
    with pytest.raises(morion.MorionError, match="left out with --nose-mm"):
        morion.verify(small, finishing, cutter_mm=1.0, nose_mm=0.5)


def test_trials_are_a_structured_array(small: morion.Profile) -> None:
    report = morion.tolerance(small, trials=64, seed=7)
    trials = report.trials
    assert trials["trial"].tolist() == list(range(64))
    budget_px, study = report["budget_px"], report
    kept = (trials["adjusted_p95_px"] <= budget_px).mean()
    figure = trials["adjusted_rms_px"] if study["criterion"] == "rms" else None
    if figure is not None:
        kept = (figure <= budget_px).mean()
    assert report["yield"]["share"] == kept
    assert "tilt_x_mrad" in (trials.dtype.names or ())
    second = morion.tolerance(small, trials=(10, 20), seed=7).trials
    assert np.array_equal(second, trials[10:20])
    with pytest.raises(morion.MorionError, match="trials must be"):
        morion.tolerance(small, trials=0)


def test_a_rendered_picture_is_an_array(small: morion.Profile) -> None:
    report = morion.render(small, "grid", smooth=True)
    picture = report.picture
    assert picture.shape == (120, 160, 3) and picture.dtype == np.uint8
    assert picture.std() > 10.0
    assert "data:image/png;base64," in report._repr_html_()
    with pytest.raises(morion.MorionError, match="the scenes are grid"):
        morion.render(small, "gird")


def test_stages_are_told_without_the_lock(small: morion.Profile) -> None:
    told: list[tuple[str, Optional[float], str]] = []
    morion.build(small, progress=lambda *stage: told.append(stage))
    begun = [stage for stage, seconds, _ in told if seconds is None]
    ended = [stage for stage, seconds, _ in told if seconds is not None]
    assert begun[0] == ended[0] == "design" and sorted(begun) == sorted(ended)
    assert {"mesh", "solid", "write", "trace", "report"} <= set(begun)
    counted = 0
    done = threading.Event()

    def study() -> None:
        morion.tolerance(small, trials=2000)
        done.set()

    thread = threading.Thread(target=study)
    thread.start()
    while not done.is_set():
        counted += 1
        time.sleep(0.001)
    thread.join()
    assert counted > 20


class Told(Exception):
    """An exception of a callable."""


def test_an_exception_of_the_callable_ends_the_call(small: morion.Profile, tmp_path: Path) -> None:
    def refuse(stage: str, seconds: Optional[float], note: str) -> None:
        if stage == "mesh":
            raise Told(stage)

    with pytest.raises(Told):
        morion.build(small, tmp_path, progress=refuse)
    assert list(tmp_path.glob("small/*.stl")) == []


def test_an_interrupt_ends_a_call_and_nothing_is_published(
    small: morion.Profile, tmp_path: Path
) -> None:
    def interrupt(stage: str, seconds: Optional[float], note: str) -> None:
        if stage == "trials" and seconds is None:
            _thread.interrupt_main()

    began = threading.active_count()
    with pytest.raises(KeyboardInterrupt):
        morion.tolerance(small, tmp_path, trials=200_000, progress=interrupt)
    assert threading.active_count() == began
    time.sleep(1.0)
    assert list(tmp_path.glob("small/*.json")) == []
