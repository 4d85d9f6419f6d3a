//! Monte Carlo against the linear model, budgets fed forward, and the same bits in every order.

use super::{engine, fixed, spec, usual, with_map};
use crate::support::shipped_builds;
use crate::support::{designed, share, shipped};
use morion::internals::geom::{BicubicSpline, GridAxis};
use morion::internals::tolerance::{
    AllocationError, Compensator, Criterion, DisplacementPx, Engine, ErrorSource, Perturbation,
    Process, ProcessPreset, Reference, SourceFacts, Study, ToleranceSpec, Trial, quantile,
    worst_offenders,
};

/// Samples that a run of the program takes.
const SAMPLES: usize = 987;
const ALL: [Compensator; 3] =
    [Compensator::Shift, Compensator::Rotation, Compensator::Magnification];

fn process() -> Process {
    Process::of(ProcessPreset::UltraPrecisionCnc)
}

fn trials(engine: &Engine, seed: u64, count: u64) -> Vec<Trial> {
    engine.trials(&engine.spec.sources, seed, 0..count, None)
}

fn rms(trials: &[Trial]) -> f64 {
    let square: f64 = trials.iter().map(|t| t.after.rms_px * t.after.rms_px).sum();
    (square / trials.len() as f64).sqrt()
}

#[test]
fn the_root_of_the_sum_of_squares_is_that_of_the_trials() {
    for (name, compensators) in
        [("conquistador", &ALL[..]), ("conquistador", &[]), ("hyperbolic", &ALL), ("conical", &[])]
    {
        let design = designed(&shipped(name));
        let sources = usual(&design, process());
        let engine = engine(&design, spec(sources, compensators));
        let found = rms(&trials(&engine, 4, 1500));
        let foreseen = rss(&engine);
        assert!((foreseen / found - 1.0).abs() < 0.05, "{name} {foreseen} {found}");
    }
}

/// What first derivatives say of the trials' RMS: the square of what all have in common, and the
/// variances of the rest.
fn rss(engine: &Engine) -> f64 {
    let sources = &engine.spec.sources;
    let mean = DisplacementPx::of(&engine.mean_field(sources)).rms_px;
    let variance: f64 = sources.iter().map(|source| engine.variance(source)).sum();
    (mean * mean + variance).sqrt()
}

/// Fixed errors have a sign and add with it, to each other and to what the design is off by.
#[test]
fn systematic_errors_add_with_their_signs() {
    // A decentred mirror under a decentred sensor, each with a displacement like the other's.
    let design = designed(&shipped("conical"));
    let mut sources =
        vec![fixed(Perturbation::DecentreX, 50.0), fixed(Perturbation::PrincipalX, 1.0)];
    let squares = |engine: &Engine| -> f64 {
        engine.spec.sources.iter().map(|source| engine.mean_square(source)).sum()
    };
    let alone = engine(&design, spec(sources.clone(), &[]));
    let found = rms(&trials(&alone, 4, 3));
    assert!((rss(&alone) / found - 1.0).abs() < 1e-3, "{} {found}", rss(&alone));
    let unsigned = squares(&alone).sqrt();
    assert!((unsigned / found - 1.0).abs() > 0.1, "{unsigned} {found}");
    sources.extend(
        usual(&design, process()).into_iter().filter(|s| s.kind != Perturbation::DecentreX),
    );
    sources.retain(|s| s.kind != Perturbation::PrincipalX || s.is_systematic());
    let all = engine(&design, spec(sources, &ALL));
    let found = rms(&trials(&all, 4, 600));
    assert!((rss(&all) / found - 1.0).abs() < 0.05, "{} {found}", rss(&all));

    // A measured bend against a projection that the design does not meet.
    let design = designed(&shipped("conquistador"));
    let knots = |reach: f64| GridAxis { first_mm: -reach, step_mm: reach / 20.0, count: 41 };
    let (x, y) = (knots(32.0), knots(24.0));
    let heights: Vec<f64> = (0..41 * 41)
        .map(|k| {
            let [u, v] = [x.at(k % 41), y.at(k / 41)];
            2e-6 * u * u - 1e-6 * u * v
        })
        .collect();
    let map = BicubicSpline::new(x, y, &heights).unwrap();
    let (tilt, share) = (fixed(Perturbation::TiltX, 0.4), fixed(Perturbation::Map, 20.0));
    for (sources, near) in [
        (vec![share, tilt], 1e-2),
        ([vec![share, tilt], vec![usual(&design, process())[1]]].concat(), 0.05),
    ] {
        let asked = ToleranceSpec { reference: Reference::Projection, ..spec(sources, &ALL[..2]) };
        let engine = engine(&design, with_map(asked, map.clone()));
        let found = rms(&trials(&engine, 4, 300));
        assert!((rss(&engine) / found - 1.0).abs() < near, "{} {found}", rss(&engine));
        let nominal = engine.unperturbed();
        let unsigned = (squares(&engine) + nominal * nominal).sqrt();
        assert!((unsigned / found - 1.0).abs() > 0.02, "{unsigned} {found}");
    }
}

/// Limits in concert leave systematic errors as they are, and say why where there are none.
#[test]
fn systematic_errors_use_up_their_part_of_the_budget() {
    let design = designed(&shipped("conquistador"));
    let mut sources = usual(&design, process());
    let tilt = sources.iter().position(|s| s.kind == Perturbation::TiltX).unwrap();
    sources[tilt] = fixed(Perturbation::TiltX, 2.5);
    let asked = |sources: &[ErrorSource], budget_px| ToleranceSpec {
        budget_px,
        samples: 60,
        ..spec(sources.to_vec(), &ALL)
    };
    let before = engine(&design, asked(&sources, 1.0));
    let joint = before.allocate_limits(3).unwrap();
    assert!(joint.sources[tilt] == sources[tilt] && !joint.widest[tilt]);
    assert_eq!(before.variance(&sources[tilt]), 0.0);
    let after = engine(&design, asked(&joint.sources, 1.0));
    let mut figures = after.figures(&trials(&after, 3, 2000));
    figures.sort_by(f64::total_cmp);
    let reached = quantile(&figures, 0.9);
    assert!((reached - 1.0).abs() < 0.01, "{reached}");
    // Alone it is at its own sign.
    let limit = before.inverse_sensitivity(&sources[tilt], 3).unwrap();
    let alone = engine(&design, asked(&[fixed(Perturbation::TiltX, limit)], 1.0));
    assert!((rms(&trials(&alone, 3, 1)) - 1.0).abs() < 1e-3, "{limit}");

    let none = |sources: &[ErrorSource], budget| {
        engine(&design, asked(sources, budget)).allocate_limits(3).err()
    };
    assert_eq!(none(&sources, 0.3), Some(AllocationError::Systematic));
    assert_eq!(none(&sources[tilt..=tilt], 1.0), Some(AllocationError::NothingToShare));
    let asked = ToleranceSpec { reference: Reference::Projection, ..asked(&sources, 0.3) };
    assert_eq!(engine(&design, asked).allocate_limits(3).err(), Some(AllocationError::Design));
}

/// A trial in which a ray does not meet the mirror is lost: it fails, and figures are of the others.
#[test]
fn lost_trials_fail_and_leave_finite_figures() {
    let design = designed(&shipped("conquistador"));
    let mut sources = usual(&design, process());
    sources[0].limit = 8e4;
    let asked = ToleranceSpec { budget_px: 1e4, samples: 60, ..spec(sources, &ALL) };
    let engine = engine(&design, asked);
    let all = trials(&engine, 4, 60);
    let study = Study::new(&engine, 4, &all);
    let lost = all.iter().filter(|trial| !trial.after.kept()).count();
    assert!((1..60).contains(&lost), "{lost}");
    assert!(all.iter().all(|trial| trial.after.kept() != trial.steps.is_empty()));
    assert_eq!((study.lost_trials, study.gap.trials), (lost as u64, 60 - lost as u64));
    assert!(study.yields.share <= 1.0 - lost as f64 / 60.0);
    let finite = [study.rms_px, study.adjusted.mean_px, study.gap.rms_px, study.adjustments[0].p95];
    assert!(finite.iter().all(|x| x.is_finite()), "{study:?}");
    let json = serde_json::to_value(&study).unwrap();
    assert_eq!(
        (&json["adjusted"]["worst_px"], json["gap"]["rms_px"].is_number()),
        (&"lost".into(), true)
    );
    let told =
        ["adjusted", "as_made", "linear", "gap", "adjustments"].map(|key| json[key].to_string());
    assert!(told.iter().all(|told| !told.contains("null")), "{told:?}");
}

#[test]
fn a_study_tells_sources_by_their_impact() {
    let design = designed(&shipped("hyperbolic"));
    let sources = usual(&design, process());
    let engine = engine(&design, ToleranceSpec { samples: 40, ..spec(sources, &ALL) });
    let study = Study::new(&engine, 4, &trials(&engine, 4, 100));
    let shares: f64 = study.sources.iter().map(|s| s.share_of_variance).sum();
    assert!((shares - 1.0).abs() < 1e-12);
    let impacts = study.sources.iter().map(|s| s.minus_adjusted_px.max(s.plus_adjusted_px));
    assert!(impacts.is_sorted_by(|a, b| a >= b));
    assert!((study.rss_px / study.rms_px - 1.0).abs() < 0.1, "{study:?}");
    assert_eq!((study.trials, study.gap.trials, study.sources.len()), (100, 100, 24));
}

/// Trial by trial, but for tracks: hits move by more than their distance, into another part of the
/// same pattern.
#[test]
fn first_derivatives_foresee_every_trial() {
    for name in ["conquistador", "hyperbolic"] {
        let design = designed(&shipped(name));
        let mut sources = usual(&design, process());
        sources.retain(|source| source.kind != Perturbation::Stepover);
        let engine = engine(&design, ToleranceSpec { samples: 60, ..spec(sources, &ALL) });
        let full = trials(&engine, 4, 200);
        let linear = engine.linear_trials(&engine.spec.sources, 4, 0..200);
        for (full, linear) in full.iter().zip(&linear) {
            let (a, b) = (full.after.rms_px, linear.after.rms_px);
            assert!((a / b - 1.0).abs() < 0.03, "{name} {}: {a} {b}", full.index);
        }
    }
}

#[test]
fn trials_do_not_depend_on_threads_or_on_their_company() {
    let design = designed(&shipped("conquistador"));
    let engine = engine(&design, spec(usual(&design, process()), &ALL));
    let all = trials(&engine, 9, 130);
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert!(pool.install(|| trials(&engine, 9, 130)) == all);
    }
    let part = |range| engine.trials(&engine.spec.sources, 9, range, None);
    let parts = [part(0..1), part(1..64), part(64..130)].concat();
    assert!(parts == all);
    // A trial's own system, rebuilt from its number alone.
    let made = engine.trial(&engine.spec.sources, 9, 77);
    let (before, after, steps) =
        engine.compensate(engine.displacements(std::slice::from_ref(&made)).remove(0));
    assert_eq!((before, after, &steps), (all[77].before, all[77].after, &all[77].steps));
    // A source more changes none of the others' draws.
    let fewer: Vec<ErrorSource> = engine.spec.sources[1..].to_vec();
    let rest = engine.trial(&fewer, 9, 77);
    assert_eq!(rest.state.form, made.state.form);
    assert_eq!(rest.state.misalignment.values()[1..], made.state.misalignment.values()[1..]);
}

#[test]
fn trials_end_when_the_yield_is_known_well_enough() {
    let design = designed(&shipped("conquistador"));
    let asked = ToleranceSpec { samples: 40, ..spec(usual(&design, process()), &ALL) };
    let engine = engine(&design, asked);
    let until = |width| engine.trials(&engine.spec.sources, 1, 0..3000, Some(width));
    let (some, most) = (until(0.09), until(1e-6));
    assert!(some.len() % 500 == 0 && some.len() < most.len(), "{}", some.len());
    assert!(engine.yields(&some).width() <= 0.09);
    assert!(most.len() == 3000 && most[..some.len()] == some);
}

#[test]
#[ignore = "long: .ci/nightly"]
fn limits_fed_forward_hit_the_budget() {
    use Criterion::{P95, Rms};
    let cases = [
        ("conquistador", Reference::Design, Rms),
        ("hyperbolic", Reference::Projection, Rms),
        ("conquistador", Reference::Projection, P95),
        ("conical", Reference::Design, P95),
    ];
    for (name, reference, criterion) in share(2, 1, cases) {
        let design = designed(&shipped(name));
        let sources = usual(&design, process());
        // No limit is widened beyond four times: budgets that are used up before.
        let budget = match (name, reference, criterion) {
            ("hyperbolic", ..) => 0.3,
            (_, Reference::Projection, P95) => 3.0,
            _ => 1.0,
        };
        let asked = ToleranceSpec {
            reference,
            criterion,
            budget_px: budget,
            samples: 150,
            ..spec(sources, &ALL)
        };
        let name = &format!("{name} {criterion:?}");
        let before = engine(&design, asked.clone());
        for source in &asked.sources {
            let Some(limit) = before.inverse_sensitivity(source, 3) else { continue };
            let reached = before.sensitivity(source, 3, limit).worst().by(criterion);
            assert!((reached / budget - 1.0).abs() < 0.01, "{name} {source:?} {limit}");
            // However far off its own limit is.
            if [Perturbation::TiltX, Perturbation::Scale].contains(&source.kind) {
                let tiny = ErrorSource { limit: 1e-9, ..*source };
                assert_eq!(before.inverse_sensitivity(&tiny, 3), Some(limit), "{name}");
            }
        }
        let joint = before.allocate_limits(3).unwrap();
        // As if they were written into the profile.
        let after =
            engine(&design, ToleranceSpec { sources: joint.sources.clone(), ..asked.clone() });
        let forward = |seed, count| after.trials(&joint.sources, seed, 0..count, None);
        let mut figures = after.figures(&forward(3, 4000));
        figures.sort_by(f64::total_cmp);
        let reached = quantile(&figures, 0.9);
        assert!((reached / budget - 1.0).abs() < 0.01, "{name}: {reached}");
        // Other parts keep it as often as was asked, as far as their number can tell.
        let holds = |seed| {
            let found = after.yields(&forward(seed, 600));
            found.low <= 0.9 && 0.9 <= found.high
        };
        let held = (20..28).filter(|&seed| holds(seed)).count();
        assert!(held >= 7, "{name}: {held}");
        // Equal weights, equal shares, but for what is not widened further.
        let shared = joint.sources.iter().filter(|source| !source.kind.is_fine());
        let most = shared.map(|source| before.variance(source)).fold(0.0, f64::max);
        for (k, (own, source)) in before.spec.sources.iter().zip(&joint.sources).enumerate() {
            let share = before.variance(source) / most;
            let widest = joint.widest[k];
            if source.kind.is_fine() {
                assert_eq!(own, source);
                continue;
            }
            assert!(
                !widest || (share < 1.0 && source.limit == 4.0 * own.limit),
                "{name} {source:?}"
            );
            assert!((share - 1.0).abs() < 1e-9 || widest || share < 1e-15, "{name} {source:?}");
        }
    }
}

#[test]
fn dear_sources_get_more_of_the_budget() {
    let design = designed(&shipped("conquistador"));
    let mut sources = usual(&design, process());
    sources[3].weight = 5.0;
    let engine = engine(&design, spec(sources, &[]));
    let joint = engine.allocate_limits(3).unwrap();
    let [dear, cheap] = [3, 4].map(|k| engine.variance(&joint.sources[k]));
    assert!((dear / cheap - 5.0).abs() < 1e-9);
}

/// Errors that know nothing of each other add up: a rough surface under facets is never better than
/// a smooth one.
#[test]
fn random_slope_on_facets_never_improves_the_figure() {
    for name in ["conquistador", "conical"] {
        let design = designed(&shipped(name));
        let mut last = 0.0;
        for slope in [0.0, 0.05, 0.1, 0.2, 0.5] {
            let sources = vec![fixed(Perturbation::Facets, 1.0), fixed(Perturbation::Slope, slope)];
            let engine = engine(&design, spec(sources.clone(), &ALL));
            let found = rms(&trials(&engine, 2, 400));
            let exact = (engine.variance(&sources[0]) + engine.variance(&sources[1])).sqrt();
            assert!(found > last, "{name} {slope}: {found} {last}");
            assert!((found / exact - 1.0).abs() < 0.02, "{name} {slope}: {found} {exact}");
            last = found;
        }
    }
}

/// The sampled picture is the whole picture: without errors it is as far from the projection as the
/// design is over all of its panel and rim.
#[test]
#[ignore = "long: .ci/nightly"]
fn the_samples_are_the_picture_of_every_shipped_mirror() {
    for shipped in morion::internals::profile::shipped() {
        let design = designed(&crate::support::shipped(shipped.name));
        // Errors of panels beside each other are spread in as many ways.
        let panels = if design.mirror.has_steps() { design.mirror.panels().len() } else { 1 };
        let samples = SAMPLES * panels;
        let engine = engine(&design, ToleranceSpec { samples, ..spec(Vec::new(), &[]) });
        let nominal = engine.nominal();
        let whole = shipped_builds::report(shipped.name).design.pixel_error_px.unwrap();
        // A mirror that is exact is so but for rounding. What the polynomial leaves of a table goes up and down some
        // forty times along the radius, more often than samples resolve: of 0.03 px, a thirtieth is open.
        let slack = if shipped.name == "soccer" { 1e-3 } else { 1e-9 };
        let near = |found: f64, exact: f64| (found - exact).abs() <= 0.01 * exact + slack;
        let (share, count) = (engine.share(), engine.samples());
        let what = format!("{}: {nominal:?} {whole:?} {share} {count}", shipped.name);
        assert!(near(nominal.rms_px, whole.rms) && near(nominal.p95_px, whole.p95), "{what}");
        assert!(share == 1.0 && count > samples * 3 / 4, "{what}");
    }
}

/// A perfect part whose design is off by more than the budget at 95 % of the picture is not good:
/// samples that kept away from the rim took 2.2 px for the 3.13 px of the conquistador.
#[test]
fn a_perfect_part_of_a_design_beyond_the_budget_fails() {
    let design = designed(&shipped("conquistador"));
    let asked = ToleranceSpec {
        samples: SAMPLES,
        criterion: Criterion::P95,
        reference: Reference::Projection,
        budget_px: 2.6,
        ..spec(Vec::new(), &[])
    };
    let engine = engine(&design, asked);
    assert!(engine.yields(&trials(&engine, 1, 20)).share == 0.0);
}

/// What forms of a high order displace at the rim counts: a Legendre term on a strip against the
/// mean over its whole picture, dense and by hand.
#[test]
#[ignore = "long: .ci/nightly"]
fn forms_displace_the_whole_picture() {
    for name in ["panoramic", "conquistador"] {
        let design = designed(&shipped(name));
        let source = fixed(Perturbation::Legendre03, 1.0);
        let made = |samples: usize| {
            let engine = engine(&design, ToleranceSpec { samples, ..spec(vec![source], &[]) });
            engine.mean_square(&source).sqrt()
        };
        let (usual, dense) = (made(SAMPLES), made(40_000));
        assert!((usual - dense).abs() < 0.01 * dense, "{name}: {usual} {dense}");
    }
}

/// A distortion of +12 500 ppm in every part was told as one of -12 500, which would do more.
#[test]
fn the_worst_of_systematic_errors_have_the_signs_that_they_were_given() {
    let design = designed(&shipped("conquistador"));
    let sources = [
        (Perturbation::Distortion, 12_500.0),
        (Perturbation::PrincipalX, 20.0),
        (Perturbation::TiltX, 1.0),
        (Perturbation::Scale, 2000.0),
    ];
    let sources = sources.map(|(kind, limit)| fixed(kind, limit)).to_vec();
    let engine = engine(&design, spec(sources, &ALL));
    let study = Study::new(&engine, 4, &trials(&engine, 4, 3));
    let worse = |s: &SourceFacts| s.minus_adjusted_px > s.plus_adjusted_px;
    assert!(study.sources.iter().any(worse), "no sign that would do more");
    for offender in worst_offenders(&study) {
        let facts = study.sources.iter().find(|s| s.source == offender.source).unwrap();
        assert_eq!(
            (offender.value, offender.adjusted_px),
            (facts.limit, facts.plus_adjusted_px),
            "{offender:?}"
        );
    }
}
