//! What a ball cutter leaves along straight moves: over each place of the plan the lowest of all its balls.
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

use super::ToolMove;
use crate::geom::{DVec2, DVec3, Rect};
use crate::parallel;

/// A square with so few moves is not divided, and the most divisions: to some hundredths of a millimetre.
const FEW: usize = 12;
const DEEPEST: usize = 11;
/// Squares are divided by several threads down to this depth.
const SHARED: usize = 3;

/// The surface below a ball cutter's moves.
#[derive(Debug)]
pub struct SweptBall {
    radius_mm: f64,
    centres: Vec<[DVec3; 2]>,
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

/// The lowest place of all balls over a place of the plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SweptPlace {
    /// Its Z, mm.
    pub z_mm: f64,
    /// Its slope (Z_X, Z_Y).
    pub slope: DVec2,
    /// Number of the move whose ball it is, the first of several.
    pub step: usize,
}

impl SweptBall {
    /// The surface that a ball of radius `radius_mm` leaves along `moves` of its lowest point, within the rectangle between two
    /// corners.
    #[must_use]
    pub fn new(moves: &[ToolMove], radius_mm: f64, [min, max]: [DVec2; 2]) -> Self {
        let up = DVec3::Z * radius_mm;
        let centres: Vec<_> = moves.iter().map(|step| [step.from + up, step.to + up]).collect();
        let bounds = Rect { min, max };
        let mut swept = Self { radius_mm, centres, bounds, root: Square::Leaf(Vec::new()) };
        swept.root = swept.square(bounds, (0..moves.len() as u32).collect(), 0);
        swept
    }

    /// The moves that may be the lowest in `rect`.
    fn square(&self, rect: Rect, mut steps: Vec<u32>, depth: usize) -> Square {
        let (middle, reach) = (rect.centre(), 0.5 * rect.size().length());
        let below = |radius: f64, k: u32| lower_side(&self.centres[k as usize], middle, radius);
        let inner = self.radius_mm - reach;
        let surely = steps.iter().filter_map(|&k| if inner > 0.0 { below(inner, k) } else { None });
        let most = surely.map(|(z, _)| z).fold(f64::INFINITY, f64::min);
        let outer = self.radius_mm + reach;
        steps.retain(|&k| below(outer, k).is_some_and(|(z, _)| z <= most));
        self.leave_higher(middle, reach, &mut steps);
        if steps.len() <= FEW || depth == DEEPEST {
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

    /// Leaves out moves that are higher than the lowest ball over `middle` all over a square of which no place is farther from
    /// it than `reach`.
    fn leave_higher(&self, middle: DVec2, reach: f64, steps: &mut Vec<u32>) {
        let radius = self.radius_mm;
        let over = |k: u32| lower_side(&self.centres[k as usize], middle, radius);
        let lowest = |a: (f64, DVec2), b: (f64, DVec2)| if b.0 < a.0 { b } else { a };
        let Some((z, slope)) = steps.iter().filter_map(|&k| over(k)).reduce(lowest) else { return };
        let centre = middle - slope * (radius / f64::sqrt(1.0 + slope.length_squared()));
        steps.retain(|&k| {
            let ends = self.centres[k as usize].map(|end| end.truncate());
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

    /// Radius of the ball, mm.
    #[must_use]
    pub fn radius_mm(&self) -> f64 {
        self.radius_mm
    }

    /// The lowest place of all balls over a place within the corners; none where no ball comes.
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
            let Some((z_mm, slope)) = lower_side(&self.centres[k as usize], at, self.radius_mm)
            else {
                continue;
            };
            if lowest.is_none_or(|lowest| z_mm < lowest.z_mm) {
                lowest = Some(SweptPlace { z_mm, slope, step: k as usize });
            }
        }
        lowest
    }

    /// Z and slope of the lower side of the balls of one move over a place of the plan.
    #[must_use]
    pub fn of_step(&self, step: usize, at: DVec2) -> Option<(f64, DVec2)> {
        lower_side(&self.centres[step], at, self.radius_mm)
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
    use crate::num::random::RandomStream;

    fn tool_move(from: DVec3, to: DVec3) -> ToolMove {
        ToolMove { from, to, feed: Some(1.0), line: 1 }
    }

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
            moves.push(tool_move(from, to));
            from = to;
        }
        let swept = SweptBall::new(&moves, 0.8, [DVec2::ZERO, DVec2::new(10.0, 8.0)]);
        for k in 0..5000 {
            let at = DVec2::new(f64::from(k % 100) * 0.0999, f64::from(k / 100) * 0.159);
            let of = |k: usize| swept.of_step(k, at).map(|(z, _)| z);
            let least = (0..moves.len()).filter_map(of).reduce(f64::min);
            let found = swept.lowest(at);
            assert_eq!(found.map(|found| found.z_mm), least, "{at}");
            let Some(found) = found else { continue };
            let step = 1e-6;
            let beside = |way: DVec2| swept.of_step(found.step, at + way * step).map(|(z, _)| z);
            let ahead = [DVec2::X, DVec2::Y].map(beside);
            let back = [DVec2::NEG_X, DVec2::NEG_Y].map(beside);
            for axis in 0..2 {
                let (Some(ahead), Some(back)) = (ahead[axis], back[axis]) else { continue };
                let slope = (ahead - back) / (2.0 * step);
                let off = (slope - found.slope[axis]).abs();
                assert!(off < 1e-5 * (1.0 + slope * slope), "{at}: {slope} {}", found.slope);
            }
        }
    }
}
