//! Studies: their grid, rows that are a build's own figures, equal bytes however they were made, and what they refuse.

use crate::support::builds::{SMALL, command, files, folder, morion, save, told};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;

/// A study of the small mirror; one of its widths is none.
const STUDY: &str = "\
profile = 'small.toml'
[[axis]]
key = 'part.width_mm'
values = [10, -1, 15]
[[axis]]
key = 'method.vector-field.degree'
from = 4
to = 8
count = 3
[[axis]]
key = 'part.base_mm'
values = [2.5, 3, 3.5]
paired_with = 'method.vector-field.degree'
[[column]]
key = 'design.pixel_error_px.rms'
goal = 'least'
[[column]]
key = 'form.sphere.pv_mm'
label = 'departure, mm'
goal = 'least'
[[column]]
key = 'design.method'
[[column]]
key = 'layout.size_mm[0]'
";

fn saved(study: &str) -> tempfile::TempDir {
    let folder = folder();
    save(folder.path(), SMALL);
    std::fs::write(folder.path().join("study.toml"), study).unwrap();
    folder
}

/// The files of the study, but for the journal.
fn made(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut made = files(&folder.join("out/sweep/study"));
    made.retain(|name, _| !name.starts_with("journal"));
    made
}

fn rows(folder: &Path) -> Vec<Value> {
    let text = String::from_utf8(made(folder)["rows.ndjson"].clone()).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[track_caller]
fn swept(folder: &Path, more: &[&str]) -> String {
    let (code, out, err) = told(&morion(folder, &[&["sweep", "study.toml"], more].concat()));
    assert_eq!(code, 0, "{err}");
    out
}

#[test]
fn rows_are_the_grid_and_their_figures_those_of_a_build() {
    let folder = saved(STUDY);
    let report: Value = serde_json::from_str(&swept(folder.path(), &["--format", "json"])).unwrap();
    assert_eq!(
        (&report["points"], &report["made"], &report["invalid"]),
        (&json!(9), &json!(6), &json!(3))
    );
    let rows = rows(folder.path());
    assert_eq!(rows.len(), 9);
    for (k, row) in rows.iter().enumerate() {
        let (width, step) = ([10.0, -1.0, 15.0][k / 3], k % 3);
        assert_eq!(row["part.width_mm"], json!(width as i64));
        assert_eq!(row["method.vector-field.degree"], json!([4, 6, 8][step]));
        assert_eq!(row["part.base_mm"].as_f64(), Some([2.5, 3.0, 3.5][step]));
        if width < 0.0 {
            assert_eq!((&row["status"], &row["design.method"]), (&json!("invalid"), &Value::Null));
            let error = row["error"].as_str().unwrap();
            assert!(error.contains("part.width_mm must be") && !error.contains('\n'), "{error}");
            continue;
        }
        // The same figures by another way: the profile edited by hand, and built.
        let profile = SMALL
            .replace("width_mm = 15", &format!("width_mm = {width}"))
            .replace("degree = 8", &format!("degree = {}", [4, 6, 8][step]))
            .replace("base_mm = 2", &format!("base_mm = {}", [2.5, 3.0, 3.5][step]));
        let hand = crate::support::builds::folder();
        save(hand.path(), &profile);
        let (code, out, err) =
            told(&morion(hand.path(), &["build", "small.toml", "--format", "json"]));
        assert!(code < 2, "{err}");
        let built: Value = serde_json::from_str(&out).unwrap();
        for (key, pointer) in [
            ("design.pixel_error_px.rms", "/design/pixel_error_px/rms"),
            ("form.sphere.pv_mm", "/form/sphere/pv_mm"),
            ("design.method", "/design/method"),
            ("layout.size_mm[0]", "/layout/size_mm/0"),
        ] {
            let figure = built.pointer(pointer).unwrap();
            assert!(!figure.is_null() && row[key] == *figure, "{k} {key}: {} {figure}", row[key]);
        }
        let (code, shown, err) =
            told(&morion(folder.path(), &["sweep", "study.toml", "--show", &k.to_string()]));
        assert_eq!(code, 0, "{err}");
        assert!(shown.contains(&format!("degree = {}", [4, 6, 8][step])), "{shown}");
    }
    // The front by its definition; what differs in the seventh digit is equal.
    let rounded = |x: f64| format!("{x:.5e}").parse::<f64>().unwrap();
    let figures = |row: &Value| {
        ["design.pixel_error_px.rms", "form.sphere.pv_mm"].map(|key| row[key].as_f64().map(rounded))
    };
    for row in &rows {
        let beats = |other: &Value| match (figures(other), figures(row)) {
            ([Some(a), Some(b)], [Some(c), Some(d)]) => a <= c && b <= d && (a < c || b < d),
            _ => false,
        };
        let expected = row["status"] == "made" && !rows.iter().any(beats);
        assert_eq!(row["front"], json!(expected), "{row}");
    }
}

#[test]
fn bytes_are_equal_on_any_number_of_threads_resumed_and_by_shards() {
    let whole = saved(STUDY);
    swept(whole.path(), &["--threads", "1"]);
    let expected = made(whole.path());
    assert_eq!(
        expected.keys().collect::<Vec<_>>(),
        ["rows.csv", "rows.ndjson", "sweep.html", "sweep.json"]
    );
    let threads = saved(STUDY);
    swept(threads.path(), &["--threads", "3"]);
    assert!(made(threads.path()) == expected);

    // As a killed run leaves it: some lines, the last of them cut off.
    let journal = "out/sweep/study/journal.ndjson";
    let text = std::fs::read_to_string(whole.path().join(journal)).unwrap();
    assert_eq!(text.lines().count(), 6);
    let resumed = saved(STUDY);
    std::fs::create_dir_all(resumed.path().join("out/sweep/study")).unwrap();
    let third = text.match_indices('\n').nth(2).unwrap().0;
    std::fs::write(resumed.path().join(journal), &text[..third + 40]).unwrap();
    let (code, _, err) = told(&morion(resumed.path(), &["sweep", "study.toml"]));
    assert!(code == 0 && err.contains("9 points, 3 of them known"), "{err}");
    assert!(made(resumed.path()) == expected);
    let now = std::fs::read_to_string(resumed.path().join(journal)).unwrap();
    assert_eq!(now.lines().count(), 6);
    assert!(now.lines().all(|line| serde_json::from_str::<Value>(line).is_ok()), "{now}");

    let shards = saved(STUDY);
    let counts = ["1/2", "2/2"].map(|shard| {
        let out = swept(shards.path(), &["--shard", shard, "--format", "json"]);
        serde_json::from_str::<Value>(&out).unwrap()["points"].as_u64().unwrap()
    });
    assert_eq!(counts, [5, 4]);
    assert!(made(shards.path()).is_empty());
    let (code, _, err) = told(&morion(shards.path(), &["sweep", "study.toml"]));
    assert!(code == 0 && err.contains("9 points, 6 of them known"), "{err}");
    assert!(made(shards.path()) == expected);
}

#[test]
fn other_axes_and_columns_take_what_is_known() {
    let folder = saved(STUDY);
    swept(folder.path(), &[]);
    let wider = STUDY.replace("values = [10, -1, 15]", "values = [12, 15]");
    std::fs::write(folder.path().join("study.toml"), &wider).unwrap();
    let (_, _, err) = told(&morion(folder.path(), &["sweep", "study.toml"]));
    assert!(err.contains("6 points, 3 of them known"), "{err}");
    let fewer = wider.replace("key = 'design.method'", "key = 'form.plane.pv_mm'");
    std::fs::write(folder.path().join("study.toml"), &fewer).unwrap();
    let (_, _, err) = told(&morion(folder.path(), &["sweep", "study.toml"]));
    assert!(err.contains("6 points, 0 of them known"), "{err}");
    // Either set of columns is known now.
    std::fs::write(folder.path().join("study.toml"), &wider).unwrap();
    let (_, _, err) = told(&morion(folder.path(), &["sweep", "study.toml"]));
    assert!(err.contains("6 points, 6 of them known"), "{err}");
    // Another profile is another point.
    save(folder.path(), &SMALL.replace("degree = 8", "degree = 8\nminimax = true"));
    let (_, _, err) = told(&morion(folder.path(), &["sweep", "study.toml"]));
    assert!(err.contains("6 points, 0 of them known"), "{err}");
}

#[test]
fn commands_have_the_keys_of_their_reports() {
    for (name, key, least) in [
        ("dry-run", "mesh.triangles", 100.0),
        ("frame", "frame.filled", 0.1),
        ("build", "trace[0].pixel_error_px.max", 0.001),
    ] {
        let study = format!(
            "profile = 'small.toml'\ncommand = '{name}'\n[[axis]]\nkey = 'part.base_mm'\nvalues = [3]\n\
             [[column]]\nkey = '{key}'\n"
        );
        let folder = saved(&study);
        swept(folder.path(), &[]);
        let row = &rows(folder.path())[0];
        assert!(row[key].as_f64().is_some_and(|figure| figure > least), "{name}: {row}");
    }
}

#[test]
fn a_study_without_any_answer_is_a_negative_one_and_says_why() {
    let study = STUDY.replace("[10, -1, 15]", "[-1, -2]");
    let folder = saved(&study);
    let (code, out, err) = told(&morion(folder.path(), &["sweep", "study.toml"]));
    assert_eq!(code, 1, "{err}");
    assert!(out.contains("0 of 6 have figures") && out.contains("6 invalid like point 0"), "{out}");
}

#[test]
fn faults_of_a_study_are_told_at_once_with_their_places() {
    let folder = saved(
        "profile = 'smal.toml'
command = 'desgin'
colour = 3
[[axis]]
key = 'part.widht_mm'
values = [1, 'two']
[[axis]]
key = 'part.base_mm'
from = 0
to = nan
count = 1e9
scale = 'log'
[[axis]]
key = \"part.'base_mm'\"
values = []
paired_with = 'part.x'
[[column]]
key = 'design.pixel_error_px'
goal = 'lest'
[[column]]
label = 3
",
    );
    let (code, out, err) =
        told(&morion(folder.path(), &["sweep", "study.toml", "--format", "json"]));
    assert_eq!(code, 2);
    for (place, words) in [
        ("1:11", "profile must be"),
        ("2:11", "did you mean \"design\"?"),
        ("3:1", "found colour"),
        ("5:7", "did you mean part.width_mm?"),
        ("6:14", "of one kind, found numbers and texts"),
        ("9:8", "a logarithmic axis has no 0"),
        ("10:6", "found nan"),
        ("11:9", "a whole number from 2 to 1000000"),
        ("14:7", "write the table and the key"),
        ("15:10", "at least one, found the list []"),
        ("16:15", "the key of an earlier axis"),
        ("18:7", "it is a group; name one of its keys, as design.pixel_error_px."),
        ("19:8", "did you mean \"least\"?"),
        ("20:1", "column.key must be"),
        ("21:9", "column.label must be"),
    ] {
        let paragraph =
            err.split("\n\n").find(|text| text.contains(&format!("study.toml:{place}: ")));
        let paragraph = paragraph.unwrap_or_else(|| panic!("{place}: {err}"));
        assert!(paragraph.contains(words), "{place} {words}: {paragraph}");
    }
    assert_eq!(out.lines().count(), err.split("\n\n").count(), "{out}");
    assert!(!folder.path().join("out").exists());
}

#[test]
fn absurd_studies_are_refused_before_any_work() {
    let column = "[[column]]\nkey = 'design.degree'\n";
    let axis = |key: &str, count: &str| {
        format!("[[axis]]\nkey = '{key}'\nfrom = 1\nto = 2\ncount = {count}\n")
    };
    let keys = ["part.width_mm", "part.base_mm", "mesh.chord_um", "accept.frame_filled"];
    let huge: String = keys.iter().map(|key| axis(key, "1000000")).collect();
    for (study, words) in [
        (axis(keys[0], "1000000000"), "a whole number from 2 to 1000000, found 1000000000"),
        (
            axis(keys[0], "1001") + &axis(keys[1], "1000"),
            "found 1001 times the 1000 of part.base_mm",
        ),
        (huge, "2000000 values together"),
        (axis(keys[0], "3") + &axis(keys[0], "3"), "part.width_mm again"),
        (axis("design.degree", "3"), "did you mean method.vector-field.degree?"),
        (axis("hole[0].depth_mm", "3"), "there is no hole[0]"),
        (axis("projection.cylindrical.elevation_deg[2]", "3"), "has no entry 2"),
        (String::new(), "axis must be a list of tables, found nothing"),
    ] {
        let folder = saved(&format!("profile = 'small.toml'\n{study}{column}"));
        let (code, _, err) = told(&morion(folder.path(), &["sweep", "study.toml"]));
        assert!(code == 2 && err.contains(words), "{words}: {err}");
        assert!(!folder.path().join("out").exists());
    }
    for (arguments, words) in [
        (&["sweep", "study.toml", "--show", "9"][..], "a point from 0 to 8, found 9"),
        (&["sweep", "none.toml"], "cannot read none.toml"),
        (&["sweep", "study.toml", "--shard", "3/2"], "as in 1/8"),
    ] {
        let folder = saved(STUDY);
        let (code, _, err) = told(&morion(folder.path(), arguments));
        assert!(code == 2 && err.contains(words), "{words}: {err}");
    }
    // A profile that is not valid itself is told as such.
    let folder = saved(STUDY);
    save(folder.path(), &SMALL.replace("width_mm = 15", "width_mm = 0"));
    let (code, _, err) = told(&morion(folder.path(), &["sweep", "study.toml"]));
    assert!(
        code == 2 && err.contains("small.toml:") && err.contains("part.width_mm must be"),
        "{err}"
    );
}

/// Every study on a page, and the one among the examples, has its axes and columns.
#[test]
fn studies_on_pages_are_valid() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut studies =
        vec![std::fs::read_to_string(root.join("examples/trade-study.toml")).unwrap()];
    for page in ["docs/commands.md", "docs/recipes.md"] {
        let page = std::fs::read_to_string(root.join(page)).unwrap();
        let blocks = page.split("```toml\n").skip(1).filter_map(|rest| rest.split_once("```"));
        studies.extend(
            blocks.map(|block| block.0.to_owned()).filter(|block| block.contains("[[axis]]")),
        );
    }
    assert_eq!(studies.len(), 3);
    for study in studies {
        let folder = saved(&study);
        let (code, shown, err) =
            told(&morion(folder.path(), &["sweep", "study.toml", "--show", "0"]));
        assert!(code == 0 && shown.contains("width_mm = "), "{err}");
    }
}

/// Texts with commas, quotes, ends of lines and formulas, through the CSV.
#[test]
fn hostile_texts_stay_in_their_fields() {
    let folder = saved(
        "profile = 'small.toml'\n[[axis]]\nkey = 'summary'\nvalues = ['=1+1', 'a,\"b\"', \"two\\nlines\", '-x']\n\
         [[column]]\nkey = 'design.degree'\n",
    );
    swept(folder.path(), &[]);
    let csv = String::from_utf8(made(folder.path())["rows.csv"].clone()).unwrap();
    let expected = "point,summary,status,front,design.degree,error\n\
        0,'=1+1,made,false,8,\n1,\"a,\"\"b\"\"\",made,false,8,\n2,\"two\nlines\",made,false,8,\n3,'-x,made,false,8,\n";
    assert_eq!(csv, expected);
    assert_eq!(rows(folder.path())[2]["summary"], "two\nlines");
}

/// Runs a study of many points until so many are kept, ends it by a signal, and takes what it says.
#[cfg(unix)]
fn ended_by(signal: &str, folder: &Path) -> (Option<i32>, String) {
    let journal = folder.join("out/sweep/study/journal.ndjson");
    let lines = || std::fs::read_to_string(&journal).map_or(0, |text| text.lines().count());
    let before = lines();
    let mut running = command(folder);
    let mut running = running
        .args(["sweep", "study.toml", "--quiet"])
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    while lines() < before + 5 && running.try_wait().unwrap().is_none() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let sent =
        std::process::Command::new("kill").args([signal, &running.id().to_string()]).status();
    assert!(sent.unwrap().success());
    let ended = running.wait_with_output().unwrap();
    (ended.status.code(), String::from_utf8(ended.stderr).unwrap())
}

#[cfg(unix)]
#[test]
fn a_sweep_that_is_ended_goes_on_with_what_it_had() {
    let study = STUDY.replace("values = [10, -1, 15]", "from = 10\nto = 20\ncount = 2000");
    let folder = saved(&study);
    let (code, err) = ended_by("-TERM", folder.path());
    assert_eq!(code, Some(143), "{err}");
    assert!(err.starts_with("interrupted: ") && err.contains("goes on from there"), "{err}");
    let (code, _) = ended_by("-KILL", folder.path());
    assert_eq!(code, None);
    assert!(made(folder.path()).is_empty());
    let few = STUDY.replace("values = [10, -1, 15]", "values = [10]");
    std::fs::write(folder.path().join("study.toml"), few).unwrap();
    let (code, _, err) = told(&morion(folder.path(), &["sweep", "study.toml"]));
    assert!(code == 0 && err.contains("3 points, 3 of them known"), "{err}");
}
