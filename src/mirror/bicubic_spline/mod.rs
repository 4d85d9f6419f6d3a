//! Sag on a regular grid: the bicubic spline through it, twice differentiable.

mod patch_bounds;

use super::bounds::{BoundCells, DerivativeBounds, UnionBound};
use super::height_field::{HeightAndSlope, HeightField, HeightRow, Hessian};
use crate::geom::{DVec2, GridAxis};
use crate::parallel;

/// f and its derivatives f_s, f_t, f_st at a node, per step of the grid: a patch between four nodes
/// is the Hermite bicubic of theirs.
type Node = [f64; 4];

/// The tensor product of cubic splines through heights on a regular grid, "not a knot" at the ends
/// (the two pieces at each end are one cubic). Outside the grid the end patches go on.
#[derive(Debug, Clone, PartialEq)]
pub struct BicubicSpline {
    x: GridAxis,
    y: GridAxis,
    nodes: Vec<Node>,
}

/// The least number of knots along an axis.
pub const LEAST_KNOTS: usize = 4;

/// Multipliers of the tridiagonal elimination for slopes at `count` even knots: rows
/// (1 2), (1 4 1) ..., (2 1).
fn multipliers(count: usize) -> Vec<f64> {
    let mut c = vec![2.0];
    for k in 1..count - 1 {
        c.push(1.0 / (4.0 - c[k - 1]));
    }
    c
}

/// Right sides of the first, an inner and the last row; `f` are three heights in a row.
fn first_side(f: [f64; 3]) -> f64 {
    2.5 * (f[1] - f[0]) + 0.5 * (f[2] - f[1])
}
fn inner_side(f: [f64; 3]) -> f64 {
    3.0 * ((f[2] - f[1]) + (f[1] - f[0]))
}
fn last_side(f: [f64; 3]) -> f64 {
    2.5 * (f[2] - f[1]) + 0.5 * (f[1] - f[0])
}

/// Slopes per step, put into entry `to`, of the spline through entries `from` of `lines` that
/// follow each other, for every place on the lines at once.
fn slopes(nodes: &mut [Node], line: usize, from: usize, to: usize) {
    let count = nodes.len() / line;
    let c = multipliers(count);
    for k in 0..count {
        for i in 0..line {
            let f = |k: usize| nodes[k * line + i][from];
            let before = if k == 0 { 0.0 } else { nodes[(k - 1) * line + i][to] };
            nodes[k * line + i][to] = if k == 0 {
                first_side([f(0), f(1), f(2)])
            } else if k < count - 1 {
                (inner_side([f(k - 1), f(k), f(k + 1)]) - before) * c[k]
            } else {
                let side = last_side([f(k - 2), f(k - 1), f(k)]);
                (side - 2.0 * before) / (1.0 - 2.0 * c[k - 1])
            };
        }
    }
    for k in (0..count - 1).rev() {
        for i in 0..line {
            nodes[k * line + i][to] -= c[k] * nodes[(k + 1) * line + i][to];
        }
    }
}

/// Hermite's cubics on [0, 1] in the order f(0), f'(0), f(1), f'(1), or a derivative of them.
#[inline]
fn hermite(t: f64) -> [f64; 4] {
    let r = 1.0 - t;
    [r * r * (1.0 + 2.0 * t), t * r * r, t * t * (3.0 - 2.0 * t), -t * t * r]
}
#[inline]
fn hermite_slope(t: f64) -> [f64; 4] {
    let rise = 6.0 * t * (1.0 - t);
    [-rise, (1.0 - t) * (1.0 - 3.0 * t), rise, t * (3.0 * t - 2.0)]
}
#[inline]
fn hermite_second(t: f64) -> [f64; 4] {
    let rise = 6.0 - 12.0 * t;
    [-rise, 6.0 * t - 4.0, rise, 6.0 * t - 2.0]
}

/// Four coefficients along s of what weights along t make of two nodes above each other.
#[inline]
fn fold([a, b]: [&Node; 2], w: &[f64; 4]) -> [f64; 2] {
    [
        a[0] * w[0] + a[2] * w[1] + b[0] * w[2] + b[2] * w[3],
        a[1] * w[0] + a[3] * w[1] + b[1] * w[2] + b[3] * w[3],
    ]
}

#[inline]
fn sum(left: [f64; 2], right: [f64; 2], w: &[f64; 4]) -> f64 {
    left[0] * w[0] + left[1] * w[1] + right[0] * w[2] + right[1] * w[3]
}

impl BicubicSpline {
    /// The spline through `values`, row after row along X; none for fewer than
    /// [`LEAST_KNOTS`] knots along an axis, steps that are not positive, a wrong number of values
    /// or values that are not finite.
    #[must_use]
    pub fn new(x: GridAxis, y: GridAxis, values: &[f64]) -> Option<Self> {
        let sound = |k: &GridAxis| {
            k.count >= LEAST_KNOTS
                && k.step_mm > 0.0
                && k.first_mm.is_finite()
                && k.last_mm().is_finite()
        };
        let fits = x.count.checked_mul(y.count) == Some(values.len());
        if !(sound(&x) && sound(&y) && fits && values.iter().all(|f| f.is_finite())) {
            return None;
        }
        let mut nodes: Vec<Node> = values.iter().map(|&f| [f, 0.0, 0.0, 0.0]).collect();
        parallel::map_chunks_mut(&mut nodes, x.count, |_, row| slopes(row, 1, 0, 1));
        slopes(&mut nodes, x.count, 0, 2);
        slopes(&mut nodes, x.count, 1, 3);
        Some(Self { x, y, nodes })
    }

    /// The knots along X and along Y.
    #[must_use]
    pub fn knots(&self) -> [GridAxis; 2] {
        [self.x, self.y]
    }

    /// Bounds over a box: those of the patches that it touches, each only a little wider than its
    /// share of the box.
    #[must_use]
    pub fn bounds(&self, lo: DVec2, hi: DVec2) -> DerivativeBounds {
        let across = |(j, t): (usize, [f64; 2])| {
            patch_bounds::touched(&self.x, lo.x, hi.x)
                .map(move |(i, s)| self.patch_bounds(i, j, s, t))
        };
        let all = patch_bounds::touched(&self.y, lo.y, hi.y).flat_map(across);
        all.reduce(UnionBound::union).expect("a box touches a patch")
    }
}

impl HeightField for BicubicSpline {
    type Row<'a> = BicubicSplineRow<'a>;

    fn row(&self, y: f64) -> BicubicSplineRow<'_> {
        let (j, t) = self.y.interval(y);
        let row = |j: usize| &self.nodes[j * self.x.count..(j + 1) * self.x.count];
        BicubicSplineRow {
            x: self.x,
            per_step: DVec2::new(1.0 / self.x.step_mm, 1.0 / self.y.step_mm),
            rows: [row(j), row(j + 1)],
            value: hermite(t),
            slope: hermite_slope(t),
        }
    }

    fn hessian(&self, q: DVec2) -> Hessian {
        let ((i, s), (j, t)) = (self.x.interval(q.x), self.y.interval(q.y));
        let column =
            |i: usize| [&self.nodes[j * self.x.count + i], &self.nodes[(j + 1) * self.x.count + i]];
        let second = |along: [f64; 4], across: [f64; 4]| {
            sum(fold(column(i), &across), fold(column(i + 1), &across), &along)
        };
        let (dx, dy) = (self.x.step_mm, self.y.step_mm);
        Hessian {
            xx: second(hermite_second(s), hermite(t)) / (dx * dx),
            xy: second(hermite_slope(s), hermite_slope(t)) / (dx * dy),
            yy: second(hermite(s), hermite_second(t)) / (dy * dy),
        }
    }

    fn reflected(&self, axis: usize) -> Self {
        let mut reflected = self.clone();
        let knots = if axis == 0 { &mut reflected.x } else { &mut reflected.y };
        knots.first_mm = -knots.last_mm();
        let [columns, rows] = [self.x.count, self.y.count];
        for (k, node) in reflected.nodes.iter_mut().enumerate() {
            let (i, j) = (k % columns, k / columns);
            let (i, j) = if axis == 0 { (columns - 1 - i, j) } else { (i, rows - 1 - j) };
            let [f, f_s, f_t, f_st] = self.nodes[j * columns + i];
            *node = if axis == 0 { [f, -f_s, f_t, -f_st] } else { [f, f_s, -f_t, -f_st] };
        }
        reflected
    }

    fn cell_bounds(&self, cells: &BoundCells) -> Vec<DerivativeBounds> {
        cells.each(|lo, hi| self.bounds(lo, hi))
    }

    fn box_bounds(&self, lo: DVec2, hi: DVec2) -> Option<DerivativeBounds> {
        Some(self.bounds(lo, hi))
    }

    fn is_bicubic(&self) -> bool {
        true
    }

    fn breaks(&self, axis: usize, lo: f64, hi: f64) -> Vec<f64> {
        [self.x, self.y][axis].breaks(lo, hi)
    }
}

/// A spline on one line of constant y.
#[derive(Debug, Clone)]
pub struct BicubicSplineRow<'a> {
    x: GridAxis,
    per_step: DVec2,
    rows: [&'a [Node]; 2],
    value: [f64; 4],
    slope: [f64; 4],
}

impl HeightRow for BicubicSplineRow<'_> {
    #[inline]
    fn at(&self, x: f64) -> HeightAndSlope {
        let (i, s) = self.x.interval(x);
        let column = |i: usize| self.rows.map(|row| &row[i]);
        let (left, right) = (column(i), column(i + 1));
        let (l, r) = (fold(left, &self.value), fold(right, &self.value));
        let along = hermite(s);
        let slope = DVec2::new(
            sum(l, r, &hermite_slope(s)),
            sum(fold(left, &self.slope), fold(right, &self.slope), &along),
        );
        HeightAndSlope { f: sum(l, r, &along), slope: slope * self.per_step }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::sample::Draws;
    use crate::num::{cos, sin};

    fn grid(x: GridAxis, y: GridAxis, f: impl Fn(DVec2) -> f64) -> BicubicSpline {
        let node = |k: usize| f(DVec2::new(x.at(k % x.count), y.at(k / x.count)));
        let values: Vec<f64> = (0..x.count * y.count).map(node).collect();
        BicubicSpline::new(x, y, &values).unwrap()
    }

    fn knots(first: f64, last: f64, count: usize) -> GridAxis {
        GridAxis { first_mm: first, step_mm: (last - first) / (count - 1) as f64, count }
    }

    fn rough(seed: u64) -> BicubicSpline {
        let mut r = Draws::new(seed);
        let values: Vec<f64> = (0..63).map(|_| r.inside([-1.0, 1.0])).collect();
        BicubicSpline::new(knots(-3.0, 2.0, 9), knots(1.0, 4.0, 7), &values).unwrap()
    }

    #[test]
    fn bicubics_are_given_back() {
        let f = |q: DVec2| {
            let (x, y) = (q.x, q.y);
            (1.0 + x * (0.5 - x * (0.3 + 0.2 * x))) * (0.7 - y * (0.2 + y * (0.4 - 0.1 * y)))
        };
        let mut r = Draws::new(5);
        for (nx, ny) in [(4, 4), (5, 9), (40, 7)] {
            let patches = grid(knots(-1.0, 2.0, nx), knots(-2.0, 1.0, ny), f);
            for _ in 0..200 {
                let q = DVec2::new(r.inside([-1.2, 2.2]), r.inside([-2.2, 1.2]));
                let HeightAndSlope { f: found, slope } = patches.at(q);
                assert!((found - f(q)).abs() < 1e-13, "{nx} {q}: {found} {}", f(q));
                let (x, y) = (q.x, q.y);
                let (g, h) =
                    (1.0 + x * (0.5 - x * (0.3 + 0.2 * x)), 0.7 - y * (0.2 + y * (0.4 - 0.1 * y)));
                let (g1, h1) = (0.5 - x * (0.6 + 0.6 * x), -0.2 - y * (0.8 - 0.3 * y));
                let (g2, h2) = (-0.6 - 1.2 * x, -0.8 + 0.6 * y);
                assert!((slope - DVec2::new(g1 * h, g * h1)).length() < 1e-12);
                let c = patches.hessian(q);
                let off = (c.xx - g2 * h).abs() + (c.xy - g1 * h1).abs() + (c.yy - g * h2).abs();
                assert!(off < 1e-10, "{off}");
            }
        }
    }

    #[test]
    fn the_hessian_goes_through_the_knots() {
        let patches = rough(1);
        let [x, y] = patches.knots();
        let mut r = Draws::new(2);
        for k in 1..x.count - 1 {
            let e = 1e-9;
            let (a, b) = (x.at(k), r.inside([y.first_mm, y.last_mm()]));
            let (c, d) = (r.inside([x.first_mm, x.last_mm()]), y.at(k.min(y.count - 2)));
            for (before, after) in [
                (DVec2::new(a - e, b), DVec2::new(a + e, b)),
                (DVec2::new(c, d - e), DVec2::new(c, d + e)),
            ] {
                let (l, r) = (patches.hessian(before), patches.hessian(after));
                let jump = (l.xx - r.xx).abs() + (l.xy - r.xy).abs() + (l.yy - r.yy).abs();
                assert!(jump < 1e-6, "{jump}");
            }
        }
    }

    #[test]
    fn sag_converges_at_fourth_order() {
        let f = |q: DVec2| sin(1.3 * q.x + 0.2) * cos(0.9 * q.y);
        let error = |n: usize| {
            let patches = grid(knots(-1.0, 2.0, n + 1), knots(-1.0, 1.0, n + 1), f);
            let at = |k: usize| {
                DVec2::new(
                    -1.0 + 3.0 * (k % 101) as f64 / 100.0,
                    -1.0 + 2.0 * (k / 101) as f64 / 100.0,
                )
            };
            (0..101 * 101).map(|k| (patches.at(at(k)).f - f(at(k))).abs()).fold(0.0, f64::max)
        };
        let ratio = error(20) / error(40);
        assert!((11.0..30.0).contains(&ratio), "{ratio}");
    }

    #[test]
    fn bounds_hold_and_are_tight() {
        for seed in 0..20 {
            let patches = rough(seed);
            let mut r = Draws::new(100 + seed);
            for _ in 0..20 {
                let ([x0, x1], [y0, y1]) = (r.range([-3.1, 2.1]), r.range([0.9, 4.1]));
                let (lo, hi) = (DVec2::new(x0, y0), DVec2::new(x1, y1));
                let bounds = patches.bounds(lo, hi);
                for _ in 0..50 {
                    let q = DVec2::new(r.inside([x0, x1]), r.inside([y0, y1]));
                    let (p, c) = (patches.at(q), patches.hessian(q));
                    assert!(bounds.f.contains(p.f), "{:?} {}", bounds.f, p.f);
                    assert!(
                        bounds.slope[0].contains(p.slope.x) && bounds.slope[1].contains(p.slope.y)
                    );
                    for (range, x) in bounds.hessian.iter().zip([c.xx, c.xy, c.yy]) {
                        assert!(range.contains(x), "{range:?} {x}");
                    }
                    // The third derivatives are constant along their own axis on a patch.
                    let e = DVec2::new(1e-4, 0.0);
                    let inside = |q: DVec2| lo.cmple(q).all() && q.cmple(hi).all();
                    let same = |q: DVec2| patches.x.interval(q.x).0;
                    if inside(q - e) && inside(q + e) && same(q - e) == same(q + e) {
                        let (a, b) = (patches.hessian(q + e), patches.hessian(q - e));
                        for (range, d) in
                            bounds.third.iter().zip([a.xx - b.xx, a.xy - b.xy, a.yy - b.yy])
                        {
                            let d = d / 2e-4;
                            assert!(range.lo - 1e-6 <= d && d <= range.hi + 1e-6, "{range:?} {d}");
                        }
                    }
                }
            }
            // A point's bounds are no wider than a share of the patch makes them.
            let q = DVec2::new(-0.3, 2.2);
            let width = patches.bounds(q, q).slope[0].width();
            let c = patches.hessian(q);
            assert!(width < 0.1 * (c.norm() + 1.0), "{width}");
        }
    }

    #[test]
    fn what_is_no_grid_is_refused() {
        let k = knots(0.0, 1.0, 4);
        assert!(BicubicSpline::new(k, k, &[0.0; 16]).is_some());
        assert!(BicubicSpline::new(k, k, &[0.0; 15]).is_none());
        assert!(BicubicSpline::new(k, k, &[f64::NAN; 16]).is_none());
        assert!(BicubicSpline::new(knots(0.0, 1.0, 3), k, &[0.0; 12]).is_none());
        assert!(BicubicSpline::new(knots(1.0, 0.0, 4), k, &[0.0; 16]).is_none());
    }

    #[test]
    fn a_reflection_is_the_spline_at_reflected_places() {
        let patches = rough(7);
        for (axis, sign) in [DVec2::new(-1.0, 1.0), DVec2::new(1.0, -1.0)].into_iter().enumerate() {
            let reflected = patches.reflected(axis);
            for q in [DVec2::new(-2.3, 1.4), DVec2::new(0.1, 2.6), DVec2::new(1.9, 3.9)] {
                let (there, here) = (reflected.at(sign * q), patches.at(q));
                assert!((there.f - here.f).abs() < 1e-12, "{axis} {q}");
                assert!((there.slope - sign * here.slope).length() < 1e-12, "{axis} {q}");
                let (there, here) = (reflected.hessian(sign * q), patches.hessian(q));
                let off = [there.xx - here.xx, there.xy + here.xy, there.yy - here.yy];
                assert!(off.into_iter().all(|x| x.abs() < 1e-11), "{axis} {q}: {off:?}");
            }
        }
    }
}
