//! Random numbers by counter: number `draw` of stream (`trial`, `source`) of a seed is a function of
//! these four alone, so that any part of a run can be repeated, or done elsewhere.
//!
//! Philox 4x32-10: J. Salmon, M. Moraes, R. Dror and D. Shaw, *Parallel random numbers: as easy as
//! 1, 2, 3*, SC11.

use super::{exp, log};

/// The Philox 4x32-10 block of `counter` under `key`.
#[inline]
#[must_use]
pub fn philox(counter: [u32; 4], key: [u32; 2]) -> [u32; 4] {
    let wide = |a: u32, b: u32| {
        let product = u64::from(a) * u64::from(b);
        ((product >> 32) as u32, product as u32)
    };
    let ([mut c0, mut c1, mut c2, mut c3], [mut k0, mut k1]) = (counter, key);
    for _ in 0..10 {
        let (hi0, lo0) = wide(0xd251_1f53, c0);
        let (hi1, lo1) = wide(0xcd9e_8d57, c2);
        [c0, c1, c2, c3] = [hi1 ^ c1 ^ k0, lo1, hi0 ^ c3 ^ k1, lo0];
        k0 = k0.wrapping_add(0x9e37_79b9);
        k1 = k1.wrapping_add(0xbb67_ae85);
    }
    [c0, c1, c2, c3]
}

/// The random numbers of one trial.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RandomStream {
    /// Of the whole run.
    pub seed: u64,
    /// Number of the trial.
    pub trial: u64,
}

impl RandomStream {
    /// Two independent numbers, uniform in (0, 1), of 52 bits each.
    #[inline]
    #[must_use]
    pub fn pair(&self, source: u32, draw: u32) -> [f64; 2] {
        let halves = |x: u64| [x as u32, (x >> 32) as u32];
        let [lo, hi] = halves(self.trial);
        let [a, b, c, d] = philox([draw, source, lo, hi], halves(self.seed));
        [unit(a, b), unit(c, d)]
    }

    /// Two independent numbers of the standard normal distribution.
    #[inline]
    #[must_use]
    pub fn normals(&self, source: u32, draw: u32) -> [f64; 2] {
        self.pair(source, draw).map(normal_quantile)
    }
}

/// A number inside (0, 1) of random bits: the middle of one of 2^52 intervals, which is exact.
#[inline]
fn unit(a: u32, b: u32) -> f64 {
    let bits = ((u64::from(a) << 32) | u64::from(b)) >> 12;
    (bits as f64 + 0.5) / (1u64 << 52) as f64
}

/// Share of the standard normal distribution below `x`.
#[must_use]
pub fn normal_cdf(x: f64) -> f64 {
    0.5 * libm::erfc(-x * std::f64::consts::FRAC_1_SQRT_2)
}

/// The number below which the share `p`, inside (0, 1), of the standard normal distribution lies:
/// P. Acklam's rational approximation (relative error 1.2e-9) and one step of Halley's method.
#[must_use]
pub fn normal_quantile(p: f64) -> f64 {
    const A: [f64; 6] = [
        -3.969_683_028_665_376e1,
        2.209_460_984_245_205e2,
        -2.759_285_104_469_687e2,
        1.383_577_518_672_69e2,
        -3.066_479_806_614_716e1,
        2.506_628_277_459_239,
    ];
    const B: [f64; 6] = [
        -5.447_609_879_822_406e1,
        1.615_858_368_580_409e2,
        -1.556_989_798_598_866e2,
        6.680_131_188_771_972e1,
        -1.328_068_155_288_572e1,
        1.0,
    ];
    const C: [f64; 6] = [
        -7.784_894_002_430_293e-3,
        -3.223_964_580_411_365e-1,
        -2.400_758_277_161_838,
        -2.549_732_539_343_734,
        4.374_664_141_464_968,
        2.938_163_982_698_783,
    ];
    const D: [f64; 5] = [
        7.784_695_709_041_462e-3,
        3.224_671_290_700_398e-1,
        2.445_134_137_142_996,
        3.754_408_661_907_416,
        1.0,
    ];
    let horner = |c: &[f64], x: f64| c.iter().fold(0.0, |sum, c| sum * x + c);
    let tail = |p: f64| {
        let q = (-2.0 * log(p)).sqrt();
        horner(&C, q) / horner(&D, q)
    };
    const TAIL: f64 = 0.024_25;
    // By the nearer end, where shares keep their digits.
    if p > 0.5 {
        return -normal_quantile(1.0 - p);
    }
    let x = if p < TAIL {
        tail(p)
    } else {
        let q = p - 0.5;
        q * horner(&A, q * q) / horner(&B, q * q)
    };
    let off = (normal_cdf(x) - p) * (2.0 * std::f64::consts::PI).sqrt() * exp(0.5 * x * x);
    x - off / (1.0 + 0.5 * x * off)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The known answers of the authors' Random123 library.
    #[test]
    fn blocks_are_those_of_the_authors() {
        let known = [
            ([0; 4], [0; 2], [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]),
            ([u32::MAX; 4], [u32::MAX; 2], [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]),
            (
                [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344],
                [0xa409_3822, 0x299f_31d0],
                [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1],
            ),
        ];
        for (counter, key, block) in known {
            assert_eq!(philox(counter, key), block);
        }
    }

    #[test]
    fn numbers_stay_inside_their_ends() {
        let [least, most] = [0, u32::MAX].map(|bits| unit(bits, bits));
        assert!(least > 0.0 && most < 1.0 && least == 1.0 - most, "{least:e} {most}");
        assert!([least, most].iter().all(|p| normal_quantile(*p).is_finite()));
    }

    /// Quantiles to 16 digits, from 40-digit arithmetic (mpmath).
    #[test]
    fn quantiles_are_those_of_the_normal_distribution() {
        for (p, x) in [
            (0.5, 0.0),
            (0.975, 1.959_963_984_540_054_2),
            (0.001, -3.090_232_306_167_813_5),
            (0.9, 1.281_551_565_544_600_5),
            (1e-10, -6.361_340_902_404_056),
        ] {
            assert!((normal_quantile(p) - x).abs() < 3e-15 * (1.0 + x.abs()), "{p}");
        }
        for k in 1..400 {
            let p = f64::from(k) / 400.0;
            assert!((normal_cdf(normal_quantile(p)) / p - 1.0).abs() < 1e-14, "{p}");
        }
    }

    #[test]
    fn draws_have_the_moments_of_their_distribution_and_do_not_follow_each_other() {
        let (n, mut sums, mut across) = (100_000, [0.0; 4], 0.0);
        for trial in 0..n {
            let stream = RandomStream { seed: 7, trial };
            let [a, b] = stream.normals(3, 0);
            let [next, _] = RandomStream { seed: 7, trial: trial + 1 }.normals(3, 0);
            let mut power = 1.0;
            for sum in &mut sums {
                power *= a;
                *sum += power / n as f64;
            }
            across += (a * b + a * next + a * stream.normals(4, 0)[0]) / n as f64;
        }
        // Five standard errors.
        let allowed = |variance: f64| 5.0 * (variance / n as f64).sqrt();
        for (moment, (exact, variance)) in
            sums.into_iter().zip([(0.0, 1.0), (1.0, 2.0), (0.0, 15.0), (3.0, 96.0)])
        {
            assert!((moment - exact).abs() < allowed(variance), "{moment} {exact}");
        }
        assert!(across.abs() < allowed(3.0), "{across}");
    }
}
