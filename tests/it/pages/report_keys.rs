//! The tables of keys in the pages about reports, against what the commands write.

use crate::support::builds::{SMALL, edited, folder, morion, told};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

pub(super) const REPORT: &str = include_str!("../../../docs/report.md");
pub(super) const STUDIES: &str = include_str!("../../../docs/report-studies.md");
pub(super) const TOLERANCE: &str = include_str!("../../../docs/report-tolerance.md");

/// The round mirror under a pinhole.
const ROUND: &str = "\
camera.pinhole = { pixels = [120, 120], lens_mm = 8, pixel_um = 40, f_number = 11, distance_mm = 40 }
projection.hyperbolic.outer_polar_deg = 110
layout.disc = {}
method.vector-field.degree = 16
part = { width_mm = 20, base_mm = 2 }
mesh.facet_px = 3
export.formats = [\"stl\"]
";
/// Programs of a mill with a flat cutter.
const ROUGHED: &str = "program.rough_radius_mm = 2\n";
/// Programs of a lathe.
const LATHE: &str = "program = { machine = \"turn\", nose_mm = 1, feed_mm_rev = 0.2 }\n";

/// Programs of a slow tool servo.
const SERVO: &str = "program = { machine = \"sts\", nose_mm = 1, feed_mm_rev = 0.2 }\n";

/// A program that faces a bar to a plane.
const FACING: &str = "G8 G95 G97 S500 M3\nG0 X14 Z9\nG1 X-1 F0.2\nG4 P1\nG0 Z20\nM2\n";

/// A program that mills to a plane below a mirror.
const FLAT: &str = "G0 Z20\nG0 X-7 Y-3\nG1 Z1 F100\nX7\nY3\nX-7\nG0 Z20\nM2\n";

/// A mirror that is given, without a projection.
const GIVEN: &str = "\
camera.orthographic.pixels = [160, 120]
mirror.polynomial = { radius_mm = -40, conic = 0 }
part = { width_mm = 15, height_mm = 11, base_mm = 2 }
mesh.chord_um = 5
export.formats = [\"stl\"]
";

/// A view from beside the part.
const OBLIQUE: &str = "\
camera.pinhole = { pixels = [160, 120], hfov_deg = 20, distance_mm = 60 }
mount = { fold_deg = 40, towards_deg = 90 }
projection.perspective.hfov_deg = 30
layout.rectangle = {}
method.vector-field.degree = 8
part = { width_mm = 24, base_mm = 2 }
mesh.facet_px = 3
export.formats = [\"stl\"]
";

/// A picture given as data: lines of row, column, X, Y and Z.
const MAP: &str = "\
camera.orthographic.pixels = [160, 120]
projection.map.file = \"wanted.csv\"
layout.rectangle = {}
method.vector-field.degree = 8
part = { width_mm = 20, base_mm = 2 }
mesh.facet_px = 3
export.formats = [\"stl\"]
";

/// Two views in the frame of a lens that bends lines.
const PANELS: &str = "\
camera.calibrated = { pixels = [120, 80], focal_px = [200, 200], principal_px = [59.5, 39.5], distortion = [-0.3, 0.1, 0, 0], \
distance_mm = 60 }
layout.rectangle = {}
method.vector-field.degree = 8
part = { width_mm = 38, base_mm = 2 }
mesh.facet_px = 3
export.formats = [\"stl\"]
[[panel]]
columns = [0, 60]
rows = [0, 80]
centre_deg = [0, 40]
hfov_deg = 40
[[panel]]
columns = [60, 120]
rows = [0, 80]
centre_deg = [180, 40]
hfov_deg = 40
";

/// A flat rim with rounded corners, a hole and a mark, and a cavity with a drain.
const RIM: &str = "\
base_mm = 8
rim_mm = 2
shell_mm = 1
drains_mm = [[0, 1, 2]]
border_mm = 6
corner_radius_mm = 2
edge_chamfer_mm = 0.4
holes_mm = [[10.5, 8.5, 2]]
marks_mm = [[-10.5, 8.5, 1]]";
/// A mould of what is cast.
const FORMED: &str = "base_mm = 2\nborder_mm = 3\nform = \"mould\"";
/// A blind hole from the base.
const BLIND: &str = "[[hole]]\nat_mm = [[0, 2]]\ndiameter_mm = 1\ndepth_mm = 0.5\n";

/// A leg beside the round mirror.
const LEG: &str = "\
[[obstacle]]
cylinder = { from_mm = [0, 16, -30], to_mm = [0, 16, 4], radius_mm = 1.5 }
";

/// A body in a file, where nobody looks.
const ASIDE: &str = "[[obstacle]]\nstl.file = \"aside.stl\"\n";
const BODY: &str = "solid aside
facet normal 0 0 1
outer loop
vertex 900 900 -90
vertex 901 900 -90
vertex 900 901 -90
endloop
endfacet
endsolid aside
";

/// A study with a pair of axes, a point that fails, and a column that no point has.
const STUDY: &str = "\
profile = 'all.toml'
axis = [{ key = 'part.width_mm', values = [15, -1] }, { key = 'part.base_mm', values = [2, 3], paired_with = 'part.width_mm', goal = 'least' }]
column = [{ key = 'design.pixel_error_px.rms', goal = 'least' }, { key = 'design.dividing_lines.departure_px' }]
";

/// Runs in a folder of their own, and the JSON values that they made.
struct Runs(tempfile::TempDir);

impl Runs {
    fn new() -> Self {
        let runs = Self(folder());
        let formats = (
            "[\"stl\", \"obj\"]",
            "[\"stl\", \"obj\", \"3mf\", \"glb\", \"step\", \"csv\"]\nstep.schema = \"ap242\"",
        );
        let budget = ("chord_um = 20\nfacet_px = 3", "max_triangles = 20000");
        let lens = ("pixels = [160, 120]", "pixels = [160, 120]\nna = 0.01");
        let valley = ("ridge = \"crest\"", "ridge = \"valley\"");
        // No limits of errors keep a budget that the design itself exceeds.
        let unmet = "\n[tolerance]\nbudget_px = 0.01\nreference = \"projection\"\n";
        for (name, text) in [
            ("all", edited(SMALL, &[formats]) + ASIDE),
            ("budget", edited(SMALL, &[lens, budget, ("\"stl\", \"obj\"", "\"obj\", \"csv\"")])),
            ("valley", edited(SMALL, &[valley]) + unmet + BLIND + ASIDE),
            ("given", GIVEN.into()),
            ("round", format!("{ROUND}{ASIDE}")),
            ("turned", format!("{ROUND}{LATHE}")),
            ("servo", format!("{ROUND}{SERVO}")),
            ("obstructed", format!("{ROUND}{ROUGHED}{LEG}")),
            ("oblique", OBLIQUE.into()),
            ("map", MAP.into()),
            ("panels", PANELS.into()),
            ("formed", edited(SMALL, &[("base_mm = 2", FORMED)])),
            (
                "rimmed",
                edited(SMALL, &[("base_mm = 2", RIM), ("\"stl\", \"obj\"", "\"pdf\"")]) + ASIDE,
            ),
        ] {
            std::fs::write(runs.path(&format!("{name}.toml")), text).unwrap();
        }
        std::fs::write(runs.path("study.toml"), STUDY).unwrap();
        std::fs::write(runs.path("aside.stl"), BODY).unwrap();
        let direction = |k: u32| {
            let (row, column) = (k / 16, k % 16);
            let [x, y] = [f64::from(column) - 7.5, 5.5 - f64::from(row)].map(|x| x / 16.0);
            let length = (x * x + y * y + 1.0).sqrt();
            format!("{row},{column},{},{},{}\n", x / length, y / length, 1.0 / length)
        };
        let lines: String = (0..192).map(direction).collect();
        std::fs::write(runs.path("wanted.csv"), lines).unwrap();
        runs
    }

    fn path(&self, name: &str) -> std::path::PathBuf {
        self.0.path().join(name)
    }

    /// The JSON that a command prints.
    #[track_caller]
    fn printed(&self, command: &str) -> Value {
        let mut arguments: Vec<&str> = command.split(' ').collect();
        arguments.extend(["--format", "json", "--quiet"]);
        let (code, out, err) = told(&morion(self.0.path(), &arguments));
        assert!(code < 2, "{command}: {err}");
        serde_json::from_str(&out).unwrap_or_else(|error| panic!("{command}: {error}\n{out}"))
    }

    #[track_caller]
    fn file(&self, name: &str) -> Value {
        serde_json::from_slice(&std::fs::read(self.path(name)).unwrap()).unwrap()
    }

    /// Leaves out the last tenth of an STL's facets.
    fn open(&self, stl: &str, scan: &Path) {
        let mut bytes = std::fs::read(self.path(stl)).unwrap();
        let facets = (bytes.len() - 84) / 50 * 9 / 10;
        bytes.truncate(84 + 50 * facets);
        bytes[80..84].copy_from_slice(&(facets as u32).to_le_bytes());
        std::fs::write(scan, bytes).unwrap();
    }
}

/// The keys of the tables below `heading` of a page. Brackets at the end tell of arrays.
pub(super) fn documented(page: &str, heading: &str) -> BTreeSet<String> {
    let (_, after) = page.split_once(heading).unwrap_or_else(|| panic!("no {heading:?}"));
    let section = after.find("\n#").map_or(after, |end| &after[..end]);
    let rows = section.lines().filter_map(|line| line.strip_prefix("| `")?.split_once('`'));
    rows.map(|(key, _)| key.trim_end_matches("[]").to_owned()).collect()
}

/// Adds the keys of the leaves of a value, and whether all of a key were null or empty.
fn collect(value: &Value, path: &str, keys: &mut BTreeMap<String, bool>) {
    match value {
        Value::Object(object) if !object.is_empty() => {
            for (key, value) in object {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                collect(value, &path, keys);
            }
        }
        Value::Array(array) if !array.is_empty() => {
            array.iter().for_each(|value| collect(value, &format!("{path}[]"), keys));
        }
        leaf => {
            let empty = matches!(leaf, Value::Null | Value::Object(_) | Value::Array(_));
            *keys.entry(path.trim_end_matches("[]").to_owned()).or_insert(true) &= empty;
        }
    }
}

/// Asserts that the tables below these headings have each key of `values`, and no other.
#[track_caller]
fn hold(page: &str, headings: &[&str], values: &[Value]) {
    let told: BTreeSet<String> =
        headings.iter().flat_map(|heading| documented(page, heading)).collect();
    let mut made = BTreeMap::new();
    values.iter().for_each(|value| collect(value, "", &mut made));
    let above = |key: &str| {
        told.iter().any(|k| k.starts_with(key) && k[key.len()..].starts_with(['.', '[']))
    };
    let missing =
        made.iter().filter(|(key, empty)| !(told.contains(*key) || **empty && above(key)));
    let missing: Vec<&String> = missing.map(|(key, _)| key).collect();
    assert!(missing.is_empty(), "{headings:?} have no row for {missing:?}");
    let idle: Vec<&String> = told.iter().filter(|key| !made.contains_key(*key)).collect();
    assert!(idle.is_empty(), "{headings:?} have rows for {idle:?}, which no run wrote");
}

/// A program that cuts a plane over the small mirror.
fn plane() -> String {
    let line = |y: i32| format!("G0 X-10 Y{y}\nG1 Z12 F500\nX10\nG0 Z30\n");
    std::iter::once("G0 Z30\n".to_owned()).chain((-8..=8).map(line)).collect()
}

#[test]
#[ignore = "long: .ci/nightly"]
fn the_page_of_reports_has_every_key() {
    let runs = Runs::new();
    let names = [
        "all",
        "budget",
        "valley",
        "given",
        "round",
        "obstructed",
        "oblique",
        "map",
        "panels",
        "formed",
        "rimmed",
    ];
    let mut reports: Vec<Value> =
        names.map(|name| runs.printed(&format!("build {name}.toml"))).into();
    runs.open("out/round/mirror.stl", &runs.path("scan.stl"));
    reports.push(runs.printed("verify scan.stl --profile round.toml --align"));
    reports.push(runs.printed("verify out/all/mirror.obj --profile all.toml"));
    runs.printed("inspect all.toml");
    let points = "verify out/all/inspection.csv --profile all.toml --align --probe-mm 0.001";
    reports.push(runs.printed(points));
    std::fs::write(runs.path("plane.nc"), plane()).unwrap();
    reports.push(runs.printed("verify plane.nc --profile all.toml --ball-mm 4"));
    std::fs::write(runs.path("facing.nc"), FACING).unwrap();
    reports.push(runs.printed("verify facing.nc --profile round.toml --nose-mm 1"));
    std::fs::write(runs.path("flat.ngc"), FLAT).unwrap();
    reports.push(runs.printed("verify flat.ngc --profile given.toml --cutter-mm 12 --corner-mm 1"));
    let headings = ["## `report.json` of a build", "## `report.json` of a verified file"];
    hold(REPORT, &headings, &reports);
    hold(REPORT, &["## `timings.json`"], &[runs.file("out/all/timings.json")]);
    let plans = ["all", "budget"].map(|name| runs.printed(&format!("build {name}.toml --dry-run")));
    hold(REPORT, &["### `morion build --dry-run`"], &plans);
    let render = runs.printed("render round.toml --scene grid");
    hold(REPORT, &["### `morion render`"], &[render]);
    std::fs::write(runs.path("pose.json"), r#"{"profile": {"sha256": "another"}}"#).unwrap();
    let photo = "unwrap out/round/render-grid.png --profile round.toml --map";
    std::fs::create_dir(runs.path("photos")).unwrap();
    std::fs::copy(runs.path("out/round/render-grid.png"), runs.path("photos/a.png")).unwrap();
    let unwrapped = [
        runs.printed(&format!("{photo} npy")),
        runs.printed(&format!("{photo} exr")),
        runs.printed("unwrap out/all/preview.png --profile all.toml --cuts"),
        runs.printed(&format!("{photo} npy --view 0,30,60 --pose pose.json")),
        runs.printed(&format!("{photo} npy --ground 100")),
        runs.printed("unwrap photos --profile round.toml"),
    ];
    hold(REPORT, &["### `morion unwrap`"], &unwrapped);
}

#[test]
#[ignore = "long: .ci/nightly"]
fn the_page_of_studies_has_every_key() {
    let runs = Runs::new();
    let frames =
        ["all", "round", "obstructed"].map(|name| runs.printed(&format!("frame {name}.toml")));
    hold(STUDIES, &["## `frame.json`"], &frames);
    let blur =
        ["blur all.toml --na 0.01", "blur round.toml --pupil-mm 1"].map(|it| runs.printed(it));
    hold(STUDIES, &["## `blur.json`"], &blur);
    std::fs::write(runs.path("pose.json"), r#"{"profile": {"sha256": "another"}}"#).unwrap();
    let tables = ["table all.toml", "table round.toml --floor-mm 100 --pose pose.json"];
    hold(STUDIES, &["## `table.json`"], &tables.map(|command| runs.printed(command)));
    let cut = [
        "machining all.toml --ball-mm 1 --stepover-mm 0.3",
        "machining obstructed.toml --ball-mm 1 --stepover-mm 0.3",
        "machining valley.toml --ball-mm 1 --stepover-mm 0.3 --budget-px 3 --scallop-um 5 --no-as-cut",
    ];
    hold(STUDIES, &["## `machining.json`"], &cut.map(|command| runs.printed(command)));
    let programs = ["all", "obstructed", "turned", "servo"].map(|it| format!("program {it}.toml"));
    hold(STUDIES, &["## `program.json`"], &programs.map(|it| runs.printed(&it)));
    hold(STUDIES, &["## `drawing.json`"], &[runs.printed("drawing rimmed.toml")]);
    hold(STUDIES, &["## `inspection.json`"], &[runs.printed("inspect all.toml")]);
    hold(STUDIES, &["## `sweep.json`"], &[runs.printed("sweep study.toml")]);
    let bench = runs.printed("bench round.toml --quick --suggest 3px");
    hold(STUDIES, &["## `bench.json`"], &[bench]);
}

#[test]
fn the_page_of_tolerances_has_every_key() {
    let runs = Runs::new();
    let study = runs.printed("tolerance valley.toml --trials 30");
    hold(TOLERANCE, &["## `tolerance.json`"], &[study]);
    let timings = runs.file("out/valley/tolerance-timings.json");
    hold(TOLERANCE, &["## `tolerance-timings.json`"], &[timings]);
    let replay = runs.printed("tolerance all.toml --replay 3 --without stepover_mm");
    hold(TOLERANCE, &["## `replay.json`"], &[replay]);
    hold(TOLERANCE, &["## `pose.json`"], &[runs.file("out/all/replay-3/pose.json")]);
}
