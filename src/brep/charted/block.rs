//! A few rows of a few rays, met with the pieces of a body that the chart shows there.

use super::tile::{Tile, TileForm, WIDENED};
use crate::brep::bicubic::{Powers, ROWS, RowLanes, Values};
use crate::geom::{Chart, DVec2, DVec3};
use crate::num::Lanes;

/// Columns of a block.
pub(super) const COLUMNS: usize = 64;
/// Steps of Newton's method at most: each leaves a third of the distance, at first.
const STEPS: usize = 12;
/// Last step of Newton's method, of a range from 0 to 1: what is left is its square.
const LAST_STEP: f64 = 1e-9;
/// How far a zero may be beyond a tile: rounding, so that none is lost between two of them.
const BEYOND: f64 = 1e-10;

/// Where a ray meets a tile or a plane face: the highest such place so far.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    /// Height over the chart's plane, mm.
    pub up: f64,
    pub face: u32,
    /// Normal of any length.
    pub normal: DVec3,
}

impl Found {
    pub(super) const NOTHING: Self =
        Self { up: f64::NEG_INFINITY, face: u32::MAX, normal: DVec3::ZERO };
}

/// Chart coordinates of some rays, and what they meet.
pub(super) struct Block {
    /// By column, of all rows; not numbers where there is no ray.
    pub rays: [[DVec2; ROWS]; COLUMNS],
    /// Number of columns.
    pub columns: usize,
    /// The box around all.
    pub bounds: [DVec2; 2],
    pub found: [[Found; ROWS]; COLUMNS],
}

impl Block {
    /// The block of rows, from one column on.
    pub(super) fn new(rows: &[&[DVec2]], first: usize) -> Self {
        let columns = (rows[0].len() - first).min(COLUMNS);
        let mut rays = [[DVec2::NAN; ROWS]; COLUMNS];
        let (mut lo, mut hi) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for (k, row) in rows.iter().enumerate() {
            for (column, &q) in rays.iter_mut().zip(&row[first..first + columns]) {
                column[k] = q;
                // (NaN stays out.)
                (lo, hi) = (q.min(lo), q.max(hi));
            }
        }
        let found = [[Found::NOTHING; ROWS]; COLUMNS];
        Self { rays, columns, bounds: [lo, hi], found }
    }

    /// The least height of what rays meet; minus infinity while one meets nothing.
    pub(super) fn lowest(&self) -> f64 {
        let all = self.found[..self.columns].iter().flatten().zip(self.rays.iter().flatten());
        all.filter(|(_, q)| !q.x.is_nan())
            .fold(f64::INFINITY, |least, (found, _)| least.min(found.up))
    }

    /// Meets all rays with a tile; `is_own` tells whether parameters of its patch belong to the face.
    pub(super) fn meet(
        &mut self,
        tile: &Tile,
        chart: &Chart,
        is_own: &mut dyn FnMut([f64; 2], DVec3) -> bool,
    ) {
        let mut before: History = [[Lanes([0.0; ROWS]); 2]; ORDER];
        let mut known = 0;
        for column in 0..self.columns {
            let rays = &self.rays[column];
            if !rays.iter().any(|&q| tile.bounds.holds(q)) {
                known = 0;
                continue;
            }
            let q = [Lanes(rays.map(|q| q.x)), Lanes(rays.map(|q| q.y))];
            // Parallel rays meet heights over a rectangle where their X and Y are.
            let start = match tile.form {
                TileForm::Heights if chart.vergence == 0.0 => tile.powers.over_rectangle(q),
                _ => extrapolated(&before, known),
            };
            let met = match tile.form {
                TileForm::Heights => newton::<Heights>(tile, chart, q, start),
                TileForm::Polynomial => newton::<Polynomial>(tile, chart, q, start),
                TileForm::Rational => newton::<Rational>(tile, chart, q, start),
            };
            before.copy_within(0..ORDER - 1, 1);
            before[0] = met.at;
            known = (known + 1).min(ORDER);
            for (row, q) in rays.iter().enumerate() {
                let found = &mut self.found[column][row];
                let Some(place) = met.above(row, found.up) else { continue };
                let up = met.up.0[row];
                if tile.trimmed {
                    let of_patch = [0, 1].map(|k| {
                        let [from, to] = tile.part[k];
                        from + (to - from) * place[k]
                    });
                    let at = *q * (1.0 - chart.vergence * up) + chart.lean * up;
                    if !is_own(of_patch, at.extend(up + chart.plane_mm)) {
                        continue;
                    }
                }
                let upright = DVec3::from_array(met.normal.map(|x| x.0[row]));
                let normal = upright - DVec3::Z * upright.truncate().dot(chart.lean);
                let normal = if tile.same { normal } else { -normal };
                *found = Found { up, face: tile.face, normal };
            }
        }
    }
}

/// Places on columns before, the last one first.
type History = [[RowLanes; 2]; ORDER];
/// Number of places from which the next is foretold: it is then nearer than [`LAST_STEP`] where a tile is seen by some
/// fifty columns.
const ORDER: usize = 6;
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
fn extrapolated(before: &History, known: usize) -> [RowLanes; 2] {
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
struct Met {
    /// Parameters less a half.
    at: [RowLanes; 2],
    /// Height over the chart's plane, mm.
    up: RowLanes,
    /// Normal of any length, of the upright body.
    normal: [RowLanes; 3],
    /// Length of the last step; not small where the tile is not met.
    last: RowLanes,
}

impl Met {
    /// The tile's parameters, from 0 to 1, of the place where a row's ray meets it; none where it does not, or not above
    /// the height `up`.
    #[inline(always)]
    fn above(&self, row: usize, up: f64) -> Option<[f64; 2]> {
        let place = self.at.map(|x| x.0[row] + 0.5);
        let is_inside = place.iter().all(|x| *x >= -BEYOND && *x <= 1.0 + BEYOND);
        // (Also false of what is no number.)
        let is_met = is_inside && self.up.0[row] > up && self.last.0[row] <= LAST_STEP;
        is_met.then_some(place)
    }
}

/// The kinds of maps that Newton's method is compiled for.
trait MapForm {
    /// Whether the weight is 1 everywhere.
    const POLYNOMIAL: bool;

    /// X and Y, times the weight.
    #[inline(always)]
    fn plan(powers: &Powers, at: [RowLanes; 2]) -> [Values; 2] {
        [powers.at(0, at), powers.at(1, at)]
    }
}

/// See [`TileForm::Heights`].
struct Heights;
/// See [`TileForm::Polynomial`].
struct Polynomial;
/// See [`TileForm::Rational`].
struct Rational;

impl MapForm for Heights {
    const POLYNOMIAL: bool = true;

    #[inline(always)]
    fn plan(powers: &Powers, at: [RowLanes; 2]) -> [Values; 2] {
        powers.rectangle_at(at)
    }
}

impl MapForm for Polynomial {
    const POLYNOMIAL: bool = true;
}

impl MapForm for Rational {
    const POLYNOMIAL: bool = false;
}

/// Newton's method for four rays at once.
#[inline(always)]
fn newton<F: MapForm>(tile: &Tile, chart: &Chart, q: [RowLanes; 2], mut at: [RowLanes; 2]) -> Met {
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
