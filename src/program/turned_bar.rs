//! A bar on a lathe: what is left of its section after each program, and moves that should not meet it.

use super::ToolMove;
use super::lathe::TurningPath;
use super::stock_map::MovedInto;
use super::swept_ball::lower_side;
use super::turned_surface::TurnedSurface;
use crate::geom::{DVec2, DVec3};
use crate::parallel;

/// Places along the radius.
const PLACES: usize = 4000;
/// Azimuths at which what is left is worked out.
const AZIMUTHS: usize = 16;
/// What is met counts from here, mm: above the rounding of programs.
const FLOOR_MM: f64 = 2e-3;

/// What is left of a bar.
#[derive(Debug, Clone, PartialEq)]
pub struct TurnedBar {
    /// Its radius, mm.
    radius_mm: f64,
    /// Z over the places along the radius where all turns are whole, mm.
    swept: Vec<f64>,
    /// Z over them at each azimuth, with the cusps between turns, mm.
    sections: Vec<Vec<f64>>,
}

/// How the moves of a program meet what is left of a bar.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BarMoves {
    /// The first rapid move through it.
    pub rapid: Option<MovedInto>,
    /// The first feed move straight down into it.
    pub plunge: Option<MovedInto>,
}

impl TurnedBar {
    /// A bar on the plane Z = 0.
    #[must_use]
    pub fn new(radius_mm: f64, top_mm: f64) -> Self {
        let whole = vec![top_mm; PLACES + 1];
        Self { radius_mm, swept: whole.clone(), sections: vec![whole; AZIMUTHS] }
    }

    /// Distance of place `k` from the axis, mm.
    #[must_use]
    pub fn place(&self, k: usize) -> f64 {
        self.radius_mm * k as f64 / PLACES as f64
    }

    /// The least and the most Z over each place, mm.
    pub fn heights(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        (0..=PLACES).map(|k| {
            let all = || self.sections.iter().map(|section| section[k]);
            [all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max)]
        })
    }

    /// Takes away what a nose cuts along a path.
    pub fn cut(&mut self, path: &TurningPath, nose_mm: f64) -> BarMoves {
        let mut found = BarMoves::default();
        for step in &path.tool.moves {
            self.sweep(step, nose_mm, &mut found);
        }
        let surface = TurnedSurface::new(path, nose_mm);
        let sections = parallel::map(AZIMUTHS, 1, |k| {
            let section = surface.section(k as f64 / AZIMUTHS as f64);
            let before = self.sections[k].iter().enumerate();
            let lower = |(place, &z): (usize, &f64)| {
                section.lowest(self.place(place)).map_or(z, |low| low.z_mm.min(z))
            };
            before.map(lower).collect()
        });
        self.sections = sections;
        found
    }

    /// Takes away the circles of one move, on both sides of the axis.
    fn sweep(&mut self, step: &ToolMove, nose_mm: f64, found: &mut BarMoves) {
        for side in sides(step, nose_mm) {
            let [least, most] = [side[0].x.min(side[1].x), side[0].x.max(side[1].x)];
            let share = PLACES as f64 / self.radius_mm;
            let from = ((least - nose_mm) * share).ceil().max(0.0);
            let to = ((most + nose_mm) * share).floor().min(PLACES as f64);
            if !(from <= to) {
                continue;
            }
            for k in from as usize..=to as usize {
                let at = DVec2::new(self.place(k), 0.0);
                let Some((z, _)) = lower_side(&side, at, nose_mm) else { continue };
                let depth_mm = self.swept[k] - z;
                if depth_mm > 0.0 {
                    if depth_mm > FLOOR_MM {
                        let at = DVec3::new(at.x, 0.0, self.swept[k]);
                        found.meet(step, MovedInto { line: step.line, at, depth_mm });
                    }
                    self.swept[k] = z;
                }
            }
        }
    }
}

/// Ends of the nose's centre in a move of its tool point, and on the other side of the axis.
fn sides(step: &ToolMove, nose_mm: f64) -> [[DVec3; 2]; 2] {
    let up = DVec3::new(nose_mm, 0.0, nose_mm);
    let centres = [step.from + up, step.to + up];
    [centres, centres.map(|at| DVec3::new(-at.x, 0.0, at.z))]
}

/// Z of the lowest place of a nose in a move at a distance from the axis, mm; none where it does not come.
#[must_use]
pub fn nose_below(step: &ToolMove, nose_mm: f64, radius_mm: f64) -> Option<f64> {
    let at = DVec2::new(radius_mm, 0.0);
    let all = sides(step, nose_mm).into_iter().filter_map(|side| lower_side(&side, at, nose_mm));
    all.map(|(z, _)| z).reduce(f64::min)
}

impl BarMoves {
    fn meet(&mut self, step: &ToolMove, moved: MovedInto) {
        let slot = if step.feed.is_none() {
            &mut self.rapid
        } else if step.from.x == step.to.x && step.to.z < step.from.z {
            &mut self.plunge
        } else {
            return;
        };
        if slot.is_none_or(|first| first.line == moved.line && first.depth_mm < moved.depth_mm) {
            *slot = Some(moved);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(moves: &[([f64; 2], [f64; 2], Option<f64>)]) -> TurningPath {
        let mut found = TurningPath::default();
        for (k, (from, to, feed)) in (1..).zip(moves) {
            let [from, to] = [from, to].map(|at| DVec3::new(at[0] - 0.8, 0.0, at[1] - 0.8));
            found.tool.moves.push(ToolMove { from, to, feed: *feed, line: k });
            found.turns.push(feed.map_or(0.0, |feed| from.distance(to) / feed));
        }
        found
    }

    /// Facing to 4 mm at 0.1 mm in a turn: least 4 mm, most a cusp higher; a rapid move and a plunge into it are found by their lines.
    #[test]
    fn moves_into_the_bar_are_found_by_their_lines() {
        let facing = ([13.0, 4.8], [0.0, 4.8], Some(0.1));
        let up = ([0.0, 4.8], [0.0, 9.0], None);
        let mut bar = TurnedBar::new(10.0, 5.0);
        assert_eq!(bar.cut(&path(&[facing, up]), 0.8), BarMoves::default());
        let cusp = 0.8 - f64::sqrt(0.64 - 0.0025);
        let [mut least, mut most] = [f64::INFINITY, f64::NEG_INFINITY];
        for (k, [low, high]) in bar.heights().enumerate() {
            // (The last turn is not whole.)
            if bar.place(k) > 0.1 && bar.place(k) < 9.9 {
                least = least.min(low);
                most = most.max(high);
            }
        }
        assert!(
            (least - 4.0).abs() < 1e-9 && (most - 4.0 - cusp).abs() < 0.02 * cusp,
            "{least} {most}"
        );
        let down = ([5.0, 9.0], [5.0, 4.3], Some(0.1));
        let across = ([5.0, 4.3], [3.0, 4.3], None);
        let found = bar.clone().cut(&path(&[down, across]), 0.8);
        let (plunge, rapid) = (found.plunge.unwrap(), found.rapid.unwrap());
        assert!(plunge.line == 1 && (plunge.depth_mm - 0.5).abs() < 1e-9, "{plunge:?}");
        assert!(rapid.line == 2 && (rapid.depth_mm - 0.5).abs() < 1e-9, "{rapid:?}");
        // Beside the bar a tool comes down as it likes.
        let beside = ([11.0, 9.0], [11.0, 1.0], None);
        assert_eq!(bar.cut(&path(&[beside]), 0.8), BarMoves::default());
    }
}
