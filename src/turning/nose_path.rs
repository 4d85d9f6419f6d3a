//! The path of a nose's centre over a mirror, from beside its rim to the axis.

use super::meridian::{Meridian, MeridianPlace};
use crate::geom::DVec2;
use crate::milling::distance_from_move;
use crate::num::{atan, cos, sin};
use std::f64::consts::FRAC_PI_2;

/// Parts of the meridian in which moves are looked for: none is longer than one of them.
const PARTS: usize = 64;
/// Divisions of a part, at most: places are then nanometres apart.
const DEEPEST: usize = 16;
/// Halvings of the interval in which the nose meets the land.
const HALVINGS: usize = 60;

/// The path of a circle's centre that touches a mirror from above.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct NosePath {
    /// The places, X and Z in mm, from the rim to the axis.
    pub places: Vec<DVec2>,
}

/// How straight moves follow a path.
#[derive(Debug, Clone, Copy)]
pub(super) struct MoveLimits {
    /// What they may be off it, mm.
    pub chord_mm: f64,
    /// Largest difference of their slopes from the path's, radians.
    pub slope: f64,
}

impl NosePath {
    /// That of a circle of radius `reach_mm`, which fits everywhere. It begins `beyond_mm` beside the rim along its tangent, so that the
    /// turns are even up to it; around a rim that rises outwards it goes until it is over it. Around the inner rim of a land it
    /// goes likewise, and follows its plane. It ends in the axis.
    pub(super) fn new(
        meridian: &Meridian,
        reach_mm: f64,
        beyond_mm: f64,
        limits: MoveLimits,
    ) -> Self {
        let [inner, outer] = meridian.ends();
        let mut path = Self { places: Vec::new() };
        let rim = meridian.at(outer);
        if rim.slope > 0.0 {
            path.around(rim.at, reach_mm, [0.0, -atan(rim.slope)], limits);
        } else {
            let along = DVec2::new(1.0, rim.slope) / rim.stretch();
            path.add(centre(&rim, reach_mm) + beyond_mm * along);
        }
        let land = meridian.at(inner);
        let end = match meridian.has_land() && land.slope > 0.0 {
            true => meets_land(meridian, reach_mm, land.at.y + reach_mm),
            false => inner,
        };
        path.along(meridian, [outer, end], reach_mm, limits);
        if meridian.has_land() {
            if land.slope < 0.0 {
                path.around(land.at, reach_mm, [-atan(land.slope), 0.0], limits);
            }
            path.add(DVec2::new(0.0, land.at.y + reach_mm));
        }
        path
    }

    fn add(&mut self, at: DVec2) {
        if self.places.last() != Some(&at) {
            self.places.push(at);
        }
    }

    /// Along the meridian from one q to another.
    fn along(
        &mut self,
        meridian: &Meridian,
        [from, to]: [f64; 2],
        reach_mm: f64,
        limits: MoveLimits,
    ) {
        let q = |k: usize| from + (to - from) * (k as f64 / PARTS as f64);
        let centre = |q: f64| centre(&meridian.at(q), reach_mm);
        self.add(centre(from));
        let mut parts: Vec<([f64; 2], usize)> =
            (0..PARTS).rev().map(|k| ([q(k), q(k + 1)], 0)).collect();
        while let Some(([a, b], depth)) = parts.pop() {
            let (ends, middle) = ([centre(a), centre(b)], 0.5 * (a + b));
            let chord = ends.map(|end| end.extend(0.0));
            let is_near = [0.25, 0.5, 0.75].into_iter().all(|share| {
                let at = centre(a + share * (b - a));
                distance_from_move(at.extend(0.0), chord) <= limits.chord_mm
            });
            let [before, after] = [a, b].map(|q| atan(meridian.at(q).slope));
            let is_straight = 0.5 * (after - before).abs() <= limits.slope;
            if depth == DEEPEST || is_near && is_straight {
                self.add(ends[1]);
            } else {
                parts.extend([([middle, b], depth + 1), ([a, middle], depth + 1)]);
            }
        }
    }

    /// Around an edge, from one angle of the radius to another: from Z towards the rim, radians.
    fn around(
        &mut self,
        edge: DVec2,
        reach_mm: f64,
        [from, to]: [f64; 2],
        MoveLimits { chord_mm, .. }: MoveLimits,
    ) {
        // A chord over the angle a is r a^2 / 8 inside its arc.
        let step = f64::sqrt(8.0 * chord_mm / reach_mm).min(0.25 * FRAC_PI_2);
        let count = ((to - from).abs() / step).ceil().max(1.0) as usize;
        for k in 0..=count {
            let angle = from + (to - from) * (k as f64 / count as f64);
            self.add(edge + reach_mm * DVec2::new(sin(angle), cos(angle)));
        }
    }
}

/// The centre of a circle that touches a place.
fn centre(place: &MeridianPlace, reach_mm: f64) -> DVec2 {
    let at = place.at + reach_mm * place.normal();
    // (In the axis to the last bit.)
    if place.at.x == 0.0 { DVec2::new(0.0, at.y) } else { at }
}

/// q of the place at which a circle touches the mirror and, with its centre at `z_mm`, a lower land.
fn meets_land(meridian: &Meridian, reach_mm: f64, z_mm: f64) -> f64 {
    let [inner, outer] = meridian.ends();
    let is_above = |q: f64| centre(&meridian.at(q), reach_mm).y >= z_mm;
    let q = |k: usize| inner + (outer - inner) * (k as f64 / PARTS as f64);
    let Some(k) = (1..=PARTS).find(|&k| is_above(q(k))) else { return outer };
    let [mut below, mut above] = [q(k - 1), q(k)];
    for _ in 0..HALVINGS {
        let middle = 0.5 * (below + above);
        if is_above(middle) { above = middle } else { below = middle }
    }
    above
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Outline;
    use crate::mirror::Mirror;
    use crate::mirror::fixtures::quadric;

    const LIMITS: MoveLimits = MoveLimits { chord_mm: 1e-4, slope: 0.02 };

    /// A paraboloid of the height -k (x^2 + y^2) / 2 between two radii, over Z = 7 in its middle.
    fn paraboloid(k: f64, inner: f64, outer: f64) -> Mirror {
        let mut mirror = quadric([-0.5 * k, 0.0, -0.5 * k], 0.0);
        mirror.outline = Outline::Ring { inner, outer };
        mirror
    }

    /// Distance of a place from the curve z = top - k x^2 / 2 for 0 < x: the least over many of its places, refined by halves.
    fn off_curve(at: DVec2, k: f64, top: f64, [inner, outer]: [f64; 2]) -> f64 {
        let place = |x: f64| DVec2::new(x, top - 0.5 * k * x * x);
        let mut step = (outer - inner) / 400.0;
        let mut best = (0..=400)
            .map(|i| inner + step * f64::from(i))
            .min_by(|a, b| place(*a).distance(at).total_cmp(&place(*b).distance(at)))
            .unwrap();
        for _ in 0..50 {
            step *= 0.5;
            for x in [best - step, best + step] {
                let x = x.clamp(inner, outer);
                if place(x).distance(at) < place(best).distance(at) {
                    best = x;
                }
            }
        }
        place(best).distance(at)
    }

    /// All along the moves the centre is a radius from the surface, within the chord: never nearer on hollow ground, never
    /// farther on ground that bulges.
    #[test]
    fn moves_keep_the_radius_within_their_chords() {
        for (k, nose_mm) in [(0.05, 0.8), (0.1, 3.0), (-0.05, 0.8), (-0.05, 5.0)] {
            let mirror = paraboloid(k, 0.0, 10.0);
            let meridian = Meridian::of_ring(&mirror, [0.0, 10.0]);
            let top = meridian.at(0.0).at.y;
            let path = NosePath::new(&meridian, nose_mm, 0.2, LIMITS);
            let places = &path.places;
            assert_eq!(places[places.len() - 1].x, 0.0);
            let [mut least, mut most] = [f64::INFINITY, f64::NEG_INFINITY];
            assert!(places.windows(2).all(|pair| pair[1].x <= pair[0].x), "{k}: it turns back");
            // Before that the nose is beside the rim, or goes around it.
            let rim = super::centre(&meridian.at(10.0), nose_mm).x;
            let first = places.iter().position(|at| at.x <= rim).unwrap();
            for pair in places[first..].windows(2) {
                for share in [0.0, 0.3, 0.5, 0.8] {
                    let off =
                        off_curve(pair[0].lerp(pair[1], share), k, top, [0.0, 10.0]) - nose_mm;
                    least = least.min(off);
                    most = most.max(off);
                }
            }
            assert!(least > -1.01e-4 && most < 1.01e-4, "{k} {nose_mm}: {least:e} {most:e}");
            // (Chords lie inside bulging paths.)
            let [inside, outside] = if k > 0.0 { [-least, most] } else { [most, -least] };
            assert!(inside > 2e-5 && outside < 1e-9, "{k} {nose_mm}: {least:e} {most:e}");
        }
    }

    /// Around a land the nose rolls about the inner rim of what bulges, and leaves a fillet between land and what is hollow: it is
    /// nowhere nearer to either than its radius, and touches the land in the axis.
    #[test]
    fn lands_are_met_without_a_gouge() {
        for k in [0.08, -0.08] {
            let mirror = paraboloid(k, 4.0, 10.0);
            let meridian = Meridian::of_ring(&mirror, [4.0, 10.0]);
            let top = meridian.at(4.0).at.y + 0.5 * k * 16.0;
            let land = meridian.at(4.0).at.y;
            let path = NosePath::new(&meridian, 0.8, 0.2, LIMITS);
            for pair in path.places.windows(2) {
                for share in [0.0, 0.5] {
                    let at = pair[0].lerp(pair[1], share);
                    let off = off_curve(at, k, top, [4.0, 10.0]);
                    assert!(off > 0.8 - 1.01e-4, "{k} {at}: {off}");
                    assert!(at.x > 4.0 || at.y >= land + 0.8 - 1.01e-4, "{k} {at}");
                }
            }
            assert_eq!(path.places[path.places.len() - 1], DVec2::new(0.0, land + 0.8));
        }
    }
}
