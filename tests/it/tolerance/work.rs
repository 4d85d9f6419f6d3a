//! What a run counts as done and as avoided.

use super::{engine, fixed, spec, usual};
use crate::support::builds::{SMALL, edited, folder, morion, save, told};
use crate::support::{designed, shipped};
use morion::internals::num::random::RandomStream;
use morion::internals::tolerance::{Engine, Perturbation, Process, ProcessPreset, WorkKind};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

const STREAM: RandomStream = RandomStream { seed: 3, trial: 1 };

fn worked(engine: &Engine, kind: WorkKind) -> [u64; 2] {
    let tally = engine.worked();
    let found = tally.kinds().find(|(other, _)| *other == kind);
    found.map_or([0, 0], |(_, counts)| counts)
}

/// A shift of 1e-303 mm moves no ray by a bit, but the engine does not know.
#[test]
fn rays_that_errors_leave_alone_are_where_tracing_finds_them() {
    for name in ["conquistador", "hyperbolic"] {
        let design = designed(&shipped(name));
        let sources = usual(&design, Process::of(ProcessPreset::PrecisionCnc));
        let engine = engine(&design, spec(sources, &[]));
        let all = engine.samples() as u64;
        assert_ne!(worked(&engine, WorkKind::Rays), [0, 0]);
        let facets = (Perturbation::Facets, 0.5);
        let still = engine.make(&[facets], STREAM);
        let skipped = engine.displacements(&[still.clone(), still]);
        assert_eq!(worked(&engine, WorkKind::Rays), [0, 2 * all], "{name}");
        let moved = engine.make(&[facets, (Perturbation::DecentreX, 1e-300)], STREAM);
        let traced = engine.displacements(&[moved]);
        assert_eq!(worked(&engine, WorkKind::Rays), [all, 0], "{name}");
        assert!(skipped[0] == traced[0] && skipped[1] == traced[0], "{name}");
        assert!(traced[0].iter().any(|x| *x != 0.0));
        // Nothing was counted since.
        assert_eq!(worked(&engine, WorkKind::Rays), [0, 0]);
    }
}

#[test]
fn what_an_engine_evaluates_and_what_stands_for_it_is_counted() {
    let design = designed(&shipped("conquistador"));
    let sources = usual(&design, Process::of(ProcessPreset::PrecisionCnc));
    let forms = sources.iter().filter(|s| s.kind.form_term().is_some()).count();
    let of = |sources| engine(&design, spec(sources, &[]));
    let full = of(sources);
    let all = full.samples() as u64;
    // Thirteen numbers that place, height and two slopes; form errors have columns made of these.
    let [done, avoided] = worked(&full, WorkKind::Derivatives);
    assert!(done == 16 * all && avoided > (forms as u64) * all, "{done} {avoided}");
    assert_eq!(full.expanded() as u64, all);
    let one = |kind, value| full.displacements(&[full.make(&[(kind, value)], STREAM)]);
    one(Perturbation::DecentreX, 1.0);
    let tally: Vec<_> = full.worked().kinds().collect();
    let at = |kind| tally.iter().find(|(other, _)| *other == kind).unwrap().1;
    assert_eq!(at(WorkKind::Rays), [all, 0]);
    // Each ray takes a step of Newton's or more, and no error of form has an amplitude.
    let [evaluated, expanded] = at(WorkKind::Surface);
    assert!(evaluated == 0 && (all..8 * all).contains(&expanded), "{expanded}");
    let [added, left] = at(WorkKind::Forms);
    // Those of the last incomplete four are not looked at.
    assert!(added < 4 * all && left > 10 * added && (added + left) % all == 0, "{added} {left}");
    one(Perturbation::Slope, 1.0);
    let [more, less] = worked(&full, WorkKind::Forms);
    assert!(more + less == added + left && more > less, "{more} {less}");
    // Far from where they are seen polynomials are no longer the mirror.
    one(Perturbation::DecentreX, 5e3);
    assert!(worked(&full, WorkKind::Surface)[0] > all);
    // Of fewer sources, fewer derivatives are avoided.
    let few = of(vec![fixed(Perturbation::DecentreX, 1.0)]);
    let [few, none] = worked(&few, WorkKind::Derivatives);
    assert!(few == 16 * all && none == 0, "{few} {none}");
}

/// Done and avoided by stage and what it is.
fn timings(home: &Path) -> BTreeMap<String, [u64; 2]> {
    let text = std::fs::read(home.join("out/small/tolerance-timings.json")).unwrap();
    let timings: Value = serde_json::from_slice(&text).unwrap();
    let seconds = timings["seconds"].as_object().unwrap();
    let sum: f64 = seconds.values().map(|s| s.as_f64().unwrap()).sum();
    assert!(sum <= timings["total_s"].as_f64().unwrap());
    let row = |work: &Value| {
        let word = |key: &str| work[key].as_str().unwrap();
        assert!(!word("why").is_empty());
        let counts = ["done", "avoided"].map(|key| work[key].as_u64().unwrap());
        (format!("{} {}", word("stage"), word("what")), counts)
    };
    timings["work"].as_array().unwrap().iter().map(row).collect()
}

#[test]
#[ignore = "long: .ci/nightly"]
fn a_run_says_what_each_stage_did_and_avoided() {
    let folder = folder();
    let home = folder.path();
    let table = "[tolerance]\nbudget_px = 3\n[export]";
    save(home, &edited(SMALL, &[("[160, 120]", "[16, 12]"), ("[export]", table)]));
    let run = |arguments: &[&str]| {
        let (code, _, err) = told(&morion(home, &[&["tolerance", "-q"], arguments].concat()));
        assert!(code < 2, "{err}");
    };
    run(&["small.toml", "--trials", "40"]);
    let whole = timings(home);
    let report = std::fs::read(home.join("out/small/tolerance.json")).unwrap();
    let report: Value = serde_json::from_slice(&report).unwrap();
    let samples = report["samples"].as_u64().unwrap();
    assert_eq!(whole["trials trials"], [40, 0]);
    assert_eq!(whole["trials rays met with the mirror"], [40 * samples, 0]);
    assert_eq!(whole["errors derivatives taken along rays"][0], 16 * samples);
    // Facets alone, of sixteen patterns, leave mirror and rays alone: at their limit, and at those
    // that are tried for the one that uses up the budget.
    let [met, left] = whole["budget rays met with the mirror"];
    assert!(met > left && left % (16 * samples) == 0 && left > 16 * samples, "{met} {left}");
    let [full, quick] = whole["budget trials traced for limits that go together"];
    assert!(full % 500 == 0 && full > 0 && quick > 10 * full, "{full} {quick}");

    // In parts, the trials are those of others; all else is done again.
    for range in ["0..15", "15..40"] {
        run(&["small.toml", "--trials", range, "--part"]);
    }
    run(&["--merge", "out/small/trials-0-15.csv", "out/small/trials-15-40.csv"]);
    let merged = timings(home);
    assert_eq!(merged["trials trials"], [0, 40]);
    assert!(!merged.contains_key("trials rays met with the mirror"));
    for (what, counts) in &whole {
        assert!(what.starts_with("trials") || merged[what] == *counts, "{what}");
    }

    // Known well enough, the yield needs no more.
    run(&["small.toml", "--trials", "2000", "--until", "30%", "--threads", "1"]);
    let early = timings(home);
    assert_eq!(early["trials trials"], [500, 1500]);
    let more = timings(home);
    run(&["small.toml", "--trials", "500", "--threads", "2"]);
    for (what, counts) in timings(home) {
        assert!(what == "trials trials" || more[&what] == counts, "{what}");
    }
}
