//! The command: files, streams, exit codes, and runs in parts.

use super::{engine, fixed, spec};
use crate::support::builds::{SMALL, edited, files, folder, morion, save, told};
use crate::support::{self, share};
use morion::internals::tolerance::Perturbation;
use std::collections::BTreeMap;
use std::path::Path;

/// The small profile under a camera of few pixels.
fn small() -> String {
    edited(SMALL, &[("[160, 120]", "[16, 12]")])
}

/// A number of triangles in the place of both limits.
const LIMITS: (&str, &str) = ("chord_um = 20\nfacet_px = 3", "max_triangles = 9000");

const FILES: [&str; 3] = ["tolerance.html", "tolerance.json", "trials.csv"];

/// The files of a run.
fn run(home: &Path, arguments: &[&str], expected: i32) -> BTreeMap<String, Vec<u8>> {
    let mut all = vec!["tolerance"];
    all.extend(arguments);
    let (code, out, err) = told(&morion(home, &all));
    assert_eq!(code, expected, "{out}{err}");
    let read = |name: &&str| std::fs::read(home.join("out/small").join(name)).unwrap();
    FILES.iter().map(|name| ((*name).to_owned(), read(name))).collect()
}

#[track_caller]
pub fn refused(home: &Path, arguments: &[&str], words: &[&str]) {
    support::refused(home, &[&["tolerance"], arguments].concat(), words);
}

#[test]
fn parts_of_any_size_make_the_bytes_of_one_run_on_any_threads() {
    let folder = folder();
    let home = folder.path();
    save(home, &small());
    let whole = run(home, &["small.toml", "--trials", "90", "--seed", "7", "--threads", "1"], 1);
    for range in ["60..90", "0..33", "33..60"] {
        let arguments = ["tolerance", "small.toml", "--trials", range, "--seed", "7", "--part"];
        let (code, out, _) = told(&morion(home, &arguments));
        assert_eq!(code, 0, "{out}");
    }
    let part = |range: &str| format!("out/small/trials-{range}.csv");
    let parts = ["60-90", "0-33", "33-60"].map(part);
    let [a, b, c] = parts.each_ref().map(String::as_str);
    assert!(run(home, &["--threads", "3", "--merge", a, b, c], 1) == whole);

    let kept = files(&home.join("out/small"));
    refused(home, &["--merge", a, b], &["trials-60-90.csv: it begins with trial 60, where 33"]);
    refused(home, &["--merge", a, "small.toml"], &["small.toml: it is no part of a run"]);
    refused(home, &["--merge", a, a], &["begins with trial 60, where 90"]);
    let torn = std::fs::read_to_string(home.join(b)).unwrap();
    std::fs::write(home.join("torn.csv"), &torn[..torn.rfind(',').unwrap() - 400]).unwrap();
    refused(home, &["--merge", "torn.csv", c], &["torn.csv: its trials are not whole"]);
    std::fs::write(home.join("other.csv"), torn.replace("# seed 7", "# seed 8")).unwrap();
    refused(home, &["--merge", b, "other.csv"], &["other.csv: its profile, seed or version"]);
    let arguments = ["tolerance", "small.toml", "--trials", "50..70", "--seed", "7", "--part"];
    assert_eq!(told(&morion(home, &arguments)).0, 0);
    let across = part("50-70");
    refused(home, &["--merge", &across, b, c], &["50-70.csv: it begins with trial 50, where 60"]);
    std::fs::remove_file(home.join(across)).unwrap();
    save(home, &format!("{}\n# changed", small()));
    refused(home, &["--merge", a, b, c], &["60-90.csv: its profile, seed or version"]);
    save(home, &small());
    assert!(files(&home.join("out/small")) == kept);
}

/// The bytes of a profile do not tell which errors its map holds.
#[test]
fn parts_with_different_maps_are_refused() {
    let folder = folder();
    let home = folder.path();
    let text = small();
    let table = "[tolerance]\nmap_file = \"map.csv\"\n";
    assert!(!text.contains("[tolerance]"));
    save(home, &format!("{text}\n{table}"));
    for (range, um) in [("0..4", 1.0), ("4..8", 2.0)] {
        let place = |k: i32| f64::from(k) * 10.0;
        let lines = (-4..=4).flat_map(|j| (-4..=4).map(move |i| (place(i), place(j))));
        let lines = lines.map(|(x, y)| format!("{x},{y},{}\n", 1e-6 * um * x * y / 4.0));
        std::fs::write(home.join("map.csv"), lines.collect::<String>()).unwrap();
        let arguments = ["tolerance", "small.toml", "--trials", range, "--part"];
        let (code, out, err) = told(&morion(home, &arguments));
        assert_eq!(code, 0, "{out}{err}");
    }
    let parts = ["out/small/trials-0-4.csv", "out/small/trials-4-8.csv"];
    let refusal = "trials-0-4.csv: its profile, seed or version is not that of";
    refused(home, &["--merge", parts[1], parts[0]], &[refusal, "a file that it names"]);
}

#[test]
fn a_run_ends_early_after_the_same_trials_on_any_threads() {
    let design = support::designed(&support::profile(&[]));
    let sources = vec![fixed(Perturbation::Slope, 2.0), fixed(Perturbation::Waviness, 1.0)];
    let mut asked = spec(sources.clone(), &[]);
    asked.samples = 40;
    let half = engine(&design, asked.clone()).trials(&sources, 3, 0..200, None);
    let mut figures: Vec<f64> = half.iter().map(|trial| trial.after.rms_px).collect();
    figures.sort_by(f64::total_cmp);
    asked.budget_px = figures[120];
    let engine = engine(&design, asked);
    let run = |threads: usize, until: f64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| engine.trials(&sources, 3, 7..20_007, Some(until)))
    };
    let once = run(1, 0.05);
    assert!(run(3, 0.05) == once);
    let width = |count: usize| engine.yields(&once[..count]).width();
    // At the first multiple of 500 that knows it well enough, and no sooner.
    let count = once.len();
    assert!(count % 500 == 0 && (1000..20_000).contains(&count), "{count}");
    assert!(width(count) <= 0.05 && width(count - 500) > 0.05);
    assert!(engine.trials(&sources, 3, 7..7 + count as u64, None) == once);
    assert_eq!(run(2, 0.5).len(), 500);
}

#[test]
fn the_page_stands_alone_and_holds_what_the_report_holds() {
    let folder = folder();
    let home = folder.path();
    let name = "a<b>&\"c";
    std::fs::write(home.join(format!("{name}.toml")), small()).unwrap();
    let file = format!("{name}.toml");
    let (code, out, _) = told(&morion(home, &["tolerance", &file, "--trials", "30", "-q", "-v"]));
    assert_eq!(code, 1);
    let made = files(&home.join("out").join(name));
    let text = |name: &str| String::from_utf8(made[name].clone()).unwrap();
    let (page, report) = (text("tolerance.html"), text("tolerance.json"));
    assert!(page.contains("<h1>a&lt;b&gt;&amp;&quot;c: "), "{}", &page[..2000]);
    for outside in ["src=", "url(", "<script", "@import"] {
        assert!(!page.contains(outside), "{outside}");
    }
    // What it links to are pages of the same folder, or of one in it.
    let links: Vec<&str> =
        page.split("href=\"").skip(1).map(|rest| rest.split('"').next().unwrap()).collect();
    let pages =
        ["report.html", "frame.html", "blur.html", "machining.html", "program/program.html"];
    assert_eq!(links, pages);
    // Four drawings, each well-formed, with a unit on every axis.
    let drawings: Vec<&str> =
        page.split("<svg").skip(1).map(|d| d.split("</svg>").next().unwrap()).collect();
    assert_eq!(drawings.len(), 4);
    for (drawing, units) in drawings.iter().zip([["%"; 2], ["px", "%"], ["px"; 2], ["px", "%"]]) {
        let whole = format!("<svg{drawing}</svg>");
        let mut reader = quick_xml::Reader::from_str(&whole);
        while !matches!(reader.read_event().unwrap(), quick_xml::events::Event::Eof) {}
        let labelled = |unit: &&str| whole.contains(&format!(", {unit}</text>"));
        assert!(units.iter().all(labelled), "{units:?}");
    }
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    let sources = report["sources"].as_array().unwrap();
    let offenders = report["worst_offenders"].as_array().unwrap();
    let px = |offender: &serde_json::Value| offender["adjusted_px"].as_f64().unwrap();
    assert!(offenders.len() == 10 && offenders.is_sorted_by(|a, b| px(a) >= px(b)));
    let worst = |s: &serde_json::Value| {
        let of = |key: &str| s[key].as_f64().unwrap();
        of("minus_adjusted_px").max(of("plus_adjusted_px"))
    };
    assert_eq!(px(&offenders[0]), sources.iter().map(worst).fold(0.0, f64::max));
    for source in sources {
        let key = source["source"].as_str().unwrap();
        // Among the sensitivities and among the limits.
        assert!(page.matches(&format!("<td>{key}</td>")).count() == 2 && out.contains(key));
    }
    for word in
        ["asked ", "nominal ", "worst ", "linear ", "RSS", "as made ", "adjusted ", "yield "]
    {
        assert!(
            out.contains(&format!("  {word}")) || word == "RSS" && out.contains(word),
            "{word}"
        );
    }
    for word in
        ["sha256", "P98", "P99", "worst", "farthest", "in concert", "95 % interval", "seed 1"]
    {
        assert!(page.contains(word), "{word}");
    }
}

#[test]
fn the_verdict_is_the_exit_code_and_json_is_the_file() {
    let folder = folder();
    let home = folder.path();
    let table = "[tolerance]\nbudget_px = 50\ncriterion = \"p95\"\nmap_file = \"map.csv\"\n\
                 [tolerance.limits]\nmap_share = 0.5\n[export]";
    save(home, &edited(&small(), &[("[export]", table)]));
    refused(home, &["small.toml"], &["cannot read", "map.csv"]);
    let node = |k: i32| format!("{},{},{}e-4", 4 * (k % 5) - 8, 3 * (k / 5) - 6, k % 3);
    let map: Vec<String> = (0..25).map(node).collect();
    std::fs::write(home.join("map.csv"), map.join("\n")).unwrap();
    let arguments = ["tolerance", "small.toml", "--trials", "40", "--format", "json", "-q"];
    let (code, out, err) = told(&morion(home, &arguments));
    assert_eq!((code, &*err), (0, ""), "{out}");
    assert_eq!(out, std::fs::read_to_string(home.join("out/small/tolerance.json")).unwrap());
    let report: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(report["verdict"], "pass");
    assert_eq!((&report["trials"], &report["first"]), (&40.into(), &0.into()));
    assert_eq!((&report["criterion"], &report["yield"]["share"]), (&"p95".into(), &1.0.into()));
    let sources = report["sources"].as_array().unwrap();
    assert_eq!(sources.len(), 27);
    let map = sources.iter().find(|source| source["source"] == "map_share").unwrap();
    assert!(map["plus_px"].as_f64().unwrap() > 0.0);

    let (code, out, _) = told(&morion(home, &["tolerance", "small.toml", "--trials", "40"]));
    assert_eq!(code, 0);
    let lines: Vec<&str> = out.lines().collect();
    assert!(lines[0].starts_with("small  (") && lines.last() == Some(&"  verdict  pass"), "{out}");
    assert!(out.contains("  yield    100.00 % within 50 px (95 % interval "), "{out}");

    let table = std::fs::read_to_string(home.join("out/small/trials.csv")).unwrap();
    let rows: Vec<&str> = table.lines().filter(|line| !line.starts_with('#')).collect();
    let width = rows[0].split(',').count();
    assert!(rows.len() == 41 && rows.iter().all(|row| row.split(',').count() == width));
    let mean: f64 = rows[1..]
        .iter()
        .map(|row| row.split(',').nth(4).unwrap().parse::<f64>().unwrap() / 40.0)
        .sum();
    let told = report["adjusted"]["mean_px"].as_f64().unwrap();
    assert!((mean - told).abs() < 1e-12 * told);
}

/// Limits that no system can have end soon, in words.
#[test]
fn absurd_limits_lose_rays_and_say_so() {
    let folder = folder();
    let home = folder.path();
    let keys = Perturbation::all()
        .map(|kind| kind.key())
        .filter(|key| !key.starts_with("zernike") && !["map_share", "stepover_mm"].contains(key));
    let limits: String = keys.map(|key| format!("{key} = 1e6\n")).collect();
    let none = "[tolerance]\nbudget_px = 1e-3\nreference = \"projection\"\n";
    save(home, &format!("{}\n{none}[tolerance.limits]\n{limits}", small()));
    let (code, out, err) = told(&morion(home, &["tolerance", "small.toml", "--trials", "8"]));
    assert_eq!(code, 1, "{out}{err}");
    assert!(out.contains("  lost     8 of 8 trials lose rays"), "{out}");
    let none = "  limits   no limits in concert meet the budget: the design alone uses it up";
    assert!(out.contains(none), "{out}");
    let made = files(&home.join("out/small"));
    let table = String::from_utf8(made["trials.csv"].clone()).unwrap();
    let page = String::from_utf8(made["tolerance.html"].clone()).unwrap();
    assert!(table.contains("\n0,lost,lost,lost,lost,lost,"), "{table}");
    assert!(page.contains("8 of them lose rays"), "{page}");
    for text in [&out, &table, &page] {
        assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
    }
    let report: serde_json::Value = serde_json::from_slice(&made["tolerance.json"]).unwrap();
    assert_eq!((&report["lost_trials"], &report["yield"]["share"]), (&8.into(), &0.0.into()));
    assert_eq!(
        (&report["adjusted"]["p95_px"], &report["rms_px"]),
        (&"lost".into(), &"lost".into())
    );
    assert_eq!(report["no_limit_joint"], "design");
    // Its lines are read again.
    let part = ["tolerance", "small.toml", "--trials", "0..8", "--part"];
    assert_eq!(told(&morion(home, &part)).0, 0);
    assert!(
        run(home, &["--merge", "out/small/trials-0-8.csv"], 1)["trials.csv"] == made["trials.csv"]
    );
}

/// One trial has no scatter; a picture of few pixels more adjustments than equations.
#[test]
#[ignore = "long: .ci/nightly"]
fn little_to_go_by_leaves_no_odd_figures() {
    let folder = folder();
    let home = folder.path();
    let table = "[tolerance]\ntarget_yield = 0.57\n\
                 compensators = [\"shift\", \"rotation\", \"magnification\", \"tilt\", \"despace\"]\n[export]";
    for pixels in ["[16, 12]", "[4, 3]", "[3, 2]"] {
        save(home, &edited(SMALL, &[("[160, 120]", pixels), ("[export]", table)]));
        let (code, out, err) =
            told(&morion(home, &["tolerance", "small.toml", "--trials", "1", "-v"]));
        if code == 2 {
            assert!(pixels == "[3, 2]" && err.contains("take a camera of more pixels"), "{err}");
            continue;
        }
        assert!(out.contains(" px for 57 % of the parts\n") && out.contains("sigma -,"), "{out}");
        let report = std::fs::read_to_string(home.join("out/small/tolerance.json")).unwrap();
        assert!(!report.contains("sigma_px\": null"), "{report}");
        for text in [&out, &report] {
            assert!(!text.contains("NaN") && !text.contains("inf"), "{pixels}: {text}");
        }
    }
}

#[test]
#[ignore = "long: .ci/nightly"]
fn facets_are_of_the_mesh_that_the_part_is_made_from() {
    let folder = folder();
    let home = folder.path();
    let run = |text: &str| -> (serde_json::Value, String) {
        save(home, text);
        let arguments = ["tolerance", "small.toml", "--trials", "3", "--verbose"];
        let (_, out, err) = told(&morion(home, &arguments));
        let report = std::fs::read_to_string(home.join("out/small/tolerance.json")).expect(&err);
        (serde_json::from_str(&report).unwrap(), out)
    };
    let facets = |text: &str| {
        let (report, out) = run(text);
        let sources = report["sources"].as_array().unwrap();
        let source = sources.iter().find(|s| s["source"] == "facets_px")?;
        assert!(out.contains("  facets   facets_px "), "{out}");
        let from = report["facets_from"].as_str().unwrap().to_owned();
        Some((from, source["limit"].as_f64().unwrap()))
    };
    let text = small();
    assert_eq!(facets(&text), Some(("mesh".into(), 3.0)));
    let with = |lines: &str| format!("{text}\n[tolerance]\n{lines}\n");
    assert_eq!(facets(&with("limits.facets_px = 2")), Some(("limits".into(), 2.0)));
    assert_eq!(facets(&with("made_from = \"step\"")), None);
    let both = with("made_from = \"step\"\nlimits.facets_px = 2");
    assert_eq!(facets(&both), Some(("limits".into(), 2.0)));
    // What is exported first.
    let step = text.replace("formats = [", "formats = [\"step\", ");
    assert!(step != text && facets(&step).is_none());
    let mesh = format!("{step}\n[tolerance]\nmade_from = \"mesh\"\n");
    assert_eq!(facets(&mesh), Some(("mesh".into(), 3.0)));
    // As many triangles as the bound takes keep about that.
    let budget = edited(&text, &[LIMITS]);
    let (from, limit) = facets(&budget).unwrap();
    let (_, out, _) = told(&morion(home, &["build", "small.toml", "--format", "json"]));
    let built: serde_json::Value = serde_json::from_str(&out).unwrap();
    let reached = built["mesh"]["facet_px"].as_f64().unwrap_or(limit);
    assert!(from == "foreseen" && (limit / reached - 1.0).abs() < 0.3, "{from} {limit} {reached}");
}

/// An error that is fixed has a sign; others have limits on both sides.
#[test]
fn fixed_errors_have_a_sign() {
    let folder = folder();
    let home = folder.path();
    let with = |lines: &str| save(home, &format!("{}\n[tolerance]\n{lines}\n", small()));
    let run = |lines: &str| -> serde_json::Value {
        with(lines);
        let (code, _, err) = told(&morion(home, &["tolerance", "small.toml", "--trials", "2"]));
        assert!(code < 2, "{err}");
        let report = std::fs::read(home.join("out/small/tolerance.json")).unwrap();
        serde_json::from_slice(&report).unwrap()
    };
    let fixed = "distributions.distortion_ppm = \"fixed\"\nlimits.distortion_ppm = ";
    let [minus, plus] = [-40000.0, 40000.0].map(|limit| {
        let report = run(&format!("{fixed}{limit}"));
        let worst = report["worst_offenders"].as_array().unwrap();
        let of = |list: &[serde_json::Value]| {
            list.iter().find(|s| s["source"] == "distortion_ppm").unwrap().clone()
        };
        let (worst, source) = (of(worst), of(report["sources"].as_array().unwrap()));
        assert_eq!(worst["value"], limit);
        assert_eq!(source["limit"], limit);
        assert_eq!(source["limit_joint"].as_f64().unwrap_or(limit), limit);
        let alone = source["limit_alone"].as_f64().unwrap();
        assert!(alone * limit > 0.0, "{alone}");
        let side = if limit < 0.0 { "minus_adjusted_px" } else { "plus_adjusted_px" };
        assert_eq!(worst["adjusted_px"], source[side]);
        report["mean_px"].as_f64().unwrap()
    });
    // Barrel and pincushion are alike by first derivatives.
    assert!((minus / plus - 1.0).abs() < 1e-9 && plus > 0.05, "{minus} {plus}");
    for (lines, words) in [
        ("limits.distortion_ppm = -5", "is \"fixed\" in [tolerance.distributions]"),
        ("limits.stepover_mm = -0.1\ndistributions.stepover_mm = \"fixed\"", "from 0 to 1000000"),
    ] {
        with(lines);
        refused(home, &["small.toml"], &[words]);
    }
}

/// Mirrors that are polished can be used; prints as they come cannot, and are worse than milled ones.
#[test]
#[ignore = "long: .ci/nightly"]
fn every_shipped_mirror_passes_polished_and_none_is_better_printed_than_milled() {
    let folder = folder();
    let home = folder.path();
    for shipped in share(12, 0, morion::internals::profile::shipped()) {
        let run = |preset: &str| -> serde_json::Value {
            save(home, &format!("{}\n[tolerance]\npreset = \"{preset}\"\n", shipped.text));
            let arguments = ["tolerance", "small.toml", "--trials", "100", "--format", "json"];
            let (code, out, err) = told(&morion(home, &arguments));
            assert!(code < 2, "{err}");
            serde_json::from_str(&out).unwrap()
        };
        let polished = run("polished");
        assert_eq!(polished["verdict"], "pass", "{}: {}", shipped.name, polished["reasons"]);
        let figure = |report: &serde_json::Value| {
            report["adjusted"]["p50_px"].as_f64().unwrap_or(f64::INFINITY)
        };
        let (printed, milled) = (run("sla-print"), run("standard-cnc"));
        let [printed_px, milled_px] = [&printed, &milled].map(figure);
        assert!(printed_px > 2.0 * milled_px, "{}: {printed_px} {milled_px}", shipped.name);
        assert_eq!(printed["verdict"], "fail");
    }
}

/// Neither a build nor anything else in the folder changes an answer.
#[test]
#[ignore = "long: .ci/nightly"]
fn a_build_beside_changes_no_answer() {
    let folder = folder();
    let home = folder.path();
    for text in [small(), edited(&small(), &[LIMITS])] {
        let run = || {
            save(home, &text);
            told(&morion(home, &["tolerance", "small.toml", "--trials", "20"]));
            std::fs::read(home.join("out/small/tolerance.json")).unwrap()
        };
        let before = run();
        let (code, _, err) = told(&morion(home, &["build", "small.toml"]));
        assert!(code < 2, "{err}");
        assert!(run() == before);
    }
}

#[test]
fn maps_that_do_not_cover_the_mirror_are_refused() {
    let folder = folder();
    let home = folder.path();
    save(home, &edited(&small(), &[("[export]", "[tolerance]\nmap_file = \"map.csv\"\n[export]")]));
    for (step, says) in [
        (
            [3, 3],
            "map.csv: it covers X from -6 to 6 mm, and the mirror goes from -7.5000 to 7.5000 mm",
        ),
        ([4, 2], "map.csv: it covers Y from -4 to 4 mm, and the mirror goes from "),
    ] {
        let node = |k: i32| format!("{},{},0\n", step[0] * (k % 5 - 2), step[1] * (k / 5 - 2));
        std::fs::write(home.join("map.csv"), (0..25).map(node).collect::<String>()).unwrap();
        refused(home, &["small.toml"], &[says, "add rows or columns"]);
    }
}

/// A name may hold anything that a file's name may.
#[cfg(unix)]
#[test]
fn a_profile_with_a_line_end_in_its_name_is_merged() {
    let folder = folder();
    let home = folder.path();
    let named = "two\nlines \"and\" quotes";
    std::fs::write(home.join(format!("{named}.toml")), small()).unwrap();
    let file = format!("{named}.toml");
    let arguments = ["tolerance", &file, "--trials", "0..6", "--part"];
    assert_eq!(told(&morion(home, &arguments)).0, 0);
    let part = home.join("out").join(named).join("trials-0-6.csv");
    let (code, out, err) = told(&morion(home, &["tolerance", "--merge", part.to_str().unwrap()]));
    assert_eq!(code, 1, "{out}{err}");
}

#[test]
fn wrong_usage_and_mirrors_that_aim_at_nothing_are_refused() {
    let folder = folder();
    let home = folder.path();
    save(home, &small());
    refused(home, &[], &["PROFILE", "Usage: "]);
    refused(home, &["small.toml", "--trials", "5..5"], &["at least one"]);
    refused(home, &["small.toml", "--until", "0"], &["percentage"]);
    refused(home, &["small.toml", "--part", "--until", "1%"], &["--until"]);
    refused(home, &["small.toml", "--merge", "a.csv"], &["--merge"]);
    refused(home, &["zebra"], &["zebra: no such file"]);
    assert!(!home.join("out").exists());
    let bare = "camera.orthographic.pixels = [64, 48]\nmirror.polynomial.terms = [[2, 0, 0.01]]\n\
                part = { width_mm = 6, height_mm = 4, base_mm = 2 }\nmesh.chord_um = 9\n\
                export.formats = [\"stl\"]\n";
    std::fs::write(home.join("bare.toml"), bare).unwrap();
    refused(home, &["bare.toml"], &["cannot tolerance bare: it has no projection"]);
}
