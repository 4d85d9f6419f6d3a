//! Closing height: the lowest that a ball can come over a point without cutting into the mirror.
//!
//! With its centre over c the ball rests at the highest of its contacts ([`Contact`]), and its lower side is
//! sqrt(R^2 - |p - c|^2) below that over p: the least of this over c is a minimax of two variables, at which the ball
//! touches in two or three places, or in p itself. As in a bundle method, each step takes every contact for a
//! quadratic model and finds the lowest place of their largest: where one is flat, on the line where two are equal,
//! or where three are. Contacts that a step turned out to pass over stay as points that the ball may not sink below.

use super::drop_cutter::{Contact, DropCutter, ball_hessian};
use crate::geom::{DVec2, DVec3};
use crate::mirror::Hessian;
use crate::num::sort_by_number;

/// What is less is no gain, mm: above the rounding of a height, some 1e-14, and far below any tolerance.
const NO_GAIN: f64 = 1e-10;
/// Models that count in a step, at most; three decide.
const MOST_MODELS: usize = 10;
/// Points that are kept, at most.
const MOST_POINTS: usize = 9;
/// Searches over the whole mirror, at most.
const MOST_SEARCHES: usize = 16;
/// Steps of a descent, at most.
const MOST_STEPS: usize = 60;

/// A height that the ball's lower side over p may not be below, as a quadratic function of the centre's motion.
#[derive(Debug, Clone, Copy)]
struct QuadraticModel {
    height: f64,
    slope: DVec2,
    hessian: Hessian,
}

impl QuadraticModel {
    fn at(&self, d: DVec2) -> f64 {
        self.height + d.dot(self.slope + 0.5 * self.hessian.times(d))
    }

    /// How much higher it is than `other` near `d`: at no motion, and its slope.
    fn above(&self, other: &Self, d: DVec2) -> (f64, DVec2) {
        let turn = 0.5 * (self.hessian.times(d) - other.hessian.times(d));
        (self.height - other.height, self.slope - other.slope + turn)
    }

    /// Where it is least, or how far it leads down.
    fn lowest(&self, reach: f64) -> DVec2 {
        if self.hessian.is_positive_definite() {
            -self.hessian.solve(self.slope)
        } else {
            -self.slope.normalize_or_zero() * reach
        }
    }
}

/// Z of the lowest ball's lower side over `p`, mm, from a centre over `start` on. Whatever is returned, a ball comes as
/// low without cutting into the mirror.
pub(super) fn closing_height(cutter: &DropCutter, p: DVec2, start: DVec2) -> f64 {
    let mut descent = Descent { cutter, p, points: Vec::new() };
    let (mut best, mut c) = (descent.rest(start), start);
    let mut reach = 2.0 * cutter.step;
    for _ in 0..MOST_SEARCHES {
        let (next, claimed) = descent.run((c, best.1.clone()), reach);
        // A search over the whole mirror may find other contacts there.
        let found = descent.rest(next);
        let done = found.0 <= claimed + 10.0 * NO_GAIN;
        descent.points.extend(found.1.iter().take(3).map(|contact| contact.at));
        let more = descent.points.len().saturating_sub(MOST_POINTS);
        descent.points.drain(..more);
        if found.0 < best.0 {
            (best, c) = (found, next);
        } else {
            reach = 0.3 * (next - c).length();
        }
        if done || reach < 1e-6 * cutter.step {
            break;
        }
    }
    best.0
}

/// The search of the lowest ball over a point.
struct Descent<'a> {
    cutter: &'a DropCutter<'a>,
    p: DVec2,
    /// Points that the ball may not sink below.
    points: Vec<DVec3>,
}

impl Descent<'_> {
    /// How far the sphere of the ball about a centre over `c` is above or below the centre over `at`, mm; no number out
    /// of its reach.
    fn root(&self, at: DVec2, c: DVec2) -> f64 {
        (self.cutter.ball_mm * self.cutter.ball_mm - (at - c).length_squared()).sqrt()
    }

    /// Z of the centre over `c` of a ball that touches `at`.
    fn centre_on(&self, at: DVec3, c: DVec2) -> f64 {
        at.z + self.root(at.truncate(), c)
    }

    /// Height over p of the lower side of a ball whose centre is at `centre_z` over `c`; infinite out of its reach.
    fn lower_side(&self, centre_z: f64, c: DVec2) -> f64 {
        let height = centre_z - self.root(self.p, c);
        if height.is_finite() { height } else { f64::INFINITY }
    }

    /// The ball at rest over `c`: the height of its lower side over p, and its contacts.
    fn rest(&self, c: DVec2) -> (f64, Vec<Contact>) {
        let contacts = self.cutter.contacts(c);
        let most = contacts.iter().map(|t| t.centre_z).fold(f64::NEG_INFINITY, f64::max);
        (self.lower_side(most, c), contacts)
    }

    /// The height over p that these contacts and the points allow.
    fn height(&self, c: DVec2, contacts: &[Contact]) -> f64 {
        let points = self.points.iter().map(|at| self.centre_on(*at, c));
        let all = contacts.iter().map(|contact| contact.centre_z).chain(points);
        self.lower_side(all.fold(f64::NEG_INFINITY, f64::max), c)
    }

    /// The models of contacts and points for motions from `c`; of a contact that is `fixed` where it is, what a ball
    /// over it cannot be below.
    fn models(&self, c: DVec2, contacts: &[Contact], fixed: bool) -> Vec<QuadraticModel> {
        let (off, root) = (self.p - c, self.root(self.p, c));
        let (tilt, round) = (off / root, ball_hessian(off, root));
        let model = |centre_z: f64, slope: DVec2, hessian: &Hessian| QuadraticModel {
            height: centre_z - root,
            slope: slope - tilt,
            hessian: Hessian {
                xx: hessian.xx + round.xx,
                xy: hessian.xy + round.xy,
                yy: hessian.yy + round.yy,
            },
        };
        let point = |at: &DVec3| {
            let (off, deep) = (at.truncate() - c, self.centre_on(*at, c) - at.z);
            let Hessian { xx, xy, yy } = ball_hessian(off, deep);
            model(at.z + deep, off / deep, &Hessian { xx: -xx, xy: -xy, yy: -yy })
        };
        let contact = |contact: &Contact| {
            let Contact { at, centre_z, slope, hessian, .. } = contact;
            if fixed { point(at) } else { model(*centre_z, *slope, hessian) }
        };
        let points = self.points.iter().map(point).filter(|model| model.height.is_finite());
        contacts.iter().map(contact).chain(points).collect()
    }

    /// Steps downwards from a centre with its contacts: the centre that these and the points allow, and the height over
    /// p.
    fn run(
        &mut self,
        (mut c, mut contacts): (DVec2, Vec<Contact>),
        mut reach: f64,
    ) -> (DVec2, f64) {
        let mut best = self.height(c, &contacts);
        // Where the models promise nothing, contacts that stay where they are.
        let mut fixed = false;
        for _ in 0..MOST_STEPS {
            let mut models = self.models(c, &contacts, fixed);
            let Some((d, foreseen)) = minimax(&mut models, reach) else { break };
            if !(best - foreseen > NO_GAIN) {
                if fixed {
                    break;
                }
                fixed = true;
                continue;
            }
            let next = c + d;
            let ascend = |contact: &Contact| self.cutter.ascend(next, &contact.seed);
            let tried: Vec<Contact> = contacts.iter().filter_map(ascend).collect();
            let value = self.height(next, &tried);
            if value < best {
                if best - value < 0.25 * (best - foreseen) {
                    reach = 0.5 * d.length();
                } else if d.length() > 0.9 * reach {
                    reach *= 2.0;
                }
                (c, contacts, best) = (next, tried, value);
            } else {
                let highest =
                    tried.iter().reduce(|a, b| if b.centre_z > a.centre_z { b } else { a });
                self.points.extend(highest.map(|contact| contact.at));
                if self.points.len() > MOST_POINTS {
                    self.points.remove(0);
                }
                reach = 0.5 * d.length();
            }
            if reach < 1e-9 * self.cutter.step {
                break;
            }
        }
        (c, best)
    }
}

/// Where the largest of `models` is least, no farther than `reach`, and how high it is there.
fn minimax(models: &mut [QuadraticModel], reach: f64) -> Option<(DVec2, f64)> {
    sort_by_number(models, |model| -model.height);
    let first = *models.first()?;
    // What lies too low to matter within reach, and what says the same.
    let mut counting: Vec<QuadraticModel> = Vec::new();
    for model in models.iter() {
        let apart = (model.slope - first.slope).length();
        let same = |other: &QuadraticModel| {
            (other.slope - model.slope).length() < 1e-9 && other.height - model.height < NO_GAIN
        };
        let curved = 0.5 * (model.hessian.norm() + first.hessian.norm());
        let low = first.height - model.height > reach * (apart + reach * curved);
        if !low && counting.len() < MOST_MODELS && !counting.iter().any(same) {
            counting.push(*model);
        }
    }
    let held = |d: DVec2| d * (reach / d.length()).min(1.0);
    let mut best: Option<(DVec2, f64)> = None;
    let mut consider = |d: DVec2| {
        let most = counting.iter().map(|model| model.at(d)).fold(f64::NEG_INFINITY, f64::max);
        if d.is_finite() && best.is_none_or(|old| most < old.1) {
            best = Some((d, most));
        }
    };
    for (k, a) in counting.iter().enumerate() {
        consider(held(a.lowest(reach)));
        for (l, b) in counting.iter().enumerate().skip(k + 1) {
            consider(held(lowest_where_equal(a, b, reach)));
            for e in &counting[l + 1..] {
                // First with slopes, then with the second derivatives over that way.
                let mut d = DVec2::ZERO;
                for _ in 0..3 {
                    let (p, q) = (a.above(b, d), a.above(e, d));
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

/// Where two models are equal and least.
fn lowest_where_equal(a: &QuadraticModel, b: &QuadraticModel, reach: f64) -> DVec2 {
    let mut d = DVec2::ZERO;
    for _ in 0..3 {
        let (gap, way) = a.above(b, d);
        let across = -way * (gap / way.length_squared());
        // How much each carries: their slopes across cancel.
        let share = (-b.slope.dot(way) / way.length_squared()).clamp(0.0, 1.0);
        let along = way.perp() / way.length();
        let turn = |d: DVec2| share * a.hessian.times(d) + (1.0 - share) * b.hessian.times(d);
        let slope = (share * a.slope + (1.0 - share) * b.slope + turn(across)).dot(along);
        let second = along.dot(turn(along));
        let step = if second > 0.0 { -slope / second } else { -slope.signum() * reach };
        let step = step.clamp(-reach, reach);
        d = across + along * step;
        d *= (reach / d.length()).min(1.0);
    }
    d
}
