//! What moves have left of a block, told from above: how low a tip comes down without meeting it.

use super::motions::{Pace, TipMove};
use super::stock_block::StockBlock;
use crate::geom::{Cutter, DVec2, DVec3};

/// Cells over the stepover of the lines that rough: balls leave 0.08 of the stepover's square over their radius between two lines, and less than
/// twice as much is told.
const CELL: f64 = 0.2;
/// Cells along the longer side of a block, at most: they take 8 MB.
const MOST_CELLS: f64 = 1000.0;
/// A tip tells of what is cut so far beside it, in stepovers of its lines: half way to the next line and some more.
const BESIDE: f64 = 0.6;

/// Heights over cells of a block's plan, below which all that moves have left of the cells lies.
pub(super) struct StockLeft {
    block: StockBlock,
    /// Side of the cells, mm, columns and rows.
    cell_mm: f64,
    size: [usize; 2],
    /// Heights, row by row, mm.
    heights_mm: Vec<f64>,
}

impl StockLeft {
    /// A whole block, of which lines at the distance `stepover_mm` will be cut first.
    pub(super) fn new(block: StockBlock, stepover_mm: f64) -> Self {
        let sides = block.max - block.min;
        let cell_mm = (CELL * stepover_mm).max(sides.max_element() / MOST_CELLS);
        let size = sides.to_array().map(|side| (side / cell_mm).ceil() as usize);
        Self { block, cell_mm, size, heights_mm: vec![block.top_mm; size[0] * size[1]] }
    }

    /// Half a diagonal of a cell, mm.
    fn half_mm(&self) -> f64 {
        self.cell_mm * std::f64::consts::FRAC_1_SQRT_2
    }

    /// The cells whose middles lie within a distance of a place of the plan: numbers, and distances of their middles.
    fn around(&self, at: DVec2, reach_mm: f64) -> impl Iterator<Item = (usize, f64)> + use<> {
        let [columns, rows] = [0, 1].map(|axis| {
            let at = (at - self.block.min)[axis];
            let [from, to] = [at - reach_mm, at + reach_mm].map(|at| at / self.cell_mm - 0.5);
            from.ceil().max(0.0) as usize
                ..((to.floor() + 1.0).max(0.0) as usize).min(self.size[axis])
        });
        let (first, cell_mm, width) = (self.block.min, self.cell_mm, self.size[0]);
        rows.flat_map(move |row| columns.clone().map(move |column| [column, row])).filter_map(
            move |[column, row]| {
                let middle = first + cell_mm * (DVec2::new(column as f64, row as f64) + 0.5);
                let off = middle.distance(at);
                (off <= reach_mm).then_some((row * width + column, off))
            },
        )
    }

    /// Lowers what moves of a cutter at feed cut, of lines at the distance `stepover_mm`.
    pub(super) fn cut(&mut self, motions: &[TipMove], cutter: Cutter, stepover_mm: f64) {
        let half_mm = self.half_mm();
        let reach_mm = cutter.radius_mm.min(BESIDE * stepover_mm + half_mm);
        let mut last: Option<DVec3> = None;
        for pair in motions.windows(2).filter(|pair| pair[1].pace != Pace::Rapid) {
            let [from, to] = [pair[0].to, pair[1].to];
            // Places a cell apart are enough.
            if last.is_some_and(|last| last.distance(to) < self.cell_mm) {
                continue;
            }
            last = Some(to);
            let steps = (from.distance(to) / self.cell_mm).ceil().max(1.0) as usize;
            for k in 1..=steps {
                let tip = from.lerp(to, k as f64 / steps as f64);
                for (cell, off) in self.around(tip.truncate(), reach_mm) {
                    if let Some(height) = cutter.height(off + half_mm) {
                        self.heights_mm[cell] = self.heights_mm[cell].min(tip.z + height);
                    }
                }
            }
        }
    }

    /// Z above which the tip of a cutter with its axis over a place of the plan is clear of what is left, mm; minus infinity beside the block.
    pub(super) fn clear_mm(&self, at: DVec2, cutter: Cutter) -> f64 {
        let half_mm = self.half_mm();
        let over = |(cell, off): (usize, f64)| {
            let height = cutter.height((off - half_mm).max(0.0))?;
            Some(self.heights_mm[cell] - height)
        };
        let cells = self.around(at, cutter.radius_mm + half_mm);
        cells.filter_map(over).fold(f64::NEG_INFINITY, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block() -> StockBlock {
        StockBlock { min: DVec2::ZERO, max: DVec2::new(20.0, 10.0), top_mm: 8.0 }
    }

    fn row(y: f64, z: f64) -> [TipMove; 2] {
        [(-5.0, Pace::Rapid), (12.0, Pace::Cut)]
            .map(|(x, pace)| TipMove { to: DVec3::new(x, y, z), pace })
    }

    /// Lines over half of a block: a ball comes down to what stands between them, exactly to the scallop but for the cells, to the block's top
    /// where nothing is cut, and as low as it likes beside it. What is told is never lower than what is left.
    #[test]
    fn a_ball_is_clear_of_what_lines_have_left() {
        for cutter in [Cutter::ball(2.0), Cutter { radius_mm: 2.0, corner_mm: 0.0 }] {
            let stepover_mm = 1.0;
            let mut left = StockLeft::new(block(), stepover_mm);
            for k in 0..11 {
                left.cut(&row(f64::from(k), 3.0), cutter, stepover_mm);
            }
            let scallop = cutter.height(0.5).unwrap();
            let cell = left.half_mm();
            for y in [1.0, 4.3, 8.5] {
                let z = left.clear_mm(DVec2::new(5.0, y), Cutter::ball(1.5));
                let most = 3.0 + cutter.height(0.6 + cell).unwrap();
                assert!(z >= 3.0 + scallop - 0.02 && z <= most + 1e-9, "{y}: {z} {scallop}");
            }
            assert_eq!(left.clear_mm(DVec2::new(17.0, 5.0), Cutter::ball(1.5)), 8.0);
            assert_eq!(left.clear_mm(DVec2::new(5.0, -1.7), Cutter::ball(1.5)), f64::NEG_INFINITY);
            // At the end of the lines a wall is told so far beside the axis as a tip tells of cuts, up to a cell's diagonal farther off, and the
            // ball comes down by its own round there.
            let down = |off: f64| 8.0 - Cutter::ball(1.5).height(off).unwrap();
            let beside = left.clear_mm(DVec2::new(12.0, 5.0), Cutter::ball(1.5));
            assert!(down(BESIDE + 2.0 * cell) <= beside && beside <= down(BESIDE), "{beside}");
        }
    }

    /// A line of moves that are much shorter than a cell leaves what one move leaves.
    #[test]
    fn short_moves_cut_as_long_ones_do() {
        let cutter = Cutter::ball(2.0);
        let [from, to] = row(5.0, 3.0);
        let short =
            (1..=1700).map(|k| TipMove { to: from.to.lerp(to.to, f64::from(k) / 1700.0), ..to });
        let short: Vec<TipMove> = std::iter::once(from).chain(short).collect();
        let told = [&short[..], &[from, to]].map(|moves| {
            let mut left = StockLeft::new(block(), 1.0);
            left.cut(moves, cutter, 1.0);
            left.clear_mm(DVec2::new(6.3, 5.0), Cutter { radius_mm: 0.4, corner_mm: 0.0 })
        });
        assert!(told[1] < 3.3 && (told[0] - told[1]).abs() < 0.03, "{told:?}");
    }

    /// Against what each of many random moves leaves of 400 places, worked out place by place.
    #[test]
    fn what_is_told_is_never_below_what_is_left() {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 40) as f64 / (1u64 << 24) as f64
        };
        let cutter = Cutter { radius_mm: 1.5, corner_mm: 0.5 };
        let mut left = StockLeft::new(block(), 1.0);
        let places: Vec<DVec3> = (0..60)
            .map(|_| DVec3::new(20.0 * random(), 10.0 * random(), 2.0 + 4.0 * random()))
            .collect();
        let moves: Vec<TipMove> =
            places.iter().map(|&to| TipMove { to, pace: Pace::Cut }).collect();
        left.cut(&moves, cutter, 1.0);
        for k in 0..400 {
            let at = DVec2::new(f64::from(k % 20) + 0.37, 0.5 * f64::from(k / 20) + 0.21);
            let lowest = places.windows(2).flat_map(|pair| {
                (0..=400).filter_map(|k| {
                    let tip = pair[0].lerp(pair[1], f64::from(k) / 400.0);
                    Some(tip.z + cutter.height(tip.truncate().distance(at))?)
                })
            });
            let exact = lowest.fold(8.0, f64::min);
            let told = left.clear_mm(at, Cutter { radius_mm: 1e-9, corner_mm: 0.0 });
            assert!(told > exact - 0.02, "{at}: {told} {exact}");
        }
    }
}
