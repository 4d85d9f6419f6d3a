"""Job "whole": `morion build` against python_stack.py, from a profile to a traced file.

Both make about the same number of optical triangles. Whole processes.
"""

import json
import math
import re
import shutil
import statistics
import sys
import tempfile
import tomllib
from pathlib import Path

from common import Row, installed

TRIANGLES = 680_000
NEAR = 0.02


def profile_with(text, facet_px):
    """The profile with this facet error as its only mesh rule and STL as its only file."""
    given = tomllib.loads(text)
    tables = {
        "mesh": given.get("mesh", {}) | {"facet_px": facet_px},
        "export": given.get("export", {}) | {"formats": ["stl"]},
    }
    tables["mesh"].pop("chord_um", None)
    for name, entries in tables.items():
        text = re.sub(rf"(?ms)^\[{name}\].*?(?=^\[[a-z]|\Z)", "", text)
        lines = [f"{key} = {json.dumps(value)}" for key, value in entries.items()]
        text = text.rstrip() + f"\n\n[{name}]\n" + "\n".join(lines) + "\n"
    if tomllib.loads(text) != given | tables:
        sys.exit("run: could not rewrite the profile's [mesh] and [export]")
    return text


def facet_for(wanted, triangles_at, start=1.0, tries=12):
    """The facet error that gives the wanted number of triangles, and that number.

    A secant in the logarithms, begun with triangles ~ 1 / facet_px^2.
    """
    x, slope, best, last = math.log(start), -2.0, None, None
    for _ in range(tries):
        count = triangles_at(math.exp(x))
        y = math.log(count / wanted)
        if best is None or abs(y) < abs(best[0]):
            best = (y, math.exp(x), count)
        if abs(count / wanted - 1) <= NEAR:
            break
        if last and x != last[0]:
            # A count that moves in steps must not throw the search far away.
            slope = min(-0.5, max(-4.0, (y - last[1]) / (x - last[0])))
        last = (x, y)
        x -= y / slope
    return best[1:]


def job(bench):
    shipped = (bench.root / "profiles" / "conquistador.toml").read_text()
    if not installed(
        "whole", {"scipy": "scipy", "trimesh": "trimesh", "Embree": "embreex"}
    ).keys() >= {
        "scipy",
        "trimesh",
        "Embree",
    }:
        return [], None
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        profile, out = folder / "conquistador.toml", folder / "out"

        def ours():
            shutil.rmtree(out, ignore_errors=True)
            seconds, _ = bench.process([bench.morion, "build", profile, "--quiet", "--out", out])
            return seconds, json.loads((out / profile.stem / "report.json").read_text())

        def triangles_at(facet_px):
            profile.write_text(profile_with(shipped, facet_px))
            return ours()[1]["mesh"]["optical_triangles"]

        facet_px, _ = facet_for(TRIANGLES, triangles_at)
        profile.write_text(profile_with(shipped, facet_px))
        command = bench.peer(
            "python_stack.py", folder / "peer.stl", "--optical-triangles", TRIANGLES
        )
        made = bench.turns({"morion": ours, "python stack": lambda: bench.said(command)})

    if "python stack" not in made:
        return [], None
    report, peer = made["morion"][-1][1], made["python stack"][-1][1]
    trace = next(t for t in report["trace"] if t["file"].endswith(".stl"))
    counts = peer["optical_triangles"], report["mesh"]["optical_triangles"]
    rms = peer["pixel_error_px"]["rms"], trace["pixel_error_px"]["rms"]
    seconds = {name: [seconds for seconds, _ in runs] for name, runs in made.items()}
    stages = statistics.median(said["total_seconds"] for _, said in made["python stack"])
    both = (
        f"profile to traced STL, whole processes: {counts[0]} and {counts[1]} optical triangles, "
        f"pixel error {rms[0]:.3f} and {rms[1]:.3f} px RMS; the peer without its start-up {stages:.3f} s"
    )
    agrees = abs(counts[1] / counts[0] - 1) <= 2 * NEAR and abs(rms[1] / rms[0] - 1) <= 0.05
    row = Row(
        "whole",
        "numpy, scipy, trimesh, Embree",
        seconds["python stack"],
        seconds["morion"],
        both,
        agrees,
    )
    return [row], None
