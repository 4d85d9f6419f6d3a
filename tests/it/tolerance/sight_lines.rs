//! Where pixels look in made systems, and how parts differ in that.

use super::{engine, spec, usual};
use crate::support::{designed, shipped};
use morion::internals::geom::{DVec2, Ray};
use morion::internals::tolerance::{
    Compensator, CovariancePx, Engine, Perturbation, PerturbedSystem, Process, ProcessPreset,
};

/// Parts of a run: the standard deviation of each variance is sqrt(2 / 600) of it, 6 %.
const PARTS: u64 = 600;

fn places(engine: &Engine) -> Vec<DVec2> {
    engine.places().map(|(point, _)| point).collect()
}

/// Covariance of the directions' displacement on the image, px^2, over parts: by the rays' own derivatives along the image.
fn over_parts(engine: &Engine, points: &[DVec2], pixel_mm: f64) -> Vec<CovariancePx> {
    let rays = |points: &[DVec2], made: &PerturbedSystem| {
        let found = engine.sight_lines(points).rays(made);
        found.into_iter().map(Option::unwrap).collect::<Vec<Ray>>()
    };
    let perfect =
        engine.make(&[], morion::internals::num::random::RandomStream { seed: 0, trial: 0 });
    let half = 0.25 * pixel_mm;
    let shifted = |way: DVec2| -> Vec<Ray> {
        let points: Vec<DVec2> = points.iter().map(|at| at + way * half).collect();
        rays(&points, &perfect)
    };
    let along = [DVec2::X, DVec2::Y].map(|way| (shifted(way), shifted(-way)));
    let middle = rays(points, &perfect);
    let mut sums = vec![[0.0; 3]; points.len()];
    for part in 0..PARTS {
        let made = engine.trial(&engine.spec.sources, 7, part);
        for (k, ray) in rays(points, &made).into_iter().enumerate() {
            let off = ray.direction - middle[k].direction;
            let [x, y] = [0, 1].map(|axis: usize| {
                let (after, before): &(Vec<Ray>, Vec<Ray>) = &along[axis];
                (after[k].direction - before[k].direction) / 0.5
            });
            // Least squares of off = a x + b y.
            let [xx, xy, yy] = [x.dot(x), x.dot(y), y.dot(y)];
            let [p, q] = [x.dot(off), y.dot(off)];
            let area = xx * yy - xy * xy;
            let [a, b] = [(p * yy - q * xy) / area, (q * xx - p * xy) / area];
            sums[k] = [sums[k][0] + a * a, sums[k][1] + a * b, sums[k][2] + b * b];
        }
    }
    sums.into_iter().map(|sum| sum.map(|s| s / PARTS as f64)).collect()
}

/// Full traces of parts that are drawn scatter as the covariances say: facets aside, which no single ray shows, and without
/// adjustments.
#[test]
fn covariances_are_those_of_parts_that_are_traced() {
    for name in ["conquistador", "hyperbolic"] {
        let design = designed(&shipped(name));
        let mut sources = usual(&design, Process::of(ProcessPreset::PrecisionCnc));
        sources.retain(|source| {
            !matches!(
                source.kind,
                Perturbation::Facets | Perturbation::Layers | Perturbation::Stepover
            )
        });
        let engine = engine(&design, spec(sources, &[]));
        let points = places(&engine);
        let told = engine.sight_lines(&points).covariances(false);
        let found = over_parts(&engine, &points, design.camera.pixel_mm);
        let trace = |[xx, _, yy]: CovariancePx| xx + yy;
        let [told_sum, found_sum] = [
            told.iter().map(|c| trace(c.unwrap())).sum::<f64>(),
            found.iter().map(|c| trace(*c)).sum::<f64>(),
        ];
        assert!((found_sum / told_sum - 1.0).abs() < 0.08, "{name}: {found_sum} {told_sum}");
        for (told, found) in told.into_iter().zip(found) {
            let ratio = trace(found) / trace(told.unwrap());
            assert!((0.7..1.4).contains(&ratio), "{name}: {ratio}");
        }
    }
}

/// Over the engine's own samples the covariances add up to the mean squares of the study, adjusted or not; what is known of a mounted
/// part adds nothing.
#[test]
fn covariances_add_up_to_the_variances_of_the_study() {
    let design = designed(&shipped("panoramic"));
    let sources = usual(&design, Process::of(ProcessPreset::PrecisionCnc));
    for asked in [&[][..], &[Compensator::Shift, Compensator::Rotation, Compensator::Tilt]] {
        let engine = engine(&design, spec(sources.clone(), asked));
        let lines = engine.sight_lines(&places(&engine));
        let sum = |is_mounted| -> f64 {
            let all = lines.covariances(is_mounted).into_iter().flatten();
            all.map(|[xx, _, yy]| xx + yy).sum::<f64>() / engine.samples() as f64
        };
        let variance = |is_counted: fn(Perturbation) -> bool| -> f64 {
            let counted = engine.spec.sources.iter().filter(|source| is_counted(source.kind));
            counted.map(|source| engine.variance(source)).sum()
        };
        let all = variance(|_| true);
        assert!((sum(false) / all - 1.0).abs() < 1e-6, "{asked:?}: {} {all}", sum(false));
        let is_made = |kind: Perturbation| {
            let acts_on = kind.row().acts_on;
            !(acts_on.is_mounting() || acts_on.is_camera() || acts_on.is_size())
        };
        let made = variance(is_made);
        assert!((sum(true) / made - 1.0).abs() < 1e-6 && made < 0.8 * all, "{made} {all}");
    }
}
