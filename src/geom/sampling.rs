//! Where a surface is sampled: regular grids, rasters and spirals.

/// Evenly spaced places along one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridAxis {
    /// The least place, mm.
    pub first_mm: f64,
    /// Distance from one place to the next, mm; positive.
    pub step_mm: f64,
    /// Number of places.
    pub count: usize,
}

impl GridAxis {
    /// Place `k`, mm, counted from 0.
    #[must_use]
    pub fn at(&self, k: usize) -> f64 {
        self.first_mm + self.step_mm * k as f64
    }

    /// The largest place, mm.
    #[must_use]
    pub fn last_mm(&self) -> f64 {
        self.at(self.count - 1)
    }

    /// The same with so many more places before the first and after the last.
    #[must_use]
    pub fn widened(self, places: usize) -> Self {
        let first_mm = self.first_mm - self.step_mm * places as f64;
        Self { first_mm, count: self.count + 2 * places, ..self }
    }

    /// The interval that `x` is in (the end ones reach to infinity), and where in it, from 0 to 1.
    #[inline]
    #[must_use]
    pub fn interval(&self, x: f64) -> (usize, f64) {
        let steps = (x - self.first_mm) / self.step_mm;
        // Saturates, and takes what is not a number to the first.
        let k = (steps.max(0.0) as usize).min(self.count - 2);
        (k, steps - k as f64)
    }

    /// `lo`, the places between, `hi`.
    #[must_use]
    pub fn breaks(&self, lo: f64, hi: f64) -> Vec<f64> {
        let (from, _) = self.interval(lo);
        let (to, _) = self.interval(hi);
        let inner = (from..=to + 1).map(|k| self.at(k)).filter(|&x| lo < x && x < hi);
        std::iter::once(lo).chain(inner).chain([hi]).collect()
    }
}

/// Order in which a scan visits a surface.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ScanPattern {
    /// Lines of increasing X, the one of the least Y first.
    #[default]
    Raster,
    /// Archimedes' spiral about the axis, from the farthest point's radius on the X axis
    /// counter-clockwise inwards.
    Spiral,
}

/// Scan of a surface, in the part frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanPath {
    /// Its lines.
    pub pattern: ScanPattern,
    /// Distance from line to line or from turn to turn, mm; a raster's lines are evenly spaced and no farther
    /// apart than this.
    pub pitch_mm: f64,
    /// Distance from point to point along them, mm.
    pub step_mm: f64,
}
