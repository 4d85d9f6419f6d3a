//! Newton's method for the places of tiles that rays meet, four rays at once.

use super::tile::{Tile, WIDENED};
use crate::brep::bicubic::{Powers, ROWS, RowLanes, Values};
use crate::geom::Chart;
use crate::num::Lanes;

/// Steps of Newton's method at most: each leaves a third of the distance, at first.
const STEPS: usize = 12;
/// Last step of Newton's method, of a range from 0 to 1: what is left is its square.
const LAST_STEP: f64 = 1e-9;
/// How far a zero may be beyond a tile: rounding, so that none is lost between two of them.
const BEYOND: f64 = 1e-10;

/// Places on columns before, the last one first.
pub(super) type History = [[RowLanes; 2]; ORDER];
/// Number of places from which the next is foretold: it is then nearer than [`LAST_STEP`] where a tile is seen by some
/// fifty columns.
pub(super) const ORDER: usize = 6;
/// By the number of places, what each counts in the value of their polynomial at the next.
const FORETOLD: [[f64; ORDER]; ORDER + 1] = [
    [0.0; ORDER],
    [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [2.0, -1.0, 0.0, 0.0, 0.0, 0.0],
    [3.0, -3.0, 1.0, 0.0, 0.0, 0.0],
    [4.0, -6.0, 4.0, -1.0, 0.0, 0.0],
    [5.0, -10.0, 10.0, -5.0, 1.0, 0.0],
    [6.0, -15.0, 20.0, -15.0, 6.0, -1.0],
];

/// The place after those of `known` columns before, by a polynomial through them.
#[inline(always)]
pub(super) fn extrapolated(before: &History, known: usize) -> [RowLanes; 2] {
    let mut next = [Lanes([0.0; ROWS]); 2];
    for (place, share) in before.iter().zip(&FORETOLD[known]).take(known) {
        next[0] = next[0] + place[0] * *share;
        next[1] = next[1] + place[1] * *share;
    }
    clamp(&mut next);
    next
}

/// Brings places into the widened tile: nothing is known of the map farther out. What is no number begins in the
/// middle.
#[inline(always)]
fn clamp(at: &mut [RowLanes; 2]) {
    for x in at.iter_mut().flat_map(|axis| &mut axis.0) {
        *x = if *x >= -MOST {
            if *x <= MOST { *x } else { MOST }
        } else if *x < 0.0 {
            -MOST
        } else {
            0.0
        };
    }
}

/// The larger of the lengths of both, row by row.
#[inline(always)]
fn largest(by: &[RowLanes; 2]) -> RowLanes {
    let mut most = by[0];
    for (most, other) in most.0.iter_mut().zip(by[1].0) {
        *most = if other.abs() > most.abs() { other.abs() } else { most.abs() };
    }
    most
}

/// Largest distance from the middle.
const MOST: f64 = 0.5 + WIDENED;

/// Where rays meet the widened tile.
pub(super) struct Met {
    /// Parameters less a half.
    pub at: [RowLanes; 2],
    /// Height over the chart's plane, mm.
    pub up: RowLanes,
    /// Normal of any length, of the upright body.
    pub normal: [RowLanes; 3],
    /// Length of the last step; not small where the tile is not met.
    last: RowLanes,
}

impl Met {
    /// Where parallel rays meet heights over a rectangle: over their X and Y.
    #[inline(always)]
    pub(super) fn over(powers: &Powers, q: [RowLanes; 2]) -> Self {
        let at = powers.over_rectangle(q);
        let [along_x, along_y] = powers.sides();
        let [up, by_u, by_v] = powers.at(2, at);
        let normal = [by_u * -along_y, by_v * -along_x, Lanes([along_x * along_y; ROWS])];
        Self { at, up, normal, last: Lanes([0.0; ROWS]) }
    }

    /// Whether a row's ray meets the tile, above the height `up`.
    #[inline(always)]
    pub(super) fn is_above(&self, up: &RowLanes) -> [bool; ROWS] {
        const MOST: f64 = 0.5 + BEYOND;
        let [u, v] = &self.at;
        // (All are false of what is no number.)
        std::array::from_fn(|n| {
            (u.0[n].abs() <= MOST)
                & (v.0[n].abs() <= MOST)
                & (self.up.0[n] > up.0[n])
                & (self.last.0[n] <= LAST_STEP)
        })
    }

    /// The tile's parameters, from 0 to 1, of a row's place.
    #[inline]
    pub(super) fn place(&self, row: usize) -> [f64; 2] {
        self.at.map(|x| x.0[row] + 0.5)
    }
}

/// The kinds of maps that Newton's method is compiled for.
pub(super) trait MapForm {
    /// Whether the weight is 1 everywhere.
    const POLYNOMIAL: bool;

    /// X and Y, times the weight.
    #[inline(always)]
    fn plan(powers: &Powers, at: [RowLanes; 2]) -> [Values; 2] {
        [powers.at(0, at), powers.at(1, at)]
    }
}

/// See [`TileForm::Heights`](super::tile::TileForm::Heights).
pub(super) struct HeightMap;
/// See [`TileForm::Polynomial`](super::tile::TileForm::Polynomial).
pub(super) struct PolynomialMap;
/// See [`TileForm::Rational`](super::tile::TileForm::Rational).
pub(super) struct RationalMap;

impl MapForm for HeightMap {
    const POLYNOMIAL: bool = true;

    #[inline(always)]
    fn plan(powers: &Powers, at: [RowLanes; 2]) -> [Values; 2] {
        powers.rectangle_at(at)
    }
}

impl MapForm for PolynomialMap {
    const POLYNOMIAL: bool = true;
}

impl MapForm for RationalMap {
    const POLYNOMIAL: bool = false;
}

/// Newton's method for four rays at once.
#[inline(always)]
pub(super) fn newton<F: MapForm>(
    tile: &Tile,
    chart: &Chart,
    q: [RowLanes; 2],
    mut at: [RowLanes; 2],
) -> Met {
    let (k, powers) = (chart.vergence, &tile.powers);
    let one = Lanes([1.0; ROWS]);
    let zero = Lanes([0.0; ROWS]);
    let mut step = 0;
    loop {
        let ([x, y], up) = (F::plan(powers, at), powers.at(2, at));
        let w = if F::POLYNOMIAL { [one, zero, zero] } else { powers.at(3, at) };
        let scale = [w[0] - up[0] * k, w[1] - up[1] * k, w[2] - up[2] * k];
        let f = [x[0] - q[0] * scale[0], x[1] - q[0] * scale[1], x[2] - q[0] * scale[2]];
        let g = [y[0] - q[1] * scale[0], y[1] - q[1] * scale[1], y[2] - q[1] * scale[2]];
        let inverse = one / (f[1] * g[2] - f[2] * g[1]);
        let by = [(f[0] * g[2] - f[2] * g[0]) * inverse, (f[1] * g[0] - f[0] * g[1]) * inverse];
        let next = [at[0] - by[0], at[1] - by[1]];
        let last = largest(&by);
        // From the second step on, who leaves the widened tile is not in the tile.
        let is_out = |n: usize| step > 1 && next.iter().any(|x| !(x.0[n].abs() <= MOST));
        if step + 1 >= STEPS || (0..ROWS).all(|n| last.0[n] <= LAST_STEP || is_out(n)) {
            let height = up[0] - up[1] * by[0] - up[2] * by[1];
            if F::POLYNOMIAL {
                return Met { at: next, up: height, normal: cross([&x, &y, &up]), last };
            }
            let weight = w[0] - w[1] * by[0] - w[2] * by[1];
            let normal = cross([&derived(&x, &w), &derived(&y, &w), &derived(&up, &w)]);
            return Met { at: next, up: height / weight, normal, last };
        }
        at = next;
        clamp(&mut at);
        step += 1;
    }
}

/// Value, and derivatives times the square of the weight, of a component divided by the weight.
#[inline(always)]
fn derived(a: &[RowLanes; 3], w: &[RowLanes; 3]) -> [RowLanes; 3] {
    [a[0], a[1] * w[0] - a[0] * w[1], a[2] * w[0] - a[0] * w[2]]
}

/// The vector product of the derivatives along u and v.
#[inline(always)]
fn cross([x, y, z]: [&[RowLanes; 3]; 3]) -> [RowLanes; 3] {
    [y[1] * z[2] - z[1] * y[2], z[1] * x[2] - x[1] * z[2], x[1] * y[2] - y[1] * x[2]]
}
