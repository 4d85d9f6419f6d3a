//! Maps of degree 3 by 3 in Bezier's form, as a camera's chart shows them, and their values by Horner's rule.

use super::patch::Patch;
use crate::geom::Chart;
use crate::num::Lanes;

/// Rows that are worked on at once.
pub(super) const ROWS: usize = 4;
/// Share of a range that counts as rounding: coordinates have 15 digits and more, places are found to 1e-9 of a range.
const ROUNDING: f64 = 1e-12;
/// A number for each of the rows.
pub(super) type RowLanes = Lanes<ROWS>;

/// A control point: X and Y and the height over the chart's plane, where a lean is taken off, and the weight; all times
/// the weight.
pub(super) type Control = [f64; 4];

/// Control points of a map of degree 3 by 3, along v for the first of u's, then for the next.
#[derive(Debug, Clone, Copy)]
pub(super) struct Net(pub [[Control; 4]; 4]);

impl Net {
    /// The control points of a patch; `None` where its degree is higher.
    pub(super) fn of(patch: &Patch, chart: &Chart) -> Option<Self> {
        let [p, q] = patch.degrees;
        if p > 3 || q > 3 {
            return None;
        }
        let mut rows = [[[0.0; 4]; 4]; 4];
        for (row, points) in rows.iter_mut().zip(patch.points.chunks_exact(q + 1)) {
            for (control, point) in row.iter_mut().zip(points) {
                let up = point.p.z - chart.plane_mm * point.w;
                let upright = point.p.truncate() - chart.lean * up;
                *control = [upright.x, upright.y, up, point.w];
            }
            elevate(row, q);
        }
        for column in 0..4 {
            let mut line = rows.map(|row| row[column]);
            elevate(&mut line, p);
            rows.iter_mut().zip(line).for_each(|(row, control)| row[column] = control);
        }
        Some(Self(rows))
    }

    /// All control points.
    pub(super) fn controls(&self) -> impl Iterator<Item = &Control> {
        self.0.iter().flatten()
    }

    /// The same map over other ranges of u and v than from 0 to 1.
    pub(super) fn over(&self, [us, vs]: [[f64; 2]; 2]) -> Self {
        let mut rows = self.0.map(|row| line_over(row, vs));
        for column in 0..4 {
            let line = line_over(rows.map(|row| row[column]), us);
            rows.iter_mut().zip(line).for_each(|(row, control)| row[column] = control);
        }
        Self(rows)
    }

    /// The axis along which control points are farther apart.
    pub(super) fn longer_axis(&self) -> usize {
        let [along_u, along_v] = self
            .derivatives()
            .map(|all| all.fold(0.0, |most: f64, [x, y, up, _]| most.max(x * x + y * y + up * up)));
        usize::from(along_v > along_u)
    }

    /// Derivatives of the map along u and along v, at their control points.
    pub(super) fn derivatives(&self) -> [impl Iterator<Item = Control> + '_; 2] {
        let difference = |a: Control, b: Control| [0, 1, 2, 3].map(|k| 3.0 * (b[k] - a[k]));
        // Along u there are three rows of four, along v four rows of three.
        let [rows, columns] = [[3usize, 4], [4, 3]];
        [(rows, [1, 0]), (columns, [0, 1])].map(move |([us, vs], [du, dv])| {
            (0..us * vs).map(move |k| {
                let (i, j) = (k / vs, k % vs);
                difference(self.0[i][j], self.0[i + du][j + dv])
            })
        })
    }
}

/// Makes control points of a lower degree those of degree 3.
fn elevate(line: &mut [Control; 4], degree: usize) {
    for n in degree + 1..=3 {
        let of = *line;
        for k in 0..=n {
            let share = k as f64 / n as f64;
            let (before, own) = (of[k.saturating_sub(1)], of[k.min(n - 1)]);
            line[k] = [0, 1, 2, 3].map(|c| share * before[c] + (1.0 - share) * own[c]);
        }
    }
}

/// The control points of a cubic over another range than from 0 to 1: its blossoms there.
fn line_over(line: [Control; 4], [from, to]: [f64; 2]) -> [Control; 4] {
    let blossom = |ends: usize| {
        let mut points = line;
        for round in 1..=3 {
            let t = if round <= ends { to } else { from };
            for k in 0..=3 - round {
                let (a, b) = (points[k], points[k + 1]);
                points[k] = [0, 1, 2, 3].map(|c| a[c] + t * (b[c] - a[c]));
            }
        }
        points[0]
    };
    [0, 1, 2, 3].map(blossom)
}

/// Value and derivatives along u and v of one of a map's components, at a place for each of the rows.
pub(super) type Values = [RowLanes; 3];

/// Coefficients of the powers of u - 1/2 (outer) and v - 1/2 of each component.
#[derive(Debug, Clone, Copy)]
pub(super) struct Powers([[[f64; 4]; 4]; 4]);

impl Powers {
    pub(super) fn of(net: &Net) -> Self {
        let component = |c: usize| {
            let rows = net.0.map(|row| powers(row.map(|control| control[c])));
            let columns = [0, 1, 2, 3].map(|j| powers(rows.map(|row| row[j])));
            [0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|j: usize| columns[j][i]))
        };
        Self([0, 1, 2, 3].map(component))
    }

    /// Value and derivatives of a component, from u - 1/2 and v - 1/2.
    #[inline(always)]
    pub(super) fn at(&self, component: usize, [u, v]: [RowLanes; 2]) -> Values {
        let [a, b, c, d] = &self.0[component];
        let (a, da) = cubic(lanes(a), v);
        let (b, db) = cubic(lanes(b), v);
        let (c, dc) = cubic(lanes(c), v);
        let (d, dd) = cubic(lanes(d), v);
        let (value, along_u) = cubic([a, b, c, d], u);
        [value, along_u, ((dd * u + dc) * u + db) * u + da]
    }

    /// Whether X goes evenly along u alone and Y along v alone, but for rounding: heights over a rectangle.
    pub(super) fn are_heights(&self) -> bool {
        let is_even = |component: usize, [i, j]: [usize; 2]| {
            let all = self.0[component];
            let coefficients = all.iter().enumerate().flat_map(|(i, row)| {
                row.iter().enumerate().map(move |(j, coefficient)| ([i, j], coefficient.abs()))
            });
            let others = coefficients.filter(|(at, _)| *at != [0, 0] && *at != [i, j]);
            let rest: f64 = others.map(|(_, coefficient)| coefficient).sum();
            rest <= ROUNDING * all[i][j].abs()
        };
        is_even(0, [1, 0]) && is_even(1, [0, 1])
    }

    /// X and Y of [heights over a rectangle](Self::are_heights).
    #[inline(always)]
    pub(super) fn rectangle_at(&self, [u, v]: [RowLanes; 2]) -> [Values; 2] {
        let zero = Lanes([0.0; ROWS]);
        let ([x, along_u], [y, along_v]) = self.rectangle();
        let slope = |by: f64| Lanes([by; ROWS]);
        [
            [u * along_u + slope(x), slope(along_u), zero],
            [v * along_v + slope(y), zero, slope(along_v)],
        ]
    }

    /// Where such X and Y are these.
    #[inline(always)]
    pub(super) fn over_rectangle(&self, [x, y]: [RowLanes; 2]) -> [RowLanes; 2] {
        let even =
            |x: RowLanes, [middle, along]: [f64; 2]| (x + Lanes([-middle; ROWS])) * (1.0 / along);
        let (of_x, of_y) = self.rectangle();
        [even(x, of_x), even(y, of_y)]
    }

    /// How much X grows along u, and Y along v.
    #[inline(always)]
    pub(super) fn sides(&self) -> [f64; 2] {
        let ([_, along_u], [_, along_v]) = self.rectangle();
        [along_u, along_v]
    }

    /// X in the middle and along u, Y in the middle and along v.
    #[inline(always)]
    fn rectangle(&self) -> ([f64; 2], [f64; 2]) {
        let [x, y, ..] = &self.0;
        ([x[0][0], x[1][0]], [y[0][0], y[0][1]])
    }

    /// Values and derivatives of all components at one place.
    pub(super) fn at_one(&self, [u, v]: [f64; 2]) -> [[f64; 3]; 4] {
        let place = [u, v].map(|x| Lanes([x; ROWS]));
        [0, 1, 2, 3].map(|component| self.at(component, place).map(|value| value.0[0]))
    }
}

#[inline(always)]
fn lanes(c: &[f64; 4]) -> [RowLanes; 4] {
    [Lanes([c[0]; ROWS]), Lanes([c[1]; ROWS]), Lanes([c[2]; ROWS]), Lanes([c[3]; ROWS])]
}

/// Value and derivative of a cubic, by Horner's rule for both.
#[inline(always)]
fn cubic([a, b, c, d]: [RowLanes; 4], t: RowLanes) -> (RowLanes, RowLanes) {
    let second = d * t + c;
    let first = second * t + b;
    (first * t + a, (d * t + second) * t + first)
}

/// Coefficients of the powers of t - 1/2 of a cubic with these control points.
fn powers([a, b, c, d]: [f64; 4]) -> [f64; 4] {
    let [first, middle, last] = [b - a, c - b, d - c];
    [
        0.125 * (a + d) + 0.375 * (b + c),
        0.75 * (first + last) + 1.5 * middle,
        1.5 * (last - first),
        (d - a) - 3.0 * (c - b),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_powers_and_higher_degrees_are_the_same_map() {
        let mut net = Net([[[0.0; 4]; 4]; 4]);
        for (k, row) in net.0.iter_mut().flatten().enumerate() {
            *row = [0, 1, 2, 3].map(|c: usize| ((k * k + 3 * c) % 7) as f64 - 0.1 * k as f64);
        }
        let part = net.over([[0.25, 1.5], [-0.5, 0.5]]);
        let (whole, of_part) = (Powers::of(&net), Powers::of(&part));
        for k in 0..=10 {
            let (u, v) = (0.1 * f64::from(k), 1.0 - 0.07 * f64::from(k));
            let a = whole.at_one([0.25 + 1.25 * u - 0.5, -0.5 + v - 0.5]);
            let b = of_part.at_one([u - 0.5, v - 0.5]);
            for (a, b) in a.iter().zip(&b) {
                assert!((a[0] - b[0]).abs() < 1e-12, "{a:?} {b:?}");
                assert!((1.25 * a[1] - b[1]).abs() < 1e-11 && (a[2] - b[2]).abs() < 1e-11);
            }
        }
        let mut line = [[0.0; 4], [2.0; 4], [0.0; 4], [0.0; 4]];
        elevate(&mut line, 1);
        for (k, control) in line.iter().enumerate() {
            assert!((control[0] - 2.0 * k as f64 / 3.0).abs() < 1e-15);
        }
    }

    #[test]
    fn heights_over_a_rectangle_are_told_from_what_is_nearly_that() {
        let net = |warp: f64| {
            let control = |i: usize, j: usize| {
                let up = ((i * 5 + j * 3) % 7) as f64;
                [3.0 + i as f64 + warp * up, -1.0 + 0.5 * j as f64, up, 1.0]
            };
            Net([0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|j| control(i, j))))
        };
        let powers = Powers::of(&net(0.0).over([[0.1, 0.3], [0.7, 0.75]]));
        assert!(powers.are_heights() && !Powers::of(&net(1e-9)).are_heights());
        let at = [Lanes([0.2; ROWS]), Lanes([-0.4; ROWS])];
        let [x, y] = powers.rectangle_at(at);
        for (plan, all) in
            [x, y].iter().flatten().zip([0, 1].map(|c| powers.at(c, at)).iter().flatten())
        {
            assert!((plan.0[0] - all.0[0]).abs() < 1e-13, "{plan:?} {all:?}");
        }
        let found = powers.over_rectangle([x[0], y[0]]);
        assert!(found.iter().zip(at).all(|(a, b)| (a.0[0] - b.0[0]).abs() < 1e-12), "{found:?}");
    }
}
