//! Monte Carlo against the linear model, budgets fed forward, and the same bits in every order.

use crate::support::{designed, shipped};
use crate::{engine, fixed, question, usual};
use morion::tolerance::{
    Compensator, Engine, Kind, Process, Question, Reference, Source, Study, Trial, quantile,
};

const ALL: [Compensator; 3] =
    [Compensator::Shift, Compensator::Rotation, Compensator::Magnification];

fn process() -> &'static Process {
    Process::named("ultra-precision-cnc").unwrap()
}

fn trials(engine: &Engine, seed: u64, count: u64) -> Vec<Trial> {
    engine.trials(&engine.question.sources, seed, 0..count, None)
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
        let engine = engine(&design, question(sources, compensators));
        let found = rms(&trials(&engine, 4, 1500));
        let variance: f64 = engine.question.sources.iter().map(|s| engine.variance(s)).sum();
        assert!((variance.sqrt() / found - 1.0).abs() < 0.05, "{name} {variance} {found}");
    }
}

#[test]
fn a_study_tells_sources_by_their_impact() {
    let design = designed(&shipped("hyperbolic"));
    let sources = usual(&design, process());
    let engine = engine(&design, Question { samples: 40, ..question(sources, &ALL) });
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
        sources.retain(|source| source.kind != Kind::ToolMarks);
        let engine = engine(&design, Question { samples: 60, ..question(sources, &ALL) });
        let full = trials(&engine, 4, 200);
        let linear = engine.linear_trials(&engine.question.sources, 4, 0..200);
        for (full, linear) in full.iter().zip(&linear) {
            let (a, b) = (full.after.rms_px, linear.after.rms_px);
            assert!((a / b - 1.0).abs() < 0.03, "{name} {}: {a} {b}", full.index);
        }
    }
}

#[test]
fn trials_do_not_depend_on_threads_or_on_their_company() {
    let design = designed(&shipped("conquistador"));
    let engine = engine(&design, question(usual(&design, process()), &ALL));
    let all = trials(&engine, 9, 130);
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert!(pool.install(|| trials(&engine, 9, 130)) == all);
    }
    let part = |range| engine.trials(&engine.question.sources, 9, range, None);
    let parts = [part(0..1), part(1..64), part(64..130)].concat();
    assert!(parts == all);
    // A trial's own system, rebuilt from its number alone.
    let made = engine.trial(&engine.question.sources, 9, 77);
    let (before, after, steps) =
        engine.judge(engine.displacements(std::slice::from_ref(&made)).remove(0));
    assert_eq!((before, after, &steps), (all[77].before, all[77].after, &all[77].steps));
    // A source more changes none of the others' draws.
    let fewer: Vec<Source> = engine.question.sources[1..].to_vec();
    let rest = engine.trial(&fewer, 9, 77);
    assert_eq!(rest.state.form, made.state.form);
    assert_eq!(rest.state.placed[1..], made.state.placed[1..]);
}

#[test]
fn trials_end_when_the_yield_is_known_well_enough() {
    let design = designed(&shipped("conquistador"));
    let asked = Question { samples: 40, ..question(usual(&design, process()), &ALL) };
    let engine = engine(&design, asked);
    let until = |width| engine.trials(&engine.question.sources, 1, 0..3000, Some(width));
    let (some, most) = (until(0.09), until(1e-6));
    assert!(some.len() % 500 == 0 && some.len() < most.len(), "{}", some.len());
    assert!(engine.yields(&some).width() <= 0.09);
    assert!(most.len() == 3000 && most[..some.len()] == some);
}

#[test]
fn limits_fed_forward_hit_the_budget() {
    for (name, reference) in
        [("conquistador", Reference::Design), ("hyperbolic", Reference::Projection)]
    {
        let design = designed(&shipped(name));
        let sources = usual(&design, process());
        let asked = Question { reference, samples: 150, ..question(sources, &ALL) };
        let budget = asked.budget_px;
        let before = engine(&design, asked.clone());
        for source in &asked.sources {
            let Some(limit) = before.limit_alone(source, 3) else { continue };
            let reached = before.impact(source, 3, limit).worst().rms_px;
            assert!((reached / budget - 1.0).abs() < 0.01, "{name} {source:?} {limit}");
        }
        let joint = before.joint(3).unwrap();
        // As if they were written into the profile.
        let after = engine(&design, Question { sources: joint.sources.clone(), ..asked.clone() });
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
        let most = joint.sources.iter().map(|source| before.variance(source)).fold(0.0, f64::max);
        for (k, (own, source)) in before.question.sources.iter().zip(&joint.sources).enumerate() {
            let share = before.variance(source) / most;
            let widest = joint.widest[k];
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
    let engine = engine(&design, question(sources, &[]));
    let joint = engine.joint(3).unwrap();
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
            let sources = vec![fixed(Kind::Facets, 1.0), fixed(Kind::Slope, slope)];
            let engine = engine(&design, question(sources.clone(), &ALL));
            let found = rms(&trials(&engine, 2, 400));
            let exact = (engine.variance(&sources[0]) + engine.variance(&sources[1])).sqrt();
            assert!(found > last, "{name} {slope}: {found} {last}");
            assert!((found / exact - 1.0).abs() < 0.02, "{name} {slope}: {found} {exact}");
            last = found;
        }
    }
}
