//! Roughing: a bar is faced at levels, from its top down.

use super::bar::Bar;
use crate::geom::DVec3;
use crate::milling::{MotionList, TipMove, level_cuts, thinned};

/// How far the nose stays clear of the bar's side where it comes down beside it, mm.
pub(super) const BESIDE_MM: f64 = 1.0;
/// What moves may be off a level, which is straight, mm: less than programs have decimals for.
const STRAIGHT_MM: f64 = 1e-5;
/// What is to be clear of a tool that comes down fast over what an earlier level has cut, mm.
const CLEARANCE_MM: f64 = 0.5;

/// How levels are cut.
pub(super) struct FacingLevels {
    /// The bar.
    pub bar: Bar,
    /// From level to level, mm.
    pub stepdown_mm: f64,
    /// What an earlier level may have left over its path, mm: its chords and cusps.
    pub left_mm: f64,
    /// Height of rapid moves, mm.
    pub safe_mm: f64,
}

impl FacingLevels {
    /// The moves at all levels along the path of a tool point from beside the bar to the axis, and how many levels there are.
    pub(super) fn moves(&self, path: &[DVec3]) -> (Vec<TipMove>, usize) {
        let lowest = path.iter().map(|at| at.z).fold(f64::INFINITY, f64::min);
        let mut list = MotionList::new(self.safe_mm);
        let (mut above, mut levels) = (f64::INFINITY, 0);
        while above > lowest {
            levels += 1;
            let level = (self.bar.top_mm - levels as f64 * self.stepdown_mm).max(lowest);
            for cut in level_cuts(path, [level, above]) {
                self.follow(&mut list, &thinned(&cut, STRAIGHT_MM));
            }
            above = level;
        }
        (list.finish(), levels)
    }

    /// From where the tool is, over the bar, to the beginning of a cut, and along it.
    fn follow(&self, list: &mut MotionList, cut: &[DVec3]) {
        let Some(&begin) = cut.first() else { return };
        if begin.x > self.bar.radius_mm {
            list.over(begin, begin.z);
            list.cut(cut.iter().copied());
        } else {
            list.over(begin, begin.z + self.left_mm + CLEARANCE_MM);
            list.entry(begin + DVec3::Z * self.left_mm);
            list.cut(cut[1..].iter().copied());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::milling::Pace;

    /// A bowl 3 mm deep under a bar that stands a millimetre over it: the first level begins beside the bar, the others where the bowl
    /// is as deep as the level before.
    #[test]
    fn levels_begin_beside_the_bar_or_where_the_path_falls_below_the_one_before() {
        let path = [(12.0, 9.0), (10.0, 9.0), (4.0, 6.0), (0.0, 6.0)];
        let path = path.map(|(x, z)| DVec3::new(x, 0.0, z));
        let bar = Bar { radius_mm: 11.0, top_mm: 10.0 };
        let levels = FacingLevels { bar, stepdown_mm: 1.5, left_mm: 0.01, safe_mm: 15.0 };
        let (moves, count) = levels.moves(&path);
        assert_eq!(count, 3);
        let cuts: Vec<DVec3> =
            moves.iter().filter(|step| step.pace == Pace::Cut).map(|step| step.to).collect();
        assert_eq!(cuts[0], DVec3::new(10.0, 0.0, 9.0));
        assert!(cuts.iter().any(|at| *at == DVec3::new(0.0, 0.0, 8.5)));
        assert!(cuts.iter().any(|at| *at == DVec3::new(0.0, 0.0, 7.0)));
        assert_eq!(cuts[cuts.len() - 1], DVec3::new(0.0, 0.0, 6.0));
        let entries: Vec<DVec3> =
            moves.iter().filter(|step| step.pace == Pace::Entry).map(|step| step.to).collect();
        assert_eq!(entries.len(), 2);
        // The path is at 8.5 and at 7 there.
        for (at, [x, z]) in entries.iter().zip([[9.0, 8.51], [6.0, 7.01]]) {
            assert!((at.x - x).abs() + (at.z - z).abs() < 1e-12, "{at}");
        }
        let rapid = moves.iter().filter(|step| step.pace == Pace::Rapid);
        assert!(rapid.clone().all(|step| step.to.z >= 7.5 || step.to.x > 11.0));
        assert_eq!(moves[moves.len() - 1].to.z, 15.0);
    }
}
