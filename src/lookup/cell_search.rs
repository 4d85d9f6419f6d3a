//! The place of a frame at which a field has wanted values: by a raster of the halves of its cells over the values.

use super::BilinearField;
use crate::geom::DVec2;
use glam::DMat2;

/// Texels of the raster along each side: cells are larger than a texel but where a field hardly changes.
const TEXELS: usize = 2048;

/// A step that changed the values by less of what was foreseen teaches nothing.
const LEAST_GAIN: f64 = 0.1;

/// Residual, px, that may grow in a step: a larger one that grows is of a step across a ridge.
const MAY_GROW_PX: f64 = 2e-3;

/// A place of the frame, and how it follows the values there: at first as the field does on its half of a cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlaceOnCell {
    /// The place, px.
    pub place: DVec2,
    /// Columns are the derivatives of the place by the values, on the half of the cell.
    on_cell: DMat2,
    /// The same as steps have shown them.
    follows: DMat2,
    /// The step before, and what was missing then.
    last: Option<[DVec2; 2]>,
    /// How far the place before the last step was off by what was missing there, px.
    off_px: f64,
}

impl PlaceOnCell {
    fn new(place: DVec2, on_cell: DMat2) -> Self {
        Self { place, on_cell, follows: on_cell, last: None, off_px: f64::INFINITY }
    }

    /// How far the place before the last step was off, px: infinite before the first.
    pub(super) fn off_px(&self) -> f64 {
        self.off_px
    }

    /// Goes by what is missing of the values at the place, and learns from how the step before fared (Broyden's method). Half of a step that
    /// led farther away, as across a ridge, is taken back.
    pub(super) fn go(&mut self, missing: DVec2) {
        self.off_px = (self.on_cell * missing).length();
        if let Some([step, before]) = self.last {
            let grows = self.off_px > (self.on_cell * before).length();
            if grows && self.off_px > MAY_GROW_PX {
                self.place -= 0.5 * step;
                self.last = Some([0.5 * step, before]);
                return;
            }
            let foreseen = self.follows * (before - missing);
            let along = step.dot(foreseen);
            if along.abs() > LEAST_GAIN * step.length_squared() {
                let row = self.follows.transpose() * step;
                let off = (step - foreseen) / along;
                self.follows += DMat2::from_cols(off * row.x, off * row.y);
            }
        }
        let step = self.follows * missing;
        self.place += step;
        self.last = Some([step, missing]);
    }
}

/// Half of a cell: the place and the values at a corner, and how places follow values.
#[derive(Debug, Clone, Copy)]
struct HalfCell {
    values: DVec2,
    at_corner: PlaceOnCell,
}

/// A raster of the halves of the cells of a field, by which places are found that have wanted values.
#[derive(Debug, Clone)]
pub struct CellSearch {
    low: DVec2,
    texel: DVec2,
    halves: Vec<HalfCell>,
    /// Number of the half that covers the middle of each texel, from 1; 0 of none.
    texels: Vec<u32>,
}

impl CellSearch {
    /// The raster of `field`, whose halves go on for as many cells as `beyond` says where there are no others.
    #[must_use]
    pub fn new(field: &BilinearField, beyond: f64) -> Self {
        let [columns, rows] = field.grid.cells();
        let cells = || (0..columns * rows).map(|k| [k % columns, k / columns]);
        let told = || cells().filter_map(|at| Some((at, field.cell(at)?)));
        let all = || told().flat_map(|(_, corners)| corners).map(DVec2::from_array);
        let low = all().fold(DVec2::INFINITY, DVec2::min);
        let high = all().fold(DVec2::NEG_INFINITY, DVec2::max);
        let cells_on = beyond / columns.min(rows).max(1) as f64;
        let (low, high) = (low - cells_on * (high - low), high + cells_on * (high - low));
        let texel = ((high - low) / TEXELS as f64).max(DVec2::splat(f64::MIN_POSITIVE));
        let texels = vec![0; TEXELS * TEXELS];
        let mut search = Self { low, texel, halves: Vec::new(), texels };
        for (at, values) in told() {
            let places = field.grid.corners(at).map(|k| DVec2::from_array(field.grid.node(k)));
            let corner = |k: usize| (places[k], DVec2::from_array(values[k]));
            for half in [[0, 1, 2], [3, 2, 1]] {
                search.add(half.map(corner));
            }
        }
        search.extend((cells_on * TEXELS as f64).ceil() as usize);
        search
    }

    /// Gives texels that no half covers the half beside them, for so many texels.
    fn extend(&mut self, texels: usize) {
        let is_covered = |k: &usize| self.texels[*k] != 0;
        let mut outermost: Vec<usize> = match texels {
            0 => Vec::new(),
            _ => (0..self.texels.len()).filter(is_covered).collect(),
        };
        for _ in 0..texels {
            let mut next = Vec::new();
            for from in outermost {
                let (column, row) = (from % TEXELS, from / TEXELS);
                let beside = [
                    (column > 0).then(|| from - 1),
                    (column + 1 < TEXELS).then_some(from + 1),
                    (row > 0).then(|| from - TEXELS),
                    (row + 1 < TEXELS).then_some(from + TEXELS),
                ];
                for k in beside.into_iter().flatten() {
                    if self.texels[k] == 0 {
                        self.texels[k] = self.texels[from];
                        next.push(k);
                    }
                }
            }
            outermost = next;
        }
    }

    fn add(&mut self, [a, b, c]: [(DVec2, DVec2); 3]) {
        let [along, down] = [b.1 - a.1, c.1 - a.1];
        let area = along.perp_dot(down);
        if area == 0.0 {
            return;
        }
        let [by_b, by_c] = [b.0 - a.0, c.0 - a.0];
        let follows = DMat2::from_cols(
            (by_b * down.y - by_c * along.y) / area,
            (by_c * along.x - by_b * down.x) / area,
        );
        let at_corner = PlaceOnCell::new(a.0, follows);
        self.halves.push(HalfCell { values: a.1, at_corner });
        let number = self.halves.len() as u32;
        let lowest = a.1 + along.min(down).min(DVec2::ZERO);
        let highest = a.1 + along.max(down).max(DVec2::ZERO);
        let [from, to] = [lowest, highest].map(|at| (at - self.low) / self.texel - 0.5);
        let range = |from: f64, to: f64| {
            from.ceil().max(0.0) as usize..=(to.floor().min(TEXELS as f64 - 1.0)).max(0.0) as usize
        };
        for row in range(from.y, to.y) {
            for column in range(from.x, to.x) {
                let middle = DVec2::new(column as f64 + 0.5, row as f64 + 0.5);
                let at = self.low + middle * self.texel - a.1;
                let [s, t] = [at.perp_dot(down), along.perp_dot(at)].map(|part| part / area);
                let texel = &mut self.texels[row * TEXELS + column];
                if s >= 0.0 && t >= 0.0 && s + t <= 1.0 && *texel == 0 {
                    *texel = number;
                }
            }
        }
    }

    /// The place, px of the frame, at which the field has these values, to the first order on its half of a cell; none where it has
    /// them nowhere.
    #[must_use]
    pub fn place(&self, values: DVec2) -> Option<DVec2> {
        self.find(values).map(|found| found.place)
    }

    /// The place at which the field has these values, to the first order; none where it has them nowhere.
    pub(super) fn find(&self, values: DVec2) -> Option<PlaceOnCell> {
        let at = (values - self.low) / self.texel;
        // (Values at the edge may be beyond it by rounding.)
        let within = |x: f64| (-1.0..=TEXELS as f64 + 1.0).contains(&x);
        if !(within(at.x) && within(at.y)) {
            return None;
        }
        let index = |x: f64| (x.max(0.0) as usize).min(TEXELS - 1);
        let [column, row] = [index(at.x), index(at.y)];
        // Beside the edge of what is told a texel's middle may be beyond it.
        let near = |at: usize| at.saturating_sub(1)..(at + 2).min(TEXELS);
        let here = self.texels[row * TEXELS + column];
        let beside =
            near(row).flat_map(|row| near(column).map(move |column| row * TEXELS + column));
        let number = [here].into_iter().chain(beside.map(|k| self.texels[k])).find(|n| *n != 0)?;
        let HalfCell { values: corner, at_corner } = self.halves[number as usize - 1];
        let place = at_corner.place + at_corner.on_cell * (values - corner);
        Some(PlaceOnCell { place, ..at_corner })
    }
}

#[cfg(test)]
mod tests {
    use super::super::PixelGrid;
    use super::*;

    /// A field that is linear is inverted to rounding, and none is found where it has no such values.
    #[test]
    fn a_linear_field_is_inverted() {
        let grid = PixelGrid { frame: [64, 48], every: 4 };
        let of = |[x, y]: [f64; 2]| [0.3 * x - 0.1 * y + 2.0, 0.05 * x + 0.2 * y];
        let values = (0..grid.count()).map(|k| Some(of(grid.node(k)))).collect();
        let corner = |k: usize| [1.0 + (k % 63) as f64, 1.0 + (k / 63) as f64];
        let known: Vec<_> = (0..63 * 47).map(corner).map(|place| (place, of(place))).collect();
        let (field, _) = BilinearField::new(grid, values, 1e12, &known);
        let search = CellSearch::new(&field, 0.0);
        for place in [[2.0, 2.0], [31.7, 20.3], [61.5, 45.9], [17.0, 30.01]] {
            let found = search.find(of(place).into()).unwrap().place;
            assert!(found.distance(place.into()) < 1e-6, "{place:?} {found}");
        }
        assert!(search.find(of([80.0, 20.0]).into()).is_none());
    }
}
