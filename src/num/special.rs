//! The special functions of [`Scalar`] as curves: with two derivatives, without
//! cancellation near 0.

use super::interval::Interval;
use super::scalar::{Scalar, SmoothFn};

/// Error of the series below, generously, as a share of their sums.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

/// (1 - exp(-x)) / x.
#[derive(Debug, Clone, Copy)]
pub struct OneMinusExpOverX;
/// log(1 + x) / x.
#[derive(Debug, Clone, Copy)]
pub struct Ln1pOverX;
/// tan(sqrt x) / sqrt x, with its continuation from -1/2 to 0.
#[derive(Debug, Clone, Copy)]
pub struct TanOverRoot;
/// atan(sqrt x) / sqrt x, with its continuation from -1/4 to 0.
#[derive(Debug, Clone, Copy)]
pub struct AtanOverRoot;

/// A function of which every derivative is monotone on its domain. That holds
///
/// - falling, rising, falling ... for integrals over s in [0, 1] of exp(-x s), 1 / (1 + x s) and
///   1 / (1 + x s^2), since each integrand does so for every s: these are `OneMinusExpOverX`,
///   `Ln1pOverX` and `AtanOverRoot`;
/// - always rising for the sum over odd n of 2 / ((n pi / 2)^2 - x), below its first pole, since
///   each term does so: this is `TanOverRoot`.
trait Special {
    const RISING: bool;
    /// (f, f', f'') near 0, where the closed form cancels; NaNs below the domain.
    fn series(x: f64) -> Option<[f64; 3]>;
    /// (f, f', f'') elsewhere, by the differential equation that gives each from the one before.
    fn closed<T: Scalar>(x: T) -> [T; 3];
}

impl<S: Special> SmoothFn for S {
    fn at(&self, x: f64) -> [f64; 3] {
        S::series(x).unwrap_or_else(|| S::closed(x))
    }

    fn over(&self, range: [f64; 2]) -> [[f64; 2]; 3] {
        let [first, last] = range.map(|x| match S::series(x) {
            Some(f) => f.map(|f| Interval::around(f, ROUNDING * f.abs())),
            None => S::closed(Interval::point(x)),
        });
        std::array::from_fn(|k| {
            let ends = if S::RISING || k == 1 { (first[k], last[k]) } else { (last[k], first[k]) };
            if ends.0.is_finite() && ends.1.is_finite() {
                [ends.0.lo, ends.1.hi]
            } else {
                [f64::NEG_INFINITY, f64::INFINITY]
            }
        })
    }
}

/// (f, f', f'') of the power series with the given coefficients.
fn power_series(coefficients: &[f64], x: f64) -> [f64; 3] {
    let (mut f, mut d, mut dd) = (0.0, 0.0, 0.0);
    for c in coefficients.iter().rev() {
        dd = dd * x + d;
        d = d * x + f;
        f = f * x + c;
    }
    [f, d, 2.0 * dd]
}

impl Special for OneMinusExpOverX {
    const RISING: bool = false;

    fn series(x: f64) -> Option<[f64; 3]> {
        // (-1)^k / (k + 1)!
        const TERMS: [f64; 23] = {
            let mut c = [1.0; 23];
            let mut k = 1;
            while k < c.len() {
                c[k] = -c[k - 1] / (k + 1) as f64;
                k += 1;
            }
            c
        };
        (x.abs() <= 1.0).then(|| power_series(&TERMS, x))
    }

    fn closed<T: Scalar>(x: T) -> [T; 3] {
        let (f, e) = (x.one_minus_exp_over_x(), (-x).exp());
        let d = (e - f) / x;
        [f, d, -(e + d * 2.0) / x]
    }
}

impl Special for Ln1pOverX {
    const RISING: bool = false;

    fn series(x: f64) -> Option<[f64; 3]> {
        // With t = x / (2 + x), log(1 + x) is 2 artanh t: sums of t^2k / (2k + 1), and of
        // t^2k / (2k + 3).
        let t = x / (2.0 + x);
        (t.abs() <= 0.34).then(|| {
            let (mut a, mut b) = (0.0, 0.0);
            for k in (0..19u32).rev() {
                a = a * t * t + 1.0 / f64::from(2 * k + 1);
                b = b * t * t + 1.0 / f64::from(2 * k + 3);
            }
            let (less, more) = (1.0 - t, 1.0 + t);
            [
                less * a,
                -less * less * (a + t * b) / (2.0 * more),
                less * less * less * (a + b + 2.0 * t * b) / (2.0 * more * more),
            ]
        })
    }

    fn closed<T: Scalar>(x: T) -> [T; 3] {
        let (f, q) = (x.ln_1p_over_x(), T::constant(1.0) / (x + 1.0));
        let d = (q - f) / x;
        [f, d, -(q.square() + d * 2.0) / x]
    }
}

impl Special for TanOverRoot {
    const RISING: bool = true;

    fn series(x: f64) -> Option<[f64; 3]> {
        // 2 x f' + f = 1 + x f^2.
        const TERMS: [f64; 33] = {
            let mut c = [1.0; 33];
            let mut k = 1;
            while k < c.len() {
                let (mut sum, mut i) = (0.0, 0);
                while i < k {
                    sum += c[i] * c[k - 1 - i];
                    i += 1;
                }
                c[k] = sum / (2 * k + 1) as f64;
                k += 1;
            }
            c
        };
        if x < -0.5 {
            return Some([f64::NAN; 3]);
        }
        (x <= 0.5).then(|| power_series(&TERMS, x))
    }

    fn closed<T: Scalar>(x: T) -> [T; 3] {
        let f = x.tan_over_root();
        let (square, twice) = (f.square(), x * 2.0);
        let d = (x * square + 1.0 - f) / twice;
        [f, d, (square + d * (twice * f - 3.0)) / twice]
    }
}

impl Special for AtanOverRoot {
    const RISING: bool = false;

    fn series(x: f64) -> Option<[f64; 3]> {
        // In u = x / (1 + x): 1 minus the sum of g_k u^k / (2k + 1), where g_k is the product of
        // 2i / (2i + 1) over 0 < i < k.
        const TERMS: [f64; 42] = {
            let mut c = [1.0; 42];
            let (mut g, mut k) = (1.0, 1);
            while k < c.len() {
                c[k] = -g / (2 * k + 1) as f64;
                g *= (2 * k) as f64 / (2 * k + 1) as f64;
                k += 1;
            }
            c
        };
        if x < -0.25 {
            return Some([f64::NAN; 3]);
        }
        (x <= 0.5).then(|| {
            let [f, d, dd] = power_series(&TERMS, x / (1.0 + x));
            let slope = 1.0 / ((1.0 + x) * (1.0 + x));
            [f, d * slope, slope * (dd * slope - 2.0 * d / (1.0 + x))]
        })
    }

    fn closed<T: Scalar>(x: T) -> [T; 3] {
        let (f, q) = (x.atan_over_root(), T::constant(1.0) / (x + 1.0));
        let twice = x * 2.0;
        let d = (q - f) / twice;
        [f, d, -(q.square() + d * 3.0) / twice]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::sample::Draws;

    type Row = (f64, [f64; 3]);

    // By mpmath, at sixty digits.
    const FADE: [Row; 11] = [
        (-30.0, [356215819384.1154, -344341958738.01154, 333259688801.6146]),
        (-1.5, [2.321126046892043, -1.4403753489640143, 1.0672922482733573]),
        (-1.0, [1.718281828459045, -1.0, 0.7182818284590452]),
        (-0.3, [1.1661960252533436, -0.6122092744088647, 0.41813419586091205]),
        (-1e-09, [1.0000000005, -0.5000000003333334, 0.33333333358333334]),
        (1e-05, [0.9999950000166666, -0.49999666667916665, 0.3333308333433333]),
        (0.25, [0.8847968677143805, -0.42398433857190265, 0.2766715762896016]),
        (1.0, [0.6321205588285577, -0.2642411176571154, 0.16060279414278839]),
        (1.0625, [0.6159145858099063, -0.2544224312780535, 0.15365092703918348]),
        (5.0, [0.1986524106001829, -0.03838289272021949, 0.014005567688270703]),
        (700.0, [0.0014285714285714286, -2.040816326530612e-06, 5.830903790087464e-09]),
    ];
    const LOG_OVER: [Row; 10] = [
        (-0.999, [6.914669948931067, -994.0794094605286, 999010.8520331103]),
        (-0.75, [1.8483924814931876, -2.86881002467575, 13.683173267531332]),
        (-0.5, [1.3862943611198906, -1.2274112777602189, 3.090354888959125]),
        (-0.25, [1.1507282898071236, -0.7304201741048385, 1.2677497182724031]),
        (-1e-09, [1.0000000005, -0.5000000006666667, 0.6666666681666666]),
        (1e-05, [0.9999950000333331, -0.4999933334083325, 0.6666516669066633]),
        (0.5, [0.8109302162163288, -0.28852709909932417, 0.2652195075084079]),
        (1.0625, [0.6813353780957166, -0.18492884070327703, 0.12685141472628955]),
        (5.0, [0.358351893845611, -0.03833704543578887, 0.009779262618759992]),
        (1000000.0, [1.3815511557963774e-05, -1.2815512557962773e-11, 2.4631027115922548e-17]),
    ];
    const TAN_OVER_ROOT: [Row; 10] = [
        (-0.5, [0.8610571715805476, 0.23176689794569397, 0.15344579071790596]),
        (-0.25, [0.9242343145200195, 0.2755731631081842, 0.19971501588193072]),
        (-1e-09, [0.9999999996666666, 0.3333333330666667, 0.26666666634285713]),
        (1e-05, [1.0000033333466667, 0.33333600001619057, 0.26666990478814834]),
        (0.25, [1.092604979687581, 0.4116828614438876, 0.36728085907849706]),
        (0.5, [1.2084602421372714, 0.521727836275965, 0.5256799953543855]),
        (0.53125, [1.2250250566214627, 0.5385549060903029, 0.5515283565195193]),
        (1.0, [1.5574077246549023, 0.9340555480799287, 1.2663814141239362]),
        (2.0, [4.47889861585922, 9.160541751608012, 39.17386466087812]),
        (2.4375, [67.08963541695748, 2236.9527418994803, 149623.04358201116]),
    ];
    const ATAN_OVER_ROOT: [Row; 9] = [
        (-0.25, [1.0986122886681098, -0.4694420893304473, 0.7389030195728719]),
        (-0.125, [1.0451009147609598, -0.3910249123847324, 0.5321908473015786]),
        (-1e-09, [1.0000000003333334, -0.33333333373333335, 0.4000000008571429]),
        (1e-05, [0.9999966666866665, -0.33332933337619003, 0.39999142870476007]),
        (0.25, [0.9272952180016122, -0.25459043600322445, 0.2475426160193468]),
        (0.5, [0.8704197513671031, -0.20375308470043654, 0.16681480965686515]),
        (0.53125, [0.8641327115117708, -0.1986555171971529, 0.15950831873820903]),
        (2.0, [0.67551085885604, -0.08554438138067666, 0.03638050825772972]),
        (1000000.0, [0.0015697963271282297, -7.843981640641144e-10, 1.17609724709617e-15]),
    ];

    fn check(curve: &impl SmoothFn, table: &[Row], value: fn(f64) -> f64, domain: [f64; 2]) {
        for &(x, exact) in table {
            let found = curve.at(x);
            let over = curve.over([x, x]);
            for k in 0..3 {
                // The tangent's own condition grows towards its pole.
                let tolerance = if x == 2.4375 { 1e-12 } else { 2e-14 };
                let error = (found[k] / exact[k] - 1.0).abs();
                assert!(error < tolerance, "order {k} at {x}: {error:e}");
                assert!(over[k][0] <= exact[k] && exact[k] <= over[k][1], "order {k} at {x}");
                assert!((over[k][1] - over[k][0]) < 10.0 * tolerance * exact[k].abs());
            }
        }
        for mut r in (0..5000).map(Draws::new) {
            let range = r.range(domain);
            let over = curve.over(range);
            for _ in 0..8 {
                let x = r.inside(range);
                let found = curve.at(x);
                assert!((found[0] / value(x) - 1.0).abs() < 1e-13, "{x}");
                for k in 0..3 {
                    assert!(over[k][0] <= found[k] && found[k] <= over[k][1], "order {k} at {x}");
                }
            }
        }
    }

    #[test]
    fn special_functions_match_the_table_and_keep_to_their_ranges() {
        check(&OneMinusExpOverX, &FADE, f64::one_minus_exp_over_x, [-20.0, 50.0]);
        check(&Ln1pOverX, &LOG_OVER, f64::ln_1p_over_x, [-0.999, 50.0]);
        check(&TanOverRoot, &TAN_OVER_ROOT, f64::tan_over_root, [-0.5, 2.46]);
        check(&AtanOverRoot, &ATAN_OVER_ROOT, f64::atan_over_root, [-0.25, 50.0]);
    }

    #[test]
    fn below_their_domains_they_are_no_numbers() {
        assert!(TanOverRoot.at(-0.6)[1].is_nan() && AtanOverRoot.at(-0.3)[0].is_nan());
        assert!((-0.6).tan_over_root().is_nan() && (-0.3).atan_over_root().is_nan());
    }
}
