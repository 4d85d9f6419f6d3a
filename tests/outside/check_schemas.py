#!/usr/bin/env python3
"""Validates the program's JSON by the JSON Schemas that `morion schema NAME` prints.

usage: check_schemas.py MORION [FOLDER]

Runs every command with --format json on small profiles, checks and forecasts every shipped one, makes errors of each
kind, and validates each line that is printed, each JSON file that is written, and each report.json and timings.json
below FOLDER, which a build left there. MORION_THOROUGH=1 runs the commands on all shipped profiles too.
Every schema is held against the metaschema of draft 2020-12, and has to have an output.
Prints one line per schema; exits 1 if an output is refused.

It is also proven that the check can fail. In one output of each schema a key is added to each object, each object is
emptied, each required key of the outermost one is removed, and each number is replaced by a text: each must be refused.
"""

import copy
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

from jsonschema import Draft202012Validator
from jsonschema.exceptions import best_match
from verdicts import told

ROOT = pathlib.Path(__file__).resolve().parents[2]
THOROUGH = os.environ.get("MORION_THOROUGH") == "1"
OPEN = {"seconds", "figures"}  # objects whose keys are names of stages and of figures
ANY = {"axes", "columns"}  # lists whose entries are those of a profile or a report: numbers, texts, flags
SAMPLE = 100  # damages of a kind, evenly among all that are possible

SMALL = """
[camera.orthographic]
pixels = [80, 60]
na = 0.002
[projection.mercator]
azimuth_deg = [-180, 180]
elevation_deg = [-30, 30]
[layout]
LAYOUT
[method.vector-field]
degree = 8
[part]
width_mm = 60
base_mm = 2
[mesh]
MESH
[export]
formats = FORMATS
[tolerance]
preset = "polished"
"""
ROUND = """
camera.pinhole = { pixels = [80, 80], lens_mm = 8, pixel_um = 60, f_number = 11, distance_mm = 40 }
projection.hyperbolic.outer_polar_deg = 110
layout.disc = {}
method.vector-field.degree = 16
part = { width_mm = 20, base_mm = 2 }
mesh.facet_px = 3
export.formats = ["stl"]
"""
GIVEN = """
camera.orthographic.pixels = [80, 60]
mirror.polynomial = { radius_mm = RADIUS, conic = 0 }
part = { width_mm = 15, height_mm = 11, base_mm = 2 }
mesh.chord_um = 5
export.formats = ["stl"]
"""
STUDY = """
profile = "strip.toml"
[[axis]]
key = "part.width_mm"
values = [50, -1, 60]
[[axis]]
key = "method.vector-field.degree"
from = 4
to = 8
count = 3
[[column]]
key = "design.pixel_error_px.rms"
goal = "least"
[[column]]
key = "form.sphere.pv_mm"
goal = "least"
[[column]]
key = "design.method"
"""


def small(layout, mesh, formats):
    return SMALL.replace("LAYOUT", layout).replace("MESH", mesh).replace("FORMATS", json.dumps(formats))


VALLEY = 'conquistador = { panel = "section", ridge = "valley" }'
PROFILES = {
    "strip": small("strip = {}", "facet_px = 3\nchord_um = 50", ["stl", "obj", "3mf", "step", "csv"]),
    "budget": small("strip = {}", "max_triangles = 4000", ["obj", "csv"]),
    "valley": small(VALLEY, "facet_px = 3", ["stl"])
    + 'budget_px = 0.01\nreference = "projection"\n',
    "milled": small("strip = {}", "facet_px = 3", ["stl"]).replace("polished", "precision-cnc"),
    "round": ROUND,
    "given": GIVEN.replace("RADIUS", "-40"),
    "hollow": GIVEN.replace("RADIUS", "60"),
    "flat": GIVEN.replace("RADIUS", "1e12"),
}


class Outputs:
    """The program's outputs by the name of their schema, and what is wrong with them."""

    def __init__(self, morion, home):
        self.morion, self.home = morion, home
        self.validators, self.outputs, self.wrong = {}, {}, {}
        for line in self.said("schema")[1]:
            name = json.loads(line)["name"]
            schema = json.loads("\n".join(self.said("schema", name)[1]))
            Draft202012Validator.check_schema(schema)
            self.validators[name] = Draft202012Validator(schema)
            self.outputs[name], self.wrong[name] = [], []

    def said(self, *arguments):
        """Exit code and lines of a command's JSON."""
        arguments = [str(argument) for argument in arguments]
        done = subprocess.run(
            [self.morion, *arguments, "--format", "json", "--quiet"],
            capture_output=True,
            text=True,
            cwd=self.home,
        )
        return done.returncode, done.stdout.splitlines()

    def add(self, name, where, text):
        value = json.loads(text)
        error = best_match(self.validators[name].iter_errors(value))
        if error:
            self.wrong[name].append(f"{where}: {error.json_path}: {error.message[:200]}")
        self.outputs[name].append(value)

    def run(self, name, *arguments, lines=False, files=()):
        """Runs a command, and takes what it prints, or the error that it ends with, and these files; its exit code."""
        code, printed = self.said(*arguments)
        where = " ".join(map(str, arguments))
        if code == 2:
            if not printed:
                self.wrong["error"].append(f"{where}: no error is printed")
            name, lines, files = "error", True, ()
        for text in printed if lines else ["\n".join(printed)]:
            self.add(name, where, text)
        for name, file in files:
            self.add(name, f"{where}: {file}", (self.home / file).read_text())
        return code

    def must(self, *arguments, **options):
        """Runs a command that has to work; its exit code."""
        code = self.run(*arguments, **options)
        if code == 2:
            error = self.outputs["error"][-1]["error"]["message"]
            self.wrong[arguments[0]].append(f"{' '.join(map(str, arguments[1:]))}: {error}")
        return code

    def fail(self, *arguments):
        """Runs a command that has to end with an error."""
        code = self.run("error", *arguments, lines=True)
        if code != 2:
            self.wrong["error"].append(f"{' '.join(map(str, arguments))}: exit code {code}, not 2")


def every_command(to, profile, name, run):
    """Every command on a profile; `run` is what is asked of those that not every mirror can do."""
    out = f"out/{name}"
    to.must("check", "check", profile)
    to.must("dry-run", "build", profile, "--dry-run")
    written = [("build", f"{out}/report.json"), ("timings", f"{out}/timings.json")]
    to.must("build", "build", profile, files=written)
    to.must("build", "build", profile, files=written)
    meshes = [mesh for mesh in sorted((to.home / out).glob("mirror.*")) if mesh.suffix != ".step"]
    for mesh in meshes:
        to.must("verify", "verify", mesh, "--profile", profile)
    run("verify", "verify", meshes[0], "--profile", profile, "--align", files=[("verify", f"{out}-verify/report.json")])
    run("render", "render", profile, "--scene", "grid")
    run("render", "render", profile, "--scene", "grid", "--smooth")
    run("frame", "frame", profile, files=[("frame", f"{out}/frame.json")])
    picture = to.home / out / "render-grid.png"
    for options in [["--map", "npy"], ["--cuts"]]:
        run("unwrap", "unwrap", picture, "--profile", profile, *options)
    for options in [["--pupil-mm", "1"], ["--na", "0.01"], []]:  # of each camera one
        to.run("blur", "blur", profile, *options, files=[("blur", f"{out}/blur.json")])
    for options in [[], ["--floor-mm", "-60"]]:
        run("table", "table", profile, *options, "--every", "8", files=[("table", f"{out}/table/table.json")])
    written = [("tolerance", f"{out}/tolerance.json"), ("tolerance-timings", f"{out}/tolerance-timings.json")]
    run("tolerance", "tolerance", profile, "--trials", "30", files=written)
    if run("part", "tolerance", profile, "--trials", "5", "--part") == 0:
        run("tolerance", "tolerance", "--merge", to.outputs["part"][-1]["part"])
    written = [("replay", f"{out}/replay-3/replay.json"), ("pose", f"{out}/replay-3/pose.json")]
    for without in ["waviness_um", "stepover_mm"]:  # some take too many facets, and not each is there
        to.run("replay", "tolerance", profile, "--replay", "3", "--without", without, files=written)
    for options in [[], ["--budget-px", "3", "--scallop-um", "5", "--no-as-cut"]]:
        tool = ["--ball-mm", "1", "--stepover-mm", "0.3"]
        run("machining", "machining", profile, *tool, *options, files=[("machining", f"{out}/machining.json")])
    run("program", "program", profile, files=[("program", f"{out}/program/program.json")])
    run("drawing", "drawing", profile, files=[("drawing", f"{out}/drawing.json")])
    run("inspect", "inspect", profile, files=[("inspect", f"{out}/inspection.json")])
    to.must("verify", "verify", f"{out}/inspection.csv", "--profile", profile, "--align", "--probe-mm", "0.01")
    # A ball that fits nowhere on a hollow mirror.
    run("machining", "machining", profile, "--ball-mm", "500", "--stepover-mm", "0.3", "--no-as-cut")


def strangers(to):
    """Files of other makers: a part with a hole in it, and one of no size that can be."""
    bytes_ = bytearray((to.home / "out/round/mirror.stl").read_bytes())
    facets = (len(bytes_) - 84) // 50 * 9 // 10
    bytes_[80:84] = facets.to_bytes(4, "little")
    (to.home / "scan.stl").write_bytes(bytes_[: 84 + 50 * facets])
    corners = ["0 0 1e200", "1e200 0 0", "0 1e200 0", "0 0 -1e200"]
    facets = ["1 2 3", "1 4 2", "2 4 3", "1 3 4"]
    lines = [f"v {corner}" for corner in corners] + [f"f {facet}" for facet in facets]
    (to.home / "huge.obj").write_text("\n".join(lines))
    (to.home / "text.stl").write_text("no mesh")
    to.must("verify", "verify", "scan.stl", "--profile", "round.toml")
    to.must("verify", "verify", "scan.stl", "--profile", "round.toml", "--align")
    to.must("verify", "verify", "huge.obj", "--profile", "round.toml")
    to.must("verify", "verify", "text.stl", "--profile", "round.toml")


def errors(to):
    """Errors of each kind: files, profiles, arguments, folders."""
    to.fail("build", "nothing.toml")
    to.fail("build", "conquistadr")
    to.fail("schema", "bild")
    to.fail("profiles", "--show", "nothing")
    to.fail("build")
    to.fail("build", "strip.toml", "--formats", "stl")
    to.fail("frame", "strip.toml", "--min", "2")
    to.fail("mesh", "strip.toml")
    to.fail("sweep", "strip.toml")
    (to.home / "file").write_text("no folder")
    to.fail("build", "strip.toml", "--out", "file")
    to.fail("build", "strip.toml", "--out", "/proc/none")
    to.fail("unwrap", "file", "--profile", "strip.toml")
    to.fail("verify", "file", "--profile", "strip.toml")
    to.fail("tolerance", "--merge", "file")
    for broken in sorted((ROOT / "tests/fixtures/broken").glob("*.toml")):
        to.fail("check", broken)
    to.fail("build", "strip.toml", "nothing.toml", ROOT / "tests/fixtures/broken/camera-typo.toml")


def all_outputs(to, folder):
    """Runs what there is to run."""
    for name, text in PROFILES.items():
        (to.home / f"{name}.toml").write_text(text)
    to.must("schema", "schema", lines=True)
    to.must("profiles", "profiles", lines=True)
    shipped = [profile["name"] for profile in to.outputs["profiles"]]
    for name in PROFILES:
        every_command(to, f"{name}.toml", name, to.must if name in ("strip", "valley", "milled") else to.run)
    (to.home / "study.toml").write_text(STUDY)
    to.must("sweep", "sweep", "study.toml", files=[("sweep", "out/sweep/study/sweep.json")])
    to.must("shard", "sweep", "study.toml", "--shard", "1/2")
    to.must("bench", "bench", "round.toml", "--quick", "--suggest", "3px")
    (to.home / "turned.toml").write_text(ROUND + '\n[program]\nmachine = "turn"\nfeed_mm_rev = 0.2\n')
    to.must("program", "program", "turned.toml", files=[("program", "out/turned/program/program.json")])
    turned = "out/turned/program/finishing.ngc"
    to.must("verify", "verify", turned, "--profile", "turned.toml", "--nose-mm", "0.8")
    (to.home / "servo.toml").write_text(ROUND + '\n[program]\nmachine = "sts"\ncontrol = "xzc"\nfeed_mm_rev = 0.2\n')
    to.must("program", "program", "servo.toml", files=[("program", "out/servo/program/program.json")])
    to.must("verify", "verify", "out/servo/program/finishing.xzc", "--profile", "servo.toml", "--nose-mm", "0.8")
    to.must("build", "build", "strip.toml", "round.toml", lines=True)
    to.must("dry-run", "build", "strip.toml", "round.toml", "--dry-run", lines=True)
    to.must("dry-run", "build", *shipped, "--dry-run", lines=True)
    for name in shipped:
        to.must("check", "check", name)
        if THOROUGH:
            every_command(to, name, name, to.run)
    strangers(to)
    errors(to)
    for name, file in [("build", "report.json"), ("timings", "timings.json")]:
        for path in sorted(folder.glob(f"*/{file}")) if folder else []:
            to.add(name, str(path), path.read_text())


def places(value, path=()):
    """The path of each value within `value`, outermost first."""
    yield path, value
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else []
    for key, below in inner:
        yield from places(below, (*path, key))


def changed(value, path, change):
    """A copy of `value` with the value at `path` changed."""
    value = {"": copy.deepcopy(value)}
    *above, last = ("", *path)
    holder = value
    for key in above:
        holder = holder[key]
    holder[last] = change(holder[last])
    return value[""]


def damaged(value, required):
    """Copies of an output with one damage each, and what that is."""
    all_places = [(path, found) for path, found in places(value)]
    objects = [path for path, found in all_places if isinstance(found, dict) and not OPEN & set(path[-1:])]
    numbers = [path for path, found in all_places if isinstance(found, (int, float)) and not isinstance(found, bool)]
    numbers = [path for path in numbers if not ANY & set(path[-2:-1])]
    kinds = [
        ("a key is added to", objects, lambda found: {**found, "surplus": 1}),
        ("nothing is left of", objects, lambda _: {}),
        ("a text replaces", numbers, str),
    ]
    for what, paths, change in kinds:
        for path in paths[:: 1 + len(paths) // SAMPLE]:
            yield f"{what} {path}", changed(value, path, change)
    for key in required:
        yield f"no {key}", {k: v for k, v in value.items() if k != key}


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    morion = shutil.which(sys.argv[1]) or sys.exit(f"no program {sys.argv[1]}")
    folder = pathlib.Path(sys.argv[2]) if len(sys.argv) == 3 else None
    with tempfile.TemporaryDirectory() as home:
        to = Outputs(str(pathlib.Path(morion).resolve()), pathlib.Path(home))
        all_outputs(to, folder)

    def complaints(name):
        outputs, wrong, refused = to.outputs[name], to.wrong[name], 0
        if not outputs:
            return "no output", [*wrong, "no command made one"]
        validator = to.validators[name]
        fullest = max(outputs, key=lambda output: len(json.dumps(output)))
        for what, value in damaged(fullest, validator.schema["required"]):
            refused += 1
            if validator.is_valid(value):
                wrong.append(f"{what}: not refused")
        return f"{len(outputs)} outputs, {refused} damaged ones refused", wrong[:5]

    code = told("schemas", to.outputs, complaints)
    print(f"schemas: {len(to.outputs)}, which {sum(map(len, to.outputs.values()))} outputs are held against")
    sys.exit(code)


if __name__ == "__main__":
    main()
