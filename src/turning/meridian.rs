//! The section of a round mirror with a half-plane through its axis.

use super::TurningError;
use crate::geom::{DVec2, Outline};
use crate::mirror::Mirror;

/// Places along the meridian at which it is looked at for what is steepest and most hollow.
const PLACES: usize = 2000;

/// The meridian of a round mirror, over the chart's distance q from the axis, mm.
#[derive(Debug, Clone, Copy)]
pub struct Meridian<'a> {
    mirror: &'a Mirror,
    /// q at the inner rim, 0 of a disc, and at the outer one.
    ends: [f64; 2],
}

/// A place of a mirror's section with a half-plane through the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeridianPlace {
    /// Distance from the axis, and Z, mm.
    pub at: DVec2,
    /// dZ / d(distance).
    pub slope: f64,
    /// Curvature, 1/mm: positive where the section is hollow, seen from above.
    pub curvature: f64,
}

impl MeridianPlace {
    /// The unit normal towards +Z.
    #[must_use]
    pub fn normal(&self) -> DVec2 {
        DVec2::new(-self.slope, 1.0) / self.stretch()
    }

    /// Length of the section over its length along X: sqrt(1 + slope^2).
    #[must_use]
    pub fn stretch(&self) -> f64 {
        (1.0 + self.slope * self.slope).sqrt()
    }
}

impl<'a> Meridian<'a> {
    /// That of a mirror.
    ///
    /// # Errors
    /// [`TurningError::NotRound`].
    pub fn new(mirror: &'a Mirror) -> Result<Self, TurningError> {
        let refused = |what| Err(TurningError::NotRound { what });
        let Outline::Ring { inner, outer } = mirror.outline else {
            return refused("the mirror's outline is a rectangle");
        };
        if !mirror.surface.is_axisymmetric() {
            return refused(
                "the mirror's height is no function of the distance from the axis alone",
            );
        }
        Ok(Self { mirror, ends: [inner, outer] })
    }

    /// That of a mirror that is known to be round, between two q.
    #[cfg(test)]
    pub(super) fn of_ring(mirror: &'a Mirror, ends: [f64; 2]) -> Self {
        Self { mirror, ends }
    }

    /// q at the inner rim, 0 of a disc, and at the outer one.
    #[must_use]
    pub fn ends(&self) -> [f64; 2] {
        self.ends
    }

    /// Whether the mirror has a flat land in its middle.
    #[must_use]
    pub fn has_land(&self) -> bool {
        self.ends[0] > 0.0
    }

    /// The place over q.
    #[must_use]
    pub fn at(&self, q: f64) -> MeridianPlace {
        let place = self.mirror.local_surface(DVec2::new(q, 0.0));
        // Discs are smooth in their middle.
        let [x, slope] = if q == 0.0 { [0.0; 2] } else { [place.at.x, place.slope.x] };
        let stretch = f64::sqrt(1.0 + slope * slope);
        let curvature = place.hessian.xx / (stretch * stretch * stretch);
        MeridianPlace { at: DVec2::new(x, place.at.z), slope, curvature }
    }

    /// Evenly spaced places from the outer rim to the inner one.
    pub fn places(&self) -> impl Iterator<Item = MeridianPlace> + Clone + '_ {
        let [inner, outer] = self.ends;
        let share = |k: usize| k as f64 / PLACES as f64;
        (0..=PLACES).map(move |k| self.at(outer + share(k) * (inner - outer)))
    }

    /// Largest |slope|.
    #[must_use]
    pub fn steepest(&self) -> f64 {
        self.places().map(|place| place.slope.abs()).fold(0.0, f64::max)
    }
}
