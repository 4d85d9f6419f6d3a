//! What a cutter leaves along one straight move: over a place of the plan the lowest of all its places.
//!
//! Over a place that is s along the move in the plan and q beside it, the cutter whose axis is at t has its lower side at
//! `z_A + m t + h(sqrt(q^2 + (t - s)^2))`, with the move's slope `m` and the height `h` of the lower side over the tip. As `h` is convex and
//! does not fall, so is that as a function of t, and its slope changes its sign once.

use super::ToolMove;
use crate::geom::{Cutter, DVec2, DVec3};

/// The most steps to the place of a move in which a bull-nosed cutter is the lowest: halving alone leaves heights off by far less than 1e-9 mm.
const STEPS: usize = 40;
/// Height of a corner's middle over a place of it, as a share of its radius, below which the side is so steep that Newton's steps come to nothing: there
/// intervals are halved.
const STEEP: f64 = 0.2;
/// The last step, mm: between the ends of a move heights are off by its square over the corner's radius, and slopes by itself over that.
const LAST_MM: f64 = 1e-10;

/// The lowest cutter of a move over a place of the plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CutterPlace {
    /// Z of its lower side there, mm.
    pub z_mm: f64,
    /// Slope (Z_X, Z_Y) of the lowest sides of all its places there.
    pub slope: DVec2,
}

/// A straight move of a cutter.
pub(super) struct CutterMove {
    cutter: Cutter,
    /// Places of the tip.
    tips: [DVec3; 2],
    /// Places of the middle of a ball.
    centres: [DVec3; 2],
    /// Direction in the plan, of unit length, and length there; no direction of a move straight up or down.
    way: DVec2,
    length: f64,
    /// Z of the lower tip, and the middle of the move in the plan, mm.
    low_mm: f64,
    middle: DVec2,
    /// Distance from the middle within which the flat part may come, mm.
    flat_reach: f64,
}

impl CutterMove {
    pub(super) fn new(step: &ToolMove, cutter: Cutter) -> Self {
        Self::between([step.from, step.to], cutter)
    }

    /// The move of a cutter's tip between two places.
    pub(super) fn between(tips: [DVec3; 2], cutter: Cutter) -> Self {
        let centres = tips.map(|tip| tip + DVec3::Z * cutter.radius_mm);
        let way = (tips[1] - tips[0]).truncate();
        let length = way.length();
        Self {
            cutter,
            tips,
            centres,
            way: way.normalize_or_zero(),
            length,
            low_mm: tips[0].z.min(tips[1].z),
            middle: 0.5 * (tips[0] + tips[1]).truncate(),
            flat_reach: 0.5 * length + cutter.flat_mm(),
        }
    }

    /// A height that the cutter is nowhere below at a place, mm: that of its lowest tip, and beside the flat part the paraboloid of the corner's
    /// curvature.
    pub(super) fn least(&self, at: DVec2) -> f64 {
        let beyond = at.distance(self.middle) - self.flat_reach;
        match beyond > 0.0 {
            true => self.low_mm + beyond * beyond / (2.0 * self.cutter.corner_mm),
            false => self.low_mm,
        }
    }

    /// Z of the lowest cutter over a place; none where none comes.
    pub(super) fn lowest(&self, at: DVec2) -> Option<f64> {
        if let Some(ball_mm) = self.cutter.ball_mm() {
            return lower_side(&self.centres, at, ball_mm).map(|(z, _)| z);
        }
        self.lowest_tip(at, f64::INFINITY).map(|(z, _)| z)
    }

    /// The lowest cutter over a place; none where none comes. It may be none too where it is above `most`, mm, which takes less time.
    pub(super) fn place_below(&self, at: DVec2, most: f64) -> Option<CutterPlace> {
        if let Some(ball_mm) = self.cutter.ball_mm() {
            let (z_mm, slope) = lower_side(&self.centres, at, ball_mm)?;
            return Some(CutterPlace { z_mm, slope });
        }
        let (z_mm, t) = self.lowest_tip(at, most)?;
        let [from, to] = self.tips;
        let off = at - from.truncate() - self.way * t;
        let beyond = off.length() - self.cutter.flat_mm();
        let Cutter { corner_mm, .. } = self.cutter;
        let slope = if corner_mm > 0.0 {
            let square = corner_mm * corner_mm - beyond * beyond;
            let steep = if beyond > 0.0 { beyond / square.max(0.0).sqrt() } else { 0.0 };
            off.normalize_or_zero() * steep
        } else {
            // A flat end cuts by the side of its edge that comes last: t goes with the place.
            let along = off.dot(self.way);
            let is_between = t > 0.0 && t < self.length && along != 0.0;
            let rise = if is_between { (to.z - from.z) / self.length } else { 0.0 };
            off * if is_between { rise / along } else { 0.0 }
        };
        slope.is_finite().then_some(CutterPlace { z_mm, slope })
    }

    /// Z of the lowest cutter with a flat end over a place, and the way of its tip, mm; none where none comes, or where it is
    /// surely above `most`.
    fn lowest_tip(&self, at: DVec2, most: f64) -> Option<(f64, f64)> {
        let [from, to] = self.tips;
        let on = at - from.truncate();
        if self.length == 0.0 {
            return Some((from.z.min(to.z) + self.cutter.height(on.length())?, 0.0));
        }
        let (along, beside) = (on.dot(self.way), on.perp_dot(self.way));
        let square = self.cutter.radius_mm * self.cutter.radius_mm - beside * beside;
        if !(square > 0.0) {
            return None;
        }
        let half = square.sqrt();
        let [low, high] = [(along - half).max(0.0), (along + half).min(self.length)];
        if !(low <= high) {
            return None;
        }
        let slope = (to.z - from.z) / self.length;
        let left = most - from.z;
        let t = self.lowest_place([along, beside], slope, [low, high], left)?;
        let off = f64::sqrt(beside * beside + (t - along) * (t - along));
        // (At an end of the part the distance is the radius but for rounding.)
        let side = self.cutter.height(off.min(self.cutter.radius_mm));
        Some((from.z + slope * t + side.unwrap_or(self.cutter.corner_mm), t))
    }

    /// Where along the move, between two places of it, the cutter is lowest over a place; none where it is surely more than `most` above
    /// where the move begins.
    fn lowest_place(
        &self,
        [along, beside]: [f64; 2],
        slope: f64,
        [mut low, mut high]: [f64; 2],
        most: f64,
    ) -> Option<f64> {
        let Cutter { corner_mm, .. } = self.cutter;
        if slope == 0.0 {
            return Some(along.clamp(low, high));
        }
        if corner_mm == 0.0 {
            return Some(if slope > 0.0 { low } else { high });
        }
        let flat = self.cutter.flat_mm();
        // Where it would be with the place on the move's line.
        let steep = slope / f64::sqrt(1.0 + slope * slope);
        let off = flat + corner_mm * steep.abs();
        let before = f64::sqrt((off * off - beside * beside).max(0.0)) * slope.signum();
        let mut t = (along - before).clamp(low, high);
        for k in 0..STEPS {
            let off = f64::sqrt(beside * beside + (t - along) * (t - along));
            let beyond = (off - flat).max(0.0);
            let square = corner_mm * corner_mm - beyond * beyond;
            // The corner's slope x / sqrt(c^2 - x^2), times that of the distance; beyond the corner it is steeper than any.
            let turn = if beyond > 0.0 { (t - along) / off } else { 0.0 };
            let side = square.max(0.0).sqrt();
            let rise = if side > 0.0 { slope + beyond / side * turn } else { turn * f64::INFINITY };
            if rise < 0.0 {
                low = t
            } else {
                high = t
            }
            // A convex function is above its tangents.
            let least = slope * t + corner_mm - side + (rise * (low - t)).min(rise * (high - t));
            if least > most {
                return None;
            }
            let radial = corner_mm * corner_mm / (side * side * side) * turn * turn;
            let around = if beyond > 0.0 { beyond / side * (1.0 - turn * turn) / off } else { 0.0 };
            let newton = t - rise / (radial + around);
            if side >= STEEP * corner_mm && (newton - t).abs() < LAST_MM {
                break;
            }
            // Of most moves an end is the lowest.
            let next = match newton {
                _ if side < STEEP * corner_mm => 0.5 * (low + high),
                inside if low < inside && inside < high => inside,
                outside if k == 0 && !outside.is_nan() => outside.clamp(low, high),
                _ => 0.5 * (low + high),
            };
            let step = (next - t).abs();
            t = next;
            if step < LAST_MM {
                break;
            }
        }
        Some(t)
    }
}

/// Z of the lowest ball of this radius with its centre between two places, over a place of the plan, and its slope there.
pub(super) fn lower_side(&[from, to]: &[DVec3; 2], at: DVec2, radius: f64) -> Option<(f64, DVec2)> {
    let way = (to - from).truncate();
    let length = way.length();
    let on = at - from.truncate();
    let centre = if length > 0.0 {
        let way = way / length;
        let (along, beside) = (on.dot(way), on.perp_dot(way));
        let left = radius * radius - beside * beside;
        if !(left > 0.0) {
            return None;
        }
        let slope = (to.z - from.z) / length;
        let short = slope * f64::sqrt(left / (1.0 + slope * slope));
        let reach = (along - short).clamp(0.0, length);
        let share = reach / length;
        DVec3::new(
            from.x + share * (to.x - from.x),
            from.y + share * (to.y - from.y),
            from.z + share * (to.z - from.z),
        )
    } else if from.z <= to.z {
        from
    } else {
        to
    };
    let off = at - centre.truncate();
    let depth = radius * radius - off.length_squared();
    if !(depth > 0.0) {
        return None;
    }
    let depth = f64::sqrt(depth);
    Some((centre.z - depth, off / depth))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The least over a thousand balls of a move is no lower than the closed form, and near it.
    #[test]
    fn the_lower_side_of_a_move_is_that_of_its_balls() {
        let from = DVec3::new(0.5, -0.3, 2.0);
        for to in [
            DVec3::new(2.5, 1.0, 2.0),
            DVec3::new(1.5, 0.2, 5.0),
            DVec3::new(-1.0, -0.5, -1.0),
            DVec3::new(0.5, -0.3, 0.5),
        ] {
            for k in 0..200 {
                let at = DVec2::new(f64::from(k % 20) * 0.3 - 2.5, f64::from(k / 20) * 0.4 - 2.0);
                let balls = (0..=1000).filter_map(|k| {
                    let centre = from.lerp(to, f64::from(k) / 1000.0);
                    let square = 4.0 - (at - centre.truncate()).length_squared();
                    (square > 0.0).then(|| centre.z - square.sqrt())
                });
                let least = balls.reduce(f64::min);
                match (lower_side(&[from, to], at, 2.0), least) {
                    (None, None) => {}
                    (Some((z, _)), Some(least)) => {
                        assert!(z <= least + 1e-12 && z > least - 2e-2, "{to} {at}: {z} {least}");
                    }
                    // (A rim that lies between two of the balls.)
                    (Some((z, _)), None) => assert!(z > from.z.min(to.z) - 0.2),
                    (None, Some(_)) => panic!("{to} {at}"),
                }
            }
        }
    }

    const MOVES: [[[f64; 3]; 2]; 5] = [
        [[0.5, -0.3, 2.0], [2.5, 1.0, 2.0]],
        [[0.5, -0.3, 2.0], [1.5, 0.2, 5.0]],
        [[0.5, -0.3, 2.0], [-1.0, -0.5, -1.0]],
        [[0.5, -0.3, 2.0], [0.5, -0.3, 0.5]],
        [[-4.0, 0.0, 1.0], [4.0, 0.5, 1.4]],
    ];

    fn passed(k: usize, cutter: Cutter) -> CutterMove {
        let [from, to] = MOVES[k].map(DVec3::from_array);
        CutterMove::new(&ToolMove { from, to, feed: Some(1.0), line: 1 }, cutter)
    }

    /// The least of 4000 cutters along a move is no lower than what is found, and near it, of every corner; nothing is below the bound.
    #[test]
    fn the_lowest_cutter_is_that_of_a_dense_row() {
        for corner_mm in [0.0, 0.3, 1.0, 1.9, 2.0] {
            let cutter = Cutter { radius_mm: 2.0, corner_mm };
            for (k, ends) in MOVES.iter().enumerate() {
                let [from, to] = ends.map(DVec3::from_array);
                let swept = passed(k, cutter);
                for n in 0..300 {
                    let at =
                        DVec2::new(f64::from(n % 20) * 0.31 - 3.0, f64::from(n / 20) * 0.35 - 2.4);
                    let one = |i: i32| {
                        let tip = from.lerp(to, f64::from(i) / 4000.0);
                        Some(tip.z + cutter.height(at.distance(tip.truncate()))?)
                    };
                    let least = (0..=4000).filter_map(one).reduce(f64::min);
                    match (swept.lowest(at), least) {
                        (None, None) => {}
                        (Some(z), Some(least)) => {
                            assert!(
                                z <= least + 1e-9 && z > least - 4e-2,
                                "{corner_mm} {k} {at}: {z} {least}"
                            );
                            assert!(swept.least(at) <= z + 1e-12, "{corner_mm} {k} {at}");
                        }
                        (Some(z), None) => assert!(z > from.z.min(to.z) - 1e-9, "{corner_mm} {at}"),
                        (None, Some(_)) => panic!("{corner_mm} {k} {at}"),
                    }
                }
            }
        }
    }

    /// Straight down a slope m beside a place by q less than the flat part: the flat end is at the plane `z = m x` lowered to its trailing edge, and the
    /// corner's envelope is the plane that is moved by the corner's radius: exact along the middle of the move.
    #[test]
    fn a_slope_is_cut_to_the_envelope_of_the_corner() {
        for corner_mm in [0.0, 0.5, 1.5] {
            for slope in [0.2, 1.0, -0.6] {
                let cutter = Cutter { radius_mm: 2.0, corner_mm };
                let (from, to) = (DVec3::ZERO, DVec3::new(10.0, 0.0, 10.0 * slope));
                let swept =
                    CutterMove::new(&ToolMove { from, to, feed: Some(1.0), line: 1 }, cutter);
                let flat = 2.0 - corner_mm;
                for x in [4.0, 5.3, 6.0] {
                    // The centre of the corner's circle on the lower side goes along a line; below that, square to it, is the envelope.
                    let back = if slope > 0.0 { flat } else { -flat };
                    let exact =
                        slope * (x - back) + corner_mm - corner_mm * f64::sqrt(1.0 + slope * slope);
                    let z = swept.lowest(DVec2::new(x, 0.0)).unwrap();
                    assert!((z - exact).abs() < 1e-9, "{corner_mm} {slope} {x}: {z} {exact}");
                }
            }
        }
    }

    /// A ball's heights are those of its closed form to the last bit, and a bull-nosed cutter that is all but a ball has them too.
    #[test]
    fn a_ball_is_a_cutter_whose_corner_is_its_radius() {
        let almost = Cutter { radius_mm: 2.0, corner_mm: 2.0 - 1e-13 };
        for (k, ends) in MOVES.iter().enumerate() {
            let [ball, near] = [Cutter::ball(2.0), almost].map(|cutter| passed(k, cutter));
            let centres = ends.map(|tip| DVec3::from_array(tip) + DVec3::Z * 2.0);
            for n in 0..300 {
                let at = DVec2::new(f64::from(n % 20) * 0.31 - 3.0, f64::from(n / 20) * 0.35 - 2.4);
                let exact = lower_side(&centres, at, 2.0).map(|(z, _)| z);
                assert_eq!(ball.lowest(at), exact);
                let (Some(z), Some(exact)) = (near.lowest(at), exact) else { continue };
                // Near the equator a lower side is steep.
                assert!((z - exact).abs() < 1e-5, "{k} {at}: {z} {exact}");
            }
        }
    }
}
