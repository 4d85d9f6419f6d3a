//! Paths of the ball: along the lines of a raster, and along the ridge of a folded mirror.

use super::super::fillet::ridge_clearance;
use super::super::{BallRaster, MachiningError, fillet_foot};
use super::pass::Pass;
use crate::geom::{DVec2, DVec3, EvenPlaces};
use crate::mirror::{LocalSurface, Mirror};

/// Most steps in the search for the place where the ball ceases to fit: bisections to a rounding error of the line.
const BISECTIONS: usize = 40;
/// Room that is left there, mm: a thousandth of what a program's finest digits are.
const CLOSE_MM: f64 = 1e-9;
/// Longest stride, in steps, over places where the ball surely fits. A step is a 200th of the face at most; after so small a part of
/// it places and the ball's centre move by less than twice as much a step.
const LONGEST_STRIDE: f64 = 16.0;

/// A line of a raster over a mirror: the places `foot` + t `along` of the plan, t between both ends.
pub(super) struct Line<'a> {
    pub mirror: &'a Mirror,
    pub raster: BallRaster,
    pub foot: DVec2,
    pub along: DVec2,
    pub ends: [f64; 2],
}

impl Line<'_> {
    /// The passes along the line: its parts on each panel, as far as the ball fits.
    ///
    /// # Errors
    /// [`MachiningError::Lost`] when the line leaves the mirror.
    pub(super) fn passes(&self, step: f64) -> Result<Vec<Pass>, MachiningError> {
        let mut passes = Vec::new();
        for [lo, hi] in self.stretches() {
            // A ridge is where one panel ends and the other begins; a hair off it tells which.
            let hair = 1e-9 * (hi - lo);
            let (lo, hi) = (lo + hair, hi - hair);
            let steps = ((hi - lo) / step).ceil().max(1.0) as usize;
            let at = |k: usize| lo + (hi - lo) * k as f64 / steps as f64;
            let good = self.good(steps, at);
            let mut next = 0;
            for run in good.chunk_by(|a, b| a == b) {
                let (begin, end) = (next, next + run.len() - 1);
                next += run.len();
                if !run[0] {
                    continue;
                }
                let from = if begin > 0 { self.edge(at(begin - 1), at(begin)) } else { at(begin) };
                let to = if end < steps { self.edge(at(end + 1), at(end)) } else { at(end) };
                passes.push(self.pass([from, to], step)?);
            }
        }
        Ok(passes)
    }

    /// Whether the ball fits at each of the places `at` 0 to `steps`.
    fn good(&self, steps: usize, at: impl Fn(usize) -> f64) -> Vec<bool> {
        let mut good = Vec::with_capacity(steps + 1);
        // The last place and the ball's centre on it, and how far the place was, a step, from the one before.
        let mut last: Option<(DVec2, DVec3)> = None;
        let (mut moved, mut stride) = (DVec2::ZERO, 1);
        while good.len() <= steps {
            let over = self.over(at(good.len()));
            let near = last.map_or(over, |(q, _)| q + moved * stride as f64);
            let mirror = self.mirror;
            let found = mirror.extended_surface_near(over, near);
            let found = found.or_else(|| mirror.extended_surface_near(over, over));
            let room = found.as_ref().map(|(place, _)| self.room(place));
            good.push(room.is_some_and(|room| room >= 0.0));
            let now = found.map(|(place, q)| (q, place.at + place.normal() * self.raster.ball_mm));
            let (Some(room), Some(now), Some(before)) = (room, now, last) else {
                (last, moved, stride) = (now, DVec2::ZERO, 1);
                continue;
            };
            let share = 1.0 / stride as f64;
            moved = (now.0 - before.0) * share;
            let fastest = moved.length().max((now.1 - before.1).length() * share);
            last = Some(now);
            stride = safe_stride(room, fastest);
            let left_out = (stride - 1).min(steps + 1 - good.len());
            good.extend(std::iter::repeat_n(true, left_out));
        }
        good
    }

    /// How far a place and the ball's centre on it may move, mm, before the ball does not fit over the face or a little beside it;
    /// negative where it does not.
    fn room(&self, place: &LocalSurface) -> f64 {
        let BallRaster { ball_mm, stepover_mm, .. } = self.raster;
        let q = self.mirror.chart.coordinates(place.at).0;
        let inside = 2.0 * stepover_mm - self.mirror.full_outline().distance_outside(q);
        inside.min(ridge_clearance(self.mirror, place, ball_mm))
    }

    /// The last place where the ball fits between one where it does not and one where it does: by false position, of which
    /// an end that stays counts for half (the method called Illinois).
    fn edge(&self, mut bad: f64, mut good: f64) -> f64 {
        let mut near = self.over(good);
        let mut room = |t: f64| {
            let (place, q) = self.mirror.extended_surface_near(self.over(t), near)?;
            near = q;
            Some(self.room(&place)).filter(|room| room.is_finite())
        };
        let (mut at_good, mut at_bad) = (room(good), room(bad).filter(|room| *room < 0.0));
        for _ in 0..BISECTIONS {
            let share = at_good.zip(at_bad).map_or(0.5, |(good, bad)| good / (good - bad));
            let t = good + (bad - good) * share;
            let found = room(t);
            if found.is_some_and(|room| room >= 0.0) {
                (good, at_good, at_bad) = (t, found, at_bad.map(|room| 0.5 * room));
                if found <= Some(CLOSE_MM) {
                    break;
                }
            } else {
                (bad, at_bad, at_good) = (t, found, at_good.map(|room| 0.5 * room));
            }
        }
        good
    }

    /// The place of the plan at `t`.
    fn over(&self, t: f64) -> DVec2 {
        self.foot + self.along * t
    }

    /// One pass from place to place, in even steps of at most `step`.
    fn pass(&self, [from, to]: [f64; 2], step: f64) -> Result<Pass, MachiningError> {
        let steps = ((to - from) / step).ceil().max(1.0) as usize;
        let step = (to - from) / steps as f64;
        let mut places = LinePlaces::new(self);
        let centre = |k: usize| {
            let t = from + step * k as f64;
            let place = places.next(t).ok_or(MachiningError::Lost { at: self.over(t) })?;
            Ok(centre(&place, self.raster.ball_mm, self.along))
        };
        let centres = (0..=steps).map(centre).collect::<Result<_, MachiningError>>()?;
        Ok(Pass { along: self.along, start: from, step, centres })
    }

    /// The parts of the line that lie on one panel each.
    fn stretches(&self) -> Vec<[f64; 2]> {
        let Self { foot, along, ends: [lo, hi], .. } = *self;
        let ridge = -foot.y / along.y;
        if self.mirror.folded && along.y != 0.0 && ridge > lo && ridge < hi {
            vec![[lo, ridge], [ridge, hi]]
        } else {
            vec![[lo, hi]]
        }
    }
}

/// Steps to a place up to which the ball surely fits, where it has `room` and moved by `fastest` a step, mm.
fn safe_stride(room: f64, fastest: f64) -> usize {
    let surely = 0.5 * room / fastest;
    if surely > 1.0 { surely.min(LONGEST_STRIDE) as usize } else { 1 }
}

/// Places of a mirror at even steps along a line: each is searched for where those before lead to.
struct LinePlaces<'a> {
    line: &'a Line<'a>,
    /// Their coordinates on the chart.
    found: EvenPlaces,
}

impl<'a> LinePlaces<'a> {
    fn new(line: &'a Line<'a>) -> Self {
        Self { line, found: EvenPlaces::default() }
    }

    /// The next place, which is at `t`; none where there is none.
    fn next(&mut self, t: f64) -> Option<LocalSurface> {
        let over = self.line.over(t);
        let near = self.found.expected().unwrap_or(over);
        let mirror = self.line.mirror;
        let found = mirror.extended_surface_near(over, near);
        let found = found.or_else(|| mirror.extended_surface_near(over, over));
        self.found.add(found.as_ref().map(|(_, q)| *q));
        Some(found?.0)
    }
}

/// The centre of the ball on `place`, and its derivative as the place moves along the plan's `along`.
fn centre(place: &LocalSurface, ball: f64, along: DVec2) -> [DVec3; 2] {
    let g = place.stretch();
    let turn = place.hessian.times(along);
    let steeper = place.slope.dot(turn) / g;
    let up = (-place.slope).extend(1.0);
    let normal = (-turn).extend(0.0) / g - up * (steeper / (g * g));
    [place.at + place.normal() * ball, along.extend(place.slope.dot(along)) + normal * ball]
}

/// The passes along the ridge of a folded mirror, their parameter x of the chart: where it is a valley
/// the ball touches both panels, where it is a crest first one and then the other.
pub(super) fn passes_along_ridge(mirror: &Mirror, ball: f64, step: f64) -> Vec<Pass> {
    if !mirror.folded {
        return Vec::new();
    }
    let bounds = mirror.outline.bounds();
    // Beyond both ends, as lines are.
    let over = 4.0 * step;
    let (start, end) = (bounds.min.x - over, bounds.max.x + over);
    let steps = ((end - start) / step).ceil() as usize;
    let step = (end - start) / steps as f64;
    let centre = |k: usize| {
        let x = start + step * k as f64;
        let foot = fillet_foot(mirror, x, ball);
        let place = mirror.extended_surface(foot.unwrap_or(DVec2::new(x, 0.0)));
        (foot.is_some(), place.at + place.normal() * ball)
    };
    let all: Vec<(bool, DVec3)> = (0..=steps).map(centre).collect();
    let (mut passes, mut next) = (Vec::new(), 0);
    for run in all.chunk_by(|a, b| a.0 == b.0) {
        let start = start + step * next as f64;
        next += run.len();
        let last = run.len() - 1;
        // (Beyond both ends there is no telling of a valley from a crest.)
        let is_beyond = start > bounds.max.x || start + step * last as f64 <= bounds.min.x;
        if last == 0 || is_beyond {
            continue;
        }
        // Differences, on one side at the ends.
        let pass = |flip: f64| {
            let at = |k: usize| run[k].1 * DVec3::new(1.0, flip, 1.0);
            let turn = |k: usize| {
                let (a, b) = (k.saturating_sub(1), (k + 1).min(last));
                (at(b) - at(a)) / (step * (b - a) as f64)
            };
            let centres = (0..=last).map(|k| [at(k), turn(k)]).collect();
            Pass { along: DVec2::X, start, step, centres }
        };
        // In a valley the centre is over its bottom.
        let flips = if run[0].0 { &[0.0][..] } else { &[1.0, -1.0] };
        passes.extend(flips.iter().map(|&flip| pass(flip)));
    }
    passes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mirror::fixtures::{quadric, roof};
    use crate::num::radians;

    /// Lines of several directions over a bowl and a saddle under a pinhole, a roof and a valley.
    fn lines(mut test: impl FnMut(&Line)) {
        let bowls = [quadric([0.05, 0.03, 0.06], 0.03), quadric([-0.06, 0.02, 0.05], 0.03)];
        for mirror in bowls.into_iter().chain([roof(20.0), roof(-20.0)]) {
            for degrees in [0.0, 33.0, 90.0] {
                let raster = BallRaster { ball_mm: 2.0, stepover_mm: 0.1, angle: radians(degrees) };
                let along = raster.along();
                for k in -25..=25 {
                    let foot = along.perp() * (0.2 * f64::from(k) + 0.01);
                    test(&Line { mirror: &mirror, raster, foot, along, ends: [-6.0, 6.0] });
                }
            }
        }
    }

    #[test]
    fn steps_are_left_out_where_the_ball_fits_alone() {
        let (mut looked_at, mut fits) = (0, 0);
        lines(|line| {
            for [lo, hi] in line.stretches() {
                let at = |k: usize| lo + 1e-6 + (hi - lo - 2e-6) * k as f64 / 240.0;
                let good = line.good(240, at);
                for (k, good) in good.into_iter().enumerate() {
                    let found = line.mirror.extended_surface_over(line.over(at(k)));
                    let exact = found.is_some_and(|place| line.room(&place) >= 0.0);
                    assert_eq!(good, exact, "{:?} at {}", line.raster, line.over(at(k)));
                    looked_at += 1;
                    fits += usize::from(good);
                }
            }
        });
        assert!(fits > looked_at / 4 && fits < looked_at * 3 / 4, "{fits} of {looked_at}");
    }

    #[test]
    fn strides_are_half_of_the_room_and_never_none() {
        for (room, fastest, steps) in [
            (1.0, 0.1, 5),
            (1.0, 0.01, 16),
            (1.0, 0.0, 16),
            (0.15, 0.1, 1),
            (-1.0, 0.1, 1),
            (f64::NAN, 0.1, 1),
            (1.0, f64::NAN, 1),
        ] {
            assert_eq!(safe_stride(room, fastest), steps, "{room} by {fastest}");
        }
    }

    #[test]
    fn passes_end_where_the_ball_ceases_to_fit() {
        lines(|line| {
            for pass in line.passes(0.05).unwrap() {
                let last = pass.centres.len() - 1;
                for t in [pass.start, pass.start + pass.step * last as f64] {
                    let is_end = line.ends.iter().any(|end| (t - end).abs() < 1e-6)
                        || line.over(t).y.abs() < 1e-6;
                    let room = |t: f64| {
                        let place = line.mirror.extended_surface_over(line.over(t)).unwrap();
                        line.room(&place)
                    };
                    assert!(
                        is_end || (-1e-9..=2.0 * CLOSE_MM).contains(&room(t)),
                        "{} {}",
                        line.over(t),
                        room(t)
                    );
                }
            }
        });
    }
}
