//! The block that a part is milled of.

use crate::geom::DVec2;

/// A block of which a part is milled: a box on the plane Z = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StockBlock {
    /// Its least X and Y, mm.
    pub min: DVec2,
    /// Its largest.
    pub max: DVec2,
    /// Z of its top, mm.
    pub top_mm: f64,
}

impl StockBlock {
    pub(super) fn corners(&self) -> [DVec2; 4] {
        let Self { min, max, .. } = *self;
        [min, max, DVec2::new(min.x, max.y), DVec2::new(max.x, min.y)]
    }
}
