//! What a nose leaves turn after turn: at each azimuth the lowest of all its circles.
//!
//! The nose is a circle in a half-plane through the spindle's axis. A place of the part at azimuth `2 pi s` comes through that plane
//! once in a turn, when the spindle has made `s + k` turns: what is left there is outside all circles about the nose's centres at these
//! moments. A circle that reaches beyond the axis meets the part on the other side, half a turn later.
//!
//! Where C, an axis, turns the spindle, its places are those of the program; else it makes the turns of one move after those of another.
//!
//! Lower sides of two circles of one radius cross once: that of the centre farther out is the lower one outwards. So the section at
//! an azimuth follows from the circles in the order of their centres, each of which is the lowest between two crossings or nowhere.

use super::lathe::TurningPath;
use crate::geom::DVec2;

/// Circles of a nose along the moves of a lathe.
#[derive(Debug, Clone)]
pub struct TurnedSurface {
    nose_mm: f64,
    /// Feed moves and dwells that turn the part.
    passes: Vec<Pass>,
    turns: f64,
}

/// A move of a nose's centre while the part turns.
#[derive(Debug, Clone, Copy)]
struct Pass {
    from: DVec2,
    to: DVec2,
    /// Turns before it, and in it, negative where C turns back.
    begin: f64,
    turns: f64,
    /// Number of the move.
    step: usize,
}

/// What is left at one azimuth.
#[derive(Debug, Clone, PartialEq)]
pub struct TurnedSection {
    nose_mm: f64,
    /// In the order of their centres from the axis.
    arcs: Vec<SectionArc>,
}

/// A circle that is the lowest from a distance of the axis up to the next one's.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SectionArc {
    from_mm: f64,
    centre: DVec2,
    step: usize,
}

/// The lowest place of all circles at a distance from the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SectionPlace {
    /// Its Z, mm.
    pub z_mm: f64,
    /// Number of the move whose circle it is.
    pub step: usize,
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
                passes.push(Pass { from, to, begin, turns, step });
                all += turns.abs();
            }
        }
        Self { nose_mm, passes, turns: all }
    }

    /// Turns of the spindle on all moves with a feed.
    #[must_use]
    pub fn turns(&self) -> f64 {
        self.turns
    }

    /// What is left at the azimuth of this share of a turn, from 0 to 1.
    #[must_use]
    pub fn section(&self, share: f64) -> TurnedSection {
        TurnedSection::new(self.centres(share), self.nose_mm)
    }

    /// Centres of the nose as that azimuth passes it, in the order of the moves, with their numbers; a negative distance is one beyond the
    /// axis, where the other side passes.
    pub(super) fn centres(&self, share: f64) -> Vec<(DVec2, usize)> {
        let mut centres: Vec<(DVec2, usize)> = Vec::new();
        for pass in &self.passes {
            let centre = |turn: f64| {
                let along = ((turn - pass.begin) / pass.turns).clamp(0.0, 1.0);
                pass.from + (pass.to - pass.from) * along
            };
            let end = pass.begin + pass.turns;
            let [begin, end] = [pass.begin.min(end), pass.begin.max(end)];
            let mut turn = share + (begin - share).ceil();
            while turn <= end {
                centres.push((centre(turn), pass.step));
                turn += 1.0;
            }
            // On the other side of the axis.
            if pass.from.x.min(pass.to.x) < self.nose_mm {
                let mut turn = share + 0.5 + (begin - share - 0.5).ceil();
                while turn <= end {
                    let at = centre(turn);
                    centres.push((DVec2::new(-at.x, at.y), pass.step));
                    turn += 1.0;
                }
            }
        }
        centres.retain(|(at, _)| at.x > -self.nose_mm);
        centres
    }
}

impl TurnedSection {
    fn new(mut centres: Vec<(DVec2, usize)>, nose_mm: f64) -> Self {
        centres
            .sort_by(|(a, k), (b, l)| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(k.cmp(l)));
        // Of the same distance from the axis the lowest alone matters.
        centres.dedup_by(|later, before| later.0.x == before.0.x);
        let mut arcs: Vec<SectionArc> = Vec::new();
        for (centre, step) in centres {
            let mut from_mm = f64::NEG_INFINITY;
            while let Some(last) = arcs.last() {
                from_mm = crossing(last.centre, centre, nose_mm);
                if from_mm > last.from_mm {
                    break;
                }
                arcs.pop();
                from_mm = f64::NEG_INFINITY;
            }
            arcs.push(SectionArc { from_mm, centre, step });
        }
        Self { nose_mm, arcs }
    }

    /// The lowest place at a distance from the axis; none where no circle comes.
    #[must_use]
    pub fn lowest(&self, radius_mm: f64) -> Option<SectionPlace> {
        let k = self.arcs.partition_point(|arc| arc.from_mm <= radius_mm).checked_sub(1)?;
        let SectionArc { centre, step, .. } = self.arcs[k];
        let off = radius_mm - centre.x;
        let depth = self.nose_mm * self.nose_mm - off * off;
        (depth >= 0.0).then(|| SectionPlace { z_mm: centre.y - depth.sqrt(), step })
    }

    /// Distances from the axis of the cusps between circles, rising.
    pub fn cusps(&self) -> impl DoubleEndedIterator<Item = f64> + '_ {
        self.arcs.iter().skip(1).map(|arc| arc.from_mm)
    }
}

/// Distance from the axis from which on the lower side of the circle about `b` is the lower one, whose centre is farther out than `a`.
fn crossing(a: DVec2, b: DVec2, radius: f64) -> f64 {
    let (middle, way) = (0.5 * (a + b), b - a);
    let length = way.length();
    let half = 0.5 * length;
    let rise = f64::sqrt((radius * radius - half * half).max(0.0)) / length;
    let cross = middle + rise * DVec2::new(way.y, -way.x);
    // Where the circles cross on the upper side of one, the other's lower side ends above it or does not meet it.
    if half >= radius || cross.y > a.y.min(b.y) {
        return if a.y < b.y { a.x + radius } else { b.x - radius };
    }
    cross.x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::DVec3;
    use crate::num::sample::Draws;
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

    /// The lowest of circles by trying all of them.
    fn tried(centres: &[DVec2], radius: f64, at: f64) -> Option<f64> {
        let depth = |c: &DVec2| radius * radius - (at - c.x) * (at - c.x);
        let all = centres.iter().filter(|c| depth(c) >= 0.0).map(|c| c.y - depth(c).sqrt());
        all.reduce(f64::min)
    }

    /// Of circles anywhere, some far apart, some hidden by others.
    #[test]
    fn a_section_is_the_lowest_of_all_circles() {
        let mut random = Draws::new(7);
        for spread in [0.1, 1.0, 10.0] {
            let centres: Vec<DVec2> =
                (0..60).map(|_| DVec2::new(20.0 * random.unit(), spread * random.unit())).collect();
            let all = centres.iter().enumerate().map(|(k, at)| (*at, k)).collect();
            let section = TurnedSection::new(all, 0.7);
            for k in 0..4000 {
                let at = -1.0 + 22.0 * f64::from(k) / 4000.0;
                let found = section.lowest(at).map(|place| place.z_mm);
                match (found, tried(&centres, 0.7, at)) {
                    (Some(a), Some(b)) => assert!((a - b).abs() < 1e-9, "{spread} {at}: {a} {b}"),
                    (a, b) => assert_eq!(a.is_some(), b.is_some(), "{spread} {at}"),
                }
            }
        }
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
