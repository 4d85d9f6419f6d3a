//! Rational B-splines of any degree: knots, curves, and tensor-product surfaces (Piegl and Tiller, The NURBS Book).

use crate::geom::DVec3;
use std::ops::{Add, Mul, Sub};

/// Largest degree: that of OpenCASCADE.
pub(super) const MOST_DEGREE: usize = 25;

/// A control point times its weight, and the weight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Weighted {
    pub p: DVec3,
    pub w: f64,
}

impl Weighted {
    pub(super) const ZERO: Self = Self { p: DVec3::ZERO, w: 0.0 };

    pub(super) fn new(at: DVec3, w: f64) -> Self {
        Self { p: at * w, w }
    }

    /// The point in space.
    pub(super) fn project(self) -> DVec3 {
        self.p / self.w
    }

    /// The derivative in space of a point with this value, from that of the weighted one.
    fn derivative(self, d: Self) -> DVec3 {
        (d.p - self.project() * d.w) / self.w
    }
}

impl Add for Weighted {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        Self { p: self.p + other.p, w: self.w + other.w }
    }
}

impl Sub for Weighted {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        Self { p: self.p - other.p, w: self.w - other.w }
    }
}

impl Mul<f64> for Weighted {
    type Output = Self;

    #[inline]
    fn mul(self, factor: f64) -> Self {
        Self { p: self.p * factor, w: self.w * factor }
    }
}

/// Degree and knots, each as often as its multiplicity.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Knots {
    pub degree: usize,
    knots: Vec<f64>,
}

/// Values and first derivatives of the basis functions that are not 0.
type Basis = ([f64; MOST_DEGREE + 1], [f64; MOST_DEGREE + 1]);

impl Knots {
    /// The knots of `count` control points.
    ///
    /// # Errors
    /// What is wrong with them.
    pub(super) fn new(
        degree: f64,
        multiplicities: &[f64],
        values: &[f64],
        count: usize,
    ) -> Result<Self, String> {
        if !(degree >= 1.0 && degree <= MOST_DEGREE as f64 && degree.fract() == 0.0) {
            return Err(format!("the degree must be 1 to {MOST_DEGREE}, not {degree}"));
        }
        let degree = degree as usize;
        if multiplicities.len() != values.len() {
            let (n, m) = (values.len(), multiplicities.len());
            return Err(format!("{n} knots with {m} multiplicities"));
        }
        let most = (degree + 1) as f64;
        if multiplicities.iter().any(|m| !(*m >= 1.0 && *m <= most && m.fract() == 0.0)) {
            return Err(format!("a multiplicity must be 1 to {most}"));
        }
        let wanted = count + degree + 1;
        let total: f64 = multiplicities.iter().sum();
        if total != wanted as f64 {
            return Err(format!(
                "{count} control points of degree {degree} take {wanted} knots, not {total}"
            ));
        }
        if values.windows(2).any(|pair| !(pair[0] < pair[1])) {
            return Err("knots must rise".into());
        }
        let repeated = values.iter().zip(multiplicities);
        let knots =
            repeated.flat_map(|(&knot, &m)| std::iter::repeat_n(knot, m as usize)).collect();
        let knots = Self { degree, knots };
        let [lo, hi] = knots.domain();
        if count <= degree || !(lo < hi) {
            return Err("too few control points for the degree".into());
        }
        Ok(knots)
    }

    /// Knots 0, 1, 2 and so on, the ends as often as a spline from its first to its last control point has them
    /// if `clamped`, the inner ones `each` times.
    pub(super) fn even(
        degree: usize,
        count: usize,
        each: usize,
        clamped: bool,
    ) -> Result<Self, String> {
        if !clamped {
            let values: Vec<f64> = (0..count + degree + 1).map(|k| k as f64).collect();
            return Self::new(degree as f64, &vec![1.0; values.len()], &values, count);
        }
        if count <= degree || !(count - degree - 1).is_multiple_of(each) {
            return Err("the number of control points does not suit the degree".into());
        }
        let spans = (count - degree - 1) / each + 1;
        let values: Vec<f64> = (0..=spans).map(|k| k as f64).collect();
        let end = (degree + 1) as f64;
        let most = |k: usize| if k == 0 || k == spans { end } else { each as f64 };
        let multiplicities: Vec<f64> = (0..=spans).map(most).collect();
        Self::new(degree as f64, &multiplicities, &values, count)
    }

    pub(super) fn count(&self) -> usize {
        self.knots.len() - self.degree - 1
    }

    /// First and last parameter.
    pub(super) fn domain(&self) -> [f64; 2] {
        [self.knots[self.degree], self.knots[self.knots.len() - self.degree - 1]]
    }

    /// The knots within the domain, each once, ends included.
    pub(super) fn breaks(&self) -> Vec<f64> {
        let mut breaks = self.knots[self.degree..self.knots.len() - self.degree].to_vec();
        breaks.dedup();
        breaks
    }

    /// Number of the knot at which the span of `u` begins.
    pub(super) fn span(&self, u: f64) -> usize {
        let inner = &self.knots[self.degree + 1..self.knots.len() - self.degree - 1];
        let at = self.degree + inner.partition_point(|&knot| knot <= u);
        // At the right end of the domain, and where inner knots are as many as at an end, the span before.
        let mut at = at.min(self.knots.len() - self.degree - 2);
        while at > self.degree && !(self.knots[at] < self.knots[at + 1]) {
            at -= 1;
        }
        at
    }

    /// The basis functions that are not 0 at `u`: the number of the first, their values and derivatives.
    fn basis(&self, u: f64) -> (usize, Basis) {
        let (k, span, p) = (&self.knots, self.span(u), self.degree);
        let (mut b, mut d) = ([0.0; MOST_DEGREE + 1], [0.0; MOST_DEGREE + 1]);
        b[0] = 1.0;
        for degree in 1..=p {
            if degree == p {
                for (r, d) in d.iter_mut().enumerate().take(p + 1) {
                    let part = |r: usize| {
                        let (left, right) = (k[span + 1 + r - p], k[span + 1 + r]);
                        p as f64 * b[r] / (right - left)
                    };
                    let before = if r > 0 { part(r - 1) } else { 0.0 };
                    *d = before - if r < p { part(r) } else { 0.0 };
                }
            }
            let mut carried = 0.0;
            for r in 0..degree {
                let (left, right) = (k[span + 1 + r - degree], k[span + 1 + r]);
                let share = b[r] / (right - left);
                b[r] = carried + (right - u) * share;
                carried = (u - left) * share;
            }
            b[degree] = carried;
        }
        (span - p, (b, d))
    }

    /// Bezier control points of the span that begins with knot `span`, by the blossom of the spline: rows of
    /// weights of its control points from `span - degree` on.
    pub(super) fn bezier(&self, span: usize) -> Vec<Vec<f64>> {
        let (k, p) = (&self.knots, self.degree);
        let ends = [k[span], k[span + 1]];
        let row = |right: usize| {
            let mut d: Vec<Vec<f64>> =
                (0..=p).map(|i| (0..=p).map(|j| f64::from(u8::from(i == j))).collect()).collect();
            for r in 1..=p {
                let x = ends[usize::from(r <= right)];
                for i in (r..=p).rev() {
                    let j = span - p + i;
                    let share = (x - k[j]) / (k[j + p - r + 1] - k[j]);
                    let (before, own) = d.split_at_mut(i);
                    for (own, before) in own[0].iter_mut().zip(&before[i - 1]) {
                        *own = (1.0 - share) * before + share * *own;
                    }
                }
            }
            d.pop().unwrap_or_default()
        };
        (0..=p).map(row).collect()
    }
}

/// A rational B-spline curve.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SplineCurve {
    pub knots: Knots,
    pub points: Vec<Weighted>,
}

impl SplineCurve {
    /// Point and derivative at `t`.
    pub(super) fn at(&self, t: f64) -> (DVec3, DVec3) {
        let (first, (b, d)) = self.knots.basis(t);
        let points = &self.points[first..=first + self.knots.degree];
        let sum =
            |b: &[f64]| points.iter().zip(b).fold(Weighted::ZERO, |sum, (&p, &b)| sum + p * b);
        let (at, along) = (sum(&b), sum(&d));
        (at.project(), at.derivative(along))
    }
}

/// A rational B-spline surface: control points along v for the first of u's, then for the next.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SplineSurface {
    pub knots: [Knots; 2],
    pub points: Vec<Weighted>,
    /// Whether the two ends of each axis are the same curve.
    pub closed: [bool; 2],
}

/// Places on an end of a surface at which it is compared with the other end.
const END_PLACES: usize = 17;
/// Distance up to which both ends of a surface are one, mm: coordinates in inches have 10 digits.
const END_GAP: f64 = 1e-8;

impl SplineSurface {
    pub(super) fn new(knots: [Knots; 2], points: Vec<Weighted>) -> Self {
        let mut surface = Self { knots, points, closed: [false; 2] };
        surface.closed = [0, 1].map(|axis| surface.is_closed(axis));
        surface
    }

    /// Whether its weights are all the same.
    pub(super) fn is_polynomial(&self) -> bool {
        self.points.iter().all(|point| point.w == self.points[0].w)
    }

    fn is_closed(&self, axis: usize) -> bool {
        let ([lo, hi], [from, to]) = (self.knots[axis].domain(), self.knots[1 - axis].domain());
        (0..END_PLACES).all(|k| {
            let across = from + (to - from) * k as f64 / (END_PLACES - 1) as f64;
            let at = |along: f64| {
                let [u, v] = if axis == 0 { [along, across] } else { [across, along] };
                self.at(u, v)[0]
            };
            at(lo).distance(at(hi)) <= END_GAP
        })
    }

    /// Point and both derivatives.
    pub(super) fn at(&self, u: f64, v: f64) -> [DVec3; 3] {
        let ((i, (a, da)), (j, (b, db))) = (self.knots[0].basis(u), self.knots[1].basis(v));
        let [p, q] = [self.knots[0].degree, self.knots[1].degree];
        let row_length = self.knots[1].count();
        let [mut at, mut along_u, mut along_v] = [Weighted::ZERO; 3];
        for k in 0..=p {
            let row = &self.points[(i + k) * row_length + j..][..=q];
            let (mut sum, mut slope) = (Weighted::ZERO, Weighted::ZERO);
            for (l, &point) in row.iter().enumerate() {
                sum = sum + point * b[l];
                slope = slope + point * db[l];
            }
            at = at + sum * a[k];
            along_u = along_u + sum * da[k];
            along_v = along_v + slope * a[k];
        }
        [at.project(), at.derivative(along_u), at.derivative(along_v)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::{cos, sin};

    /// A quarter of the unit circle, exactly.
    fn quarter() -> SplineCurve {
        let w = std::f64::consts::FRAC_1_SQRT_2;
        let points = [(DVec3::X, 1.0), (DVec3::X + DVec3::Y, w), (DVec3::Y, 1.0)];
        let points = points.map(|(at, w)| Weighted::new(at, w)).to_vec();
        SplineCurve { knots: Knots::new(2.0, &[3.0, 3.0], &[0.0, 1.0], 3).unwrap(), points }
    }

    #[test]
    fn a_rational_quadratic_is_a_circle() {
        let curve = quarter();
        for k in 0..=20 {
            let (at, along) = curve.at(f64::from(k) / 20.0);
            assert!((at.length() - 1.0).abs() < 4e-16 && at.dot(along).abs() < 4e-16);
        }
    }

    #[test]
    fn a_cubic_meets_its_polynomial_and_its_bezier_points_lie_on_it() {
        // Greville's abscissae are the control points of the identity.
        let knots = Knots::new(3.0, &[4.0, 1.0, 2.0, 4.0], &[-1.0, 0.5, 2.0, 3.0], 7).unwrap();
        let greville: Vec<f64> =
            (0..7).map(|k| knots.knots[k + 1..k + 4].iter().sum::<f64>() / 3.0).collect();
        let points = greville.iter().map(|&x| Weighted::new(DVec3::X * x, 1.0)).collect();
        let curve = SplineCurve { knots, points };
        for k in 0..=40 {
            let t = -1.0 + 0.1 * f64::from(k);
            let (at, along) = curve.at(t);
            assert!((at.x - t).abs() < 1e-14 && (along.x - 1.0).abs() < 1e-13, "{t} {at} {along}");
        }
        for ends in curve.knots.breaks().windows(2) {
            let span = curve.knots.span(0.5 * (ends[0] + ends[1]));
            for (k, row) in curve.knots.bezier(span).iter().enumerate() {
                let x: f64 = row.iter().zip(&greville[span - 3..]).map(|(w, x)| w * x).sum();
                assert!((x - (ends[0] + (ends[1] - ends[0]) * k as f64 / 3.0)).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn knots_that_do_not_fit_are_refused_before_they_take_memory() {
        let fault = |m: &[f64], k: &[f64]| Knots::new(3.0, m, k, 4).unwrap_err();
        assert_eq!(fault(&[1e18, 4.0], &[0.0, 1.0]), "a multiplicity must be 1 to 4");
        assert_eq!(
            fault(&[4.0, 3.0], &[0.0, 1.0]),
            "4 control points of degree 3 take 8 knots, not 7"
        );
        assert_eq!(fault(&[4.0, 4.0], &[1.0, 1.0]), "knots must rise");
        assert_eq!(fault(&[4.0], &[0.0, 1.0]), "2 knots with 1 multiplicities");
        assert!(Knots::new(1e9, &[4.0, 4.0], &[0.0, 1.0], 4).is_err());
    }

    #[test]
    fn a_cylinder_of_splines_is_closed_along_one_axis() {
        let knots = [Knots::even(2, 9, 2, true).unwrap(), Knots::even(1, 2, 1, true).unwrap()];
        let w = std::f64::consts::FRAC_1_SQRT_2;
        let circle = |k: usize| {
            let angle = std::f64::consts::FRAC_PI_4 * k as f64;
            let (r, w) = if k % 2 == 1 { (1.0 / w, w) } else { (1.0, 1.0) };
            (DVec3::new(r * cos(angle), r * sin(angle), 0.0), w)
        };
        let points = (0..9).flat_map(|k| {
            [0.0, 1.0].map(|z| Weighted::new(circle(k).0 + DVec3::Z * z, circle(k).1))
        });
        let surface = SplineSurface::new(knots, points.collect());
        assert_eq!(surface.closed, [true, false]);
        let [at, along_u, along_v] = surface.at(0.3, 0.6);
        assert!((at.truncate().length() - 1.0).abs() < 1e-15 && (at.z - 0.6).abs() < 1e-15);
        assert!(along_u.cross(along_v).dot(at.truncate().extend(0.0)) > 0.0);
    }
}
