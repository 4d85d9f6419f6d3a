//! Degree against error: how far a design of finite degree is from the best one there is.

use super::{BenchError, BenchSweep, BenchTime, Subject, run, timed};
use crate::design::{DesignFacts, design};
use crate::num::stats::Summary;
use crate::pipeline::Error;
use crate::profile::{Method, MethodKind, Profile, ShapeSpec};

/// Every method.
pub(super) const METHODS: [MethodKind; 3] =
    [MethodKind::VectorField, MethodKind::FixedSurface, MethodKind::Distribution];
/// Degrees swept, and the one that stands for the optimum: least squares, minimax designs (which take
/// many times as long), and in haste.
const LEAST_SQUARES: (&[usize], usize) = (&[4, 6, 8, 10, 12, 14, 16, 20, 24], 28);
const MINIMAX: (&[usize], usize) = (&[4, 6, 8, 10, 12, 14], 16);
const QUICK: (&[usize], usize) = (&[4, 6, 8, 10], 12);

/// Degrees of every designed mirror by every method (of round mirrors by their own: all give the same),
/// on one core. The error is the surplus of the ray error (its RMS, of minimax designs the largest) over
/// the least that any of the designs and some of still higher degree come to: over the optimum, as far
/// as it is known. Shapes are analytic, so it falls exponentially, to where the method's own optimum
/// lies.
pub(super) fn sweep(subjects: &[Subject], quick: bool) -> Result<BenchSweep, BenchError> {
    let one_core = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .map_err(|error| BenchError::Plot(error.to_string()))?;
    let mut runs = Vec::new();
    for subject in subjects {
        let ShapeSpec::Designed(own) = subject.profile.shape else { continue };
        let is_round = subject.design.mirror.surface.is_axisymmetric();
        let methods = if is_round { &[own.kind][..] } else { &METHODS };
        for minimax in [false, true].into_iter().filter(|minimax| !(is_round && *minimax)) {
            let (degrees, utmost) = match (quick, minimax) {
                (true, _) => QUICK,
                (false, false) => LEAST_SQUARES,
                (false, true) => MINIMAX,
            };
            let (mut curves, mut optimum) = (Vec::new(), f64::INFINITY);
            for &kind in methods {
                let of = |degree| {
                    let shape = ShapeSpec::Designed(Method { kind, degree, minimax });
                    Profile { shape, ..subject.profile.clone() }
                };
                optimum = optimum.min(goal(&designed(&of(utmost))?));
                for &degree in degrees {
                    let profile = of(degree);
                    let once = || one_core.install(|| designed(&profile));
                    let (time_ms, facts) = timed(quick, once)?;
                    optimum = optimum.min(goal(&facts));
                    curves.push((time_ms, facts));
                }
            }
            runs.extend(curves.iter().map(|(time_ms, facts)| {
                let goal_word = if facts.minimax { ", minimax" } else { "" };
                let series = format!("{}{goal_word}", facts.method);
                let surplus = goal(facts) - optimum;
                let at = (subject.name(), &*series);
                run(at, facts.degree as f64, *time_ms, surplus, figures(facts))
            }));
        }
    }
    Ok(BenchSweep {
        name: "design",
        about: "Degree of the design",
        time: BenchTime::Run,
        setting: "degree",
        error: "surplus_mrad",
        error_axis: "ray error over the least of any design, mrad",
        runs,
        orders: Vec::new(),
    })
}

fn designed(profile: &Profile) -> Result<DesignFacts, Error> {
    let fail = |source| Error::Design { profile: profile.name.clone(), source };
    Ok(design(profile).map_err(fail)?.facts)
}

/// What the method makes small, mrad.
fn goal(facts: &DesignFacts) -> f64 {
    let pick = |s: Summary| if facts.minimax { s.max } else { s.rms };
    facts.ray_error_mrad.map_or(f64::NAN, pick)
}

fn figures(facts: &DesignFacts) -> std::collections::BTreeMap<&'static str, f64> {
    let of = |summary: Option<Summary>| summary.map_or([f64::NAN; 2], |s| [s.rms, s.max]);
    let [ray, pixel] = [facts.ray_error_mrad, facts.pixel_error_px].map(of);
    [
        ("unknowns", facts.unknowns as f64),
        ("condition", facts.condition.unwrap_or(f64::NAN)),
        ("ray_rms_mrad", ray[0]),
        ("ray_max_mrad", ray[1]),
        ("pixel_rms_px", pixel[0]),
        ("pixel_max_px", pixel[1]),
    ]
    .into()
}
