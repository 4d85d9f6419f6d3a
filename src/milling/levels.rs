//! Roughing: the lines of a tip at levels, from the stock's top down.

use super::bridge::TipLines;
use super::motions::{MotionList, TipMove};
use super::stock_block::StockBlock;
use super::tip_line::{TipLine, thinned};
use crate::geom::{DVec2, DVec3, Rect};
use crate::machining::BallRaster;

/// How far the ball stays clear of the stock's sides where it comes down beside them, mm.
const BESIDE_MM: f64 = 1.0;
/// What is to be clear of a tip that comes down fast over what an earlier level has cut, mm.
const CLEARANCE_MM: f64 = 0.5;
/// A tip goes over to the next line beside the stock, if that is no farther than so many stepovers.
const NEXT: f64 = 4.0;

/// How levels are cut.
pub(super) struct LevelCut {
    /// The block.
    pub stock: StockBlock,
    /// The lines' ball and direction.
    pub raster: BallRaster,
    /// From level to level, mm.
    pub stepdown_mm: f64,
    /// What straight moves may be off the path, mm.
    pub chord_mm: f64,
    /// Height of rapid moves, mm.
    pub safe_mm: f64,
}

impl LevelCut {
    /// The moves at all levels, and how many levels there are.
    pub(super) fn moves(&self, lines: &TipLines) -> (Vec<TipMove>, usize) {
        let lines = self.over_the_block(lines);
        let lowest = lines.iter().flat_map(|line| &line.places).map(|at| at.z);
        let lowest = lowest.fold(f64::INFINITY, f64::min);
        let mut list = MotionList::new(self.safe_mm);
        let (mut above, mut levels) = (f64::INFINITY, 0);
        while above > lowest {
            levels += 1;
            let level = (self.stock.top_mm - levels as f64 * self.stepdown_mm).max(lowest);
            let mut backwards = levels % 2 == 0;
            let turned: Vec<&TipLine> =
                if backwards { lines.iter().rev().collect() } else { lines.iter().collect() };
            for line in turned {
                let cuts = level_cuts(&line.places, [level, above]);
                let cuts = cuts.into_iter().map(|cut| thinned(&cut, self.chord_mm));
                let mut cuts: Vec<Vec<DVec3>> = cuts.collect();
                if backwards {
                    cuts.reverse();
                    cuts.iter_mut().for_each(|cut| cut.reverse());
                }
                cuts.iter().for_each(|cut| self.follow(&mut list, cut));
                backwards = !backwards;
            }
            above = level;
        }
        (list.finish(), levels)
    }

    /// From where the tip is to the beginning of a cut, and along it.
    fn follow(&self, list: &mut MotionList, cut: &[DVec3]) {
        let Some(&begin) = cut.first() else { return };
        let beside = self.around();
        let is_clear = |at: DVec3| !beside.contains(at.truncate());
        match list.place() {
            Some(at)
                if is_clear(at)
                    && is_clear(begin)
                    && is_clear(0.5 * (at + begin))
                    && (begin - at).truncate().length() <= NEXT * self.raster.stepover_mm =>
            {
                list.rapid(begin);
            }
            _ if is_clear(begin) => {
                list.over(begin, begin.z);
            }
            _ => {
                // What earlier levels have left of the line is within the chords of both.
                let above = begin + DVec3::Z * (2.0 * self.chord_mm);
                list.over(begin, begin.z + CLEARANCE_MM);
                list.entry(above);
                list.cut(cut[1..].iter().copied());
                return;
            }
        }
        list.cut(cut.iter().copied());
    }

    /// The plan of the block, grown by the ball, in which a tip may meet it.
    fn around(&self) -> Rect {
        let reach = DVec2::splat(self.raster.ball_mm + 0.5 * BESIDE_MM);
        Rect { min: self.stock.min - reach, max: self.stock.max + reach }
    }

    /// The lines from one side of the block to the other, with more of them beside the mirror, and those of its ridge.
    ///
    /// Outside the mirror a line goes on at its height, and lines beside the outermost one at its heights: the mirror has no place
    /// there that could be in the way.
    fn over_the_block(&self, lines: &TipLines) -> Vec<TipLine> {
        let across = self.raster.along().perp();
        let corners = self.stock.corners().map(|corner| corner.dot(across));
        let most = corners.into_iter().fold(f64::MIN, f64::max);
        let least = corners.into_iter().fold(f64::MAX, f64::min);
        let step = self.raster.stepover_mm;
        let middle = |line: &TipLine| {
            let sum: f64 = line.places.iter().map(|at| at.truncate().dot(across)).sum();
            sum / line.places.len() as f64
        };
        let (Some(first), Some(last)) = (lines.across.first(), lines.across.last()) else {
            return Vec::new();
        };
        let count = |room: f64| (room / step).ceil().max(0.0) as usize;
        let below = count(middle(first) - least);
        let above = count(most - middle(last));
        let before = (1..=below).rev().map(|k| first.shifted(across * (-step * k as f64)));
        let after = (1..=above).map(|k| last.shifted(across * (step * k as f64)));
        let all = before.chain(lines.across.iter().cloned()).chain(after);
        all.chain(lines.ridge.iter().cloned()).map(|line| self.extended(line)).collect()
    }

    /// A line with both ends straight on at their heights until they are beside the block.
    fn extended(&self, mut line: TipLine) -> TipLine {
        let reach = DVec2::splat(self.raster.ball_mm + BESIDE_MM);
        let around = Rect { min: self.stock.min - reach, max: self.stock.max + reach };
        let [from, to] = line.ends();
        let [first, last] = line.directions.map(|way| way.truncate().normalize_or_zero());
        if let Some(way) = way_out(around, from.truncate(), -first) {
            line.places.insert(0, from - (first * way).extend(0.0));
        }
        if let Some(way) = way_out(around, to.truncate(), last) {
            line.places.push(to + (last * way).extend(0.0));
        }
        line
    }
}

/// How far it is along `way` from a place within a rectangle to its side; none from outside.
fn way_out(rect: Rect, from: DVec2, way: DVec2) -> Option<f64> {
    if !rect.contains(from) {
        return None;
    }
    let side = |from: f64, way: f64, [min, max]: [f64; 2]| {
        if way > 0.0 {
            (max - from) / way
        } else if way < 0.0 {
            (min - from) / way
        } else {
            f64::INFINITY
        }
    };
    let x = side(from.x, way.x, [rect.min.x, rect.max.x]);
    let y = side(from.y, way.y, [rect.min.y, rect.max.y]);
    Some(x.min(y)).filter(|way| way.is_finite())
}

/// The parts of a line that lie lower than the level `above`, which is cut, no lower than `level`.
#[must_use]
pub fn level_cuts(places: &[DVec3], [level, above]: [f64; 2]) -> Vec<Vec<DVec3>> {
    let (mut cuts, mut cut) = (Vec::new(), Vec::<DVec3>::new());
    let held = |at: DVec3| at.with_z(at.z.max(level));
    for pair in places.windows(2) {
        let [from, to] = [pair[0], pair[1]];
        // Where the move passes through either level.
        let mut stops: Vec<DVec3> = vec![from];
        let mut crossings: Vec<f64> = [level, above]
            .into_iter()
            .filter(|height| (from.z - height) * (to.z - height) < 0.0)
            .map(|height| (height - from.z) / (to.z - from.z))
            .collect();
        crossings.sort_by(f64::total_cmp);
        stops.extend(crossings.into_iter().map(|share| from.lerp(to, share)));
        stops.push(to);
        for part in stops.windows(2) {
            if 0.5 * (part[0].z + part[1].z) < above {
                if cut.is_empty() {
                    cut.push(held(part[0]));
                }
                cut.push(held(part[1]));
            } else if !cut.is_empty() {
                cuts.push(std::mem::take(&mut cut));
            }
        }
    }
    if !cut.is_empty() {
        cuts.push(cut);
    }
    cuts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_cut_below_the_level_before_and_down_to_its_own() {
        let places = [(0.0, 0.0), (10.0, 10.0), (20.0, 0.0)].map(|(x, z)| DVec3::new(x, 1.0, z));
        let found = level_cuts(&places, [4.0, 7.0]);
        let flat = |cut: &Vec<DVec3>| cut.iter().map(|at| (at.x, at.z)).collect::<Vec<_>>();
        assert_eq!(
            found.iter().map(flat).collect::<Vec<_>>(),
            [vec![(0.0, 4.0), (4.0, 4.0), (7.0, 7.0)], vec![(13.0, 7.0), (16.0, 4.0), (20.0, 4.0)]]
        );
        assert_eq!(level_cuts(&places, [12.0, f64::INFINITY])[0][1], DVec3::new(10.0, 1.0, 12.0));
        assert!(level_cuts(&places, [-2.0, -1.0]).is_empty());
    }

    #[test]
    fn lines_leave_the_block_on_every_side() {
        let rect = Rect { min: DVec2::new(-2.0, -1.0), max: DVec2::new(4.0, 3.0) };
        let way = |x: f64, y: f64| way_out(rect, DVec2::ZERO, DVec2::new(x, y));
        assert_eq!((way(1.0, 0.0), way(-1.0, 0.0)), (Some(4.0), Some(2.0)));
        assert_eq!((way(0.6, 0.8), way(0.0, 0.0)), (Some(3.75), None));
        assert_eq!(way_out(rect, DVec2::splat(9.0), DVec2::X), None);
    }
}
