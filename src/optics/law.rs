//! Laws of a strip: how an image row maps to elevation.
//!
//! Every law is read as E(z) = exp(-m), the length of the stereographic coordinate of what row z
//! sees (m: isometric latitude, tan e = sinh m), and back. Image coordinates are in the paper's
//! units (one per radian of azimuth).

use super::TabulatedLaw;
use crate::num::{Lanes, Scalar, radians, tan};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
use std::sync::Arc;

/// The law of the rows of a panorama.
#[derive(Debug, Clone, PartialEq)]
pub enum StripLaw {
    /// tan e = z: the paper's projection onto a cylinder.
    Cylindrical,
    /// tan e = sinh z: conformal.
    Mercator,
    /// e = z.
    Equirectangular,
    /// sin e = z: equal solid angle per pixel.
    EqualArea,
    /// Through given points.
    Tabulated(Arc<TabulatedLaw>),
}

impl StripLaw {
    /// E = exp(-m) = cos e / (1 + sin e) at image coordinate `z`, to a few ulps. (For the paper's
    /// law 1 / (z + sqrt(1 + z^2)); its other form, sqrt(1 + z^2) - z, loses every digit for large
    /// z.)
    #[inline]
    pub fn stereographic_radius<S: Scalar>(&self, z: S) -> S {
        match self {
            Self::Cylindrical if z.mid() > 0.0 => {
                S::constant(1.0) / (z + (z.square() + 1.0).sqrt())
            }
            Self::Cylindrical => (z.square() + 1.0).sqrt() - z,
            Self::Mercator => (-z).exp(),
            Self::Equirectangular => (-z * 0.5 + FRAC_PI_4).tan(),
            Self::EqualArea => ((-z + 1.0) / (z + 1.0)).sqrt(),
            Self::Tabulated(table) => table.stereographic_radius(z),
        }
    }

    /// The image coordinate whose E is `radius`.
    #[inline]
    pub fn image_coordinate<S: Scalar>(&self, radius: S) -> S {
        match self {
            Self::Cylindrical => (S::constant(1.0) / radius - radius) * 0.5,
            Self::Mercator => -radius.log(),
            Self::Equirectangular => radius.atan() * -2.0 + FRAC_PI_2,
            Self::EqualArea => {
                let w = radius.square();
                (-w + 1.0) / (w + 1.0)
            }
            Self::Tabulated(table) => table.image_coordinate(radius),
        }
    }

    /// Whether there is a way along the picture that is shorter than [`Self::image_coordinate`].
    #[inline]
    pub(super) fn has_steps(&self) -> bool {
        match self {
            Self::Cylindrical | Self::Mercator => true,
            Self::Equirectangular | Self::EqualArea => false,
            Self::Tabulated(table) => table.has_steps(),
        }
    }

    /// The image coordinates where the isometric latitude is `step`, at most 1 / 32, more than at `z`, but for the last bits;
    /// none where one needs [`Self::image_coordinate`].
    #[inline(always)]
    #[must_use]
    pub(super) fn image_coordinate_beside<const L: usize>(
        &self,
        z: Lanes<L>,
        step: Lanes<L>,
    ) -> Option<Lanes<L>> {
        match self {
            Self::Mercator => Some(z + step),
            Self::Cylindrical => {
                // sinh(m + step), by the series of both functions of the step.
                let square = step * step;
                let cosine_less_1 = square * ((square * (1.0 / 720.0) + 1.0 / 24.0) * square + 0.5);
                let over_step =
                    ((square * (1.0 / 5040.0) + 1.0 / 120.0) * square + 1.0 / 6.0) * square + 1.0;
                let cosine = Lanes(z.0.map(|z| (1.0 + z * z).sqrt()));
                Some(z + (z * cosine_less_1 + cosine * (over_step * step)))
            }
            Self::Tabulated(table) => table.image_coordinate_beside(z, step),
            Self::Equirectangular | Self::EqualArea => None,
        }
    }

    /// The image coordinate of the pole, for laws that reach it.
    #[must_use]
    pub fn pole_coordinate(&self) -> Option<f64> {
        match self {
            Self::Equirectangular => Some(FRAC_PI_2),
            Self::EqualArea => Some(1.0),
            _ => None,
        }
    }

    /// Image coordinate of an elevation in degrees, inside +-90.
    #[must_use]
    pub fn image_of_degrees(&self, elevation: f64) -> f64 {
        self.image_coordinate(tan(radians(0.5 * (90.0 - elevation))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::{asinh, sin};

    fn close(found: f64, exact: f64, ulps: f64) -> bool {
        (found - exact).abs() <= ulps * f64::EPSILON * exact.abs()
    }

    /// (z, exp(-asinh z), 1/sqrt(1 + z^2)) in 40-digit arithmetic (mpmath).
    #[rustfmt::skip]
    #[expect(clippy::excessive_precision, reason = "as the other program printed them")]
    const CYLINDRICAL: [(f64, f64, f64); 14] = [
        (-1000000.0, 2000000.0000005, 9.999999999995e-7),
        (-30000.0, 60000.000016666666662, 0.00003333333331481481483),
        (-577.25, 1154.5008661751838376, 0.0017323490679640148728),
        (-10.0, 20.04987562112089027, 0.099503719020998913567),
        (-0.5773502691896257, 1.7320508075688772434, 0.86602540378443865931),
        (-0.001, 1.0010004999998750001, 0.99999950000037499969),
        (0.0, 1.0, 1.0),
        (1e-09, 0.9999999990000000005, 0.9999999999999999995),
        (0.5890486225480862, 0.57154531148991217171, 0.86162780165561294287),
        (3.0, 0.162277660168379332, 0.3162277660168379332),
        (40.0, 0.01249804748511324818, 0.024992191160203068862),
        (1000.0, 0.00049999987500006249996, 0.00099999950000037499969),
        (123456.75, 4.0500013161839975916e-6, 8.1000026322351348037e-6),
        (1000000.0, 4.99999999999875e-7, 9.999999999995e-7),
    ];

    /// (z, exp(-z), 1/cosh z) in 40-digit arithmetic (mpmath).
    #[rustfmt::skip]
    #[expect(clippy::excessive_precision, reason = "as the other program printed them")]
    const MERCATOR: [(f64, f64, f64); 10] = [
        (-700.0, 1.0142320547350045095e+304, 1.9719353087519541713e-304),
        (-20.5, 799902177.4755054067, 2.500305732773485254e-9),
        (-1.5, 4.4816890703380648226, 0.42509603494228046092),
        (-0.125, 1.1331484530668263168, 0.99223804147512576124),
        (0.0, 1.0, 1.0),
        (0.25, 0.77880078307140486825, 0.96954362914021458505),
        (2.25, 0.10539922456186433678, 0.20848241865658825143),
        (19.0, 5.60279643753726754e-9, 1.1205592875074534728e-8),
        (300.0, 5.1482002224120137812e-131, 1.0296400444824027562e-130),
        (700.0, 9.8596765437597708567e-305, 1.9719353087519541713e-304),
    ];

    #[test]
    fn law_forms_lose_no_digits() {
        for (law, table) in
            [(StripLaw::Cylindrical, &CYLINDRICAL[..]), (StripLaw::Mercator, &MERCATOR[..])]
        {
            for &(z, radius, cos_e) in table {
                let found = law.stereographic_radius(z);
                assert!(close(found, radius, 3.0), "{law:?} {z}: {found}");
                if (1e-150..1e150).contains(&found) {
                    assert!(close(2.0 / (found + 1.0 / found), cos_e, 4.0), "{law:?} {z}");
                }
            }
        }
    }

    const LAWS: [StripLaw; 4] =
        [StripLaw::Cylindrical, StripLaw::Mercator, StripLaw::Equirectangular, StripLaw::EqualArea];

    #[test]
    fn every_law_puts_an_elevation_where_its_definition_says() {
        for degrees in [-89.9, -60.0, -30.0, -1e-6, 0.0, 12.5, 45.0, 89.9] {
            let e = radians(degrees);
            let exact = [tan(e), asinh(tan(e)), e, sin(e)];
            for (law, exact) in LAWS.into_iter().zip(exact) {
                let z = law.image_of_degrees(degrees);
                assert!(
                    (z - exact).abs() < 1e-12 * exact.abs().max(1e-3),
                    "{law:?} {degrees}: {z}"
                );
            }
        }
    }

    #[test]
    fn image_inverts_shrink() {
        for law in LAWS {
            for z in [-0.95, -0.6, -1e-8, 0.0, 0.3, 0.99] {
                let back = law.image_coordinate(law.stereographic_radius(z));
                assert!((back - z).abs() < 1e-14, "{law:?} {z}: {back}");
            }
        }
    }
}
