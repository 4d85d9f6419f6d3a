//! The lowest that a ball can come over a place without cutting into the ground.
//!
//! With its centre over c the ball rests at the highest of its tops ([`Contact`]), and its lower side is
//! sqrt(R^2 - |p - c|^2) below that over p: the least of this over c is a minimax of two variables, at which the ball
//! touches in two or three places, or in p itself. Each step takes the tops for parabolas and finds the lowest place
//! of their largest: where one is flat, on the line where two are equal, or where three are. Tops that a step
//! turned out to pass over stay as points that the ball may not sink below.

use super::drop_cutter::{Contact, DropCutter, lower_side};
use crate::geom::{DVec2, DVec3};
use crate::mirror::Hessian;

/// What is less is no gain, mm.
const TINY: f64 = 1e-10;
/// Tops that count in a step, at most.
const CUTS: usize = 10;
/// Points that are kept, at most.
const KEPT: usize = 9;
/// Searches over all the ground, at most.
const ROUNDS: usize = 16;

/// A height that the ball's lower side over p may not be below, as a parabola of the centre's motion.
#[derive(Debug, Clone, Copy)]
struct Cut {
    height: f64,
    slope: DVec2,
    bend: Hessian,
}

impl Cut {
    fn at(&self, d: DVec2) -> f64 {
        self.height + d.dot(self.slope + 0.5 * self.bend.times(d))
    }
}

/// Z of the lowest ball's lower side over `p`, mm, from a centre over `start` on. Whatever is returned, a ball comes as
/// low without cutting into the ground.
pub(super) fn closing_height(ground: &DropCutter, p: DVec2, start: DVec2) -> f64 {
    let square = ground.ball_mm * ground.ball_mm;
    let laid = |c: DVec2| {
        let tops = ground.contacts(c);
        let most = tops.iter().map(|t| t.top).fold(f64::NEG_INFINITY, f64::max);
        let height = most - (square - (p - c).length_squared()).sqrt();
        (if height.is_finite() { height } else { f64::INFINITY }, tops)
    };
    let (mut best, mut c) = (laid(start), start);
    let (mut points, mut reach) = (Vec::new(), 2.0 * ground.step);
    for _ in 0..ROUNDS {
        let (next, claimed) = descended(ground, p, (c, best.1.clone()), &mut points, reach);
        // A search over all the ground may find other tops there.
        let found = laid(next);
        let done = found.0 <= claimed + 10.0 * TINY;
        points.extend(found.1.iter().take(3).map(|top| top.at));
        points.drain(..points.len().saturating_sub(KEPT));
        if found.0 < best.0 {
            (best, c) = (found, next);
        } else {
            reach = 0.3 * (next - c).length();
        }
        if done || reach < 1e-6 * ground.step {
            break;
        }
    }
    best.0
}

/// Steps downwards from a centre with its tops: the centre that these and `points` allow, and the height over `p`.
fn descended(
    ground: &DropCutter,
    p: DVec2,
    (mut c, mut tops): (DVec2, Vec<Contact>),
    points: &mut Vec<DVec3>,
    mut reach: f64,
) -> (DVec2, f64) {
    let square = ground.ball_mm * ground.ball_mm;
    let under = |c: DVec2| (square - (p - c).length_squared()).sqrt();
    let on = |at: DVec3, c: DVec2| at.z + (square - (at.truncate() - c).length_squared()).sqrt();
    let height = |c: DVec2, tops: &[Contact], points: &[DVec3]| {
        let tops = tops.iter().map(|top| top.top).chain(points.iter().map(|at| on(*at, c)));
        // Out of the reach of p is no number.
        let height = tops.fold(f64::NEG_INFINITY, f64::max) - under(c);
        if height.is_finite() { height } else { f64::INFINITY }
    };
    let mut best = height(c, &tops, points);
    // Where the parabolas promise nothing, tops that stay where they are: what a ball over them cannot be below.
    let mut fixed = false;
    for _ in 0..60 {
        let (off, root) = (p - c, under(c));
        let (tilt, round) = (off / root, lower_side(off, root));
        let cut = |top: f64, slope: DVec2, bend: &Hessian| Cut {
            height: top - root,
            slope: slope - tilt,
            bend: Hessian {
                xx: bend.xx + round.xx,
                xy: bend.xy + round.xy,
                yy: bend.yy + round.yy,
            },
        };
        let point = |at: &DVec3| {
            let (off, deep) = (at.truncate() - c, on(*at, c) - at.z);
            let Hessian { xx, xy, yy } = lower_side(off, deep);
            cut(at.z + deep, off / deep, &Hessian { xx: -xx, xy: -xy, yy: -yy })
        };
        let mut cuts: Vec<Cut> = tops
            .iter()
            .map(|top| if fixed { point(&top.at) } else { cut(top.top, top.rise, &top.bend) })
            .collect();
        cuts.extend(points.iter().map(point).filter(|cut| cut.height.is_finite()));
        let Some((d, foreseen)) = step(&mut cuts, reach) else { break };
        if !(best - foreseen > TINY) {
            if fixed {
                break;
            }
            fixed = true;
            continue;
        }
        let next = c + d;
        let tried: Vec<Contact> =
            tops.iter().filter_map(|top| ground.ascend(next, &top.seed)).collect();
        let value = height(next, &tried, points);
        if value < best {
            if best - value < 0.25 * (best - foreseen) {
                reach = 0.5 * d.length();
            } else if d.length() > 0.9 * reach {
                reach *= 2.0;
            }
            (c, tops, best) = (next, tried, value);
        } else {
            let highest = tried.iter().reduce(|a, b| if b.top > a.top { b } else { a });
            points.extend(highest.map(|top| top.at));
            if points.len() > KEPT {
                points.remove(0);
            }
            reach = 0.5 * d.length();
        }
        if reach < 1e-9 * ground.step {
            break;
        }
    }
    (c, best)
}

/// Where the largest of `cuts` is least, no farther than `reach`, and how high it is there.
fn step(cuts: &mut [Cut], reach: f64) -> Option<(DVec2, f64)> {
    cuts.sort_by(|a, b| b.height.total_cmp(&a.height));
    let first = *cuts.first()?;
    // What lies too low to matter within reach, and what says the same.
    let mut counting: Vec<Cut> = Vec::new();
    for cut in cuts.iter() {
        let apart = (cut.slope - first.slope).length();
        let same = |other: &Cut| {
            (other.slope - cut.slope).length() < 1e-9 && other.height - cut.height < TINY
        };
        let bent = 0.5 * (cut.bend.norm() + first.bend.norm());
        let low = first.height - cut.height > reach * (apart + reach * bent);
        if !low && counting.len() < CUTS && !counting.iter().any(same) {
            counting.push(*cut);
        }
    }
    let held = |d: DVec2| d * (reach / d.length()).min(1.0);
    let mut best: Option<(DVec2, f64)> = None;
    let mut consider = |d: DVec2| {
        let most = counting.iter().map(|cut| cut.at(d)).fold(f64::NEG_INFINITY, f64::max);
        if d.is_finite() && best.is_none_or(|old| most < old.1) {
            best = Some((d, most));
        }
    };
    for (k, a) in counting.iter().enumerate() {
        consider(held(alone(a, reach)));
        for (l, b) in counting.iter().enumerate().skip(k + 1) {
            consider(held(level(a, b, reach)));
            for e in &counting[l + 1..] {
                // Twice: first with slopes, then with the bends over that way.
                let mut d = DVec2::ZERO;
                for _ in 0..3 {
                    let (p, q) = (difference(a, b, d), difference(a, e, d));
                    let det = p.1.perp_dot(q.1);
                    d = held(
                        DVec2::new(q.0 * p.1.y - p.0 * q.1.y, p.0 * q.1.x - q.0 * p.1.x) / det,
                    );
                }
                consider(d);
            }
        }
    }
    best
}

/// How much higher `a` is than `b` near `d`: at no motion, and its slope.
fn difference(a: &Cut, b: &Cut, d: DVec2) -> (f64, DVec2) {
    let turn = 0.5 * (a.bend.times(d) - b.bend.times(d));
    (a.height - b.height, a.slope - b.slope + turn)
}

/// Where one parabola is least.
fn alone(cut: &Cut, reach: f64) -> DVec2 {
    if cut.bend.is_positive_definite() {
        -cut.bend.solve(cut.slope)
    } else {
        -cut.slope.normalize_or_zero() * reach
    }
}

/// Where two parabolas are equal and least.
fn level(a: &Cut, b: &Cut, reach: f64) -> DVec2 {
    let mut d = DVec2::ZERO;
    for _ in 0..3 {
        let (gap, way) = difference(a, b, d);
        let across = -way * (gap / way.length_squared());
        // How much each carries: their slopes across cancel.
        let share = (-b.slope.dot(way) / way.length_squared()).clamp(0.0, 1.0);
        let along = way.perp() / way.length();
        let turn = |d: DVec2| share * a.bend.times(d) + (1.0 - share) * b.bend.times(d);
        let slope = (share * a.slope + (1.0 - share) * b.slope + turn(across)).dot(along);
        let bend = along.dot(turn(along));
        let step = if bend > 0.0 { -slope / bend } else { -slope.signum() * reach };
        let step = step.clamp(-reach, reach);
        d = across + along * step;
        d *= (reach / d.length()).min(1.0);
    }
    d
}
