//! Rays of the witness against the error of the pixel error that it finds.

use super::{BenchError, BenchSweep, BenchTime, Subject, convergence_order, run, timed};
use crate::pipeline::{Run, Silent, build_in_memory};
use crate::trace::{CameraTrace, Scene, TraceStrip, TraceSummary};
use crate::verdict::{RimShift, expected_rays, wanted_picture};
use std::convert::Infallible;

/// Pixels to the side, as shares of the camera's own; and those of the truth.
const SCALES: [f64; 6] = [0.0625, 0.125, 0.25, 0.5, 1.0, 2.0];
const TRUTH: f64 = 4.0;

/// Cameras of more and fewer pixels look into the mesh that the profile asks for. The error is that of
/// the RMS pixel error (in the camera's own pixels) against the one by most rays. A facet's error is
/// independent of its neighbours', so it falls as the root of the number of rays.
pub(super) fn sweep(subjects: &[Subject], quick: bool) -> Result<BenchSweep, BenchError> {
    let (scales, truth) = if quick { (&SCALES[..4], 0.25 * TRUTH) } else { (&SCALES[..], TRUTH) };
    let mut runs = Vec::new();
    for subject in subjects.iter().filter(|subject| subject.design.view.is_some()) {
        let design = &subject.design;
        let made =
            build_in_memory(&Run::in_memory(&subject.profile, &Silent), design, &mut |_| {})?;
        let scene = &made.scene;
        let look = |scale: f64| Ok::<_, Infallible>(estimate(subject, scene, scale));
        let Ok((true_px, _)) = look(truth);
        for &scale in scales {
            let Ok((time_ms, (px, rays))) = timed(quick, || look(scale));
            let figures = [("pixel_rms_px", px), ("true_px", true_px)].into();
            let error = (px - true_px).abs();
            runs.push(run((subject.name(), ""), rays, time_ms, error, figures));
        }
    }
    let orders = [
        convergence_order(&runs, "error ~ rays", -0.5, |run| (run.setting, run.error)),
        convergence_order(&runs, "error ~ time", -0.5, |run| (run.time_ms, run.error)),
    ];
    Ok(BenchSweep {
        name: "witness",
        about: "Rays of the witness",
        time: BenchTime::Run,
        setting: "rays",
        error: "error_px",
        error_axis: "error of the RMS pixel error, px",
        runs,
        orders: orders.into_iter().flatten().collect(),
    })
}

/// The RMS pixel error as `scale` times as many pixels to the side show it, in pixels of the camera of
/// `subject`; and how many rays that took.
fn estimate(subject: &Subject, scene: &Scene, scale: f64) -> (f64, f64) {
    let Subject { profile, design, .. } = subject;
    let own = &design.camera;
    let pixels = own.pixels.map(|n| ((f64::from(n) * scale).round() as u32).max(1));
    let scaled = design.with_pixels(pixels);
    let trace = CameraTrace::new(scene, &scaled.camera, scene.above_mm());
    let table = expected_rays(&scaled, RimShift::None);
    let mut summary = TraceSummary::default();
    let picture = wanted_picture(profile, &scaled);
    TraceStrip::each(&trace, None, picture, table, |strip| summary.add(strip));
    let [[_, found, _], _] = summary.errors();
    let rms = found.map_or(f64::NAN, |summary| summary.rms / own.pixel_mm);
    (rms, f64::from(pixels[0]) * f64::from(pixels[1]))
}
