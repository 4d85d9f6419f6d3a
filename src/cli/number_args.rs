//! Numbers as arguments, each with what it must be.

use crate::pipeline::ViewAngles;
use crate::profile::MOST_POINTS;
use std::ops::Range;

/// A number for which `fits` holds; otherwise it says what it must be.
fn number(text: &str, must: &str, fits: impl Fn(f64) -> bool) -> Result<f64, String> {
    let number = text.parse().ok().filter(|&x: &f64| x.is_finite() && fits(x));
    number.ok_or_else(|| format!("it must be {must}"))
}

/// Most threads: more of them than cores are of no use, and each has a stack.
const MOST_THREADS: usize = 1024;

pub(super) fn threads(text: &str) -> Result<usize, String> {
    let number = text.parse().ok().filter(|n| (1..=MOST_THREADS).contains(n));
    number.ok_or_else(|| format!("it must be a whole number from 1 to {MOST_THREADS}"))
}

pub(super) fn share(text: &str) -> Result<f64, String> {
    number(text, "a number from 0 to 1", |x| (0.0..=1.0).contains(&x))
}

pub(super) fn positive(text: &str) -> Result<f64, String> {
    number(text, "a number of millimetres from 1e-6 to 1e9", |x| (1e-6..=1e9).contains(&x))
}

pub(super) fn aperture(text: &str) -> Result<f64, String> {
    number(text, "a number from 1e-6 to 0.99", |x| (1e-6..=0.99).contains(&x))
}

/// Pixels, with or without their unit.
pub(super) fn pixels(text: &str) -> Result<f64, String> {
    let number_of = text.trim().trim_end_matches("px").trim();
    number(number_of, "a number of pixels from 1e-6 to 1e6, as in 0.5px", |x| {
        (1e-6..=1e6).contains(&x)
    })
}

pub(super) fn finite(text: &str) -> Result<f64, String> {
    number(text, "a number from -1e9 to 1e9", |x| x.abs() <= 1e9)
}

/// Pixels across and down.
pub(super) fn frame_size(text: &str) -> Result<[usize; 2], String> {
    let size = text.split_once(['x', 'X']).and_then(|(width, height)| {
        Some([width.trim().parse().ok()?, height.trim().parse().ok()?])
    });
    size.ok_or_else(|| "it must be pixels across and down, as in 1280x720".into())
}

/// Direction and field of a view, degrees.
pub(super) fn view_angles(text: &str) -> Result<ViewAngles, String> {
    let angles: Option<Vec<f64>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    match angles.as_deref() {
        Some(&[azimuth_deg, elevation_deg, field_deg]) => {
            Ok(ViewAngles { azimuth_deg, elevation_deg, field_deg })
        }
        _ => Err(
            "it must be three numbers of degrees, azimuth, elevation and field, as in 30,-10,60"
                .into(),
        ),
    }
}

/// Most trials of a run.
const MOST_TRIALS: u64 = 10_000_000;
/// The last number of a trial: as far as whole numbers of JSON go everywhere.
const LAST_TRIAL: u64 = 1 << 53;

/// A number of trials, or the numbers of some.
pub(super) fn trials(text: &str) -> Result<Range<u64>, String> {
    let number = |text: &str| text.trim().replace('_', "").parse::<u64>().ok();
    let range = match text.split_once("..") {
        None => number(text).map(|count| 0..count),
        Some((from, to)) => number(from).zip(number(to)).map(|(from, to)| from..to),
    };
    match range {
        Some(range) if range.is_empty() => Err("there must be at least one".into()),
        Some(range) if range.end > LAST_TRIAL => Err(format!("the last number is {LAST_TRIAL}")),
        Some(range) if range.end - range.start > MOST_TRIALS => {
            Err(format!("there must be at most {MOST_TRIALS} at a time; make --part after --part"))
        }
        Some(range) => Ok(range),
        None => Err("write a number, as in 10000, or a range, as in 5000..10000".into()),
    }
}

/// The number of a job, from 1, and of how many.
pub(super) fn shard(text: &str) -> Result<[usize; 2], String> {
    /// Most jobs: as many as a study may have points.
    const MOST: usize = MOST_POINTS;
    let numbers = text
        .split_once('/')
        .and_then(|(number, of)| Some([number.trim().parse().ok()?, of.trim().parse().ok()?]));
    let fits = |[number, of]: &[usize; 2]| (1..=*of).contains(number) && *of <= MOST;
    let must = format!("it must be K/N, job K of N, as in 1/8; N is at most {MOST}");
    numbers.filter(fits).ok_or(must)
}

/// A share, from percent.
pub(super) fn percent(text: &str) -> Result<f64, String> {
    let percent = text.trim().trim_end_matches('%').trim();
    number(percent, "a percentage over 0, as in 0.5%", |p| p > 0.0 && p <= 100.0).map(|p| p / 100.0)
}
