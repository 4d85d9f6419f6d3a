//! Tolerancing: against closed forms, differences, and statistics of its own full traces.

mod footprint;
mod physics;
mod program;
mod replay;
mod statistics;
mod work;

use morion::internals::design::Design;
use morion::internals::mirror::BicubicSpline;
use morion::internals::tolerance::{
    Compensator, Criterion, Distribution, Engine, Kind, Measure, Process, Question, Reference,
    Source,
};

/// A source that is always at `limit`.
fn fixed(kind: Kind, limit: f64) -> Source {
    Source { kind, limit, distribution: Distribution::Fixed, weight: 1.0 }
}

/// All usual sources of a mirror, as a process leaves them.
fn usual(design: &Design, process: &Process) -> Vec<Source> {
    let round = matches!(design.mirror.outline, morion::internals::geom::Outline::Ring { .. });
    let applies = |kind: &Kind| match kind {
        Kind::Legendre(..) => !round,
        Kind::Zernike(_) => round,
        Kind::Telecentricity => design.camera.chart.vergence == 0.0,
        Kind::Map => false,
        _ => true,
    };
    let source = |kind: Kind| {
        let (limit, distribution) = match kind {
            Kind::Facets => (0.5, Distribution::Fixed),
            kind => process.usual(kind),
        };
        Source { kind, limit, distribution, weight: 1.0 }
    };
    Kind::all().filter(applies).map(source).filter(|source| source.limit != 0.0).collect()
}

fn question(sources: Vec<Source>, compensators: &[Compensator]) -> Question {
    Question {
        sources,
        form: Measure::Pv,
        texture: Process::named("precision-cnc").unwrap().texture,
        map: None,
        compensators: compensators.to_vec(),
        criterion: Criterion::Rms,
        reference: Reference::Design,
        budget_px: 1.0,
        budget_blur_px: 1.0,
        target_yield: 0.9,
        samples: 150,
    }
}

fn engine(design: &Design, question: Question) -> Engine {
    let view = design.view.as_ref().unwrap();
    Engine::new(&design.mirror, &design.camera, view, question).unwrap()
}

/// The same with a measured form error.
fn with_map(question: Question, map: BicubicSpline) -> Question {
    Question { map: Some(map), ..question }
}
