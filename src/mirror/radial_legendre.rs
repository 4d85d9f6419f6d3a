//! Axisymmetric surfaces: one Legendre series along the radius.

use super::bounds::{BoundCells, OFF};
use super::height_field::{HeightAndSlope, HeightField, HeightRow, Hessian};
use crate::geom::{DVec2, DerivativeBounds, Outline};
use crate::num::legendre::{Jet, Row, Series};
use crate::num::{Interval, Scalar, bernstein};
use crate::parallel;

/// Rings that a thread bounds at a time.
const RUN: usize = 32;

/// The surface f(r) = s G(u), u over [-1, 1]: of r^2 for discs, where the surface is smooth at the
/// centre, of r for rings.
#[derive(Debug, Clone)]
pub struct RadialLegendre {
    /// G, a series in u alone (one column).
    series: Series,
    /// The same, ready for values of u.
    row: Row,
    /// Inner and outer radius, mm; the inner one is 0 for a disc.
    pub radius: [f64; 2],
    /// s, mm per unit of G.
    pub scale_mm: f64,
}

/// f and what its derivatives are made of, with D = (1/r) d/dr: f_i = D f q_i,
/// f_ij = D f d_ij + D^2 f q_i q_j, f_ijk = D^2 f (q_i d_jk + ...) + D^3 f q_i q_j q_k.
#[derive(Debug, Clone, Copy)]
struct Steps {
    f: f64,
    d: f64,
    dd: f64,
}

/// An axisymmetric surface on one line of constant y.
#[derive(Debug, Clone)]
pub struct RadialLegendreRow<'a> {
    surface: &'a RadialLegendre,
    y: f64,
}

impl HeightRow for RadialLegendreRow<'_> {
    #[inline]
    fn at(&self, x: f64) -> HeightAndSlope {
        self.surface.at(DVec2::new(x, self.y))
    }

    #[inline]
    fn at_each<const N: usize>(&self, xs: [f64; N]) -> [HeightAndSlope; N] {
        self.surface.at_each(xs.map(|x| DVec2::new(x, self.y)))
    }
}

impl HeightField for RadialLegendre {
    type Row<'a> = RadialLegendreRow<'a>;

    #[inline]
    fn row(&self, y: f64) -> RadialLegendreRow<'_> {
        RadialLegendreRow { surface: self, y }
    }

    #[inline]
    fn at(&self, q: DVec2) -> HeightAndSlope {
        let r2 = q.length_squared();
        let Steps { f, d, .. } = self.steps(r2, &self.row.gradient(self.unit(r2)));
        HeightAndSlope { f, slope: q * d }
    }

    #[inline]
    fn at_each<const N: usize>(&self, places: [DVec2; N]) -> [HeightAndSlope; N] {
        let r2 = places.map(DVec2::length_squared);
        let jets = self.row.gradients(r2.map(|r2| self.unit(r2)));
        std::array::from_fn(|k| {
            let Steps { f, d, .. } = self.steps(r2[k], &jets[k]);
            HeightAndSlope { f, slope: places[k] * d }
        })
    }

    fn hessian(&self, q: DVec2) -> Hessian {
        self.at_with_hessian(q).1
    }

    fn at_with_hessian(&self, q: DVec2) -> (HeightAndSlope, Hessian) {
        let r2 = q.length_squared();
        let Steps { f, d, dd } = self.steps(r2, &self.row.jet(self.unit(r2)));
        let hessian =
            Hessian { xx: d + dd * q.x * q.x, xy: dd * q.x * q.y, yy: d + dd * q.y * q.y };
        (HeightAndSlope { f, slope: q * d }, hessian)
    }

    /// The surface itself.
    fn reflected(&self, _axis: usize) -> Self {
        self.clone()
    }

    fn cell_bounds(&self, cells: &BoundCells) -> Vec<DerivativeBounds> {
        cells.each(|lo, hi| self.bounds(lo, hi))
    }

    fn box_bounds(&self, lo: DVec2, hi: DVec2) -> Option<DerivativeBounds> {
        Some(self.bounds(lo, hi))
    }

    fn radii(&self) -> Option<[f64; 2]> {
        Some(self.radius)
    }

    fn is_axisymmetric(&self) -> bool {
        true
    }
}

impl RadialLegendre {
    /// The surface of G = `series`.
    ///
    /// # Panics
    /// When the series depends on its second variable.
    #[must_use]
    pub fn new(series: Series, radius: [f64; 2], scale_mm: f64) -> Self {
        assert_eq!(series.shape().1, 1, "a series in u alone");
        Self { row: series.row(0.0), series, radius, scale_mm }
    }

    /// u at radius `r`.
    #[inline]
    fn unit(&self, r2: f64) -> f64 {
        let [inner, outer] = self.radius;
        if inner == 0.0 {
            2.0 * r2 / (outer * outer) - 1.0
        } else {
            (2.0 * r2.sqrt() - inner - outer) / (outer - inner)
        }
    }

    fn steps(&self, r2: f64, jet: &Jet) -> Steps {
        let [inner, outer] = self.radius;
        let [g, g1, g2] = [jet.f, jet.gradient[0], jet.hessian[0]].map(|g| g * self.scale_mm);
        if inner == 0.0 {
            // D = 2 d/d(r^2).
            let rate = 4.0 / (outer * outer);
            Steps { f: g, d: g1 * rate, dd: g2 * rate * rate }
        } else {
            let rate = 2.0 / (outer - inner);
            let d = g1 * rate / r2.sqrt();
            Steps { f: g, d, dd: (g2 * rate * rate - d) / r2 }
        }
    }

    /// Bounds over the points of a box whose distance from the axis lies within the surface's
    /// radii.
    #[must_use]
    pub fn bounds(&self, lo: DVec2, hi: DVec2) -> DerivativeBounds {
        let (q, r2) = self.reach(lo, hi);
        let edges = [self.unit(r2.lo), self.unit(r2.hi)];
        let [ranges] = self.ranges(&edges)[..] else { unreachable!("one range for two edges") };
        self.of_ranges(q, r2, ranges)
    }

    /// The ranges of x and y in a box, and those of r^2 as far as the surface reaches.
    fn reach(&self, lo: DVec2, hi: DVec2) -> ([Interval; 2], Interval) {
        let q = [Interval::new(lo.x, hi.x), Interval::new(lo.y, hi.y)];
        let r2 = q[0].square() + q[1].square();
        let [least, most] = self.squares();
        let [inner, outer] = self.radius.map(|r| r * r);
        (q, Interval::new(r2.lo.clamp(least, outer), r2.hi.clamp(inner, most)))
    }

    /// Between which values of r^2 bounds hold: chords of the inner rim run a little inside it, and
    /// single precision may put points of the outer one a little outside.
    fn squares(&self) -> [f64; 2] {
        let [inner, outer] = self.radius;
        let least = inner * (1.0 - 2.0 * Outline::EDGE);
        [least * least, outer * outer * (1.0 + 4e-7)]
    }

    /// Ranges of f and its first three derivatives by u between each two neighbours of `edges`.
    fn ranges(&self, edges: &[f64]) -> Vec<[Interval; 4]> {
        let mut series = self.series.clone();
        let mut ranges = vec![[Interval::point(0.0); 4]; edges.len() - 1];
        for k in 0..4 {
            let found = bernstein::ranges(&series, edges, &[-1.0, 1.0]);
            for (range, [lo, hi]) in ranges.iter_mut().zip(found) {
                range[k] = Interval::new(lo, hi) * self.scale_mm;
            }
            series = series.derivative_u();
        }
        ranges
    }

    /// The same where `edges` are so near to each other that the third derivative hardly varies
    /// between two: the others by Taylor's theorem.
    fn close_ranges(&self, edges: &[f64]) -> Vec<[Interval; 4]> {
        let third = self.series.derivative_u().derivative_u().derivative_u();
        let run = |edges: &[f64]| bernstein::ranges(&third, edges, &[-1.0, 1.0]);
        let starts: Vec<usize> = (0..edges.len() - 1).step_by(RUN).collect();
        let run = |&k: &usize| run(&edges[k..(k + RUN + 1).min(edges.len())]);
        let third: Vec<[f64; 2]> = parallel::map_slice(&starts, 1, run).concat();
        let jets: Vec<Jet> =
            edges.windows(2).map(|ring| self.row.jet(0.5 * (ring[0] + ring[1]))).collect();
        let values = |jet: &Jet| [jet.f, jet.gradient[0], jet.hessian[0]];
        let largest = |i: usize| jets.iter().map(|jet| values(jet)[i].abs()).fold(0.0, f64::max);
        let off: [f64; 3] = std::array::from_fn(|i| OFF * largest(i));
        let ranges = |((ring, [lo, hi]), jet): ((&[f64], [f64; 2]), &Jet)| {
            let step = Interval::around(0.0, 0.5 * (ring[1] - ring[0]));
            let [f, f1, f2] = values(jet);
            let g3 = Interval::new(lo, hi);
            let g2 = Interval::around(f2, off[2]) + g3 * step;
            let g1 = Interval::around(f1, off[1]) + g2 * step;
            [Interval::around(f, off[0]) + g1 * step, g1, g2, g3].map(|g| g * self.scale_mm)
        };
        edges.windows(2).zip(third).zip(&jets).map(ranges).collect()
    }

    fn of_ranges(&self, q: [Interval; 2], r2: Interval, ranges: [Interval; 4]) -> DerivativeBounds {
        let [inner, outer] = self.radius;
        let [g, g1, g2, g3] = ranges;
        let [d, dd, ddd] = if inner == 0.0 {
            let rate = 4.0 / (outer * outer);
            [g1 * rate, g2 * (rate * rate), g3 * (rate * rate * rate)]
        } else {
            let rate = 2.0 / (outer - inner);
            let r = r2.sqrt();
            let d = g1 * rate / r;
            let dd = (g2 * (rate * rate) - d) / r2;
            // D^3 f = (f''' / r - 3 D^2 f) / r^2.
            [d, dd, (g3 * (rate * rate * rate) / r - dd * 3.0) / r2]
        };
        let [x, y] = q;
        let [xx, yy] = q.map(Interval::square);
        DerivativeBounds {
            f: g,
            slope: [d * x, d * y],
            hessian: [d + dd * xx, dd * x * y, d + dd * yy],
            third: [
                x * (dd * 3.0 + ddd * xx),
                y * (dd + ddd * xx),
                x * (dd + ddd * yy),
                y * (dd * 3.0 + ddd * yy),
            ],
        }
    }
}

/// Bounds of a round surface over boxes, from those over many rings.
#[derive(Debug, Clone)]
pub struct Rings {
    round: RadialLegendre,
    /// u where the first ring begins, and rings to a unit of u.
    start: f64,
    per_unit: f64,
    ranges: Vec<[Interval; 4]>,
}

impl Rings {
    /// How many.
    const COUNT: usize = 512;

    /// The rings of `round`.
    #[must_use]
    pub fn new(round: &RadialLegendre) -> Self {
        let [start, end] = round.squares().map(|r2| round.unit(r2));
        let step = (end - start) / Self::COUNT as f64;
        let edges: Vec<f64> = (0..=Self::COUNT).map(|k| start + step * k as f64).collect();
        Self {
            round: round.clone(),
            start,
            per_unit: 1.0 / step,
            ranges: round.close_ranges(&edges),
        }
    }

    /// What [`RadialLegendre::bounds`] gives, but for the width of the rings.
    #[must_use]
    pub fn bounds(&self, lo: DVec2, hi: DVec2) -> DerivativeBounds {
        let (q, r2) = self.round.reach(lo, hi);
        let [first, last] = [r2.lo, r2.hi].map(|r2| {
            let ring = (self.round.unit(r2) - self.start) * self.per_unit;
            (ring.max(0.0) as usize).min(Self::COUNT - 1)
        });
        let both = |a: [Interval; 4], b: &[Interval; 4]| std::array::from_fn(|k| a[k].hull(b[k]));
        let ranges = self.ranges[first + 1..=last].iter().fold(self.ranges[first], both);
        self.round.of_ranges(q, r2, ranges)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (f, f', f'') of a radius.
    type Exact = fn(f64) -> [f64; 3];

    /// f = 0.01 r^4 - 0.3 r^2 on a disc of radius 5, f = r^2 / 4 - r on a ring of 1..5.
    fn surfaces() -> [(RadialLegendre, Exact); 2] {
        // r^2 = 12.5 (u + 1); u^2 = (2 P2 + 1) / 3.
        let disc =
            [1.5625 * (4.0 / 3.0) - 0.3 * 12.5, 1.5625 * 2.0 - 0.3 * 12.5, 1.5625 * (2.0 / 3.0)];
        // r = 3 + 2 u.
        let ring = [(9.0 + 4.0 / 3.0) / 4.0 - 3.0, 3.0 - 2.0, (8.0 / 3.0) / 4.0];
        [
            (
                RadialLegendre::new(Series::from_fn(3, 1, |i, _| disc[i] / 2.0), [0.0, 5.0], 2.0),
                |r| {
                    let r2 = r * r;
                    [0.01 * r2 * r2 - 0.3 * r2, 0.04 * r2 * r - 0.6 * r, 0.12 * r2 - 0.6]
                },
            ),
            (RadialLegendre::new(Series::from_fn(3, 1, |i, _| ring[i]), [1.0, 5.0], 1.0), |r| {
                [0.25 * r * r - r, 0.5 * r - 1.0, 0.5]
            }),
        ]
    }

    #[test]
    fn derivatives_are_those_of_the_profile() {
        for (surface, exact) in surfaces() {
            for r in [1.0, 2.5, 5.0] {
                let n = DVec2::new(0.6, -0.8);
                let (q, [f, f1, f2]) = (n * r, exact(r));
                let point = surface.at(q);
                assert!((point.f - f).abs() < 1e-13 && (point.slope - n * f1).length() < 1e-13);
                let c = surface.hessian(q);
                let across = DVec2::new(0.8, 0.6);
                assert!((c.times(n) - n * f2).length() < 1e-13);
                assert!((c.times(across) - across * f1 / r).length() < 1e-13);
            }
        }
    }

    #[test]
    fn bounds_hold_at_every_sample() {
        for (surface, _) in surfaces() {
            let rings = Rings::new(&surface);
            let each = |bounds: DerivativeBounds| (0..81).map(move |j| (bounds, j));
            for k in 0..64 {
                let lo = DVec2::new(f64::from(k % 8) - 4.0, f64::from(k / 8) - 4.0) * 0.8;
                let hi = lo + 0.8;
                for (bounds, j) in
                    [surface.bounds(lo, hi), rings.bounds(lo, hi)].into_iter().flat_map(each)
                {
                    let q = lo + DVec2::new(f64::from(j % 9), f64::from(j / 9)) * 0.1;
                    let r = q.length();
                    if r < surface.radius[0] || r > surface.radius[1] {
                        continue;
                    }
                    let (point, c) = (surface.at(q), surface.hessian(q));
                    assert!(bounds.f.contains(point.f));
                    assert!(bounds.slope[0].contains(point.slope.x));
                    assert!(bounds.slope[1].contains(point.slope.y));
                    for (range, x) in bounds.hessian.iter().zip([c.xx, c.xy, c.yy]) {
                        assert!(range.contains(x), "{range:?} {x}");
                    }
                    let h = 1e-5;
                    let d = |e: DVec2| {
                        let (a, b) = (surface.hessian(q + e * h), surface.hessian(q - e * h));
                        [a.xx - b.xx, a.xy - b.xy, a.yy - b.yy].map(|x| x / (2.0 * h))
                    };
                    let (dx, dy) = (d(DVec2::X), d(DVec2::Y));
                    for (range, x) in bounds.third.iter().zip([dx[0], dx[1], dx[2], dy[2]]) {
                        assert!(range.lo - 1e-8 <= x && x <= range.hi + 1e-8, "{range:?} {x}");
                    }
                }
            }
        }
    }
}
