//! Limits of the mesh against the errors that are proven of it, its size, time and memory.

use super::memory::{forget_peak, resident};
use super::{
    BenchError, BenchRun, BenchSweep, BenchTime, ConvergenceOrder, Subject, convergence_order, run,
    timed,
};
use crate::geom::Precision;
use crate::mesh::{Face, Limits, MeshError, forecast, mesh};
use crate::num::{exp, log};
use crate::pipeline::Error;

/// Which limit governs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum GoverningLimit {
    /// The image's displacement: falls as the root of the number of triangles.
    Facet,
    /// The height between facet and mirror: falls as their number.
    Chord,
}

/// Numbers of triangles, about.
const SIZES: [f64; 5] = [1e4, 3e4, 1e5, 3e5, 1e6];
/// Times of smaller meshes are mostly overhead, and no part of the fits.
const FITTED: f64 = 5e4;

/// Meshes of 1e4 to 1e6 triangles, each within one limit alone.
pub(super) fn sweep(
    subjects: &[Subject],
    rule: GoverningLimit,
    quick: bool,
) -> Result<BenchSweep, BenchError> {
    let (name, about, [setting, error, error_axis], per_triangle) = match rule {
        GoverningLimit::Facet => (
            "mesh-facet",
            "Facet error of the mesh",
            ["facet_px", "bound_px", "proven facet error, px"],
            -0.5,
        ),
        GoverningLimit::Chord => (
            "mesh-chord",
            "Chord error of the mesh",
            ["chord_um", "bound_um", "proven chord error, um"],
            -1.0,
        ),
    };
    let sizes = if quick { &SIZES[..3] } else { &SIZES };
    let mut runs = Vec::new();
    for subject in subjects {
        let design = &subject.design;
        let unit_mm = match rule {
            GoverningLimit::Facet if design.bounded_view().is_none() => continue,
            GoverningLimit::Facet => design.camera.pixel_mm,
            GoverningLimit::Chord => 1e-3,
        };
        let (mirror, chart, view) = (&design.mirror, &design.camera.chart, design.bounded_view());
        let fail = |error: MeshError| Error::Mesh {
            profile: subject.name().to_owned(),
            source: error.into(),
        };
        let mut limit = 1.0;
        for &size in sizes {
            // Twice, as the law holds for large meshes only.
            for _ in 0..2 {
                let seen = forecast(mirror, chart, view, limits(rule, limit * unit_mm));
                limit *= exp(per_triangle * log(size / seen.map_err(fail)?.facets));
            }
            let limits = limits(rule, limit * unit_mm);
            let before = resident("VmRSS:");
            let peak_from_now = forget_peak();
            let first = mesh(mirror, chart, view, limits).map_err(fail)?;
            let peak = before.zip(resident("VmHWM:")).filter(|_| peak_from_now);
            let count = first.mesh.triangles.len() as f64;
            let bytes = peak.map_or(f64::NAN, |(before, peak)| (peak - before) / count);
            drop(first);
            let (time_ms, face) = timed(quick, || mesh(mirror, chart, view, limits).map_err(fail))?;
            let (reached, least) = match rule {
                GoverningLimit::Facet => (face.bound.facet_mm, face.optimum.facet(limit * unit_mm)),
                GoverningLimit::Chord => (face.bound.chord_mm, face.optimum.chord(limit * unit_mm)),
            };
            let figures = figures(&face, least, bytes, time_ms);
            runs.push(run((subject.name(), ""), limit, time_ms, reached / unit_mm, figures));
        }
    }
    let orders = orders(&runs, per_triangle);
    Ok(BenchSweep { name, about, time: BenchTime::Run, setting, error, error_axis, runs, orders })
}

/// Orders of error and time in the number of triangles, of meshes that are not mostly overhead.
fn orders(runs: &[BenchRun], per_triangle: f64) -> Vec<ConvergenceOrder> {
    let large: Vec<_> =
        runs.iter().filter(|run| run.figures["triangles"] > FITTED).cloned().collect();
    let orders = [
        convergence_order(&large, "error ~ triangles", per_triangle, |run| {
            (run.figures["triangles"], run.error)
        }),
        convergence_order(&large, "time ~ triangles", 1.0, |run| {
            (run.figures["triangles"], run.time_ms)
        }),
        convergence_order(&large, "error ~ time", per_triangle, |run| (run.time_ms, run.error)),
    ];
    orders.into_iter().flatten().collect()
}

fn limits(rule: GoverningLimit, limit_mm: f64) -> Limits {
    let of = |this| (rule == this).then_some(limit_mm);
    Limits {
        chord_mm: of(GoverningLimit::Chord),
        facet_mm: of(GoverningLimit::Facet),
        precision: Precision::Double,
    }
}

fn figures(
    face: &Face,
    least: Option<f64>,
    bytes: f64,
    time_ms: f64,
) -> std::collections::BTreeMap<&'static str, f64> {
    let count = face.mesh.triangles.len() as f64;
    [
        ("triangles", count),
        ("over_optimum", least.map_or(f64::NAN, |least| count / least)),
        ("triangles_per_s", count / time_ms * 1e3),
        ("peak_bytes_per_triangle", bytes),
    ]
    .into()
}
