//! Depth bounds of a band of rows, by which the rasterizer skips hidden facets.

use super::ray_end::RayEnd;

/// Rows of a band, which is resolved by one thread, by the frame's columns: what is kept of a band's pixels, some 100
/// bytes each, then takes some 3 MB at the most.
pub(super) const fn band_rows(columns: usize) -> usize {
    match columns {
        ..=1024 => 32,
        1025..=2048 => 16,
        _ => 8,
    }
}

/// Columns of a run, and of the largest square of pixels whose reflected rays are proven unoccluded together.
pub(super) const RUN: usize = 32;

/// Greatest hit distances over a band of rows, mm: facets farther than these are hidden.
#[derive(Debug)]
pub(super) struct BandDepths {
    /// The greatest over each run of columns.
    runs: Vec<f64>,
    /// The greatest over the band.
    pub whole: f64,
}

impl BandDepths {
    /// Depths of the ends of a band's rays, row by row.
    pub(super) fn new(ends: &[RayEnd], columns: usize) -> Self {
        let mut runs = vec![f64::NEG_INFINITY; columns.div_ceil(RUN)];
        for row in ends.chunks(columns) {
            for (depth, run) in runs.iter_mut().zip(row.chunks(RUN)) {
                *depth = run.iter().map(|end| end.t).fold(*depth, greater);
            }
        }
        let whole = runs.iter().copied().fold(f64::NEG_INFINITY, greater);
        Self { runs, whole }
    }

    /// Whether pixels of the columns from `left` up to `right` may show something as far as `t`.
    #[inline]
    pub(super) fn reach(&self, [left, right]: [usize; 2], t: f64) -> bool {
        left < right && self.runs[left / RUN..=(right - 1) / RUN].iter().any(|&d| d >= t)
    }
}

/// The greater of two numbers as one machine instruction; NaN is left out.
#[inline]
pub(super) fn greater(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}
