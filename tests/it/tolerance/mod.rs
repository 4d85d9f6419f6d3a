//! Tolerancing: against closed forms, differences, and statistics of its own full traces.

mod footprint;
mod physics;
mod program;
mod replay;
mod sight_lines;
mod statistics;
mod work;

use morion::internals::design::Design;
use morion::internals::geom::BicubicSpline;
use morion::internals::tolerance::{
    Compensator, Criterion, Distribution, Engine, ErrorSource, ErrorSourceRow, FormMeasure,
    Perturbation, Process, ProcessPreset, Reference, ToleranceSpec,
};

/// A source that is always at `limit`.
fn fixed(kind: Perturbation, limit: f64) -> ErrorSource {
    ErrorSource { kind, limit, distribution: Distribution::Fixed, weight: 1.0 }
}

/// All usual sources of a mirror, as a process leaves them.
fn usual(design: &Design, process: Process) -> Vec<ErrorSource> {
    let round = matches!(design.mirror.outline, morion::internals::geom::Outline::Ring { .. });
    let telecentric = design.camera.chart.vergence == 0.0;
    let source = |kind: Perturbation| {
        let (limit, distribution) = match kind {
            Perturbation::Facets => (0.5, Distribution::Fixed),
            kind => process.usual(kind),
        };
        ErrorSource { kind, limit, distribution, weight: 1.0 }
    };
    ErrorSourceRow::TABLE
        .iter()
        .filter(|row| row.applies_to.holds(round, telecentric, false))
        .map(|row| source(row.perturbation))
        .filter(|source| source.limit != 0.0)
        .collect()
}

fn spec(sources: Vec<ErrorSource>, compensators: &[Compensator]) -> ToleranceSpec {
    ToleranceSpec {
        sources,
        form: FormMeasure::Pv,
        texture: Process::of(ProcessPreset::PrecisionCnc).texture,
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

fn engine(design: &Design, spec: ToleranceSpec) -> Engine {
    let view = design.view.as_ref().unwrap();
    Engine::new(&design.mirror, &design.camera, view, spec).unwrap()
}

/// The same with a measured form error.
fn with_map(spec: ToleranceSpec, map: BicubicSpline) -> ToleranceSpec {
    ToleranceSpec { map: Some(map), ..spec }
}
