//! A block under a cutter: what is left of it over a grid of places after each program, and moves that should not meet it.

use super::ToolMove;
use super::band_heights::BandHeights;
use super::cutter_move::CutterMove;
use super::stock_beside::{HighestBeside, StockBeside};
use crate::geom::{Cutter, DVec2, DVec3};
use crate::parallel;

/// Places along the longer side of a block, at most, and the least distance of two, mm.
const MOST_PLACES: f64 = 400.0;
const LEAST_PITCH_MM: f64 = 0.02;
/// What is met counts from here, mm: above the rounding of programs, a tenth of a micrometre, on the steepest slopes.
const FLOOR_MM: f64 = 2e-3;
/// Rows of the grid that a thread takes at once.
const BAND: usize = 16;

/// What is left of a block, over a grid.
#[derive(Debug, Clone, PartialEq)]
pub struct StockMap {
    /// Columns and rows.
    pub size: [usize; 2],
    /// X and Y of the first place, mm.
    pub first: DVec2,
    /// Distance of the places, mm.
    pub pitch_mm: f64,
    /// Z of what is left over each place, mm, row by row with Y rising.
    pub heights: Vec<f64>,
}

/// A move into the block that should not meet it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovedInto {
    /// Line of the program.
    pub line: u32,
    /// A place where it meets the block, and Z of what was left there, mm.
    pub at: DVec3,
    /// How deep the cutter goes into it there, mm.
    pub depth_mm: f64,
}

/// A cutter in its holder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeldCutter {
    /// Its end.
    pub cutter: Cutter,
    /// Radius of what is above its teeth, mm.
    pub shank_mm: f64,
    /// Radius of the holder, mm.
    pub holder_mm: f64,
}

/// How the moves of a program meet what is left of a block.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct StockMoves {
    /// The first rapid move through the block.
    pub rapid: Option<MovedInto>,
    /// The first feed move straight down into it.
    pub plunge: Option<MovedInto>,
    /// What is highest over the tip where the shank or the cutter's end pass: teeth must be longer.
    pub by_shank: Option<StockBeside>,
    /// What is highest over the tip where the holder passes: the cutter must stand out of it by more.
    pub by_holder: Option<StockBeside>,
}

impl StockMap {
    /// A block on the plane Z = 0 between two corners, with its top at `top_mm`.
    #[must_use]
    pub fn new([min, max]: [DVec2; 2], top_mm: f64) -> Self {
        let sides = max - min;
        let pitch_mm = (sides.max_element() / MOST_PLACES).max(LEAST_PITCH_MM);
        let size = [sides.x, sides.y].map(|side| (side / pitch_mm).floor() as usize + 1);
        let heights = vec![top_mm; size[0] * size[1]];
        Self { size, first: min, pitch_mm, heights }
    }

    /// Place number `k`.
    #[must_use]
    pub fn place(&self, k: usize) -> DVec2 {
        let [columns, _] = self.size;
        self.first + self.pitch_mm * DVec2::new((k % columns) as f64, (k / columns) as f64)
    }

    /// Takes away what a cutter cuts along `moves` of its tip, one after the other.
    pub fn cut(&mut self, moves: &[ToolMove], cutter: &HeldCutter) -> StockMoves {
        let [columns, rows] = self.size;
        let bands = rows.div_ceil(BAND);
        let found = parallel::map(bands, 1, |band| {
            let from = band * BAND;
            let count = BAND.min(rows - from);
            let heights = self.heights[from * columns..(from + count) * columns].to_vec();
            let heights = BandHeights::new(heights, (columns, from), (self.first, self.pitch_mm));
            let mut band = Band::new(heights, cutter);
            moves.iter().for_each(|step| band.pass(step));
            band.end()
        });
        let mut moved = StockMoves::default();
        self.heights.clear();
        for (heights, found) in found {
            self.heights.extend(heights);
            moved.rapid = first_of(moved.rapid, found.rapid);
            moved.plunge = first_of(moved.plunge, found.plunge);
            moved.by_shank = highest_of(moved.by_shank, found.by_shank);
            moved.by_holder = highest_of(moved.by_holder, found.by_holder);
        }
        moved
    }
}

/// The one of the earlier line; of one line the deeper.
fn first_of(a: Option<MovedInto>, b: Option<MovedInto>) -> Option<MovedInto> {
    match (a, b) {
        (Some(a), Some(b)) => {
            let b_first = b.line < a.line || b.line == a.line && b.depth_mm > a.depth_mm;
            Some(if b_first { b } else { a })
        }
        (a, b) => a.or(b),
    }
}

/// The higher one; of two as high the first.
fn highest_of(a: Option<StockBeside>, b: Option<StockBeside>) -> Option<StockBeside> {
    match (a, b) {
        (Some(a), Some(b)) => Some(if b.over_tip_mm > a.over_tip_mm { b } else { a }),
        (a, b) => a.or(b),
    }
}

/// Some rows of the grid, and a cutter over them.
struct Band {
    heights: BandHeights,
    cutter: Cutter,
    by_shank: HighestBeside,
    by_holder: HighestBeside,
    found: StockMoves,
}

impl Band {
    fn new(heights: BandHeights, cutter: &HeldCutter) -> Self {
        let HeldCutter { cutter, shank_mm, holder_mm } = *cutter;
        Self {
            heights,
            cutter,
            by_shank: HighestBeside::new(shank_mm.max(cutter.radius_mm)),
            by_holder: HighestBeside::new(holder_mm),
            found: StockMoves::default(),
        }
    }

    fn end(self) -> (Vec<f64>, StockMoves) {
        let [by_shank, by_holder] = [self.by_shank.found, self.by_holder.found];
        (self.heights.into_heights(), StockMoves { by_shank, by_holder, ..self.found })
    }

    fn pass(&mut self, step: &ToolMove) {
        self.by_shank.pass(step, &mut self.heights);
        self.by_holder.pass(step, &mut self.heights);
        self.cut(step);
    }

    fn cut(&mut self, step: &ToolMove) {
        let passed = CutterMove::new(step, self.cutter);
        let ends = [step.from, step.to].map(|tip| tip.truncate());
        let [rows, columns] = self.heights.within(ends, self.cutter.radius_mm);
        for row in rows {
            for column in columns.clone() {
                let k = row * self.heights.columns() + column;
                let (at, height) = (self.heights.place(row, column), self.heights.height(k));
                // Most places are lower by then.
                if height <= passed.least(at) {
                    continue;
                }
                let Some(z) = passed.lowest(at) else { continue };
                let depth_mm = height - z;
                if depth_mm > 0.0 {
                    if depth_mm > FLOOR_MM {
                        self.meet(step, at.extend(height), depth_mm);
                    }
                    self.heights.lower(k, z);
                }
            }
        }
    }

    fn meet(&mut self, step: &ToolMove, at: DVec3, depth_mm: f64) {
        let moved = Some(MovedInto { line: step.line, at, depth_mm });
        if step.feed.is_none() {
            self.found.rapid = first_of(self.found.rapid, moved);
        } else if step.from.truncate() == step.to.truncate() && step.to.z < step.from.z {
            self.found.plunge = first_of(self.found.plunge, moved);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(from: [f64; 3], to: [f64; 3], feed: Option<f64>, line: u32) -> ToolMove {
        ToolMove { from: from.into(), to: to.into(), feed, line }
    }

    fn cutter(ball_mm: f64) -> HeldCutter {
        HeldCutter { cutter: Cutter::ball(ball_mm), shank_mm: ball_mm, holder_mm: 5.0 }
    }

    fn block() -> StockMap {
        StockMap::new([DVec2::splat(-10.0), DVec2::splat(10.0)], 5.0)
    }

    /// A groove of a ball is a part of a cylinder: 5 - (sqrt(4 - y^2) - 1) where its tip is a millimetre deep, less its lower side.
    #[test]
    fn a_groove_has_the_balls_section() {
        let mut map = block();
        let found =
            map.cut(&[step([-13.0, 0.0, 4.0], [13.0, 0.0, 4.0], Some(1.0), 1)], &cutter(2.0));
        assert_eq!((found.rapid, found.plunge), (None, None));
        for k in 0..map.heights.len() {
            let y = map.place(k).y;
            let exact = if 4.0 - y * y > 1.0 { 6.0 - f64::sqrt(4.0 - y * y) } else { 5.0 };
            assert!((map.heights[k] - exact).abs() < 1e-12, "{y}");
        }
    }

    #[test]
    fn rapid_moves_and_plunges_into_the_block_are_found_by_their_first_line() {
        let cut = step([-13.0, 0.0, 4.0], [13.0, 0.0, 4.0], Some(1.0), 1);
        let over = step([13.0, 0.0, 4.0], [-13.0, 0.0, 4.0], None, 2);
        let aside = step([-13.0, 0.5, 4.0], [13.0, 0.5, 4.0], None, 3);
        let again = step([13.0, 1.0, 4.0], [-13.0, 1.0, 4.0], None, 4);
        let found = block().cut(&[cut, over, aside, again], &cutter(2.0));
        let rapid = found.rapid.unwrap();
        assert_eq!((rapid.line, found.plunge), (3, None));
        // At most what the groove beside leaves: at y = 1.5 + 0.25, half way between both arcs' depths.
        assert!(rapid.depth_mm > 0.3 && rapid.depth_mm < 1.0, "{rapid:?}");
        let down = step([0.0, 5.0, 6.0], [0.0, 5.0, 4.5], Some(1.0), 7);
        let plunge = block().cut(&[cut, down], &cutter(2.0)).plunge.unwrap();
        assert!(plunge.line == 7 && (plunge.depth_mm - 0.5).abs() < 1e-2, "{plunge:?}");
        let ramp = step([0.0, 5.0, 6.0], [1.0, 5.0, 4.5], Some(1.0), 7);
        let found = block().cut(&[cut, ramp], &cutter(2.0));
        assert_eq!((found.rapid, found.plunge), (None, None));
    }

    /// A groove of a flat cutter has straight walls, one of a bull-nosed cutter quarters of circles in its corners.
    #[test]
    fn a_groove_has_the_cutters_section() {
        let along = step([-13.0, 0.0, 4.0], [13.0, 0.0, 4.0], Some(1.0), 1);
        for corner_mm in [0.0, 0.5] {
            let end = Cutter { radius_mm: 2.0, corner_mm };
            let mut map = block();
            map.cut(&[along], &HeldCutter { cutter: end, ..cutter(2.0) });
            for k in 0..map.heights.len() {
                let y = map.place(k).y.abs();
                let x = y - (2.0 - corner_mm);
                let exact = match x {
                    _ if y >= 2.0 => 5.0,
                    _ if x > 0.0 => 4.0 + corner_mm - f64::sqrt(corner_mm * corner_mm - x * x),
                    _ => 4.0,
                };
                assert!((map.heights[k] - exact).abs() < 1e-12, "{corner_mm} {y}");
            }
        }
    }

    /// Beside a groove that is cut in two steps, the ball has a millimetre and then two over its tip, the holder as much of the block's
    /// top, wherever it passes; beside the block, what the holder reaches of it.
    #[test]
    fn what_stands_beside_a_cutter_is_measured_from_its_tip() {
        let first = step([-13.0, 0.0, 4.0], [13.0, 0.0, 4.0], Some(1.0), 1);
        let second = step([13.0, 0.0, 2.5], [-13.0, 0.0, 2.5], Some(1.0), 2);
        let mut map = block();
        let found = map.cut(&[first], &cutter(2.0));
        let [shank, holder] = [found.by_shank, found.by_holder].map(Option::unwrap);
        assert_eq!((shank.over_tip_mm, shank.line), (1.0, 1));
        assert_eq!((holder.over_tip_mm, holder.line), (1.0, 1));
        let found = map.cut(&[second], &cutter(2.0));
        // The ball has left the block's top two millimetres and more beside its middle: sqrt(4 - 1) = 1.73 of the first groove.
        assert_eq!(found.by_shank.unwrap().over_tip_mm, 2.5);
        assert_eq!(found.by_holder.unwrap().over_tip_mm, 2.5);
        // A thin shank would pass, but the ball's sides do not.
        let thin = HeldCutter { shank_mm: 0.5, ..cutter(1.0) };
        let found = map.cut(&[second], &thin);
        assert!(found.by_shank.unwrap().over_tip_mm < 0.3, "{found:?}");
        // Down beside the block, 14 mm from its middle: the holder of 5 mm comes over its side, one of 3 mm does not.
        let beside = step([14.0, 0.0, 9.0], [14.0, 0.0, 1.0], None, 3);
        let found = block().cut(&[beside], &cutter(2.0));
        assert_eq!(
            (found.by_shank, found.by_holder.map(|beside| beside.over_tip_mm)),
            (None, Some(4.0))
        );
        let narrow = HeldCutter { holder_mm: 3.0, ..cutter(2.0) };
        assert_eq!(block().cut(&[beside], &narrow).by_holder, None);
    }
}
