//! The heights at which a nose touches a disc, over its distance from the axis, at evenly spaced azimuths.

use super::TurningError;
use super::disc_sections::{Circle, DiscSections};
use super::meridian::MeridianPlace;
use crate::geom::{DVec2, EvenPlaces};
use crate::num::{degrees, exp};
use crate::parallel;
use std::f64::consts::TAU;

/// Where the centre of a circle is that touches a disc at each azimuth, and beside it goes on smoothly.
///
/// Within the rim the circle touches the section. Beside it, it goes on along the rim's tangent, where the rim rises outwards until it is over
/// it at least, and bends to a height of its own. Between azimuths at which the rim rises and falls heights have no corner.
pub(super) struct NoseHeights<'a> {
    sections: &'a DiscSections<'a>,
    /// Radius of the circle, mm.
    reach_mm: f64,
    /// How far it goes along a rim's tangent, mm, and how far on it bends.
    tangent_mm: f64,
    /// The rim at each azimuth, or the edge of the disc around a rectangle, and the centre that touches it.
    rims: Vec<(MeridianPlace, DVec2)>,
}

impl<'a> NoseHeights<'a> {
    /// Those of a circle at `per_turn` azimuths.
    ///
    /// # Errors
    /// [`TurningError::NoSection`].
    pub(super) fn new(
        sections: &'a DiscSections<'a>,
        reach_mm: f64,
        per_turn: usize,
        tangent_mm: f64,
    ) -> Result<Self, TurningError> {
        let rims = parallel::map(per_turn, 1, |k| {
            let azimuth = TAU * k as f64 / per_turn as f64;
            let outer_mm = || sections.most(|place| place.section.at.x);
            let rim = sections.edge(azimuth).ok_or_else(|| lost(azimuth, outer_mm()))?;
            Ok::<_, TurningError>((rim, rim.at + reach_mm * rim.normal()))
        });
        let rims = rims.into_iter().collect::<Result<_, _>>()?;
        Ok(Self { sections, reach_mm, tangent_mm, rims })
    }

    /// Azimuths of a turn.
    pub(super) fn per_turn(&self) -> usize {
        self.rims.len()
    }

    /// Distance from the axis from which on the circle is beside the mirror at all azimuths, mm.
    pub(super) fn outside_mm(&self) -> f64 {
        let ends = self.rims.iter().map(|(rim, centre)| rim.at.x.max(centre.x));
        ends.fold(0.0, f64::max)
    }

    /// Z of the centre at azimuth `k` of a turn and a distance from the axis, mm.
    ///
    /// # Errors
    /// [`TurningError::NoSection`].
    pub(super) fn over(&self, k: usize, x_mm: f64) -> Result<f64, TurningError> {
        Ok(self.touching(k, x_mm, None)?.0)
    }

    /// The same, and the chart's coordinates of the place that it touches, which is searched for from `start` on.
    fn touching(
        &self,
        k: usize,
        x_mm: f64,
        start: Option<DVec2>,
    ) -> Result<(f64, Option<DVec2>), TurningError> {
        let (rim, centre) = &self.rims[k];
        if x_mm >= centre.x {
            return Ok((self.beside(rim, *centre, x_mm), None));
        }
        let azimuth = TAU * k as f64 / self.per_turn() as f64;
        let circle = Circle { reach_mm: self.reach_mm, x_mm, most_mm: rim.at.x };
        let from = |start: Option<DVec2>| self.sections.touched(azimuth, &circle, start);
        let touched = from(start).or_else(|| from(None));
        let (touched, q) = touched.ok_or_else(|| lost(azimuth, x_mm))?;
        let depth = self.reach_mm * self.reach_mm - (touched.at.x - x_mm) * (touched.at.x - x_mm);
        Ok((touched.at.y + depth.max(0.0).sqrt(), Some(q)))
    }

    /// Z of the centre beside the mirror.
    fn beside(&self, rim: &MeridianPlace, centre: DVec2, x_mm: f64) -> f64 {
        let beyond = x_mm - centre.x;
        let tangent = self.tangent_mm + (rim.at.x - centre.x).max(0.0);
        let along = match beyond > tangent {
            true => tangent * (2.0 - exp(1.0 - beyond / tangent)),
            false => beyond,
        };
        centre.y + rim.slope * along
    }
}

fn lost(azimuth: f64, radius_mm: f64) -> TurningError {
    TurningError::NoSection { azimuth_deg: degrees(azimuth), radius_mm }
}

/// Distances of a spiral from the axis: it comes nearer by a feed in each turn, the last of which take two, so that it slows down, and ends
/// with a turn in the axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct NoseSpiral {
    /// Where it begins, mm: a whole number of feeds.
    first_mm: f64,
    feed_mm: f64,
}

/// Turns in which the last feed is gone, and the one in the axis.
const LAST_TURNS: f64 = 2.0;
const HELD_TURNS: f64 = 1.0;

impl NoseSpiral {
    /// One that begins no nearer to the axis than `outside_mm`.
    pub(super) fn new(outside_mm: f64, feed_mm: f64) -> Self {
        Self { first_mm: feed_mm * (outside_mm / feed_mm).ceil(), feed_mm }
    }

    /// Its turns.
    pub(super) fn turns(&self) -> f64 {
        (self.first_mm / self.feed_mm).round() - 1.0 + LAST_TURNS + HELD_TURNS
    }

    /// Distance from the axis after so many turns, mm.
    fn at(&self, turn: f64) -> f64 {
        let left = (self.turns() - HELD_TURNS - turn).max(0.0);
        match left < LAST_TURNS {
            // Even up to two turns before its end, where it goes a feed in a turn.
            true => self.feed_mm * left * left / (2.0 * LAST_TURNS),
            false => self.feed_mm * (left - 0.5 * LAST_TURNS),
        }
    }

    /// The places of the centre along it, from azimuth 0 on.
    ///
    /// # Errors
    /// [`TurningError::NoSection`].
    pub(super) fn places(&self, heights: &NoseHeights) -> Result<Vec<DVec2>, TurningError> {
        let per_turn = heights.per_turn();
        let turns = self.turns() as usize;
        let x_mm = |turn: usize, k: usize| self.at(turn as f64 + k as f64 / per_turn as f64);
        let turn = |turn: usize| {
            let mut touched = EvenPlaces::default();
            let place = |k: usize| {
                let x = x_mm(turn, k);
                let (z, near) = heights.touching(k, x, touched.expected())?;
                touched.add(near);
                Ok::<_, TurningError>(DVec2::new(x, z))
            };
            (0..per_turn).map(place).collect::<Result<Vec<_>, _>>()
        };
        let all = parallel::map(turns, 1, turn);
        let mut places = all.into_iter().collect::<Result<Vec<_>, _>>()?.concat();
        let end = x_mm(turns, 0);
        places.push(DVec2::new(end, heights.over(0, end)?));
        Ok(places)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Outline;
    use crate::mirror::Mirror;
    use crate::mirror::fixtures::sloping;
    use crate::num::cos;

    fn disc(slopes: [f64; 2], terms: [f64; 3]) -> Mirror {
        let mut mirror = sloping(slopes, terms, 0.0);
        mirror.outline = Outline::Ring { inner: 0.0, outer: 8.0 };
        mirror
    }

    /// Over the plane z = a x a circle's centre is at r sqrt(1 + a^2 cos^2 t) + a rho cos t.
    #[test]
    fn over_a_tilted_plane_heights_are_those_of_the_closed_form() {
        let (a, reach, per_turn) = (0.3, 0.8, 48);
        let mirror = disc([a, 0.0], [0.0; 3]);
        let sections = DiscSections::new(&mirror).unwrap();
        let sides = [1.0, -1.0].map(|rho| sections.at(0.0, rho).unwrap().at.y);
        let top = 0.5 * (sides[0] + sides[1]);
        let heights = NoseHeights::new(&sections, reach, per_turn, 0.2).unwrap();
        for k in 0..per_turn {
            let slope = a * cos(TAU * k as f64 / per_turn as f64);
            for x in [0.0, 0.1, 1.0, 7.5] {
                let exact = top + reach * f64::sqrt(1.0 + slope * slope) + slope * x;
                let found = heights.over(k, x).unwrap();
                assert!((found - exact).abs() < 1e-9, "{k} {x}: {found} {exact}");
            }
        }
    }

    /// Over a saddle the circle is nowhere nearer to the section than its radius, and somewhere no farther.
    #[test]
    fn over_a_saddle_the_circle_touches_and_does_not_cut() {
        let reach = 0.8;
        let mirror = disc([0.05, 0.02], [0.02, 0.0, -0.02]);
        let sections = DiscSections::new(&mirror).unwrap();
        let heights = NoseHeights::new(&sections, reach, 24, 0.2).unwrap();
        for k in (0..24).step_by(2) {
            let azimuth = TAU * k as f64 / 24.0;
            for x in [0.0, 0.3, 4.0, 7.0, 8.0, 8.3, 9.0, 12.0] {
                let centre = DVec2::new(x, heights.over(k, x).unwrap());
                let off = |rho: f64| centre.distance(sections.at(azimuth, rho).unwrap().at);
                let tried = (0..=200).map(|i| (x - 1.0 + 0.01 * f64::from(i)).min(8.0));
                let nearer = |a: f64, b: f64| if off(b) < off(a) { b } else { a };
                let mut near = tried.reduce(nearer).unwrap();
                for halving in 1..24 {
                    let step = 0.01 / f64::from(1 << halving);
                    near = nearer(nearer(near, near - step), (near + step).min(8.0));
                }
                let least = off(near);
                assert!(least > reach - 1e-6, "{k} {x}: {least}");
                assert!(x > 7.0 || least < reach + 1e-6, "{k} {x}: {least}");
            }
        }
        // Beside the rim heights go on without a step, and end even.
        for k in 0..24 {
            let x = |i: u32| 7.5 + 1e-3 * f64::from(i);
            let found: Vec<f64> = (0..4000).map(|i| heights.over(k, x(i)).unwrap()).collect();
            assert!(found.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 1e-3), "{k}");
            let far = [40.0, 60.0].map(|x| heights.over(k, x).unwrap());
            assert!((far[1] - far[0]).abs() < 1e-9, "{k}");
        }
    }

    #[test]
    fn a_spiral_goes_a_feed_in_a_turn_and_slows_down_in_the_axis() {
        let spiral = NoseSpiral::new(9.95, 0.1);
        assert!((spiral.at(0.0) - 10.0).abs() < 1e-12 && spiral.turns() == 102.0);
        assert!((spiral.at(10.0) - 9.0).abs() < 1e-12 && (spiral.at(99.0) - 0.1).abs() < 1e-12);
        assert!((spiral.at(99.0) - spiral.at(99.01) - 0.001).abs() < 1e-5);
        assert_eq!([spiral.at(101.0), spiral.at(102.0)], [0.0; 2]);
    }
}
