//! A block under a ball cutter: what is left of it over a grid of places after each program, and moves that should not meet it.

use super::ToolMove;
use super::swept_ball::lower_side;
use crate::geom::{DVec2, DVec3};
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

/// What is wrong with the moves of a program on what is left of a block: the first of each kind.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct StockMoves {
    /// A rapid move through the block.
    pub rapid: Option<MovedInto>,
    /// A feed move straight down into it.
    pub plunge: Option<MovedInto>,
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

    /// Takes away what the ball of radius `radius_mm` cuts along `moves` of its tip, one after the other.
    pub fn cut(&mut self, moves: &[ToolMove], radius_mm: f64) -> StockMoves {
        let [columns, rows] = self.size;
        let bands = rows.div_ceil(BAND);
        let found = parallel::map(bands, 1, |band| {
            let from = band * BAND;
            let count = BAND.min(rows - from);
            let heights = self.heights[from * columns..(from + count) * columns].to_vec();
            let mut band = Band { map: self, from, heights, found: StockMoves::default() };
            moves.iter().for_each(|step| band.cut(step, radius_mm));
            (band.heights, band.found)
        });
        let mut moved = StockMoves::default();
        self.heights.clear();
        for (heights, found) in found {
            self.heights.extend(heights);
            moved.rapid = first_of(moved.rapid, found.rapid);
            moved.plunge = first_of(moved.plunge, found.plunge);
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

/// Some rows of the grid.
struct Band<'a> {
    map: &'a StockMap,
    from: usize,
    heights: Vec<f64>,
    found: StockMoves,
}

impl Band<'_> {
    fn cut(&mut self, step: &ToolMove, radius_mm: f64) {
        let [columns, _] = self.map.size;
        let rows = self.heights.len() / columns;
        let up = DVec3::Z * radius_mm;
        let centres = [step.from + up, step.to + up];
        let [a, b] = centres.map(|centre| (centre.truncate() - self.map.first) / self.map.pitch_mm);
        let reach = radius_mm / self.map.pitch_mm;
        let range = |low: f64, high: f64, count: usize| {
            let from = (low - reach).ceil().max(0.0);
            let to = (high + reach).floor().min(count as f64 - 1.0);
            if to < from { 0..0 } else { from as usize..to as usize + 1 }
        };
        let down = self.from as f64;
        let lines = range(a.y.min(b.y) - down, a.y.max(b.y) - down, rows);
        if lines.is_empty() {
            return;
        }
        let places = range(a.x.min(b.x), a.x.max(b.x), columns);
        let middle = 0.5 * (centres[0] + centres[1]).truncate();
        let half = 0.5 * (centres[1] - centres[0]).truncate().length();
        let lowest = step.from.z.min(step.to.z);
        for row in lines {
            for column in places.clone() {
                let k = row * columns + column;
                let at = self.map.place((self.from + row) * columns + column);
                // A ball's lower side is above the paraboloid of its curvature; most places are lower by then.
                let beside = (at.distance(middle) - half).max(0.0);
                if self.heights[k] <= lowest + beside * beside / (2.0 * radius_mm) {
                    continue;
                }
                let Some((z, _)) = lower_side(&centres, at, radius_mm) else { continue };
                let depth_mm = self.heights[k] - z;
                if depth_mm > 0.0 {
                    if depth_mm > FLOOR_MM {
                        self.meet(step, at.extend(self.heights[k]), depth_mm);
                    }
                    self.heights[k] = z;
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

    fn block() -> StockMap {
        StockMap::new([DVec2::splat(-10.0), DVec2::splat(10.0)], 5.0)
    }

    /// A groove of a ball is a part of a cylinder: 5 - (sqrt(4 - y^2) - 1) where its tip is a millimetre deep, less its lower side.
    #[test]
    fn a_groove_has_the_balls_section() {
        let mut map = block();
        let found = map.cut(&[step([-13.0, 0.0, 4.0], [13.0, 0.0, 4.0], Some(1.0), 1)], 2.0);
        assert_eq!(found, StockMoves::default());
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
        let found = block().cut(&[cut, over, aside, again], 2.0);
        let rapid = found.rapid.unwrap();
        assert_eq!((rapid.line, found.plunge), (3, None));
        // At most what the groove beside leaves: at y = 1.5 + 0.25, half way between both arcs' depths.
        assert!(rapid.depth_mm > 0.3 && rapid.depth_mm < 1.0, "{rapid:?}");
        let down = step([0.0, 5.0, 6.0], [0.0, 5.0, 4.5], Some(1.0), 7);
        let plunge = block().cut(&[cut, down], 2.0).plunge.unwrap();
        assert!(plunge.line == 7 && (plunge.depth_mm - 0.5).abs() < 1e-2, "{plunge:?}");
        let ramp = step([0.0, 5.0, 6.0], [1.0, 5.0, 4.5], Some(1.0), 7);
        assert_eq!(block().cut(&[cut, ramp], 2.0), StockMoves::default());
    }
}
