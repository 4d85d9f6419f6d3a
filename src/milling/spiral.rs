//! One spiral of a tip over a round mirror: from beyond its rim to the axis, or to beyond its inner rim.
//!
//! The places of contact are at `r = r_0 - w t / (2 pi)` from the axis after an angle `t`, one stepover `w` nearer after each turn. Turns go
//! clockwise from above: the material that is still there lies on the right of a cutter that turns clockwise, whose teeth cut downwards into it
//! (climb milling).

use super::tip_line::TipLine;
use crate::geom::{DVec2, DVec3};
use crate::machining::{MOST_POINTS, MachiningError, rim_distances};
use crate::mirror::Mirror;
use crate::num::{cos, sin};
use crate::parallel;
use std::f64::consts::TAU;

/// Stepovers beyond a rim at which the spiral begins and ends: all around a rim there is then a turn within half of one beyond it.
const BEYOND: f64 = 1.5;
/// What a spiral keeps of the radius of an inner rim that is nearer to the axis than that.
const KEPT: f64 = 0.5;
/// Longest stretch that is taken for a parabola: as a share of the outer radius, and in radians.
const STRETCH: f64 = 1.0 / 25.0;
const STRETCH_RAD: f64 = std::f64::consts::PI / 8.0;
/// What the tip rises at the feed from its last place, mm, before it is retracted.
const LEAD_OUT_MM: f64 = 0.5;

/// How a spiral is taken.
pub(super) struct TipSpiral<'a> {
    /// The mirror.
    pub mirror: &'a Mirror,
    /// Radius of the ball, and what it leaves, mm.
    pub ball_mm: [f64; 2],
    /// From turn to turn in the plan, mm.
    pub stepover_mm: f64,
    /// What straight moves may be off the path, mm.
    pub chord_mm: f64,
    /// Longest move, mm.
    pub longest_mm: f64,
}

impl TipSpiral<'_> {
    /// The tip's path, with a way up at its end.
    ///
    /// # Errors
    /// [`MachiningError::TooFine`] when there are too many turns, [`MachiningError::Lost`] of a place beyond the rim that the
    /// mirror's surface does not reach.
    pub(super) fn line(&self) -> Result<TipLine, MachiningError> {
        let w = self.stepover_mm;
        let [[inner, _], [_, outer]] = rim_distances(self.mirror).unwrap_or_default();
        let first = outer + BEYOND * w;
        let last = if inner > 0.0 { (inner - BEYOND * w).max(KEPT * inner) } else { 0.0 };
        let turn = TAU * (first - last) / w;
        let count = turn / STRETCH + turn / STRETCH_RAD;
        if !(count <= MOST_POINTS) {
            let (what, least_mm) = ("points of a spiral", None);
            return Err(MachiningError::TooFine { stepover_mm: w, count, what, least_mm });
        }
        let mut angles = vec![0.0];
        let mut at = 0.0;
        while at < turn {
            let radius = first - w * at / TAU;
            at += STRETCH_RAD.min(STRETCH * outer / radius);
            angles.push(at.min(turn));
        }
        let place = |angle: f64| self.tip(first, angle);
        let stretches = parallel::map(angles.len() - 1, 16, |k| {
            self.stretch(&place, [angles[k], angles[k + 1]])
        });
        let mut places = vec![place(0.0)?];
        for stretch in stretches {
            places.extend(stretch?);
        }
        let end = places.len() - 1;
        let way = |from: DVec3, to: DVec3| (to - from).normalize_or(DVec3::X);
        let directions = [way(places[0], places[1]), way(places[end - 1], places[end])];
        places.push(places[end] + DVec3::Z * LEAD_OUT_MM);
        Ok(TipLine { places, directions })
    }

    /// The tip after an angle of a spiral that begins at the radius `first`, mm.
    fn tip(&self, first: f64, angle: f64) -> Result<DVec3, MachiningError> {
        let radius = (first - self.stepover_mm * angle / TAU).max(0.0);
        let at = radius * DVec2::new(cos(angle), -sin(angle));
        let place = self.mirror.extended_surface_over(at).ok_or(MachiningError::Lost { at })?;
        let [ball_mm, left_mm] = self.ball_mm;
        Ok(place.at + (ball_mm + left_mm) * place.normal() - DVec3::Z * ball_mm)
    }

    /// Ends of the moves from one angle to another.
    fn stretch(
        &self,
        place: &impl Fn(f64) -> Result<DVec3, MachiningError>,
        [from, to]: [f64; 2],
    ) -> Result<Vec<DVec3>, MachiningError> {
        let at = |share: f64| place(from + share * (to - from));
        let quarters = [at(0.0)?, at(0.25)?, at(0.5)?, at(0.75)?, at(1.0)?];
        // A quarter's second difference d is that of a curve whose chord over all of the stretch is 2 d off, over one of n parts 2 d / n^2.
        let bend = |three: &[DVec3]| (three[0] - 2.0 * three[1] + three[2]).length();
        let most = quarters.windows(3).map(bend).fold(0.0, f64::max);
        let by_chord = (2.0 * most / self.chord_mm).sqrt();
        let by_length = (quarters[4] - quarters[0]).length() / self.longest_mm;
        let parts = by_chord.max(by_length).ceil().max(1.0);
        let inside = (1..parts as usize).map(|n| at(n as f64 / parts));
        inside.chain([Ok(quarters[4])]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Outline;
    use crate::milling::distance_from_move;
    use crate::mirror::fixtures::{quadric, sloping};
    use crate::num::atan2;

    fn round(mut mirror: Mirror, inner: f64) -> Mirror {
        mirror.outline = Outline::Ring { inner, outer: 4.0 };
        mirror
    }

    fn spiral(mirror: &Mirror, chord_mm: f64) -> TipLine {
        let (ball_mm, longest_mm) = ([1.5, 0.25], f64::INFINITY);
        let spiral = TipSpiral { mirror, ball_mm, stepover_mm: 0.2, chord_mm, longest_mm };
        spiral.line().unwrap()
    }

    /// Of a plane that is tilted, and of a bowl: where the ball of each place touches is a radius and the allowance off along the normal, and
    /// one stepover nearer to the axis after a turn; moves are within the chord of the path.
    #[test]
    fn a_spiral_touches_the_mirror_at_even_turns() {
        for (mirror, inner) in [
            (round(sloping([0.3, -0.2], [0.0; 3], 0.0), 0.0), 0.0),
            (round(quadric([0.05, 0.0, 0.05], 0.0), 0.0), 0.0),
            (round(quadric([-0.06, 0.03, -0.02], 0.02), 1.5), 1.5),
        ] {
            let chord_mm = 4e-4;
            let line = spiral(&mirror, chord_mm);
            let centre = |tip: &DVec3| *tip + DVec3::Z * 1.5;
            let foot = |centre: DVec3| {
                let mut at = centre.truncate();
                for _ in 0..25 {
                    let normal = mirror.extended_surface_over(at).unwrap().normal();
                    at = (centre - 1.75 * normal).truncate();
                }
                mirror.extended_surface_over(at).unwrap().at
            };
            let path = &line.places[..line.places.len() - 1];
            let contacts: Vec<DVec3> = path.iter().map(|tip| foot(centre(tip))).collect();
            let mut turned = 0.0;
            let begin = contacts[0].truncate().length();
            for (k, contact) in contacts.iter().enumerate() {
                let radius = contact.truncate().length();
                if k > 0 && radius > 1e-3 {
                    let [a, b] = [contacts[k - 1], *contact].map(DVec3::truncate);
                    turned -= atan2(a.perp_dot(b), a.dot(b));
                    let exact = begin - 0.2 * turned / TAU;
                    assert!((radius - exact).abs() < 1e-7, "{k}: {radius} {exact}");
                }
                assert!((contact.distance(centre(&path[k])) - 1.75).abs() < 1e-9, "{k}");
            }
            for pair in path.windows(2) {
                let middle = centre(&(0.5 * (pair[0] + pair[1])));
                let off = middle.distance(foot(middle)) - 1.75;
                assert!(off.abs() < 1.05 * chord_mm, "{off}");
            }
            let end = contacts[contacts.len() - 1].truncate().length();
            let [[within, _], [_, beyond]] = rim_distances(&mirror).unwrap();
            assert!(if inner == 0.0 { end < 1e-12 } else { end < within - 0.1 }, "{end}");
            assert!(begin > beyond + 0.1, "{begin}");
            assert!(line.places[path.len()].z > path[path.len() - 1].z);
        }
    }

    /// Places of a path with a tenth of the chord are no farther off the moves than the chord.
    #[test]
    fn straight_moves_keep_to_a_finer_path() {
        let mirror = round(quadric([0.05, 0.02, -0.03], 0.0), 0.0);
        let [coarse, fine] = [1e-3, 1e-4].map(|chord_mm| spiral(&mirror, chord_mm).places);
        assert!(fine.len() > 2 * coarse.len(), "{} {}", fine.len(), coarse.len());
        let mut k = 0;
        for at in &fine {
            // Both go the same way; the move that is nearest is the same one or one of the next.
            let off = |k: usize| distance_from_move(*at, [coarse[k], coarse[k + 1]]);
            let near =
                (k..(k + 3).min(coarse.len() - 1)).min_by(|a, b| off(*a).total_cmp(&off(*b)));
            k = near.unwrap_or(k);
            assert!(off(k) < 1.15e-3, "{at}: {}", off(k));
        }
    }
}
