//! Splines that vanish along the sides of a rectangle, and beyond the cells that are wanted.

use super::{AxisNode, AxisTable, Basis};
use crate::geom::Rect;
use crate::num::quadrature::gauss_legendre;

/// Gauss nodes along each side of a cell: a product of two splines' derivatives takes two, a smooth factor one more.
const NODES: usize = 3;

/// The quadratic B-spline on [0, 3], and its derivative.
fn b_spline(t: f64) -> [f64; 2] {
    match t {
        0.0..1.0 => [0.5 * t * t, t],
        1.0..2.0 => [0.75 - (t - 1.5) * (t - 1.5), -2.0 * (t - 1.5)],
        2.0..3.0 => [0.5 * (3.0 - t) * (3.0 - t), t - 3.0],
        _ => [0.0; 2],
    }
}

/// Spline number `k` of those on `cells` cells of length 1 from 0 that vanish at both ends, and its derivative: those
/// at an end are joined with their reflections, the sign changed.
fn vanishing(k: usize, cells: usize, t: f64) -> [f64; 2] {
    let from = 1.0 - k as f64;
    let [own, low, high] = [t + from, from - t, 2.0 * cells as f64 - t + from].map(b_spline);
    [own[0] - low[0] - high[0], own[1] + low[1] + high[1]]
}

impl Basis {
    /// Products of quadratic B-splines over `cells` x `cells` cells of `area` (mm) that vanish along its sides, looked at
    /// in Gauss nodes. Of these, those that are not zero at a place that is not wanted are left out; `is_wanted` has one
    /// entry for each place of [`Basis::cells`].
    #[must_use]
    pub(in crate::design) fn splines(area: Rect, cells: usize, is_wanted: &[bool]) -> Self {
        let side = NODES * cells;
        let is_free = |i: usize, j: usize| {
            let places = |k: usize| NODES * k.saturating_sub(1)..side.min(NODES * (k + 2));
            places(i).all(|a| places(j).all(|b| is_wanted[a * side + b]))
        };
        let all = (0..cells).flat_map(|i| (0..cells).map(move |j| (i, j)));
        let terms: Vec<_> = all.filter(|&(i, j)| is_free(i, j)).collect();
        Self { levels: vec![0.0; terms.len()], terms, ..Self::cells(area, cells) }
    }

    /// The places of [`Basis::splines`] with their weights, and no functions.
    #[must_use]
    pub(in crate::design) fn cells(area: Rect, cells: usize) -> Self {
        let (nodes, weights) = gauss_legendre(NODES);
        let table = |axis: usize| {
            let length = area.size()[axis] / cells as f64;
            let node = |k: usize| {
                let t = (k / NODES) as f64 + 0.5 + 0.5 * nodes[k % NODES];
                let values = (0..cells).map(|spline| vanishing(spline, cells, t));
                let (p, d) = values.map(|[p, d]| (p, d / length)).unzip();
                let weight = 0.5 * length * weights[k % NODES];
                AxisNode { at: area.min[axis] + length * t, weight, coarse: true, p, d }
            };
            AxisTable { places: (0..NODES * cells).map(node).collect() }
        };
        Self {
            along: table(0),
            across: table(1),
            terms: Vec::new(),
            levels: Vec::new(),
            size_mm: area.size().max_element(),
            is_scattered: false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::DVec2;

    #[test]
    fn splines_vanish_at_the_ends_and_have_their_derivatives() {
        for cells in [1, 2, 3, 7] {
            for k in 0..cells {
                for end in [0.0, cells as f64] {
                    assert!(vanishing(k, cells, end)[0].abs() < 1e-15, "{cells} {k}");
                }
                for step in 1..50 {
                    let (t, h) = (f64::from(step) / 50.0 * cells as f64 + 1e-3, 1e-6);
                    let [low, high] = [t - h, t + h].map(|t| vanishing(k, cells, t)[0]);
                    let [value, slope] = vanishing(k, cells, t);
                    assert!((slope - (high - low) / (2.0 * h)).abs() < 1e-8, "{cells} {k} {t}");
                    let is_in = k as f64 - 1.0 < t && t < k as f64 + 2.0;
                    assert!(is_in || value == 0.0, "{cells} {k} {t}");
                }
            }
        }
    }

    #[test]
    fn no_spline_reaches_a_place_that_is_not_wanted() {
        let area = Rect { min: DVec2::new(-2.0, 1.0), max: DVec2::new(4.0, 3.0) };
        let places = Basis::cells(area, 6);
        let is_wanted = |q: DVec2| q.x > 0.5 || q.y > 2.2;
        let wanted: Vec<bool> = (0..places.len()).map(|k| is_wanted(places.at(k))).collect();
        let basis = Basis::splines(area, 6, &wanted);
        assert!(basis.unknowns() > 5 && basis.unknowns() < 30, "{}", basis.unknowns());
        let all: f64 = (0..basis.len()).map(|k| basis.weight(k)).sum();
        assert!((all - 12.0).abs() < 1e-12);
        for k in (0..basis.len()).filter(|&k| !wanted[k]) {
            assert!(basis.row(k).all(|local| local == [0.0; 3]));
        }
    }
}
