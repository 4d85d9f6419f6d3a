//! Numbers on a regular grid: the bicubic spline through them, twice differentiable.

mod patch_bounds;

use super::{DVec2, DerivativeBounds, GridAxis};
use crate::parallel;

/// f and its derivatives f_s, f_t, f_st at a node, per step of the grid: a patch between four nodes
/// is the Hermite bicubic of theirs.
type Node = [f64; 4];

/// The tensor product of cubic splines through values on a regular grid, "not a knot" at the ends
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

    /// Largest magnitude of its values at the knots.
    #[must_use]
    pub fn largest_value(&self) -> f64 {
        self.nodes.iter().fold(0.0, |most, [f, ..]| most.max(f.abs()))
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
        all.reduce(DerivativeBounds::union).expect("a box touches a patch")
    }

    /// The spline on the line of constant `y`.
    #[must_use]
    pub fn row(&self, y: f64) -> BicubicSplineRow<'_> {
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

    /// The second derivatives f_xx, f_xy and f_yy at a point.
    #[must_use]
    pub fn second(&self, q: DVec2) -> [f64; 3] {
        let ((i, s), (j, t)) = (self.x.interval(q.x), self.y.interval(q.y));
        let column =
            |i: usize| [&self.nodes[j * self.x.count + i], &self.nodes[(j + 1) * self.x.count + i]];
        let second = |along: [f64; 4], across: [f64; 4]| {
            sum(fold(column(i), &across), fold(column(i + 1), &across), &along)
        };
        let (dx, dy) = (self.x.step_mm, self.y.step_mm);
        [
            second(hermite_second(s), hermite(t)) / (dx * dx),
            second(hermite_slope(s), hermite_slope(t)) / (dx * dy),
            second(hermite(s), hermite_second(t)) / (dy * dy),
        ]
    }

    /// The same function on the grid and a step beyond, where its end patches go on; over so many further `steps` with
    /// constant second derivatives across the edge, and from there on linear: over so many `rings` along X and Y, and on
    /// without end. Its second derivatives have no jump but where the linear part begins.
    #[must_use]
    pub fn with_ends(&self, steps: usize, rings: [usize; 2]) -> Self {
        let (x, y) = (self.x.widened(1), self.y.widened(1));
        let going_on = |k: usize| self.node_at(DVec2::new(x.at(k % x.count), y.at(k / x.count)));
        let nodes = parallel::map(x.count * y.count, x.count, going_on);
        let wider = Self { x, y, nodes }.continued(0, steps, true).continued(1, steps, true);
        wider.continued(0, rings[0], false).continued(1, rings[1], false)
    }

    /// The same function, going on over so many steps to either side along an axis: with the second derivatives that it
    /// has at the ends, or none.
    fn continued(&self, axis: usize, steps: usize, bends: bool) -> Self {
        let mut wider = Self { nodes: Vec::new(), ..self.clone() };
        let along = if axis == 0 { &mut wider.x } else { &mut wider.y };
        *along = along.widened(steps);
        let (count, columns) = ([self.x, self.y][axis].count, wider.x.count);
        // A node's value and slope along the axis, and the same of its slope across.
        let pairs = if axis == 0 { [[0, 1], [2, 3]] } else { [[0, 2], [1, 3]] };
        let node = |k: usize| {
            let mut at = [k % columns, k / columns];
            let inside = at[axis].clamp(steps, steps + count - 1);
            let t = at[axis] as f64 - inside as f64;
            at[axis] = inside - steps;
            let of = |at: [usize; 2]| self.nodes[at[1] * self.x.count + at[0]];
            let mut node = of(at);
            if t == 0.0 {
                return node;
            }
            let inwards = if t < 0.0 { at[axis] + 1 } else { at[axis] - 1 };
            let next = of(if axis == 0 { [inwards, at[1]] } else { [at[0], inwards] });
            for [value, slope] in pairs {
                let (f, d) = (node[value], node[slope]);
                // Of the cubic between both nodes, at this one.
                let second = 6.0 * (next[value] - f) + t.signum() * (4.0 * d + 2.0 * next[slope]);
                let second = if bends { second } else { 0.0 };
                node[value] = f + t * (d + 0.5 * t * second);
                node[slope] = d + t * second;
            }
            node
        };
        wider.nodes = parallel::map(wider.x.count * wider.y.count, columns, node);
        wider
    }

    /// What a node at `q` would hold.
    fn node_at(&self, q: DVec2) -> Node {
        let ((i, s), (j, t)) = (self.x.interval(q.x), self.y.interval(q.y));
        let column =
            |i: usize| [&self.nodes[j * self.x.count + i], &self.nodes[(j + 1) * self.x.count + i]];
        let of = |along: [f64; 4], across: [f64; 4]| {
            sum(fold(column(i), &across), fold(column(i + 1), &across), &along)
        };
        let (along, across) = ([hermite(s), hermite_slope(s)], [hermite(t), hermite_slope(t)]);
        [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(p, q)| of(along[p], across[q]))
    }

    /// The spline reflected in the line where the coordinate `axis` is 0.
    #[must_use]
    pub fn reflected(&self, axis: usize) -> Self {
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

impl BicubicSplineRow<'_> {
    /// f and (f_x, f_y) at `x`.
    #[inline]
    #[must_use]
    pub fn value_and_slope(&self, x: f64) -> (f64, DVec2) {
        let (i, s) = self.x.interval(x);
        let column = |i: usize| self.rows.map(|row| &row[i]);
        let (left, right) = (column(i), column(i + 1));
        let (l, r) = (fold(left, &self.value), fold(right, &self.value));
        let along = hermite(s);
        let slope = DVec2::new(
            sum(l, r, &hermite_slope(s)),
            sum(fold(left, &self.slope), fold(right, &self.slope), &along),
        );
        (sum(l, r, &along), slope * self.per_step)
    }
}
