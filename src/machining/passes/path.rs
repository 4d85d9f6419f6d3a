//! Paths of the ball: along the lines of a raster, and along the ridge of a folded mirror.

use super::super::{BallRaster, MachiningError, clears_ridge, fillet_foot};
use super::pass::Pass;
use crate::geom::{DVec2, DVec3, EvenPlaces};
use crate::mirror::{LocalSurface, Mirror};

/// Bisections for the place where the ball ceases to fit: to a rounding error of the line.
const BISECTIONS: usize = 40;

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
            let mut places = LinePlaces::new(self);
            let good: Vec<bool> = (0..=steps)
                .map(|k| places.next(at(k)).is_some_and(|place| self.fits(&place)))
                .collect();
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

    /// Whether the ball fits on a place, over the face or a little beside it.
    fn fits(&self, place: &LocalSurface) -> bool {
        let BallRaster { ball_mm, stepover_mm, .. } = self.raster;
        let q = self.mirror.chart.coordinates(place.at).0;
        clears_ridge(self.mirror, place, ball_mm)
            && self.mirror.full_outline().distance_outside(q) <= 2.0 * stepover_mm
    }

    /// The last place where the ball fits between one where it does not and one where it does.
    fn edge(&self, mut bad: f64, mut good: f64) -> f64 {
        let over = |t: f64| self.foot + self.along * t;
        let mut near = over(good);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (bad + good);
            let found = self.mirror.extended_surface_near(over(middle), near);
            near = found.as_ref().map_or(near, |(_, q)| *q);
            if found.is_some_and(|(place, _)| self.fits(&place)) {
                good = middle;
            } else {
                bad = middle;
            }
        }
        good
    }

    /// One pass from place to place, in even steps of at most `step`.
    fn pass(&self, [from, to]: [f64; 2], step: f64) -> Result<Pass, MachiningError> {
        let steps = ((to - from) / step).ceil().max(1.0) as usize;
        let step = (to - from) / steps as f64;
        let mut places = LinePlaces::new(self);
        let centre = |k: usize| {
            let t = from + step * k as f64;
            let at = self.foot + self.along * t;
            let place = places.next(t).ok_or(MachiningError::Lost { at })?;
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
        let over = self.line.foot + self.line.along * t;
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
