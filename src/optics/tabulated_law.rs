//! Laws given by numbers: elevations at some rows, and a smooth monotone curve through them.

use crate::num::{Lanes, MonotoneCubic, Scalar};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// Quantity that a table interpolates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum TabulatedQuantity {
    Elevation,
    Latitude,
}

/// A law through given points: elevation, or isometric latitude, as a monotone cubic of the image
/// coordinate z (paper's units). Beyond its ends it goes on linearly.
#[derive(Debug, Clone, PartialEq)]
pub struct TabulatedLaw {
    curve: MonotoneCubic,
    quantity: TabulatedQuantity,
}

impl TabulatedLaw {
    /// The law that shows elevation `elevations[k]` (radians, inside +-pi/2) at `z[k]`, elevation
    /// interpolated; None unless both rise strictly and there are two or more.
    #[must_use]
    pub fn from_elevations(z: &[f64], elevations: &[f64]) -> Option<Self> {
        Self::rising(z, elevations, TabulatedQuantity::Elevation)
    }

    /// The law that shows isometric latitude m, tan(elevation) = sinh m, of `latitudes[k]` at
    /// `z[k]`, m interpolated; None unless both rise strictly and there are two or more.
    #[must_use]
    pub fn from_latitudes(z: &[f64], latitudes: &[f64]) -> Option<Self> {
        Self::rising(z, latitudes, TabulatedQuantity::Latitude)
    }

    fn rising(z: &[f64], values: &[f64], quantity: TabulatedQuantity) -> Option<Self> {
        let curve = MonotoneCubic::new(z, values)?;
        (values.first() < values.last()).then_some(Self { curve, quantity })
    }

    /// exp(-m) at image coordinate `z`.
    #[inline]
    pub fn stereographic_radius<S: Scalar>(&self, z: S) -> S {
        let value = z.map(&self.curve);
        match self.quantity {
            TabulatedQuantity::Elevation => (value * -0.5 + FRAC_PI_4).tan(),
            TabulatedQuantity::Latitude => (-value).exp(),
        }
    }

    /// The image coordinate whose exp(-m) is `radius`.
    #[inline]
    pub fn image_coordinate<S: Scalar>(&self, radius: S) -> S {
        let value = match self.quantity {
            TabulatedQuantity::Elevation => radius.atan() * -2.0 + FRAC_PI_2,
            TabulatedQuantity::Latitude => -radius.log(),
        };
        value.map(&self.curve.inverse())
    }

    /// Whether steps in m are steps along the curve.
    #[inline]
    pub(super) fn has_steps(&self) -> bool {
        self.quantity == TabulatedQuantity::Latitude
    }

    /// The image coordinates where m is `step` more than at `z`, but for the last bits; none where one needs the whole
    /// way back.
    #[inline]
    pub(super) fn image_coordinate_beside<const L: usize>(
        &self,
        z: Lanes<L>,
        step: Lanes<L>,
    ) -> Option<Lanes<L>> {
        self.has_steps().then(|| self.curve.inverse().beside(z, step)).flatten()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::sample::Draws;
    use crate::num::{Interval, Jet2, asinh, radians, tan};

    const DEGREES: [f64; 5] = [-41.0, -10.0, 3.0, 4.0, 62.0];
    const Z: [f64; 5] = [-1.0, -0.2, 0.1, 0.3, 1.4];

    fn tables() -> [TabulatedLaw; 2] {
        let e = DEGREES.map(radians);
        let m = e.map(|e| asinh(tan(e)));
        [
            TabulatedLaw::from_elevations(&Z, &e).unwrap(),
            TabulatedLaw::from_latitudes(&Z, &m).unwrap(),
        ]
    }

    #[test]
    fn rungs_are_met_and_the_way_back_is_found() {
        for table in tables() {
            for (z, degrees) in Z.into_iter().zip(DEGREES) {
                let exact = tan(radians(0.5 * (90.0 - degrees)));
                assert!((table.stereographic_radius(z) / exact - 1.0).abs() < 1e-14);
            }
            for k in -120..=150 {
                let z = f64::from(k) / 100.0;
                assert!(
                    (table.image_coordinate(table.stereographic_radius(z)) - z).abs() < 1e-13,
                    "{z}"
                );
            }
        }
    }

    #[test]
    fn bounds_hold_values_and_derivatives_both_ways() {
        for (table, mut r) in tables().iter().zip((0..).map(Draws::new)) {
            let parts = |j: Jet2<f64>| [j.value, j.gradient[0], j.hessian[0]];
            for _ in 0..500 {
                let range = r.range([-1.2, 1.5]);
                let over = Jet2::variable_x(Interval::new(range[0], range[1]));
                let radius = table.stereographic_radius(over);
                let back = table.image_coordinate(Jet2::variable_x(radius.value));
                for _ in 0..4 {
                    let found = table.stereographic_radius(Jet2::variable_x(r.inside(range)));
                    let undone = table.image_coordinate(Jet2::variable_x(found.value));
                    for (over, at) in [(radius, parts(found)), (back, parts(undone))] {
                        assert!(over.value.contains(at[0]), "{at:?} {over:?}");
                        assert!(over.gradient[0].contains(at[1]), "{at:?} {over:?}");
                        assert!(over.hessian[0].contains(at[2]), "{at:?} {over:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn what_does_not_rise_is_no_ladder() {
        assert!(TabulatedLaw::from_elevations(&[0.0, 1.0], &[0.1, 0.0]).is_none());
        assert!(TabulatedLaw::from_latitudes(&[0.0, 0.0], &[0.0, 0.1]).is_none());
        assert!(TabulatedLaw::from_latitudes(&[0.0], &[0.1]).is_none());
    }
}
