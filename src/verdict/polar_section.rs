//! What is left of a face along one azimuth.

use crate::program::TurnedSection;

/// What is left along one azimuth, by a nose or by a ball.
pub(super) trait PolarSection {
    /// Distances of the cusps from the axis, rising, mm.
    fn cusps_mm(&self) -> Vec<f64>;

    /// Z of the cut at a distance from the axis, mm, and the move that cuts there; none where none does.
    fn cut(&self, radius_mm: f64) -> Option<(f64, usize)>;

    /// The same without the cusps, as far as it is known.
    fn without_cusps(&self, radius_mm: f64) -> Option<(f64, usize)> {
        self.cut(radius_mm)
    }

    /// Distance from the axis, mm, Z and move of the cusp that is the nearest to a distance from the axis; none where it is not known.
    fn cusp_beside(&self, _radius_mm: f64) -> Option<(f64, f64, usize)> {
        None
    }

    /// The same of a cusp that is left out of [`Self::cut`].
    fn left_out(&self, _radius_mm: f64) -> Option<(f64, f64, usize)> {
        None
    }
}

impl PolarSection for TurnedSection {
    fn cusps_mm(&self) -> Vec<f64> {
        self.cusps().collect()
    }

    fn cut(&self, radius_mm: f64) -> Option<(f64, usize)> {
        self.lowest(radius_mm).map(|place| (place.z_mm, place.step))
    }

    fn without_cusps(&self, radius_mm: f64) -> Option<(f64, usize)> {
        TurnedSection::without_cusps(self, radius_mm).map(|place| (place.z_mm, place.step))
    }

    fn cusp_beside(&self, radius_mm: f64) -> Option<(f64, f64, usize)> {
        let (at, place) = TurnedSection::cusp_beside(self, radius_mm)?;
        Some((at, place.z_mm, place.step))
    }
}
