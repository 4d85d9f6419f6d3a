//! Intervals hold what they must, and little more.

use super::*;
use crate::num::sample::Draws;
use crate::num::special::{AtanOverRoot, Ln1pOverX, OneMinusExpOverX, TanOverRoot};

type Unary = (&'static str, fn(Interval) -> Interval, fn(f64) -> f64, [f64; 2]);

macro_rules! unary {
    ($($name:ident in $lo:expr, $hi:expr;)*) => {
        [$((stringify!($name), Interval::$name, <f64 as Scalar>::$name, [$lo, $hi])),*]
    };
}

/// Every function, with a range of arguments it is defined on.
const UNARY: [Unary; 12] = unary! {
    square in -3.0, 3.0;
    sqrt in 0.0, 9.0;
    exp in -30.0, 30.0;
    log in 1e-6, 50.0;
    sin in -20.0, 20.0;
    cos in -20.0, 20.0;
    tan in -1.57, 1.57;
    atan in -9.0, 9.0;
    one_minus_exp_over_x in -20.0, 20.0;
    ln_1p_over_x in -0.9999, 20.0;
    tan_over_root in -0.45, 2.4673;
    atan_over_root in -0.2, 20.0;
};

#[test]
fn functions_hold_their_values_and_little_more() {
    for (name, over, at, domain) in UNARY {
        for mut r in (0..4000).map(Draws::new) {
            let [lo, hi] = r.range(domain);
            let found = over(Interval::new(lo, hi));
            let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
            for k in 0..=32 {
                let x = lo + (hi - lo) * (f64::from(k) / 32.0).min(1.0);
                let y = at(x.clamp(lo, hi));
                assert!(found.contains(y), "{name} {lo} {hi}: {y} not in {found:?}");
                (least, most) = (least.min(y), most.max(y));
            }
            // A narrow range is curved too little for the samples to miss much of it.
            if hi - lo < 1e-6 * (1.0 + lo.abs()) && name != "tan_over_root" {
                let excess = found.width() - (most - least);
                let bent = 1e-12 * (1.0 + found.magnitude());
                let steep = if name == "tan" { 1e-5 * found.magnitude() } else { 0.0 };
                assert!(excess < bent + steep + 1e-9 * (hi - lo), "{name} {lo} {hi}: {excess}");
            }
        }
    }
}

#[test]
fn arithmetic_holds_its_values() {
    for mut r in (0..20_000).map(Draws::new) {
        let (a, b) = (r.range([-4.0, 4.0]), r.range([-4.0, 4.0]));
        let [x, y] = [a, b].map(|[lo, hi]| Interval::new(lo, hi));
        for _ in 0..8 {
            let (p, q) = (r.inside(a), r.inside(b));
            assert!((x + y).contains(p + q));
            assert!((x - y).contains(p - q));
            assert!((x * y).contains(p * q));
            assert!((x / y).contains(p / q));
            assert!((x * q).contains(p * q) && (x / q).contains(p / q));
            assert!((x + q).contains(p + q) && (x - q).contains(p - q));
            assert!((-x).contains(-p) && x.hull(y).contains(p) && x.hull(y).contains(q));
            assert!(x.atan2(y).contains(Scalar::atan2(p, q)), "{x:?} {y:?}");
            assert!(x.mignitude() <= p.abs() && p.abs() <= x.magnitude());
            assert!(x.contains(x.mid()) && x.width() >= p - a[0]);
        }
    }
}

#[test]
fn results_go_past_the_true_value_by_ulps_only() {
    let third = Interval::point(1.0) / 3.0;
    assert!(third.lo < third.hi && third.width() <= 2.0 * f64::EPSILON * third.hi);
    // 3 * third - 1 is a rounding, not 0.
    assert!((third * 3.0 - 1.0).contains(0.0));
    let turn = Interval::new(-0.5, 0.25).atan2(Interval::new(1.0, 2.0));
    let exact = [-Scalar::atan(0.5), Scalar::atan(0.25)];
    assert!((turn.lo - exact[0]).abs() < 1e-14 && (turn.hi - exact[1]).abs() < 1e-14);
    assert_eq!(Interval::new(1.0, 2.0).sin().hi, 1.0);
    assert_eq!(Interval::new(3.0, 3.5).cos().lo, -1.0);
    assert_eq!(Interval::new(-1.0, 2.0).square().lo, 0.0);
    assert_eq!(Interval::point(0.0) * Interval::new(-3.0, 4.0), Interval::point(0.0));
    assert_eq!(Interval::new(0.0, 1e300).sin(), Interval::new(-1.0, 1.0));
    assert!((Interval::new(0.0, 1000.0).exp().lo - 1.0).abs() < 1e-15);
}

#[test]
fn what_is_undefined_is_the_whole_line() {
    let crossing = Interval::new(-1.0, 1.0);
    let one = Interval::point(1.0);
    for found in [
        Interval::new(f64::NAN, 1.0),
        Interval::new(1.0, -1.0),
        one / crossing,
        crossing / Interval::point(0.0),
        crossing.sqrt(),
        crossing.log(),
        Interval::new(0.0, 1.0).log(),
        Interval::new(1.5, 1.6).tan(),
        crossing.atan2(crossing),
        crossing.atan2(Interval::new(-2.0, -1.0)),
        Interval::new(-2.0, 1.0).ln_1p_over_x(),
        Interval::new(-1.0, 1.0).ln_1p_over_x(),
        Interval::new(2.0, 2.5).tan_over_root(),
        Interval::new(-2.0, 1.0).tan_over_root(),
        Interval::new(-2.0, 1.0).atan_over_root(),
        Interval::point(0.0) * Interval::WHOLE,
        Interval::WHOLE - Interval::WHOLE,
        Interval::WHOLE.tan(),
        Interval::WHOLE.curve(&Ln1pOverX)[2],
        Interval::new(2.0, 2.5).curve(&TanOverRoot)[0],
        Interval::new(2.0, 2.5).curve(&TanOverRoot)[1],
    ] {
        assert_eq!(found, Interval::WHOLE);
    }
    assert_eq!(Interval::WHOLE.mid(), 0.0);
    assert!(!Interval::WHOLE.is_finite() && crossing.is_finite());
}

#[test]
fn infinite_and_extreme_ends_lose_nothing() {
    const MAX: f64 = f64::MAX;
    const INF: f64 = f64::INFINITY;
    const ENDS: [f64; 15] = [
        -INF, -MAX, -1e200, -800.0, -1.0, -1e-200, -5e-324, 0.0, 5e-324, 1e-200, 1.0, 800.0, 1e200,
        MAX, INF,
    ];
    let pairs = || (0..ENDS.len()).flat_map(|i| (i..ENDS.len()).map(move |j| (i, j)));
    let finite = |i: usize, j: usize| ENDS[i..=j].iter().filter(|x| x.is_finite());
    for (i, j) in pairs() {
        let x = Interval::new(ENDS[i], ENDS[j]);
        assert!(x.mid().is_finite());
        for (name, over, at, _) in UNARY {
            let found = over(x);
            assert!(found.lo <= found.hi);
            for p in finite(i, j).map(|&p| at(p)).filter(|p| !p.is_nan()) {
                assert!(found.contains(p), "{name} {x:?}: {p} not in {found:?}");
            }
        }
        for parts in [
            x.curve(&OneMinusExpOverX),
            x.curve(&Ln1pOverX),
            x.curve(&TanOverRoot),
            x.curve(&AtanOverRoot),
        ] {
            assert!(parts.iter().all(|part| part.lo <= part.hi));
        }
        for (k, l) in pairs() {
            let y = Interval::new(ENDS[k], ENDS[l]);
            let found = [x + y, x - y, x * y, x / y, x.atan2(y)];
            for &p in finite(i, j) {
                for &q in finite(k, l) {
                    let exact = [p + q, p - q, p * q, p / q, Scalar::atan2(p, q)];
                    for (found, exact) in found.iter().zip(exact) {
                        assert!(exact.is_nan() || found.contains(exact), "{x:?} {y:?}");
                    }
                }
            }
        }
    }
}
