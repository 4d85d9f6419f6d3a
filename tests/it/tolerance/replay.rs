//! Replayed trials: the same figures, and files that have the surface and show them.

use super::program::refused;
use crate::support::builds::{SMALL, edited, files, folder, morion, save, told};
use morion::internals::export::read_stl;
use morion::internals::geom::{DVec2, DVec3};
use morion::internals::solid::check;
use serde_json::Value;
use std::path::Path;

/// The small profile under a camera of few pixels, with errors of every kind, which a mesh can
/// follow.
fn rough() -> String {
    let limits = "facet_px = 0.2\n\n[tolerance]\nball_radius_mm = 10\nwaviness_period_mm = 4\n\
                  slope_correlation_mm = 3\n[tolerance.limits]\nstepover_mm = 1.8\n\
                  waviness_um = 60\nslope_mrad = 60\nscale_ppm = 900\n\n[export]";
    let text = edited(SMALL, &[("[160, 120]", "[24, 18]"), ("facet_px = 3\n\n[export]", limits)]);
    edited(&text, &[("chord_um = 20\n", "")])
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

/// Replays a trial, which must end with `expected`.
fn replay(home: &Path, trial: u64, more: &[&str], expected: i32) -> (Value, Value) {
    let number = trial.to_string();
    let mut all = vec!["tolerance", "small.toml", "--replay", &number, "--seed", "7"];
    all.extend(more);
    let (code, out, err) = told(&morion(home, &all));
    assert_eq!(code, expected, "{out}{err}");
    let folder = home.join("out/small").join(format!("replay-{trial}"));
    (json(&folder.join("replay.json")), json(&folder.join("pose.json")))
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// RMS and P95, as made and adjusted.
fn figures(judged: &Value) -> [f64; 4] {
    let of = |what: &str, key: &str| number(&judged[what][key]);
    [
        of("as_made", "rms_px"),
        of("as_made", "p95_px"),
        of("adjusted", "rms_px"),
        of("adjusted", "p95_px"),
    ]
}

#[test]
#[ignore = "long: .ci/nightly"]
fn a_replayed_trial_has_the_figures_of_the_run_and_its_files_show_them() {
    let folder = folder();
    let home = folder.path();
    save(home, &rough());
    let arguments = ["tolerance", "small.toml", "--trials", "9", "--seed", "7", "-q"];
    assert_ne!(told(&morion(home, &arguments)).0, 2);
    let table = std::fs::read_to_string(home.join("out/small/trials.csv")).unwrap();
    let rows: Vec<Vec<f64>> = table
        .lines()
        .filter(|line| line.starts_with(|c: char| c.is_ascii_digit()))
        .map(|line| line.split(',').map(|word| word.parse().unwrap()).collect())
        .collect();
    for trial in [0, 4, 8] {
        let (report, pose) = replay(home, trial, &[], 0);
        let row = &rows[trial as usize];
        for (again, run) in figures(&report["repeated"]).iter().zip(&row[1..5]) {
            assert!((again - run).abs() <= 1e-9, "{trial}: {again} {run}");
        }
        let draws = &row[row.len() - report["errors"].as_array().unwrap().len()..];
        for (error, drawn) in report["errors"].as_array().unwrap().iter().zip(draws) {
            // The reader of JSON may be off by the last digit.
            let off = number(&error["value"]) - drawn;
            assert!(off.abs() <= 1e-15 * drawn.abs(), "{error} {drawn}");
        }
        assert_eq!(report["without"], serde_json::json!(["facets_px"]));
        let smooth = figures(&report["smooth"]);
        let made = report["files"].as_array().unwrap();
        assert_eq!(made.len(), 2);
        for file in made {
            let name = file["name"].as_str().unwrap();
            let [rms, max] = ["rms", "max"].map(|key| number(&file["facet_error_px"][key]));
            let count = |key: &str| file[key].as_u64().unwrap();
            assert_eq!((count("hit") + count("beyond"), count("lost")), (count("rays"), 0));
            // The rest is where rough errors lead rays over the rim.
            assert!(count("hit") > 300, "{name}");
            for (shown, smooth) in figures(&file["displacement"]).iter().zip(smooth).step_by(2) {
                assert!((shown - smooth).abs() <= rms, "{name}: {shown} {smooth} +- {rms}");
            }
            // Less than what there is to be seen, so that a wrong surface would show.
            assert!(rms < 0.3 * smooth[2] && max < 3.0 * smooth[2], "{name}: {rms} {max}");
        }
        let bytes = std::fs::read(home.join(format!("out/small/replay-{trial}/mirror.stl")));
        let mesh = read_stl(&bytes.unwrap()).unwrap().mesh;
        assert!(check(&mesh).is_solid(), "{:?}", check(&mesh).reasons());

        // The pose is complete, and its motion is what its angles say.
        let count = |table: &str| pose[table].as_object().unwrap().len();
        assert_eq!([count("part"), count("camera"), count("in_the_files")], [6, 6, 2]);
        let error = |table: &str, key: &str| {
            let drawn = report["errors"].as_array().unwrap().iter();
            // An error without a limit is not drawn: there is none of it.
            let drawn = drawn.clone().find(|e| e["source"] == key).map(|e| number(&e["value"]));
            assert!(drawn.is_some() || key == "coma_ppm", "{key}");
            assert_eq!(number(&pose[table][key]), drawn.unwrap_or(0.0));
            drawn.unwrap_or(0.0)
        };
        for key in pose["camera"].as_object().unwrap().keys() {
            error("camera", key);
        }
        let turn = |i: usize, j: usize| number(&pose["world_from_file"]["turn"][i][j]);
        let [x, y, z] =
            ["tilt_x_mrad", "tilt_y_mrad", "clocking_mrad"].map(|key| 1e-3 * error("part", key));
        for (found, angle) in [(turn(2, 1), x), (turn(0, 2), y), (turn(1, 0), z)] {
            assert!((found - angle).abs() < 3e-6, "{found} {angle}");
        }
        for (k, key) in ["decentre_x_um", "decentre_y_um", "despace_um"].iter().enumerate() {
            let shift = number(&pose["world_from_file"]["shift_mm"][k]);
            assert!((shift - 1e-3 * error("part", key)).abs() < 1e-15);
        }
        let ppm =
            error("in_the_files", "scale_ppm") + 23.0 * error("in_the_files", "temperature_k");
        assert!((number(&pose["growth"]) - 1.0 - 1e-6 * ppm).abs() < 1e-14);
    }
    // Byte for byte, on any threads.
    let once = files(&home.join("out/small/replay-4"));
    replay(home, 4, &["--threads", "1"], 0);
    assert!(files(&home.join("out/small/replay-4")) == once);
}

#[test]
fn the_files_have_the_form_and_the_size_that_formulas_say() {
    let folder = folder();
    let home = folder.path();
    let none: Vec<String> = morion::internals::tolerance::Perturbation::all()
        .map(|kind| kind.key())
        .filter(|key| !key.starts_with("zernike") && !["map_share", "scale_ppm"].contains(key))
        .filter(|key| *key != "legendre_20_um" && *key != "waviness_um")
        .map(|key| format!("{key} = 0\n"))
        .collect();
    let text = rough();
    let at = text.find("[tolerance.limits]").unwrap();
    let end = text[at..].find("[export]").unwrap() + at;
    let limits = format!(
        "[tolerance.limits]\nlegendre_20_um = 80\nscale_ppm = 4000\nwaviness_um = 9\n{}\
         [tolerance.distributions]\nlegendre_20_um = \"fixed\"\nscale_ppm = \"fixed\"\n\n",
        none.concat()
    );
    save(home, &format!("{}{limits}{}", &text[..at], &text[end..]));
    let (report, _) = replay(home, 3, &[], 0);
    assert_eq!(report["errors"].as_array().unwrap().len(), 3);
    let bytes = std::fs::read(home.join("out/small/replay-3/mirror.stl")).unwrap();
    let mesh = read_stl(&bytes).unwrap().mesh;
    let profile =
        morion::internals::pipeline::load(home.join("small.toml").to_str().unwrap()).unwrap();
    let design = crate::support::designed(&profile);
    let optical = report["files"][0]["optical_triangles"].as_u64().unwrap() as usize;
    let half = 7.5;
    // A wave of period 4 mm along Y and an unknown phase: its quadrature sums at equal weights.
    let (mut with_cos, mut with_sin) = (0.0, 0.0);
    let mut rest: Vec<(f64, f64)> = Vec::new();
    for &v in mesh.triangles[..optical].iter().flatten() {
        let at: DVec3 = mesh.vertices[v as usize] / 1.004;
        let u = at.x / half;
        let form = 0.08 * (1.5 * u * u - 0.5) / 1.5;
        let q = DVec2::new(at.x, at.y);
        let designed = design.mirror.position(q, &design.mirror.row(q.y).at(q.x)).z;
        rest.push((at.y, at.z - designed - form));
    }
    let (mut cc, mut cs, mut ss) = (0.0, 0.0, 0.0);
    for &(y, z) in &rest {
        let phase = std::f64::consts::TAU * y / 4.0;
        let (c, s) = (morion::internals::num::cos(phase), morion::internals::num::sin(phase));
        with_cos += c * z;
        with_sin += s * z;
        (cc, cs, ss) = (cc + c * c, cs + c * s, ss + s * s);
    }
    let below = cc * ss - cs * cs;
    let a = (with_cos * ss - with_sin * cs) / below;
    let b = (with_sin * cc - with_cos * cs) / below;
    assert!(((a * a + b * b).sqrt() - 0.0045).abs() < 1e-6, "{a} {b}");
    for &(y, z) in &rest {
        let phase = std::f64::consts::TAU * y / 4.0;
        let wave = a * morion::internals::num::cos(phase) + b * morion::internals::num::sin(phase);
        assert!((z - wave).abs() < 1e-5, "{y}: {z} {wave}");
    }
}

#[test]
fn a_round_mirror_under_a_pinhole_is_replayed_too() {
    let folder = folder();
    let text = "camera.pinhole = { pixels = [24, 18], distance_mm = 150, focal_px = 60 }\n\
                layout.disc = {}\nmethod.vector-field.degree = 12\n\
                projection.equiangular.outer_polar_deg = 100\n\
                part = { width_mm = 30, base_mm = 5 }\nmesh = { facet_px = 0.3 }\n\
                export.formats = [\"stl\"]\n[tolerance]\ncompensators = [\"tilt\", \"despace\"]\n\
                criterion = \"p95\"\nreference = \"projection\"\n[tolerance.limits]\n\
                stepover_mm = 0\nzernike_7_um = 40\nprincipal_x_px = 0.5\n";
    save(folder.path(), text);
    let (report, pose) = replay(folder.path(), 1, &["--without", "clocking_mrad"], 0);
    assert_eq!(report["without"], serde_json::json!(["clocking_mrad", "facets_px"]));
    assert_eq!(number(&pose["part"]["clocking_mrad"]), 0.0);
    let file = &report["files"][0];
    let [shown, smooth] = [&file["displacement"], &report["smooth"]].map(figures);
    let max = number(&file["facet_error_px"]["max"]);
    assert!((shown[1] - smooth[1]).abs() <= max && max < 0.5 * smooth[1], "{shown:?} {smooth:?}");
    let names: Vec<String> = files(&folder.path().join("out/small/replay-1")).into_keys().collect();
    assert_eq!(names, ["mirror.stl", "pose.json", "replay.json"]);
}

#[test]
fn what_cannot_be_replayed_is_refused_with_a_remedy_that_helps() {
    let folder = folder();
    let home = folder.path();
    let fine = edited(&rough(), &[("stepover_mm = 1.8", "stepover_mm = 0.01")]);
    save(home, &fine);
    let replay_2 = ["small.toml", "--replay", "2"];
    let told_so = ["small: stepover_mm swings within 0.01 mm", "--without stepover_mm"];
    refused(home, &replay_2, &told_so);
    assert!(files(&home.join("out/small/replay-2")).is_empty());
    refused(
        home,
        &[&replay_2[..], &["--without", "zebra"]].concat(),
        &["zebra is none of its errors"],
    );
    refused(home, &[&replay_2[..], &["--trials", "5"]].concat(), &["--trials"]);
    refused(home, &["small.toml", "--without", "scale_ppm"], &["--replay"]);
    let (report, _) = replay(home, 2, &["--without", "stepover_mm"], 0);
    assert_eq!(report["without"], serde_json::json!(["stepover_mm", "facets_px"]));
    assert_ne!(report["repeated"], report["smooth"]);
}
