//! Slopes of what a nose leaves turn after turn, at any place.
//!
//! Where the circle about the centre (c, h) is the lowest at a distance r from the axis, the cut is at
//! `Z = h - sqrt(R^2 - (r - c)^2)`, and centre and circle move around the axis with the spindle. So along the radius it slopes by
//! `Z_r = (r - c) / d`, and around the axis by `Z_phi / r` with `Z_phi = h_phi - c_phi (r - c) / d`, where d is the root.
//!
//! Which circle that is, sections at some azimuths tell for the nearest of these; between two of them the cusps have moved by some
//! turns at the most, so the circles of the turns beside it are tried as long as they are lower.

use super::turned_section::{NoseCircle, TurnedSection};
use super::turned_surface::{PassRun, TurnedSurface};
use crate::geom::DVec2;
use crate::num::atan2;
use crate::parallel;
use std::f64::consts::TAU;

/// Sections that circles are looked up in.
const SECTIONS: usize = 64;

/// Slopes of what a nose leaves.
#[derive(Debug)]
pub struct TurnedSlopes {
    nose_mm: f64,
    sections: Vec<TurnedSection>,
    /// Passes, by the number of the first move of each run.
    runs: Vec<(usize, PassRun)>,
}

/// A circle at an azimuth, over a place there.
#[derive(Clone, Copy)]
struct CircleOver {
    z_mm: f64,
    /// Along the radius, and around the axis in mm for a radian.
    slope: DVec2,
}

impl TurnedSlopes {
    /// Those of `surface`.
    #[must_use]
    pub fn new(surface: TurnedSurface) -> Self {
        let sections = parallel::map(SECTIONS, 1, |k| surface.section(k as f64 / SECTIONS as f64));
        Self { nose_mm: surface.nose_mm(), sections, runs: surface.runs() }
    }

    /// The slope (Z_X, Z_Y) over a place of the plan, mm; none where no circle comes, and in the axis.
    #[must_use]
    pub fn slope_over(&self, at: DVec2) -> Option<DVec2> {
        let radius = at.length();
        let share = (atan2(at.y, at.x) / TAU).rem_euclid(1.0);
        let nearest = (share * SECTIONS as f64).round();
        let circle = self.sections[nearest as usize % SECTIONS].circle_over(radius)?;
        let begun = self.runs.partition_point(|(first, _)| *first <= circle.step);
        let (_, run) = &self.runs[begun.checked_sub(1)?];
        let turned = circle.turn + share - nearest / SECTIONS as f64;
        let over = |turns: f64| self.over((circle, run), turned + turns, radius);
        let mut lowest = over(0.0);
        for way in [1.0, -1.0] {
            let mut turns = way;
            while let Some(next) = over(turns)
                && lowest.is_none_or(|lowest| next.z_mm < lowest.z_mm)
            {
                lowest = Some(next);
                turns += way;
            }
        }
        let (out, slope) = (at / radius, lowest?.slope);
        let slope = out * slope.x + out.perp() * (slope.y / radius);
        slope.is_finite().then_some(slope)
    }

    /// The circle that the nose has after so many turns, on the side of the axis where `circle` is; none that does not come over the place.
    fn over(
        &self,
        (circle, run): (&NoseCircle, &PassRun),
        turn: f64,
        radius: f64,
    ) -> Option<CircleOver> {
        let pass = run.pass_at(turn)?;
        let side = if circle.is_beyond { DVec2::new(-1.0, 1.0) } else { DVec2::ONE };
        let [centre, way] = [pass.centre(turn), pass.way_in_a_turn() / TAU].map(|at| at * side);
        let (nose, off) = (self.nose_mm, radius - centre.x);
        let depth = nose * nose - off * off;
        let along = off / depth.sqrt();
        (depth > 0.0).then(|| CircleOver {
            z_mm: centre.y - depth.sqrt(),
            slope: DVec2::new(along, way.y - along * way.x),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::DVec3;
    use crate::num::{cos, sin};
    use crate::program::{SpindleTurn, ToolMove, TurningPath};

    /// A path whose centre is `height` over a spiral with the feed `feed_mm`, `per_turn` moves a turn, from 12 mm to 0.4 mm beyond the axis.
    fn path(
        height: impl Fn(f64, f64) -> f64,
        [nose_mm, feed_mm]: [f64; 2],
        (per_turn, way): (usize, f64),
    ) -> TurningPath {
        let at = |k: usize| {
            let turn = way * k as f64 / per_turn as f64;
            let x = 12.0 - feed_mm * turn.abs();
            (DVec3::new(x - nose_mm, 0.0, height(x, TAU * turn) - nose_mm), turn)
        };
        let mut path = TurningPath::default();
        for k in 0..(12.4 / feed_mm) as usize * per_turn {
            let ((from, begin), (to, end)) = (at(k), at(k + 1));
            path.tool.moves.push(ToolMove { from, to, feed: Some(1.0), line: 1 });
            path.turns.push(end - begin);
            path.commanded.push(SpindleTurn { begin, end, minutes: 1.0 });
        }
        path
    }

    /// Slopes are those of differences of the sections' heights, of round and of other surfaces, whichever way C turns.
    #[test]
    fn slopes_are_those_of_differences() {
        let saddle = |x: f64, azimuth: f64| 8.0 - 0.02 * x * x * (1.0 + 0.5 * cos(2.0 * azimuth));
        for (nose_mm, feed_mm, way) in [(1.0, 0.02, 1.0), (0.5, 0.05, -1.0), (2.0, 0.011, 1.0)] {
            let above =
                path(|x, azimuth| saddle(x, azimuth) + 0.01, [nose_mm, feed_mm], (100, way));
            let mut path = path(saddle, [nose_mm, feed_mm], (360, way));
            // (C is where it began, for a cut over the same places that leaves nothing.)
            path.tool.moves.splice(0..0, above.tool.moves);
            path.turns.splice(0..0, above.turns);
            path.commanded.splice(0..0, above.commanded);
            let surface = TurnedSurface::new(&path, nose_mm);
            let slopes = TurnedSlopes::new(surface.clone());
            let z = |at: DVec2| {
                let share = (atan2(at.y, at.x) / TAU).rem_euclid(1.0);
                surface.section(share).lowest(at.length()).unwrap().z_mm
            };
            let (mut tried, mut on_cusps) = (0, 0);
            for k in 0..400 {
                let (radius, angle) = (0.3 + 0.0233 * f64::from(k), 0.7 * f64::from(k));
                let at = radius * DVec2::new(cos(angle), sin(angle));
                let found = slopes.slope_over(at).unwrap();
                let step = 1e-6;
                let slope = [DVec2::X, DVec2::Y]
                    .map(|axis| (z(at + step * axis) - z(at - step * axis)) / (2.0 * step));
                let off = (found - DVec2::from_array(slope)).length();
                tried += 1;
                // (A cusp, or the end of a chord, between both ends of a difference.)
                on_cusps += usize::from(off > 1e-5);
            }
            assert!(tried == 400 && on_cusps < 4, "{nose_mm} {feed_mm}: {on_cusps}");
        }
    }

    /// Over a plane slopes are even between -f / 2r and f / 2r: their mean square is a third of the largest one's.
    #[test]
    fn slopes_over_a_plane_are_even() {
        let [nose_mm, feed_mm] = [1.0, 0.004];
        let path = path(|_, _| 5.0, [nose_mm, feed_mm], (48, 1.0));
        let slopes = TurnedSlopes::new(TurnedSurface::new(&path, nose_mm));
        let most = 0.5 * feed_mm / nose_mm;
        let found: Vec<f64> = (0..20_000)
            .map(|k| {
                let (radius, angle) = (1.0 + 4.5e-4 * f64::from(k), 2.4 * f64::from(k));
                slopes.slope_over(radius * DVec2::new(cos(angle), sin(angle))).unwrap().length()
            })
            .collect();
        let square = found.iter().map(|slope| slope * slope).sum::<f64>() / found.len() as f64;
        let greatest = found.into_iter().fold(0.0, f64::max);
        assert!((square.sqrt() / (most / f64::sqrt(3.0)) - 1.0).abs() < 0.01, "{square}");
        assert!((greatest / most - 1.0).abs() < 0.01, "{greatest} {most}");
    }
}
