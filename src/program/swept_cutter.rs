//! What a cutter leaves along straight moves: over each place of the plan the lowest of all its places.
//!
//! The balls of a move from A to B have their centres between A and B. Over (X, Y) that is s along the move in the plan and q
//! beside it, the ball whose centre is u short of s has its lower side at
//! `z_A + m (s - u) - sqrt(r^2 - u^2)`, with `r^2 = R^2 - q^2` and the move's slope `m`. That is least at `u = m r / sqrt(1 + m^2)`,
//! or at the end of the move that is nearer to it.
//!
//! A tree of squares holds, in each square of the plan, the moves that may be the lowest there. A ball of radius `R + d` about
//! the same centres is nowhere higher over a square's middle than the ball of radius `R` is over the square, whose corners are `d` from
//! its middle; one of radius `R - d` is nowhere lower. So in a large square a move is left out where its larger ball is above the
//! smaller ball of another. In a small one slopes tell more. What one move leaves is convex too, as the lower side is: it is nowhere below its tangent over the middle. The lowest one over
//! the middle is nowhere above its own tangent by more than `B d^2 / 2`, with the largest second derivative B of the lower side within `d` of the
//! place that is over the middle. So a move is left out where it is higher there by more than `|p - q| d + B d^2 / 2`, with its slope p and that of the lowest one, q;
//! and one that does not come over the middle where its larger cutter is higher than the lowest place by more than `|q| d + B d^2 / 2`, the most that it
//! rises to within the square.
//!
//! Of a cutter with a flat end the larger one has a flat part wider by `d`, and the smaller one a flat part narrower by `d` or, where it is narrower
//! than that, the ball that is left of it, as far up.

use super::ToolMove;
use super::cutter_move::{CutterMove, CutterPlace, lower_side};
use crate::geom::{Cutter, DVec2, DVec3, Rect};
use crate::parallel;
use std::sync::OnceLock;

/// A square with so few moves is not divided, and the most divisions: to some hundredths of a millimetre.
const FEW: usize = 12;
const DEEPEST: usize = 11;
/// Divisions from which on a square of which no move was left out is not divided: many moves of a flat end may be as low as each other all over it.
const DEEP: usize = 9;
/// More than heights of a cutter with a flat end are off, mm.
const ROUNDING_MM: f64 = 1e-9;
/// Squares are divided by several threads down to this depth.
const SHARED: usize = 3;

/// The surface below a cutter's moves.
#[derive(Debug)]
pub struct SweptCutter {
    cutter: Cutter,
    /// Ends of the moves, of the middle of the cutter's ball or of its tip where it is none.
    ends: Vec<[DVec3; 2]>,
    bounds: Rect,
    root: Square,
}

/// A square of the plan.
#[derive(Debug)]
struct Square {
    /// Numbers of the moves that may be the lowest in it, rising.
    steps: Vec<u32>,
    /// Left below, right below, left above, right above, each from when a place in it is first asked for; none where it is not divided.
    parts: Option<Box<[OnceLock<Square>; 4]>>,
}

/// The lowest place of all cutters over a place of the plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SweptPlace {
    /// Its Z, mm.
    pub z_mm: f64,
    /// Its slope (Z_X, Z_Y).
    pub slope: DVec2,
    /// Number of the move whose cutter it is, the first of several.
    pub step: usize,
}

impl SweptCutter {
    /// The surface that a cutter leaves along `moves` of its tip, within the rectangle between two corners.
    #[must_use]
    pub fn new(moves: &[ToolMove], cutter: Cutter, [min, max]: [DVec2; 2]) -> Self {
        let up = DVec3::Z * cutter.ball_mm().unwrap_or(0.0);
        let ends: Vec<_> = moves.iter().map(|step| [step.from + up, step.to + up]).collect();
        let bounds = Rect { min, max };
        let mut swept =
            Self { cutter, ends, bounds, root: Square { steps: Vec::new(), parts: None } };
        swept.root = swept.square((0..moves.len() as u32).collect(), bounds, 0);
        swept.divide(&swept.root, bounds, 0);
        swept
    }

    /// A square of which some of `steps` may be the lowest, `depth` divisions down.
    fn square(&self, mut steps: Vec<u32>, rect: Rect, depth: usize) -> Square {
        let (middle, reach) = (rect.centre(), 0.5 * rect.size().length());
        let given = steps.len();
        if !self.leave_higher(middle, reach, &mut steps) {
            self.leave_above_others(middle, reach, &mut steps);
        }
        steps.shrink_to_fit();
        let is_in_vain = depth >= DEEP && steps.len() == given;
        let is_leaf = steps.len() <= FEW || depth == DEEPEST || is_in_vain;
        Square { steps, parts: (!is_leaf).then(Default::default) }
    }

    /// Divides a square that has many moves beforehand, by several threads.
    fn divide(&self, square: &Square, rect: Rect, depth: usize) {
        let Some(parts) = square.parts.as_deref().filter(|_| depth < SHARED) else { return };
        parallel::map(4, 1, |k| {
            self.divide(
                self.part(square, (&parts[k], quarter(rect, k)), depth),
                quarter(rect, k),
                depth + 1,
            );
        });
    }

    /// A part of a square, made when it is first asked for.
    fn part<'a>(
        &self,
        square: &Square,
        (part, rect): (&'a OnceLock<Square>, Rect),
        depth: usize,
    ) -> &'a Square {
        part.get_or_init(|| self.square(square.steps.clone(), rect, depth + 1))
    }

    /// Z over `middle` of a cutter larger by `wider` mm, which one move is nowhere lower than within as much of it; where that is negative,
    /// of a smaller one, which it is nowhere higher than. None where such a cutter does not come over it.
    fn lowest_within(&self, step: u32, middle: DVec2, wider: f64) -> Option<f64> {
        let ends = self.ends[step as usize];
        let radius_mm = self.cutter.radius_mm + wider;
        if !(radius_mm > 0.0) {
            return None;
        }
        if self.cutter.ball_mm().is_some() {
            return lower_side(&ends, middle, radius_mm).map(|(z, _)| z);
        }
        let corner_mm = self.cutter.corner_mm.min(radius_mm);
        let raised = self.cutter.corner_mm - corner_mm;
        let moved = CutterMove::between(ends, Cutter { radius_mm, corner_mm });
        Some(moved.lowest(middle)? + raised)
    }

    /// Leaves out moves of which a larger cutter is above a smaller one of another.
    fn leave_above_others(&self, middle: DVec2, reach: f64, steps: &mut Vec<u32>) {
        let surely = steps.iter().filter_map(|&k| self.lowest_within(k, middle, -reach));
        // The flat end of a move over all of the square is as low for both, but for rounding.
        let rounding = if self.cutter.ball_mm().is_some() { 0.0 } else { ROUNDING_MM };
        let most = surely.fold(f64::INFINITY, f64::min) + rounding;
        steps.retain(|&k| self.lowest_within(k, middle, reach).is_some_and(|z| z <= most));
    }

    /// Leaves out moves that are higher than the lowest one over `middle` all over a square of which no place is farther from it than `reach`;
    /// false where that cannot be told.
    fn leave_higher(&self, middle: DVec2, reach: f64, steps: &mut Vec<u32>) -> bool {
        if !(self.cutter.corner_mm > reach) {
            return false;
        }
        let places: Vec<_> = steps.iter().map(|&k| self.of_step(k as usize, middle)).collect();
        let lower = |a: (f64, DVec2), b: (f64, DVec2)| if b.0 < a.0 { b } else { a };
        let lowest = places.iter().flatten().copied().reduce(lower);
        let bend = lowest.and_then(|(_, slope)| self.most_bent(slope, reach));
        let Some(((z, slope), bend)) = lowest.zip(bend) else { return false };
        let rise = |slope: DVec2| reach * (slope.length() + 0.5 * reach * bend) + ROUNDING_MM;
        let most = z + rise(slope);
        let mut places = places.into_iter();
        steps.retain(|&k| match places.next().flatten() {
            Some((own, way)) => own - z <= rise(slope - way),
            // (It is not over the middle.)
            None => self.lowest_within(k, middle, reach).is_some_and(|z| z <= most),
        });
        true
    }

    /// The largest second derivative of the lower side of a cutter, 1/mm, within `reach` mm of a place of it with this slope; none where its side
    /// is too near, and of a flat end, whose slopes change at once.
    fn most_bent(&self, slope: DVec2, reach: f64) -> Option<f64> {
        let corner = self.cutter.corner_mm;
        let steep = slope.length();
        let beyond = corner * steep / f64::sqrt(1.0 + steep * steep) + reach;
        let square = corner * corner - beyond * beyond;
        (square > 0.05 * corner * corner).then(|| corner * corner / (square * square.sqrt()))
    }

    /// The cutter.
    #[must_use]
    pub fn cutter(&self) -> Cutter {
        self.cutter
    }

    /// The lowest place of all cutters over a place within the corners; none where no cutter comes.
    #[must_use]
    pub fn lowest(&self, at: DVec2) -> Option<SweptPlace> {
        let (mut square, mut rect, mut depth) = (&self.root, self.bounds, 0);
        while let Some(parts) = &square.parts {
            let middle = rect.centre();
            let k = usize::from(at.x > middle.x) + 2 * usize::from(at.y > middle.y);
            rect = quarter(rect, k);
            square = self.part(square, (&parts[k], rect), depth);
            depth += 1;
        }
        let mut lowest: Option<SweptPlace> = None;
        for &k in &square.steps {
            let most = lowest.map_or(f64::INFINITY, |lowest| lowest.z_mm + ROUNDING_MM);
            let place = self.step_below(k as usize, at, most);
            let Some(CutterPlace { z_mm, slope }) = place else { continue };
            if lowest.is_none_or(|lowest| z_mm < lowest.z_mm) {
                lowest = Some(SweptPlace { z_mm, slope, step: k as usize });
            }
        }
        lowest
    }

    /// Z and slope of the lower side of the cutters of one move over a place of the plan.
    #[must_use]
    pub fn of_step(&self, step: usize, at: DVec2) -> Option<(f64, DVec2)> {
        let CutterPlace { z_mm, slope } = self.step_below(step, at, f64::INFINITY)?;
        Some((z_mm, slope))
    }

    /// The same; it may be none too where it is above `most`, mm.
    fn step_below(&self, step: usize, at: DVec2, most: f64) -> Option<CutterPlace> {
        let ends = self.ends[step];
        match self.cutter.ball_mm() {
            Some(ball_mm) => {
                lower_side(&ends, at, ball_mm).map(|(z_mm, slope)| CutterPlace { z_mm, slope })
            }
            None => CutterMove::between(ends, self.cutter).place_below(at, most),
        }
    }
}

fn quarter(Rect { min, max }: Rect, k: usize) -> Rect {
    let middle = 0.5 * (min + max);
    let (mut low, mut high) = (min, max);
    if k.is_multiple_of(2) {
        high.x = middle.x
    } else {
        low.x = middle.x
    }
    if k < 2 {
        high.y = middle.y
    } else {
        low.y = middle.y
    }
    Rect { min: low, max: high }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::random::RandomStream;

    /// The tree finds what a search among all moves finds, and slopes are those of differences.
    #[test]
    fn the_tree_leaves_nothing_out() {
        let draws = RandomStream { seed: 7, trial: 0 };
        let mut draw = 0;
        let mut place = || {
            draw += 1;
            let ([x, y], [z, _]) = (draws.pair(0, draw), draws.pair(1, draw));
            DVec3::new(10.0 * x, 8.0 * y, 3.0 * z)
        };
        let mut moves = Vec::new();
        let mut from = place();
        for k in 0..400 {
            let to = place();
            let to = if k % 3 == 0 { to } else { from.lerp(to, 0.1) };
            moves.push(ToolMove { from, to, feed: Some(1.0), line: 1 });
            from = to;
        }
        let corners = [DVec2::ZERO, DVec2::new(10.0, 8.0)];
        for corner_mm in [0.8, 0.3, 0.0] {
            let cutter = Cutter { radius_mm: 0.8, corner_mm };
            held_against_all(&SweptCutter::new(&moves, cutter, corners), moves.len());
        }
    }

    /// A bull-nosed cutter along dense lines over a dome: most moves are left out of a square, and none that is the lowest in it.
    #[test]
    fn few_of_dense_lines_are_left_in_a_square() {
        let cutter = Cutter { radius_mm: 1.2, corner_mm: 0.3 };
        let tip = |x: f64, y: f64| {
            let at = DVec2::new(x - 5.0, y - 4.0);
            DVec3::new(x, y, -at.length_squared() / 40.0)
        };
        let mut moves = Vec::new();
        for line in 0..160 {
            let y = 0.05 * f64::from(line);
            let step = |n: i32| {
                let [from, to] = [n, n + 1].map(|n| tip(0.25 * f64::from(n), y));
                ToolMove { from, to, feed: Some(1.0), line: 1 }
            };
            moves.extend((0..40).map(step));
        }
        let swept = SweptCutter::new(&moves, cutter, [DVec2::splat(1.5), DVec2::new(8.5, 6.5)]);
        for k in 0..400 {
            let at = DVec2::new(1.5 + f64::from(k % 20) * 0.349, 1.5 + f64::from(k / 20) * 0.249);
            let all = (0..moves.len()).filter_map(|k| swept.of_step(k, at));
            let least = all.map(|(z, _)| z).reduce(f64::min).unwrap();
            let found = swept.lowest(at).unwrap().z_mm;
            assert!((found - least).abs() < 1e-12, "{at}: {found} {least}");
        }
        let most = leaves(&swept.root).into_iter().max().unwrap();
        assert!(most <= 5 * FEW, "{most} of {}", moves.len());
    }

    /// Moves in each leaf that a place was asked for in.
    fn leaves(square: &Square) -> Vec<usize> {
        match &square.parts {
            None => vec![square.steps.len()],
            Some(parts) => parts.iter().filter_map(OnceLock::get).flat_map(leaves).collect(),
        }
    }

    fn held_against_all(swept: &SweptCutter, moves: usize) {
        for k in 0..5000 {
            let at = DVec2::new(f64::from(k % 100) * 0.0999, f64::from(k / 100) * 0.159);
            let of = |k: usize| swept.of_step(k, at).map(|(z, _)| z);
            let least = (0..moves).filter_map(of).reduce(f64::min);
            let found = swept.lowest(at);
            // (Of many moves with a flat end some are told by bounds.)
            let rounding = if swept.cutter().ball_mm().is_some() { 0.0 } else { 1e-12 };
            let off = found.zip(least).map_or(0.0, |(found, least)| (found.z_mm - least).abs());
            let is_it = found.is_some() == least.is_some() && off <= rounding;
            assert!(is_it, "{at}: {found:?} {least:?}");
            let Some(found) = found else { continue };
            // (Corners are more tightly curved.)
            let (step, most) = (1e-6, if rounding == 0.0 { 1e-5 } else { 1e-4 });
            let beside = |way: DVec2| swept.of_step(found.step, at + way * step).map(|(z, _)| z);
            let ahead = [DVec2::X, DVec2::Y].map(beside);
            let back = [DVec2::NEG_X, DVec2::NEG_Y].map(beside);
            for axis in 0..2 {
                let (Some(ahead), Some(back)) = (ahead[axis], back[axis]) else { continue };
                let slope = (ahead - back) / (2.0 * step);
                let off = (slope - found.slope[axis]).abs();
                assert!(off < most * (1.0 + slope * slope), "{at}: {slope} {}", found.slope);
            }
        }
    }
}
