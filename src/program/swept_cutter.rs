//! What a cutter leaves along straight moves: over each place of the plan the lowest of all its places.
//!
//! The balls of a move from A to B have their centres between A and B. Over (X, Y) that is s along the move in the plan and q
//! beside it, the ball whose centre is u short of s has its lower side at
//! `z_A + m (s - u) - sqrt(r^2 - u^2)`, with `r^2 = R^2 - q^2` and the move's slope `m`. That is least at `u = m r / sqrt(1 + m^2)`,
//! or at the end of the move that is nearer to it.
//!
//! A tree of squares holds, in each square of the plan, the moves that may be the lowest there. A ball of radius `R + d` about
//! the same centres is nowhere higher over a square's middle than the ball of radius `R` is over the square, whose corners are `d` from
//! its middle; one of radius `R - d` is nowhere lower. So a move is left out of a square where its larger ball is above the
//! smaller ball of another. Slopes of two balls whose centres are c apart in the plan differ by no more than `R^2 c / (R^2 - e^2)^1.5` within
//! `e` of both centres, so a move is left out too where it is higher over the middle than the lowest ball by `d` times that.
//!
//! Of a cutter with a flat end the larger one has a flat part wider by `d`, and the smaller one a flat part narrower by `d` or, where it is narrower
//! than that, the ball that is left of it, as far up.

use super::ToolMove;
use super::cutter_move::{CutterMove, CutterPlace, lower_side};
use crate::geom::{Cutter, DVec2, DVec3, Rect};
use crate::parallel;

/// A square with so few moves is not divided, and the most divisions: to some hundredths of a millimetre.
const FEW: usize = 12;
const DEEPEST: usize = 11;
/// The most divisions for a cutter with a flat end, of whose moves fewer are left out of a square: deeper ones take memory and spare little.
const DEEPEST_FLAT: usize = 9;
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

#[derive(Debug)]
enum Square {
    /// Numbers of moves, rising.
    Leaf(Vec<u32>),
    /// Left below, right below, left above, right above.
    Divided(Box<[Square; 4]>),
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
        let mut swept = Self { cutter, ends, bounds, root: Square::Leaf(Vec::new()) };
        swept.root = swept.square(bounds, (0..moves.len() as u32).collect(), 0);
        swept
    }

    /// The moves that may be the lowest in `rect`.
    fn square(&self, rect: Rect, mut steps: Vec<u32>, depth: usize) -> Square {
        let (middle, reach) = (rect.centre(), 0.5 * rect.size().length());
        let surely = steps.iter().filter_map(|&k| self.lowest_within(k, middle, -reach));
        // The flat end of a move over all of the square is as low for both, but for what halving leaves.
        let rounding = if self.cutter.ball_mm().is_some() { 0.0 } else { ROUNDING_MM };
        let most = surely.fold(f64::INFINITY, f64::min) + rounding;
        steps.retain(|&k| self.lowest_within(k, middle, reach).is_some_and(|z| z <= most));
        self.leave_higher(middle, reach, &mut steps);
        let deepest = if self.cutter.ball_mm().is_some() { DEEPEST } else { DEEPEST_FLAT };
        if steps.len() <= FEW || depth == deepest {
            steps.shrink_to_fit();
            return Square::Leaf(steps);
        }
        let quarter = |k: usize| self.square(quarter(rect, k), steps.clone(), depth + 1);
        let parts: Vec<Square> = match depth < SHARED {
            true => parallel::map(4, 1, quarter),
            false => (0..4).map(quarter).collect(),
        };
        match <[Square; 4]>::try_from(parts) {
            Ok(parts) => Square::Divided(Box::new(parts)),
            Err(_) => Square::Leaf(steps),
        }
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

    /// Leaves out moves that are higher than the lowest ball over `middle` all over a square of which no place is farther from
    /// it than `reach`.
    fn leave_higher(&self, middle: DVec2, reach: f64, steps: &mut Vec<u32>) {
        // Slopes of a flat end change at once.
        let Some(radius) = self.cutter.ball_mm() else { return };
        let over = |k: u32| lower_side(&self.ends[k as usize], middle, radius);
        let lowest = |a: (f64, DVec2), b: (f64, DVec2)| if b.0 < a.0 { b } else { a };
        let Some((z, slope)) = steps.iter().filter_map(|&k| over(k)).reduce(lowest) else { return };
        let centre = middle - slope * (radius / f64::sqrt(1.0 + slope.length_squared()));
        steps.retain(|&k| {
            let ends = self.ends[k as usize].map(|end| end.truncate());
            let largest =
                |from: DVec2| ends.map(|end| end.distance(from)).into_iter().fold(0.0, f64::max);
            let far = largest(middle).max(centre.distance(middle)) + reach;
            let left = radius * radius - far * far;
            // Near the balls' sides, and of long moves, nothing is known so.
            if !(left > 0.05 * radius * radius) {
                return true;
            }
            let steeper = radius * radius / (left * f64::sqrt(left)) * largest(centre);
            over(k).is_none_or(|(own, _)| own - z <= reach * steeper)
        });
    }

    /// The cutter.
    #[must_use]
    pub fn cutter(&self) -> Cutter {
        self.cutter
    }

    /// The lowest place of all cutters over a place within the corners; none where no cutter comes.
    #[must_use]
    pub fn lowest(&self, at: DVec2) -> Option<SweptPlace> {
        let (mut square, mut rect) = (&self.root, self.bounds);
        while let Square::Divided(parts) = square {
            let middle = rect.centre();
            let k = usize::from(at.x > middle.x) + 2 * usize::from(at.y > middle.y);
            (square, rect) = (&parts[k], quarter(rect, k));
        }
        let Square::Leaf(steps) = square else { return None };
        let mut lowest: Option<SweptPlace> = None;
        for &k in steps {
            let Some((z_mm, slope)) = self.of_step(k as usize, at) else { continue };
            if lowest.is_none_or(|lowest| z_mm < lowest.z_mm) {
                lowest = Some(SweptPlace { z_mm, slope, step: k as usize });
            }
        }
        lowest
    }

    /// Z and slope of the lower side of the cutters of one move over a place of the plan.
    #[must_use]
    pub fn of_step(&self, step: usize, at: DVec2) -> Option<(f64, DVec2)> {
        let ends = self.ends[step];
        match self.cutter.ball_mm() {
            Some(ball_mm) => lower_side(&ends, at, ball_mm),
            None => {
                let CutterPlace { z_mm, slope } =
                    CutterMove::between(ends, self.cutter).place(at)?;
                Some((z_mm, slope))
            }
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

    fn held_against_all(swept: &SweptCutter, moves: usize) {
        for k in 0..5000 {
            let at = DVec2::new(f64::from(k % 100) * 0.0999, f64::from(k / 100) * 0.159);
            let of = |k: usize| swept.of_step(k, at).map(|(z, _)| z);
            let least = (0..moves).filter_map(of).reduce(f64::min);
            let found = swept.lowest(at);
            // (The places of cutters with a flat end are found by halving.)
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
