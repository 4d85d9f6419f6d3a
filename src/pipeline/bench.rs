//! Run time against error: the shipped mirrors designed in every way, timed on one core.

use super::Error;
use super::files::Folder;
use crate::design::design;
use crate::profile::{Method, MethodKind, Profile, Shape, shipped};
use crate::report::{Bench, DesignRun};
use std::io::Write;
use std::path::Path;
use std::time::{Duration, Instant};

const METHODS: [MethodKind; 3] =
    [MethodKind::VectorField, MethodKind::FixedSurface, MethodKind::Distribution];
/// The problems without an exact mirror.
const SWEPT: [&str; 2] = ["panoramic", "conquistador"];
/// A median that takes longer is cut short.
const PATIENCE: Duration = Duration::from_millis(1500);

/// Benchmarks the design stage and writes `bench.json`, `design.csv` and `design.svg` into
/// `out`/bench. `quick` takes few degrees and one run of each.
///
/// # Errors
/// [`enum@Error`] when a design fails or the disk refuses.
pub fn bench(out: &Path, quick: bool) -> Result<Bench, Error> {
    let folder = Folder::create(&out.join("bench"))?;
    let degrees: &[usize] = if quick { &[4, 8, 12] } else { &[4, 6, 8, 10, 12, 14, 16, 20, 24] };
    let runs = if quick { 1 } else { 7 };
    let one_core = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .map_err(|error| Error::Bench(error.to_string()))?;
    let bench = one_core.install(|| -> Result<Bench, Error> {
        let mut design = Vec::new();
        for name in SWEPT {
            for kind in METHODS {
                for minimax in [false, true] {
                    for &degree in degrees {
                        let method = Method { kind, degree, minimax };
                        let profile = parsed(name);
                        let profile = Profile { shape: Shape::Designed(method), ..profile };
                        design.push(timed(&profile, runs)?);
                    }
                }
            }
        }
        let shipped = shipped()
            .iter()
            .map(|profile| timed(&parsed(profile.name), runs))
            .collect::<Result<_, Error>>()?;
        Ok(Bench { schema: 1, design, shipped })
    })?;
    let svg = bench.svg().map_err(|error| Error::Bench(error.to_string()))?;
    let files = [("bench.json", bench.json()), ("design.csv", bench.csv()), ("design.svg", svg)];
    for (name, text) in files {
        folder.stage(name, |out: &mut dyn Write| out.write_all(text.as_bytes()))?.publish()?;
    }
    Ok(bench)
}

fn parsed(name: &str) -> Profile {
    let profile = shipped().iter().find(|profile| profile.name == name).expect("it is shipped");
    Profile::parse(name, name, profile.text.as_bytes()).expect("shipped profiles are valid")
}

/// The median of some runs, after one that is not counted.
fn timed(profile: &Profile, runs: usize) -> Result<DesignRun, Error> {
    let fail = |source| Error::Design { profile: profile.name.clone(), source };
    let began = Instant::now();
    let facts = design(profile, None).map_err(fail)?.facts;
    let mut times = vec![began.elapsed()];
    if runs > 1 {
        times.clear();
        while times.len() < runs && (times.is_empty() || began.elapsed() < PATIENCE) {
            let began = Instant::now();
            design(profile, None).map_err(fail)?;
            times.push(began.elapsed());
        }
    }
    times.sort_unstable();
    let (ray, pixel) = (facts.ray_error_mrad, facts.pixel_error_px);
    let of = |summary: Option<crate::num::stats::Summary>| {
        summary.map_or([f64::NAN; 2], |summary| [summary.rms, summary.max])
    };
    let ([ray_rms_mrad, ray_max_mrad], [pixel_rms_px, pixel_max_px]) = (of(ray), of(pixel));
    Ok(DesignRun {
        profile: profile.name.clone(),
        method: facts.method,
        minimax: facts.minimax,
        degree: facts.degree,
        unknowns: facts.unknowns,
        time_ms: 1e3 * times[times.len() / 2].as_secs_f64(),
        ray_rms_mrad,
        ray_max_mrad,
        pixel_rms_px,
        pixel_max_px,
    })
}
