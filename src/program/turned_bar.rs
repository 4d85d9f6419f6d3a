//! A bar on a lathe: what is left of its section after each program, and moves that should not meet it.

use super::ToolMove;
use super::cutter_move::lower_side;
use super::lathe::TurningPath;
use super::stock_map::MovedInto;
use super::turned_section::NoseCircle;
use super::turned_surface::TurnedSurface;
use crate::geom::{DVec2, DVec3};
use crate::num::{cos, sin};
use crate::parallel;
use std::f64::consts::TAU;

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
        Self::at_azimuths(radius_mm, top_mm, AZIMUTHS)
    }

    /// The same, of which what is left is worked out at so many azimuths.
    #[must_use]
    pub fn at_azimuths(radius_mm: f64, top_mm: f64, count: usize) -> Self {
        let whole = vec![top_mm; PLACES + 1];
        Self { radius_mm, swept: whole.clone(), sections: vec![whole; count] }
    }

    /// Distance of place `k` from the axis, mm.
    #[must_use]
    pub fn place(&self, k: usize) -> f64 {
        self.radius_mm * k as f64 / PLACES as f64
    }

    /// The least and the most Z over each place of all azimuths, mm.
    pub fn heights(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        Self::extremes(&self.sections)
    }

    /// Z over each place at azimuth `k` of all that it is worked out at, mm, twice.
    pub fn heights_at(&self, k: usize) -> impl Iterator<Item = [f64; 2]> + '_ {
        Self::extremes(&self.sections[k..=k])
    }

    fn extremes(sections: &[Vec<f64>]) -> impl Iterator<Item = [f64; 2]> + '_ {
        (0..=PLACES).map(|k| {
            let all = || sections.iter().map(|section| section[k]);
            [all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max)]
        })
    }

    /// Takes away what a nose cuts along a path. Where C is commanded each place is held against the bar at the azimuth that passes the nose,
    /// and rapid moves are not.
    pub fn cut(&mut self, path: &TurningPath, nose_mm: f64) -> BarMoves {
        let mut found = BarMoves::default();
        if !path.is_commanded() {
            for step in &path.tool.moves {
                self.sweep(step, nose_mm, &mut found);
            }
        }
        let surface = TurnedSurface::new(path, nose_mm);
        if path.is_commanded() {
            return self.cut_by_azimuths(path, &surface, nose_mm);
        }
        let sections = parallel::map(self.sections.len(), 1, |k| {
            let section = surface.section(k as f64 / self.sections.len() as f64);
            let before = self.sections[k].iter().enumerate();
            let lower = |(place, &z): (usize, &f64)| {
                section.lowest(self.place(place)).map_or(z, |low| low.z_mm.min(z))
            };
            before.map(lower).collect()
        });
        self.sections = sections;
        found
    }

    /// The same at each azimuth, circle after circle.
    fn cut_by_azimuths(
        &mut self,
        path: &TurningPath,
        surface: &TurnedSurface,
        nose_mm: f64,
    ) -> BarMoves {
        let count = self.sections.len();
        let cut = parallel::map(count, 1, |k| {
            let mut section = self.sections[k].clone();
            let circles = surface.circles(k as f64 / count as f64);
            let plunge = self.lower(&mut section, &circles, nose_mm);
            (section, plunge)
        });
        let mut first: Option<(usize, MovedInto)> = None;
        self.sections.clear();
        for (k, (section, plunge)) in cut.into_iter().enumerate() {
            self.sections.push(section);
            let Some((step, at, depth_mm)) = plunge else { continue };
            if first.is_none_or(|(before, _)| step < before) {
                let angle = TAU * k as f64 / count as f64;
                let at = DVec3::new(at.x * cos(angle), at.x * sin(angle), at.y);
                let line = path.tool.moves[step].line;
                first = Some((step, MovedInto { line, at, depth_mm }));
            }
        }
        BarMoves { rapid: None, plunge: first.map(|(_, moved)| moved) }
    }

    /// Lowers the heights at one azimuth to circles one after the other; the first that goes straight down into them from turn to turn: its
    /// move, the place and the depth, mm.
    fn lower(
        &self,
        section: &mut [f64],
        circles: &[NoseCircle],
        nose_mm: f64,
    ) -> Option<(usize, DVec2, f64)> {
        let mut plunge = None;
        let mut before = f64::NAN;
        let share = PLACES as f64 / self.radius_mm;
        for &NoseCircle { centre, step, .. } in circles {
            let from = ((centre.x - nose_mm) * share).ceil().max(0.0);
            let to = ((centre.x + nose_mm) * share).floor().min(PLACES as f64);
            let mut deepest = (0.0, DVec2::ZERO);
            // (None beside the bar.)
            let places = if from <= to { from as usize..to as usize + 1 } else { 0..0 };
            for k in places {
                let off = self.place(k) - centre.x;
                let z = centre.y - f64::sqrt((nose_mm * nose_mm - off * off).max(0.0));
                let depth_mm = section[k] - z;
                if depth_mm > 0.0 {
                    if depth_mm > deepest.0 {
                        deepest = (depth_mm, DVec2::new(self.place(k), section[k]));
                    }
                    section[k] = z;
                }
            }
            if centre.x == before && deepest.0 > FLOOR_MM && plunge.is_none() {
                plunge = Some((step, deepest.1, deepest.0));
            }
            if centre.x >= 0.0 {
                before = centre.x;
            }
        }
        plunge
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

    /// While C turns the nose comes down beside the bar and goes inwards: nothing is wrong, and at each azimuth the bar is as low as the nose was there.
    /// Down where the bar is, it is found with its azimuth.
    #[test]
    fn a_commanded_spindle_is_held_to_the_bar_at_each_azimuth() {
        let cut = |places: &dyn Fn(f64) -> [f64; 2], turns: u32| {
            let mut text = "# spindle_rpm 60\n".to_owned();
            for k in 0..=36 * turns {
                let [x, z] = places(f64::from(k) / 36.0);
                text += &format!("{} {} {}\n", x - 0.8, z - 0.8, 10 * k);
            }
            let path = TurningPath::read_table(text.as_bytes()).unwrap();
            let mut bar = TurnedBar::at_azimuths(10.0, 5.0, 8);
            let found = bar.cut(&path, 0.8);
            (bar, found)
        };
        // A plane that is tilted by its height over a diameter of 20 mm.
        let tilt = |turn: f64| cos(TAU * turn);
        let inwards = |turn: f64| {
            let x = (13.0 - 0.1 * (turn - 10.0).max(0.0)).max(0.0);
            [x, 4.0 + (10.0 - turn).max(0.0) + 0.02 * x * tilt(turn)]
        };
        let (bar, found) = cut(&inwards, 142);
        assert_eq!(found, BarMoves::default());
        for k in 0..8 {
            let slope = 0.02 * tilt(f64::from(k as u32) / 8.0);
            let heights: Vec<[f64; 2]> = bar.heights_at(k).collect();
            for (place, [low, high]) in heights.into_iter().enumerate() {
                let at = bar.place(place);
                // A circle about the line's parallel touches it a little higher than a line so far below it.
                let exact = 4.0 + slope * at - 0.8 * f64::sqrt(1.0 + slope * slope);
                let cusp = 0.01 / 6.4;
                assert!(
                    at < 0.2 || low == high && (low - exact).abs() < 1.5 * cusp,
                    "{k} {at}: {low} {exact}"
                );
            }
        }
        let down = |turn: f64| [5.0, 7.0 - 0.5 * turn];
        let (_, found) = cut(&down, 4);
        let plunge = found.plunge.unwrap();
        // Its nose is at the bar's top after 2.4 turns.
        assert!(plunge.line > 36 * 2 && plunge.depth_mm > 0.0, "{plunge:?}");
        assert!((plunge.at.truncate().length() - 5.0).abs() < 0.8, "{plunge:?}");
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
