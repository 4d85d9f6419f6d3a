//! Ascent to a contact: from a node next to it to the local maximum of the ball's height over the mirror itself.

use super::rim::{RimEdge, inward_direction};
use super::{Contact, DropCutter, PanelPoint, Seed, ball_hessian, flipped};
use crate::geom::{DVec2, DVec3};
use crate::mirror::Hessian;

/// Changes between the inside of the panel and its rim, at most.
const MOST_CHANGES: usize = 4;
/// Steps of Newton's method inside, shortenings of a step, and parabolas along an edge, at most.
const MOST_STEPS: usize = 30;
const MOST_SHORTENINGS: usize = 8;
const MOST_PARABOLAS: usize = 64;
/// What is less, as a share of the ball's radius, is no gain.
const NO_GAIN: f64 = 1e-12;
/// A parabola along an edge that reaches over fewer steps is the last.
const LAST_REACH: f64 = 1e-3;
/// Steps from an edge's end within which a contact is in the corner.
const CORNER: f64 = 0.01;

/// A contact and where the ascent goes on from it, if it does.
type Ascended = Option<(Contact, Option<PanelPoint>)>;

impl DropCutter<'_> {
    /// The contact next to `seed` of a ball over `c`; none out of its reach.
    pub(crate) fn ascend(&self, c: DVec2, seed: &Seed) -> Option<Contact> {
        let Seed { mut point, reflected } = *seed;
        let own = flipped(c.extend(0.0), reflected).truncate();
        let mut found = None;
        for _ in 0..MOST_CHANGES {
            let (contact, next) = match point {
                PanelPoint::Inside(q) => self.ascend_inside(own, q)?,
                PanelPoint::Rim(edge, t) => self.ascend_edge(own, edge, t)?,
            };
            // As high on the rim counts as there.
            let on_rim = matches!(point, PanelPoint::Rim(..));
            let hair = if on_rim { NO_GAIN * self.ball_mm } else { 0.0 };
            let better = found.is_none_or(|old: Contact| contact.centre_z + hair > old.centre_z);
            if better {
                found = Some(contact);
            }
            match next {
                Some(next) if better => point = next,
                _ => break,
            }
        }
        let Contact { seed, at, centre_z, slope, hessian } = found?;
        let Hessian { xx, xy, yy } = hessian;
        let sign = if reflected { -1.0 } else { 1.0 };
        Some(Contact {
            seed: Seed { reflected, ..seed },
            at: flipped(at, reflected),
            centre_z,
            slope: slope * DVec2::new(1.0, sign),
            hessian: Hessian { xx, xy: sign * xy, yy },
        })
    }

    /// Newton's method from `q` of the designed panel, and the rim where that ends on it.
    fn ascend_inside(&self, c: DVec2, mut q: DVec2) -> Ascended {
        let outline = &self.mirror.outline;
        let (mut surface, mut jacobian) = self.mirror.extended_surface_and_jacobian(q);
        let mut centre_z = self.centre_z(c, surface.at)?;
        let (mut held, mut curved) = (false, None);
        for _ in 0..MOST_STEPS {
            let (off, root) = (surface.at.truncate() - c, centre_z - surface.at.z);
            let (ball, mirror) = (ball_hessian(off, root), surface.hessian);
            let between = Hessian {
                xx: ball.xx - mirror.xx,
                xy: ball.xy - mirror.xy,
                yy: ball.yy - mirror.yy,
            };
            let rise = surface.slope - off / root;
            curved = between.is_positive_definite().then_some((ball, between));
            let mut d = match curved {
                Some(_) => between.solve(rise),
                None => rise.normalize_or_zero() * self.step,
            };
            d *= (2.0 * self.step / d.length()).min(1.0);
            let mut better = None;
            for _ in 0..MOST_SHORTENINGS {
                let wanted = q + jacobian.step(d);
                let next = outline.nearest(wanted);
                held = (next - wanted).length() > 1e-12 * self.step;
                let moved = self.mirror.extended_surface_and_jacobian(next);
                let higher = self.centre_z(c, moved.0.at).filter(|z| *z > centre_z);
                better = higher.map(|z| (z, next, moved));
                if better.is_some() {
                    break;
                }
                d *= 0.25;
            }
            let Some((z, next, moved)) = better else { break };
            let gain = z - centre_z;
            (centre_z, q, (surface, jacobian)) = (z, next, moved);
            if gain < NO_GAIN * self.ball_mm {
                break;
            }
        }
        let slope = (surface.at.truncate() - c) / (centre_z - surface.at.z);
        let hessian = curved.map_or(Hessian { xx: 0.0, xy: 0.0, yy: 0.0 }, |(ball, between)| {
            // As the contact moves with the centre: A (A - B)^-1 A - A.
            let image = |d: DVec2| ball.times(between.solve(ball.times(d)));
            let (x, y) = (image(DVec2::X), image(DVec2::Y));
            Hessian { xx: x.x - ball.xx, xy: x.y - ball.xy, yy: y.y - ball.yy }
        });
        let seed = Seed { point: PanelPoint::Inside(q), reflected: false };
        let rim = if held { self.rim_point(q) } else { None };
        Some((Contact { seed, at: surface.at, centre_z, slope, hessian }, rim))
    }

    /// The edge that `q` is on.
    fn rim_point(&self, q: DVec2) -> Option<PanelPoint> {
        let on = |(k, edge): (usize, &RimEdge)| {
            let (t, off) = edge.nearest(q);
            (off, PanelPoint::Rim(k, t))
        };
        let nearest = self.edges.iter().enumerate().map(on).min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.filter(|(off, _)| *off < 1e-9 * self.step).map(|(_, point)| point)
    }

    /// The point of the mirror `t` steps along an edge.
    fn edge_point(&self, number: usize, t: f64) -> DVec3 {
        self.mirror.extended_surface(self.edges[number].at(t)).at
    }

    /// The highest contact along an edge next to `t`, and where to go on from there: inwards, or along the next edge.
    fn ascend_edge(&self, c: DVec2, number: usize, t: f64) -> Ascended {
        let (centre_z, t, fall) = self.highest_on_edge(c, number, t);
        if centre_z == f64::NEG_INFINITY {
            return None;
        }
        let edge = self.edges[number];
        let last = edge.steps as f64;
        let at = self.edge_point(number, t);
        let (off, root) = (at.truncate() - c, centre_z - at.z);
        let ball = ball_hessian(off, root);
        let in_corner = !edge.is_closed() && (t < CORNER || t > last - CORNER);
        // On an edge the contact moves along it alone, in a corner not at all.
        let image = if in_corner || !(fall > 0.0) {
            DVec2::ZERO
        } else {
            let [after, before] = [t + CORNER, t - CORNER].map(|t| self.edge_point(number, t));
            let tangent = (after - before).truncate() / (2.0 * CORNER);
            ball.times(tangent) / fall.sqrt()
        };
        let hessian = Hessian {
            xx: image.x * image.x - ball.xx,
            xy: image.x * image.y - ball.xy,
            yy: image.y * image.y - ball.yy,
        };
        let seed = Seed { point: PanelPoint::Rim(number, t), reflected: false };
        let contact = Contact { seed, at, centre_z, slope: off / root, hessian };
        // A hair inwards, if that is upwards.
        let way = inward_direction(&self.mirror.outline, edge.at(t), 1e-9 * self.step);
        let inner = way * (1e-3 * self.step) + edge.at(t);
        let inwards = self.centre_z(c, self.mirror.extended_surface(inner).at);
        let count = self.edges.len();
        let next = match inwards.filter(|z| *z > centre_z) {
            Some(_) => Some(PanelPoint::Inside(inner)),
            None if in_corner && t < CORNER => {
                let before = (number + count - 1) % count;
                Some(PanelPoint::Rim(before, self.edges[before].steps as f64))
            }
            None if in_corner => Some(PanelPoint::Rim((number + 1) % count, 0.0)),
            None => None,
        };
        Some((contact, next))
    }

    /// The highest centre of a ball over `c` that touches an edge, by parabolas from `t` steps along it: its Z, where
    /// it touches, and the second difference of the last parabola, downwards.
    fn highest_on_edge(&self, c: DVec2, number: usize, t: f64) -> (f64, f64, f64) {
        let edge = self.edges[number];
        let last = edge.steps as f64;
        let height =
            |t: f64| self.centre_z(c, self.edge_point(number, t)).unwrap_or(f64::NEG_INFINITY);
        let mut best = (height(t), t);
        let (mut reach, mut fall) = (1.0, 0.0);
        for _ in 0..MOST_PARABOLAS {
            let middle = if edge.is_closed() { best.1 } else { best.1.clamp(reach, last - reach) };
            let all = [middle - reach, middle, middle + reach].map(|t| (height(t), t));
            let [a, b, d] = all.map(|found| found.0);
            let second = a + d - 2.0 * b;
            fall = -second / (reach * reach);
            let vertex = middle + reach * (0.5 * (a - d) / second).clamp(-1.0, 1.0);
            let vertex = if second < 0.0 { vertex } else { middle };
            for found in all.into_iter().chain([(height(vertex), vertex)]) {
                if found.0 > best.0 {
                    best = found;
                }
            }
            // On with the same reach while the highest is not between its ends.
            let end = !edge.is_closed() && (best.1 <= 0.0 || best.1 >= last);
            if end || (best.1 - middle).abs() < 0.999 * reach {
                reach *= 0.2;
            }
            if reach < LAST_REACH {
                break;
            }
        }
        (best.0, best.1, fall)
    }
}
