//! What is left of a face along one azimuth.

use crate::program::TurnedSection;

/// What is left along one azimuth, by a nose or by a ball.
pub(super) trait PolarSection {
    /// Distances of the cusps from the axis, rising, mm.
    fn cusps_mm(&self) -> Vec<f64>;

    /// Z of the cut at a distance from the axis, mm, and the move that cuts there; none where none does.
    fn cut(&self, radius_mm: f64) -> Option<(f64, usize)>;
}

impl PolarSection for TurnedSection {
    fn cusps_mm(&self) -> Vec<f64> {
        self.cusps().collect()
    }

    fn cut(&self, radius_mm: f64) -> Option<(f64, usize)> {
        self.lowest(radius_mm).map(|place| (place.z_mm, place.step))
    }
}
