//! Laws: how an image row maps to elevation.
//!
//! Every law is read against one coordinate, the *isometric latitude* m with tan e = sinh m
//! (Mercator's own image coordinate): the slope a vertical camera ray needs is exp(-m) long, and
//! `z(m)` says where the law puts it in the image. Image coordinates are in the paper's units
//! (one per radian of azimuth).

use crate::num::{asinh, cosh, exp, hypot, sinh, tan, tanh};

/// The law of the rows of a cylindrical panorama.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Law {
    /// tan e = z: the paper's projection onto a cylinder.
    Cylindrical,
    /// tan e = sinh z: conformal.
    Mercator,
}

impl Law {
    /// (sin e, cos e) of the elevation that image coordinate `z` must see.
    #[inline]
    #[must_use]
    pub fn elevation(self, z: f64) -> [f64; 2] {
        match self {
            Self::Cylindrical => {
                let far = hypot(1.0, z);
                [z / far, 1.0 / far]
            }
            Self::Mercator => [tanh(z), 1.0 / cosh(z)],
        }
    }

    /// Image coordinate of the direction with the given `tan e`.
    #[inline]
    #[must_use]
    pub fn image_of_tangent(self, tan_e: f64) -> f64 {
        match self {
            Self::Cylindrical => tan_e,
            Self::Mercator => asinh(tan_e),
        }
    }

    /// Image coordinate of elevation `e` (radians, inside +-pi/2).
    #[must_use]
    pub fn image_of_elevation(self, e: f64) -> f64 {
        self.image_of_tangent(tan(e))
    }

    /// Length E = exp(-m) = cos e / (1 + sin e) of the slope at image coordinate `z`, to a few
    /// ulps for every z. (The paper's 1/(z + sqrt(1 + z^2)); its other form, sqrt(1 + z^2) - z,
    /// loses every digit for large z.)
    #[inline]
    #[must_use]
    pub fn slope(self, z: f64) -> f64 {
        match self {
            Self::Cylindrical if z > 0.0 => 1.0 / (z + hypot(1.0, z)),
            Self::Cylindrical => hypot(1.0, z) - z,
            Self::Mercator => exp(-z),
        }
    }

    /// dE/dz.
    #[inline]
    #[must_use]
    pub fn slope_derivative(self, z: f64) -> f64 {
        match self {
            Self::Cylindrical => -self.slope(z) / hypot(1.0, z),
            Self::Mercator => -self.slope(z),
        }
    }

    /// (sup |dz/dm|, sup |d^2 z/dm^2|) over the isometric latitudes `lo`..=`hi`.
    #[inline]
    #[must_use]
    pub fn stretch(self, lo: f64, hi: f64) -> [f64; 2] {
        let far = lo.abs().max(hi.abs());
        match self {
            Self::Cylindrical => [cosh(far), sinh(far)],
            Self::Mercator => [1.0, 0.0],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        for (law, table) in [(Law::Cylindrical, &CYLINDRICAL[..]), (Law::Mercator, &MERCATOR[..])] {
            for &(z, slope, cos_e) in table {
                assert!(close(law.slope(z), slope, 3.0), "{law:?} {z}: {}", law.slope(z));
                assert!(close(law.elevation(z)[1], cos_e, 3.0), "{law:?} {z}");
            }
        }
    }

    #[test]
    fn image_inverts_elevation() {
        for law in [Law::Cylindrical, Law::Mercator] {
            for z in [-5.0, -0.6, -1e-8, 0.0, 0.3, 2.0, 5.0] {
                let [sin_e, cos_e] = law.elevation(z);
                let back = law.image_of_tangent(sin_e / cos_e);
                assert!((back - z).abs() < 1e-14 * z.abs().max(1e-3), "{law:?} {z}: {back}");
            }
        }
    }

    #[test]
    fn slope_is_the_half_angle_tangent_and_has_its_derivative() {
        for law in [Law::Cylindrical, Law::Mercator] {
            for z in [-3.0, -0.5, 0.0, 0.7, 4.0] {
                let [sin_e, cos_e] = law.elevation(z);
                assert!(close(law.slope(z) * (1.0 + sin_e), cos_e, 64.0));
                let h = 1e-6;
                let central = (law.slope(z + h) - law.slope(z - h)) / (2.0 * h);
                assert!((central - law.slope_derivative(z)).abs() < 1e-8 * law.slope(z));
            }
        }
    }

    #[test]
    fn stretch_bounds_the_law_against_isometric_latitude() {
        let h = 1e-4;
        for law in [Law::Cylindrical, Law::Mercator] {
            let image = |m: f64| law.image_of_tangent(sinh(m));
            let [first, second] = law.stretch(-0.4, 1.1);
            for k in 0..=15 {
                let m = -0.4 + 0.1 * f64::from(k);
                let d = (image(m + h) - image(m - h)) / (2.0 * h);
                let dd = (image(m + h) - 2.0 * image(m) + image(m - h)) / (h * h);
                assert!(d.abs() <= first + 1e-6 && dd.abs() <= second + 1e-6, "{law:?} {m}");
            }
        }
    }
}
