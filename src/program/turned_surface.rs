//! What a nose leaves turn after turn: at each azimuth the lowest of all its circles.
//!
//! The nose is a circle in a half-plane through the spindle's axis. A place of the part at azimuth `2 pi s` comes through that plane
//! once in a turn, when the spindle has made `s + k` turns: what is left there is outside all circles about the nose's centres at these
//! moments. A circle that reaches beyond the axis meets the part on the other side, half a turn later.
//!
//! Where C, an axis, turns the spindle, its places are those of the program; else it makes the turns of one move after those of another.

use super::azimuth_bins::AzimuthBins;
use super::lathe::TurningPath;
use super::turned_section::{NoseCircle, TurnedSection};
use crate::geom::DVec2;

/// What rounding leaves between a pass and the next one, turns.
const GAP_TURNS: f64 = 1e-9;

/// Circles of a nose along the moves of a lathe.
#[derive(Debug, Clone)]
pub struct TurnedSurface {
    nose_mm: f64,
    /// Feed moves and dwells that turn the part.
    passes: Vec<TurningPass>,
    turns: f64,
    /// All passes, and those in which the nose reaches beyond the axis, by azimuth.
    bins: [AzimuthBins; 2],
}

/// A move of a nose's centre while the part turns.
#[derive(Debug, Clone, Copy)]
pub(super) struct TurningPass {
    from: DVec2,
    to: DVec2,
    /// Turns before it, and in it, negative where C turns back.
    begin: f64,
    turns: f64,
    /// Number of the move.
    step: usize,
}

impl TurningPass {
    /// Turns at its ends, rising.
    fn span(&self) -> [f64; 2] {
        let end = self.begin + self.turns;
        [self.begin.min(end), self.begin.max(end)]
    }

    /// The nose's centre after so many turns.
    pub(super) fn centre(&self, turn: f64) -> DVec2 {
        let along = ((turn - self.begin) / self.turns).clamp(0.0, 1.0);
        self.from + (self.to - self.from) * along
    }

    /// How the centre moves in a turn, mm.
    pub(super) fn way_in_a_turn(&self) -> DVec2 {
        (self.to - self.from) / self.turns
    }
}

/// Passes in the order of their turns.
#[derive(Debug)]
pub(super) struct PassRun(Vec<TurningPass>);

impl PassRun {
    /// The pass in which the spindle has made so many turns; none between passes.
    pub(super) fn pass_at(&self, turn: f64) -> Option<&TurningPass> {
        let next = self.0.partition_point(|pass| pass.span()[0] <= turn);
        let pass = &self.0[next.checked_sub(1)?];
        (turn <= pass.span()[1] + GAP_TURNS).then_some(pass)
    }
}

impl TurnedSurface {
    /// The surface that a nose leaves whose tool point, a radius nearer to the axis and lower than its centre, follows a path.
    #[must_use]
    pub fn new(path: &TurningPath, nose_mm: f64) -> Self {
        let (mut passes, mut all) = (Vec::new(), 0.0);
        for (step, (moved, &turns)) in path.tool.moves.iter().zip(&path.turns).enumerate() {
            if turns != 0.0 {
                let [from, to] =
                    [moved.from, moved.to].map(|at| DVec2::new(at.x + nose_mm, at.z + nose_mm));
                let begin = path.commanded.get(step).map_or(all, |turn| turn.begin);
                passes.push(TurningPass { from, to, begin, turns, step });
                all += turns.abs();
            }
        }
        let spans = (0u32..).zip(passes.iter().map(TurningPass::span));
        let reaches_beyond = |&(number, _): &(u32, [f64; 2])| {
            let pass: &TurningPass = &passes[number as usize];
            pass.from.x.min(pass.to.x) < nose_mm
        };
        let bins =
            [AzimuthBins::new(spans.clone()), AzimuthBins::new(spans.filter(reaches_beyond))];
        Self { nose_mm, passes, turns: all, bins }
    }

    /// Turns of the spindle on all moves with a feed.
    #[must_use]
    pub fn turns(&self) -> f64 {
        self.turns
    }

    /// What is left at the azimuth of this share of a turn, from 0 to 1.
    #[must_use]
    pub fn section(&self, share: f64) -> TurnedSection {
        TurnedSection::new(self.circles(share), self.nose_mm)
    }

    /// Circles of the nose as that azimuth passes it, in the order of the moves.
    pub(super) fn circles(&self, share: f64) -> Vec<NoseCircle> {
        let mut circles = Vec::new();
        for is_beyond in [false, true] {
            let share = if is_beyond { share + 0.5 } else { share };
            for &pass in self.bins[usize::from(is_beyond)].near(share) {
                let pass = &self.passes[pass as usize];
                let [begin, end] = pass.span();
                let mut turn = share + (begin - share).ceil();
                while turn <= end {
                    let at = pass.centre(turn);
                    let x = if is_beyond { -at.x } else { at.x };
                    let centre = DVec2::new(x, at.y);
                    circles.push(NoseCircle { centre, step: pass.step, turn, is_beyond });
                    turn += 1.0;
                }
            }
        }
        circles.retain(|circle| circle.centre.x > -self.nose_mm);
        circles.sort_by_key(|circle| circle.step);
        circles
    }

    /// Radius of the nose, mm.
    pub(super) fn nose_mm(&self) -> f64 {
        self.nose_mm
    }

    /// The passes in runs in each of which the spindle goes on one way, by the number of the first move.
    pub(super) fn runs(mut self) -> Vec<(usize, PassRun)> {
        let goes_on = |a: &TurningPass, b: &TurningPass| {
            let way = a.turns.signum();
            way * b.turns > 0.0 && way * (b.begin - a.begin - a.turns) > -GAP_TURNS
        };
        let mut runs: Vec<(usize, PassRun)> = Vec::new();
        let mut rest = std::mem::take(&mut self.passes);
        while let Some(first) = rest.first().copied() {
            let ends = rest.windows(2).position(|pair| !goes_on(&pair[0], &pair[1]));
            let after = rest.split_off(ends.map_or(rest.len(), |last| last + 1));
            if first.turns < 0.0 {
                rest.reverse();
            }
            runs.push((first.step, PassRun(rest)));
            rest = after;
        }
        runs
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::DVec3;
    use crate::program::ToolMove;

    fn path(places: &[(f64, f64)], nose_mm: f64, feed_mm: f64) -> TurningPath {
        let point = |(x, z): (f64, f64)| DVec3::new(x - nose_mm, 0.0, z - nose_mm);
        let mut found = TurningPath::default();
        for pair in places.windows(2) {
            let [from, to] = [point(pair[0]), point(pair[1])];
            found.tool.moves.push(ToolMove { from, to, feed: Some(1.0), line: 1 });
            found.turns.push(from.distance(to) / feed_mm);
        }
        found
    }

    /// Over a plane the cusps stand r - sqrt(r^2 - f^2 / 4) over the lowest places, which are f apart.
    #[test]
    fn a_plane_has_cusps_of_the_closed_form() {
        for (nose_mm, feed_mm) in [(0.4, 0.05), (0.8, 0.1), (2.0, 0.5), (0.8, 0.7)] {
            let surface =
                TurnedSurface::new(&path(&[(30.0, 5.0), (0.0, 5.0)], nose_mm, feed_mm), nose_mm);
            let exact = nose_mm - f64::sqrt(nose_mm * nose_mm - 0.25 * feed_mm * feed_mm);
            for share in [0.0, 0.3, 0.77] {
                let section = surface.section(share);
                let cusps: Vec<f64> = section.cusps().filter(|at| *at > nose_mm).collect();
                assert!(cusps.len() as f64 > (28.0 - nose_mm) / feed_mm);
                for pair in cusps.windows(2) {
                    assert!((pair[1] - pair[0] - feed_mm).abs() < 1e-9);
                    let low = section.lowest(0.5 * (pair[0] + pair[1])).unwrap().z_mm;
                    let high = section.lowest(pair[0]).unwrap().z_mm;
                    assert!((low - (5.0 - nose_mm)).abs() < 1e-12, "{low}");
                    assert!((high - low - exact).abs() < 1e-9, "{share}: {} {exact}", high - low);
                }
            }
        }
    }

    /// On cones and spheres, bulging and hollow, the cusps have the height of T117's exact form, square to the surface: a circle's centre is
    /// on the parallel curve, neighbouring ones f apart along it.
    #[test]
    fn cones_and_spheres_have_cusps_of_the_closed_form() {
        for (nose_mm, feed_mm) in [(0.4, 0.1), (0.8, 0.05), (0.8, 0.1), (0.8, 0.2), (3.0, 0.4)] {
            let cone = path(&[(30.0, 5.0), (5.0, 20.0)], nose_mm, feed_mm);
            let cone_cusp = nose_mm - f64::sqrt(nose_mm * nose_mm - 0.25 * feed_mm * feed_mm);
            let section = TurnedSurface::new(&cone, nose_mm).section(0.4);
            let slope = -15.0 / 25.0;
            let stretch = f64::sqrt(1.0 + slope * slope);
            let cusps: Vec<f64> = section.cusps().filter(|at| (8.0..25.0).contains(at)).collect();
            assert!(cusps.len() > 30);
            for &at in &cusps {
                // The line that all circles touch is a radius below that of their centres.
                let line = 5.0 + slope * (at - 30.0) - nose_mm * stretch;
                let high = (section.lowest(at).unwrap().z_mm - line) / stretch;
                assert!((high - cone_cusp).abs() < 1e-9, "{nose_mm} {feed_mm}: {high} {cone_cusp}");
            }
            for sphere_mm in [40.0, -40.0] {
                // The centres' sphere is larger by the nose, or smaller; chords of 1e-5 rad are picometres inside it.
                let centres: f64 = sphere_mm + nose_mm;
                let angle = |k: usize| 0.6 * (1.0 - k as f64 / 60_000.0);
                let places: Vec<(f64, f64)> = (0..=60_000)
                    .map(|k| {
                        let [x, z] = [crate::num::sin(angle(k)), crate::num::cos(angle(k))];
                        (centres.abs() * x, centres * z)
                    })
                    .collect();
                let section =
                    TurnedSurface::new(&path(&places, nose_mm, feed_mm), nose_mm).section(0.4);
                // (Neighbours are f apart along the arc.)
                let half = centres.abs() * crate::num::sin(0.5 * feed_mm / centres.abs());
                let rise = f64::sqrt(nose_mm * nose_mm - half * half);
                let exact = f64::sqrt(centres * centres - half * half)
                    - rise.copysign(sphere_mm)
                    - sphere_mm.abs();
                let exact = exact.abs();
                let approximate = feed_mm * feed_mm / (8.0 * nose_mm * (1.0 + nose_mm / sphere_mm));
                let share = (feed_mm / nose_mm) * (feed_mm / nose_mm);
                assert!((approximate / exact - 1.0).abs() < 0.1 * share, "{approximate} {exact}");
                let cusps: Vec<f64> =
                    section.cusps().filter(|at| (1.0..20.0).contains(at)).collect();
                assert!(cusps.len() > 30);
                for &at in &cusps {
                    let z = section.lowest(at).unwrap().z_mm;
                    let high = (f64::sqrt(at * at + z * z) - sphere_mm.abs()) * sphere_mm.signum();
                    assert!((high - exact).abs() < 5e-9, "{sphere_mm} {feed_mm}: {high} {exact}");
                }
            }
        }
    }

    /// The cut goes around the axis as a spiral: half a turn farther, all cusps are half a feed nearer to it.
    #[test]
    fn cusps_follow_the_turns() {
        let surface = TurnedSurface::new(&path(&[(30.0, 5.0), (0.0, 5.0)], 0.8, 0.1), 0.8);
        let [first, later] = [0.2, 0.7].map(|share| surface.section(share));
        for (a, b) in first.cusps().rev().zip(later.cusps().rev()).take(100) {
            assert!((a - b - 0.05).abs() < 1e-9, "{a} {b}");
        }
        assert!((surface.turns() - 300.0).abs() < 1e-9);
    }

    /// At each azimuth the nose is where C was commanded to, forwards or backwards: over a spiral that falls a millimetre in a quarter of
    /// each turn and rises again in the rest, circles have those heights at each azimuth.
    #[test]
    fn a_commanded_spindle_has_the_heights_of_its_azimuths() {
        let height =
            |share: f64| if share < 0.25 { 5.0 - 4.0 * share } else { 3.667 + 1.333 * share };
        for way in [1.0, -1.0] {
            let at = |k: usize| {
                let turn = k as f64 / 40.0;
                (
                    DVec3::new(10.0 - 0.1 * turn - 0.8, 0.0, height(turn.fract()) - 0.8),
                    0.5 + way * turn,
                )
            };
            let mut path = TurningPath::default();
            for k in 0..400 {
                let ([from, to], [begin, end]) = ([at(k).0, at(k + 1).0], [at(k).1, at(k + 1).1]);
                path.tool.moves.push(ToolMove { from, to, feed: Some(1.0), line: 1 });
                path.turns.push(end - begin);
                path.commanded.push(crate::program::SpindleTurn { begin, end, minutes: 1.0 });
            }
            let surface = TurnedSurface::new(&path, 0.8);
            assert!((surface.turns() - 10.0).abs() < 1e-9);
            for part in [0.1_f64, 0.2, 0.6, 0.9] {
                let section = surface.section((0.5 + way * part).rem_euclid(1.0));
                // Right below a centre.
                let z = section.lowest(10.0 - 0.1 * (3.0 + part)).unwrap().z_mm;
                assert!((z - height(part) + 0.8).abs() < 1e-9, "{way} {part}: {z}");
            }
        }
    }

    /// A nose that goes half its radius beyond the axis cuts as deep on the other side, half a turn later.
    #[test]
    fn beyond_the_axis_the_other_side_is_cut() {
        let surface = TurnedSurface::new(&path(&[(0.3, 5.0), (-0.4, 4.0)], 0.8, 0.01), 0.8);
        let z = |share: f64, at: f64| surface.section(share).lowest(at).unwrap().z_mm;
        // Its lowest circle is about (-0.4, 4), on the other side about (0.4, 4).
        assert!((z(0.0, 0.4) - 3.2).abs() < 0.02, "{}", z(0.0, 0.4));
        let stopped = TurnedSurface::new(&path(&[(0.3, 5.0), (0.0, 5.0)], 0.8, 0.01), 0.8);
        let exact = 5.0 - f64::sqrt(0.64 - 0.25);
        let found = stopped.section(0.4).lowest(0.5).unwrap().z_mm;
        assert!((found - (5.0 - f64::sqrt(0.64 - 0.04))).abs() < 0.01 && found < exact);
    }
}
