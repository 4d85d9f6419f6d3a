//! Two numbers at each node of a grid, read by bilinear interpolation.

use super::PixelGrid;
use crate::num::stats::Summary;
use crate::parallel;

/// What a table may be off by, px: cells that are off by more are left out.
pub const MOST_OFF_PX: f64 = 0.25;

/// Two numbers at each node.
#[derive(Debug, Clone, PartialEq)]
pub struct BilinearField {
    /// The nodes.
    pub grid: PixelGrid,
    /// The step, which is a number in single precision.
    pub step: f64,
    /// At each node, in whole steps; none where there is nothing.
    pub values: Vec<Option<[f64; 2]>>,
    /// Whether each cell is told, row by row.
    pub told: Vec<bool>,
}

/// What interpolation is off by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FieldErrors {
    /// In the cells that are told, px; none where there are none.
    pub off_px: Option<Summary>,
    /// Share of the places that show something which are in such cells.
    pub told: f64,
}

/// A place of the frame, px, and what is there.
pub(super) type KnownPlace = ([f64; 2], [f64; 2]);

impl BilinearField {
    /// The field of these values, in whole steps of a largest number of `most` steps, held against what is known of places between the
    /// nodes. Nodes of cells that show nothing have none; those beside what is known go on from their neighbours.
    #[must_use]
    pub fn new(
        grid: PixelGrid,
        values: Vec<Option<[f64; 2]>>,
        most: f64,
        known: &[KnownPlace],
    ) -> (Self, FieldErrors) {
        let [columns, rows] = grid.cells();
        let cell = |place: [f64; 2]| grid.cell(place).0;
        let number = |[column, row]: [usize; 2]| row * columns + column;
        let mut told = vec![false; columns * rows];
        let mut is_read = vec![false; values.len()];
        for (place, _) in known {
            told[number(cell(*place))] = true;
            grid.corners(cell(*place)).into_iter().for_each(|k| is_read[k] = true);
        }
        let read = |k: usize| is_read[k].then(|| values[k].or_else(|| extended(grid, &values, k)));
        let mut values: Vec<_> = (0..values.len()).map(|k| read(k).flatten()).collect();
        let largest = values.iter().flatten().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
        // (Readers have the step in single precision.)
        let step = f64::from((largest / (most - 1.0)).max(1e-30) as f32);
        let rounded = |value: [f64; 2]| value.map(|x| (x / step).round() * step);
        values.iter_mut().for_each(|value| *value = value.map(rounded));
        let mut field = Self { grid, values, step, told };
        let off: Vec<f64> = parallel::map_slice(known, 64, |known| field.off_px(known));
        for ((place, _), off) in known.iter().zip(&off) {
            field.told[number(cell(*place))] &= *off <= MOST_OFF_PX;
        }
        let kept = known.iter().zip(off).filter(|((at, _), _)| field.told[number(cell(*at))]);
        let kept: Vec<f64> = kept.map(|(_, off)| off).collect();
        let told = kept.len() as f64 / known.len().max(1) as f64;
        (field, FieldErrors { off_px: Summary::of(kept), told })
    }

    /// The values at the corners of a cell that is told.
    #[must_use]
    pub fn cell(&self, at: [usize; 2]) -> Option<[[f64; 2]; 4]> {
        let [columns, _] = self.grid.cells();
        if !*self.told.get(at[1] * columns + at[0])? {
            return None;
        }
        let [a, b, c, d] = self.grid.corners(at).map(|k| self.values[k]);
        Some([a?, b?, c?, d?])
    }

    /// What is read at a place of the frame, px.
    #[must_use]
    pub fn read(&self, place: [f64; 2]) -> Option<[f64; 2]> {
        let (cell, share) = self.grid.cell(place);
        Some(bilinear(&self.cell(cell)?, share))
    }

    /// How far from a place what is known there is read, px.
    fn off_px(&self, (place, exact): &KnownPlace) -> f64 {
        let (cell, share) = self.grid.cell(*place);
        let Some(corners) = self.cell(cell) else { return f64::INFINITY };
        let found = bilinear(&corners, share);
        let [along, down] = derivatives(&corners, share);
        let off = [exact[0] - found[0], exact[1] - found[1]];
        let area = along[0] * down[1] - along[1] * down[0];
        let x = (off[0] * down[1] - off[1] * down[0]) / area;
        let y = (along[0] * off[1] - along[1] * off[0]) / area;
        let off = self.grid.every as f64 * (x * x + y * y).sqrt();
        if off.is_nan() { f64::INFINITY } else { off }
    }
}

/// What a node without values has if those on one side of it go on as a parabola does, in the mean over all sides; none without three of
/// them in a row.
fn extended(grid: PixelGrid, values: &[Option<[f64; 2]>], k: usize) -> Option<[f64; 2]> {
    let nodes = grid.nodes().map(|count| count as i64);
    let at = [k as i64 % nodes[0], k as i64 / nodes[0]];
    let on = |way: [i64; 2], steps: i64| {
        let [x, y] = [0, 1].map(|axis: usize| at[axis] + steps * way[axis]);
        let is_node = (0..nodes[0]).contains(&x) && (0..nodes[1]).contains(&y);
        if is_node { values[(y * nodes[0] + x) as usize] } else { None }
    };
    let ways = (0..9).map(|k| [k % 3 - 1, k / 3 - 1]).filter(|way| *way != [0, 0]);
    let found = ways.filter_map(|way| {
        let [a, b, c] = [on(way, 1)?, on(way, 2)?, on(way, 3)?];
        Some([0, 1].map(|i| 3.0 * (a[i] - b[i]) + c[i]))
    });
    let all: Vec<[f64; 2]> = found.collect();
    let mean = [0, 1].map(|i| all.iter().map(|v| v[i]).sum::<f64>() / all.len() as f64);
    (!all.is_empty()).then_some(mean)
}

fn bilinear([a, b, c, d]: &[[f64; 2]; 4], [x, y]: [f64; 2]) -> [f64; 2] {
    std::array::from_fn(|k| {
        (1.0 - y) * ((1.0 - x) * a[k] + x * b[k]) + y * ((1.0 - x) * c[k] + x * d[k])
    })
}

/// Derivatives along and down a cell, by its sides.
fn derivatives([a, b, c, d]: &[[f64; 2]; 4], [x, y]: [f64; 2]) -> [[f64; 2]; 2] {
    let along = std::array::from_fn(|k| (1.0 - y) * (b[k] - a[k]) + y * (d[k] - c[k]));
    let down = std::array::from_fn(|k| (1.0 - x) * (c[k] - a[k]) + x * (d[k] - b[k]));
    [along, down]
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: PixelGrid = PixelGrid { frame: [40, 24], every: 4 };

    fn known(of: impl Fn([f64; 2]) -> [f64; 2]) -> Vec<KnownPlace> {
        let corner = |k: usize| [1.0 + (k % 39) as f64, 1.0 + (k / 39) as f64];
        (0..39 * 23).map(corner).map(|place| (place, of(place))).collect()
    }

    fn field(of: impl Fn([f64; 2]) -> [f64; 2] + Copy) -> (BilinearField, FieldErrors) {
        let values = (0..GRID.count()).map(|k| Some(of(GRID.node(k)))).collect();
        BilinearField::new(GRID, values, 1e9, &known(of))
    }

    /// On x + x^2 / 2 c a chord from x = 2 to 6 is off by 16 s (1 - s) / 2 c: most a quarter of a cell beside the first node, at x = 1,
    /// where s = -1/4. Its slope is 1 + 4 / c.
    #[test]
    fn a_parabola_is_off_by_what_interpolation_says() {
        for curved in [40.0, 10.0, 4.0] {
            let (found, errors) = field(|[x, y]| [x + x * x / (2.0 * curved), y]);
            let most = errors.off_px.unwrap().max;
            let exact = 0.3125 * 16.0 / (2.0 * curved) / (1.0 + 4.0 / curved);
            if exact <= MOST_OFF_PX {
                assert!((most - exact).abs() < 1e-5, "{most} {exact}");
                assert_eq!(errors.told, 1.0);
            } else {
                assert!(most <= MOST_OFF_PX && errors.told < 1.0, "{most}");
                assert_eq!(found.read([1.0, 12.0]), None);
                assert!(found.read([9.0, 12.0]).is_some());
            }
        }
    }

    /// A node that shows nothing beside some that do goes on as they do.
    #[test]
    fn a_missing_node_at_the_rim_goes_on_from_its_neighbours() {
        let of = |[x, y]: [f64; 2]| [x + x * x / 80.0, y - x * y / 200.0];
        let on_mirror = |[x, y]: [f64; 2]| x >= 8.0 && y >= 7.0;
        let node = |k: usize| Some(GRID.node(k)).filter(|&at| on_mirror(at)).map(of);
        let values = (0..GRID.count()).map(node).collect();
        let known: Vec<_> = known(of).into_iter().filter(|(at, _)| on_mirror(*at)).collect();
        let (found, errors) = BilinearField::new(GRID, values, 1e9, &known);
        assert!(errors.told == 1.0 && errors.off_px.unwrap().max < 0.1, "{errors:?}");
        assert!(found.read([8.0, 7.0]).is_some() && found.values[0].is_none());
    }

    #[test]
    fn a_cell_across_a_jump_is_left_out_and_its_neighbours_are_kept() {
        let (found, errors) = field(|[x, y]| [x, if y < 12.0 { y } else { 500.0 - y }]);
        assert_eq!(found.read([20.0, 12.0]), None);
        assert!((found.read([20.0, 9.0]).unwrap()[1] - 9.0).abs() < 1e-5);
        assert!((found.read([20.0, 15.0]).unwrap()[1] - 485.0).abs() < 1e-5);
        assert!(errors.told > 0.8 && errors.told < 0.9, "{errors:?}");
        assert!(errors.off_px.unwrap().max < 1e-5);
    }

    #[test]
    fn steps_of_a_table_count() {
        let values = (0..GRID.count()).map(|k| Some(GRID.node(k))).collect();
        let (_, errors) = BilinearField::new(GRID, values, 128.0, &known(|place| place));
        let off = errors.off_px.unwrap().max;
        assert!(off > 0.05 && off < 0.24, "{off}");
    }
}
