//! Tip lines out of the paths of a ball: what lies between the parts of one line.

use super::tip_line::TipLine;
use crate::geom::DVec3;
use crate::machining::{BallPath, BallPaths};

/// Parts whose ends are nearer to each other in the plan go on without a bridge, mm.
const TOGETHER_MM: f64 = 1e-3;
/// A centre that is nearer to the plane of the ridge is over a valley's bottom, as a share of the ball's radius.
const OVER_RIDGE: f64 = 1e-6;

/// Slope at which the ball rises from the end of a part, more than that of mirrors, which are seen from above: 63 degrees.
const RISE: f64 = 2.0;

/// The lines of a tip over a mirror.
pub(super) struct TipLines {
    /// In the order across.
    pub across: Vec<TipLine>,
    /// Along the ridge of a folded mirror.
    pub ridge: Vec<TipLine>,
}

impl TipLines {
    /// Those of a ball of radius `radius_mm` whose centre follows `paths`, over a mirror that is `folded` along X or is not.
    pub(super) fn new(paths: &BallPaths, radius_mm: f64, folded: bool) -> Self {
        let parts = || paths.lines.iter().flatten().chain(&paths.ridge);
        let highest = parts().flat_map(|part| &part.centres).map(|centre| centre.z);
        // No contact is higher than its centre: the tip is above all of them.
        let clear_mm = highest.fold(f64::NEG_INFINITY, f64::max) + radius_mm;
        let over = Bridge { radius_mm, folded, clear_mm };
        let line = |parts: &[BallPath]| {
            let line = joined(parts, over)?;
            let places = line.places.iter().map(|&centre| centre - DVec3::Z * radius_mm);
            Some(TipLine { places: places.collect(), ..line })
        };
        let across = paths.lines.iter().filter_map(|parts| line(parts)).collect();
        let ridge = paths.ridge.iter().filter_map(|part| line(std::slice::from_ref(part)));
        Self { across, ridge: ridge.collect() }
    }
}

/// How a ball goes on from one part of a line to the next.
#[derive(Clone, Copy)]
struct Bridge {
    /// Radius of the ball, mm.
    radius_mm: f64,
    /// Whether the mirror is folded along X.
    folded: bool,
    /// Height of the centre at which the ball is above all of the mirror, mm.
    clear_mm: f64,
}

/// The parts of a line as one.
fn joined(parts: &[BallPath], over: Bridge) -> Option<TipLine> {
    let (first, last) = (parts.first()?, parts.last()?);
    let mut places = first.centres.clone();
    for pair in parts.windows(2) {
        let end =
            |path: &BallPath| (*path.centres.last().unwrap_or(&DVec3::ZERO), path.directions[1]);
        let begin = |path: &BallPath| (path.centres[0], path.directions[0]);
        places.extend(over.places([end(&pair[0]), begin(&pair[1])]));
        places.extend(&pair[1].centres);
    }
    Some(TipLine { places, directions: [first.directions[0], last.directions[1]] })
}

impl Bridge {
    /// The places of the ball's centre between the end of one part and the beginning of the next, each with its direction.
    ///
    /// Over a crest both go on straight to the plane of the ridge, Y = 0: a ball along the tangent of a side stays above that
    /// side's plane, and the other side is below it. Elsewhere, over a hole, beside a rim that bulges between both ends and along a
    /// valley's bottom, the ball rises more steeply than a mirror does, to above all of it at most.
    fn places(&self, [(a, along_a), (b, along_b)]: [(DVec3, DVec3); 2]) -> Vec<DVec3> {
        let gap = (b - a).truncate().length();
        if gap < TOGETHER_MM {
            return Vec::new();
        }
        let is_beside = |at: DVec3| at.y.abs() > OVER_RIDGE * self.radius_mm;
        if self.folded && is_beside(a) && is_beside(b) && a.y * b.y < 0.0 {
            let [before, after] = [-a.y / along_a.y, b.y / along_b.y];
            if before > 0.0 && after > 0.0 && before.max(after) < 1e3 * self.radius_mm {
                let (from, to) = (a + along_a * before, b - along_b * after);
                let top = from.z.max(to.z);
                return vec![from.with_z(top), to.with_z(top)];
            }
        }
        // Where both slopes would meet, if the ball is not above the mirror before.
        let meet = 0.5 * (a.z + b.z + RISE * gap);
        let top = meet.min(self.clear_mm).max(a.z).max(b.z);
        let share = |z: f64| (top - z) / (RISE * gap);
        vec![a.lerp(b, share(a.z)).with_z(top), b.lerp(a, share(b.z)).with_z(top)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::DVec2;
    use crate::machining::{BallRaster, Passes};
    use crate::mirror::fixtures::roof;
    use crate::num::{cos, radians, sin};

    /// From one end of a gap to the other a ball rises and comes down at a slope of two, no higher than is clear.
    #[test]
    fn a_gap_is_passed_above_what_bulges_beside_it() {
        let ends = [DVec3::new(0.0, 0.0, 5.0), DVec3::new(10.0, 0.0, 3.0)].map(|at| (at, DVec3::X));
        let over = |clear_mm: f64| {
            let bridge = Bridge { radius_mm: 2.0, folded: false, clear_mm };
            bridge.places(ends).into_iter().map(|at| (at.x, at.z)).collect::<Vec<_>>()
        };
        for (clear_mm, exact) in [
            (100.0, [(4.5, 14.0), (4.5, 14.0)]),
            (9.0, [(2.0, 9.0), (7.0, 9.0)]),
            (0.0, [(0.0, 5.0), (9.0, 5.0)]),
        ] {
            for (found, exact) in over(clear_mm).into_iter().zip(exact) {
                assert!((found.0 - exact.0).abs() + (found.1 - exact.1).abs() < 1e-12, "{found:?}");
            }
        }
    }

    const CORNERS: [DVec2; 2] = [DVec2::splat(-4.0), DVec2::splat(4.0)];

    fn lines(degrees: f64, angle: f64) -> TipLines {
        let mirror = roof(degrees);
        let raster = BallRaster { ball_mm: 2.0, stepover_mm: 0.5, angle: radians(angle) };
        let passes = Passes::new(&mirror, CORNERS, raster).unwrap();
        TipLines::new(&passes.paths(1e-4, 0.2), 2.0, true)
    }

    /// Over a crest of two planes, 30 degrees down on either side, the centre is 2 / cos(30 degrees) above the crest, and nowhere
    /// nearer to either plane than the radius; along a valley's bottom it stays where it touches both.
    #[test]
    fn a_crest_stays_sharp_and_a_valley_is_followed() {
        let [sine, cosine] = [sin(radians(30.0)), cos(radians(30.0))];
        for angle in [90.0, 60.0] {
            let crest = lines(-30.0, angle);
            for line in &crest.across {
                let top = line.places.iter().map(|at| at.z).fold(f64::MIN, f64::max);
                let [from, to] = line.ends();
                let crosses = from.y < -1.5 && to.y > 1.5;
                assert!(
                    !crosses || (top - (7.0 + 2.0 / cosine - 2.0)).abs() < 1e-9,
                    "{angle}: {top}"
                );
                for at in &line.places {
                    let centre = *at + DVec3::Z * 2.0 - DVec3::Z * 7.0;
                    let off = centre.z * cosine + centre.y.abs() * sine;
                    assert!(off > 2.0 - 1e-9, "{angle} {at}: {off}");
                }
            }
            let valley = lines(30.0, angle);
            for at in valley.across.iter().flat_map(|line| &line.places) {
                let centre = *at + DVec3::Z * 2.0 - DVec3::Z * 7.0;
                let off = centre.z * cosine - centre.y.abs() * sine;
                assert!(off > 2.0 - 1e-9, "{angle} {at}: {off}");
            }
        }
        assert_eq!(lines(30.0, 0.0).ridge.len(), 1);
    }
}
