//! Run time and memory of the witness against the size of the frame.

use super::memory::{forget_peak, resident};
use super::{BenchError, BenchSweep, BenchTime, Subject, convergence_order, run, timed};
use crate::pipeline::{Run, Silent, build_in_memory};
use crate::trace::{CameraTrace, TraceStrip, TraceSummary};
use crate::verdict::{RimShift, expected_rays, wanted_picture};
use std::convert::Infallible;

/// Pixels to the side over the camera's own: from 0.3 to 315 megapixels of 640 x 480.
const SCALES: [u32; 6] = [1, 2, 4, 8, 16, 32];

/// The first mirror that has a picture is traced by cameras of ever more pixels: time is to grow as their
/// number, and memory not at all. What is compared is the time a pixel, in the place of an error.
pub(super) fn sweep(subjects: &[Subject], quick: bool) -> Result<BenchSweep, BenchError> {
    let scales = if quick { &SCALES[..3] } else { &SCALES[..] };
    let mut runs = Vec::new();
    if let Some(subject) = subjects.iter().find(|subject| subject.design.view.is_some()) {
        let made = build_in_memory(
            &Run::in_memory(&subject.profile, &Silent),
            &subject.design,
            &mut |_| {},
        )?;
        for &scale in scales {
            let scaled =
                subject.design.with_pixels(subject.design.camera.pixels.map(|n| n * scale));
            let trace = CameraTrace::new(&made.scene, &scaled.camera, made.scene.above_mm());
            let look = || {
                let mut summary = TraceSummary::default();
                let table = expected_rays(&scaled, RimShift::None);
                let picture = wanted_picture(&subject.profile, &scaled);
                TraceStrip::each(&trace, None, picture, table, |strip| summary.add(strip));
                Ok::<_, Infallible>(summary.errors())
            };
            let before = resident("VmRSS:");
            let peak_from_now = forget_peak();
            let Ok((time_ms, _)) = timed(quick, look);
            let peak = before.zip(resident("VmHWM:")).filter(|_| peak_from_now);
            let peak_mb = peak.map_or(f64::NAN, |(before, peak)| 1e-6 * (peak - before));
            let megapixels = scaled.camera.pixels.map(f64::from).iter().product::<f64>() * 1e-6;
            let figures = [("peak_mb", peak_mb)].into();
            let ns_per_pixel = time_ms / megapixels;
            runs.push(run((subject.name(), ""), megapixels, time_ms, ns_per_pixel, figures));
        }
    }
    let orders = [convergence_order(&runs, "time ~ pixels", 1.0, |run| (run.setting, run.time_ms))];
    Ok(BenchSweep {
        name: "frames",
        about: "Frames of any size",
        time: BenchTime::Run,
        setting: "megapixels",
        error: "ns_per_pixel",
        error_axis: "time a pixel, ns",
        runs,
        orders: orders.into_iter().flatten().collect(),
    })
}
