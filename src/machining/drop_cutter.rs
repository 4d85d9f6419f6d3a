//! Where a ball from above, let down with its centre over a place of the plan, comes to rest on a mirror.
//!
//! A ball with its centre over c touches the ground at Q when the centre is at Q_z + sqrt(R^2 - |Q - c|^2), and it
//! rests where that is largest. A grid over the face and nodes along its rims find every top of it to a step; from
//! there Newton's method climbs on the mirror itself, and parabolas along a rim or a ridge. Beyond the rim there is
//! no ground.

use crate::geom::{DVec2, DVec3, Outline, Rect};
use crate::mirror::{Hessian, LocalSurface, Mirror};
use crate::num::{atan2, cos, sin};
use std::f64::consts::TAU;

/// Tops that are climbed to, at most.
const TOPS: usize = 8;

/// The second derivatives of a ball's lower side where its surface is `off` in the plan and `root` below the centre.
pub(super) fn lower_side(off: DVec2, root: f64) -> Hessian {
    let lean = off / root;
    Hessian {
        xx: (1.0 + lean.x * lean.x) / root,
        xy: lean.x * lean.y / root,
        yy: (1.0 + lean.y * lean.y) / root,
    }
}

/// A side of the designed panel's outline, or a round rim.
#[derive(Debug, Clone, Copy)]
enum Path {
    Line(DVec2, DVec2),
    Circle(f64),
}

/// A path with as many steps.
#[derive(Debug, Clone, Copy)]
struct Edge {
    path: Path,
    steps: usize,
}

impl Edge {
    /// The place of the chart `t` steps along it.
    fn at(&self, t: f64) -> DVec2 {
        let share = t / self.steps as f64;
        match self.path {
            Path::Line(from, to) => from.lerp(to, share),
            Path::Circle(radius) => DVec2::new(cos(TAU * share), sin(TAU * share)) * radius,
        }
    }

    fn closed(&self) -> bool {
        matches!(self.path, Path::Circle(_))
    }
}

/// Where on the designed panel: within it, by the chart's coordinates, or on a rim, by the number of its edge and
/// steps along that.
#[derive(Debug, Clone, Copy)]
enum Spot {
    Within(DVec2),
    Rim(usize, f64),
}

/// A place of a panel; of the reflected one by its image on the designed panel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seed {
    spot: Spot,
    reflected: bool,
}

/// A top: where the ball would rest but for others.
#[derive(Debug, Clone, Copy)]
pub(super) struct Contact {
    pub seed: Seed,
    /// The place of the ground, mm.
    pub at: DVec3,
    /// Z of the ball's centre, mm, with its first and second derivatives as the centre moves in the plan and the
    /// contact with it.
    pub top: f64,
    pub rise: DVec2,
    pub bend: Hessian,
}

/// A mirror under a ball, with the nodes of a search.
pub(super) struct DropCutter<'a> {
    pub mirror: &'a Mirror,
    pub ball_mm: f64,
    /// Distance of the grid's nodes, mm.
    pub step: f64,
    /// X and Y of the first, columns and rows.
    pub first: DVec2,
    pub size: [usize; 2],
    /// Z over them, mm; none (no number) off the face.
    pub heights: Vec<f64>,
    edges: Vec<Edge>,
    /// Nodes of the edges and of their images.
    rim: Vec<(Vec<DVec3>, usize, bool)>,
}

impl<'a> DropCutter<'a> {
    /// A grid of `size` nodes, `step` apart from `first` on, over `mirror`.
    pub fn new(
        mirror: &'a Mirror,
        ball_mm: f64,
        step: f64,
        first: DVec2,
        size: [usize; 2],
        heights: Vec<f64>,
    ) -> Self {
        let steps = |length: f64| (length / step).ceil().max(4.0) as usize;
        let edges: Vec<Edge> = match mirror.outline {
            Outline::Rect(Rect { min, max }) => {
                let corners = [min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)];
                let side = |k: usize| {
                    let (from, to) = (corners[k], corners[(k + 1) % 4]);
                    Edge { path: Path::Line(from, to), steps: steps((to - from).length()) }
                };
                (0..4).map(side).collect()
            }
            Outline::Ring { inner, outer } => [outer, inner]
                .into_iter()
                .filter(|radius| *radius > 0.0)
                .map(|radius| Edge { path: Path::Circle(radius), steps: steps(TAU * radius) })
                .collect(),
        };
        let sides = if mirror.folded { &[false, true][..] } else { &[false] };
        let nodes = |(k, edge): (usize, &Edge)| {
            let all: Vec<DVec3> =
                (0..=edge.steps).map(|n| mirror.extended_surface(edge.at(n as f64)).at).collect();
            sides
                .iter()
                .map(|&reflected| {
                    (all.iter().map(|p| flipped(*p, reflected)).collect(), k, reflected)
                })
                .collect::<Vec<_>>()
        };
        let rim = edges.iter().enumerate().flat_map(nodes).collect();
        Self { mirror, ball_mm, step, first, size, heights, edges, rim }
    }

    /// Z of the centre over `c` of a ball that touches `at`; none out of its reach.
    fn top(&self, c: DVec2, at: DVec3) -> Option<f64> {
        let square = self.ball_mm * self.ball_mm - (at.truncate() - c).length_squared();
        (square > 0.0).then(|| at.z + square.sqrt())
    }

    /// The columns and rows of nodes under a ball over `c`, each the first and how many.
    fn window(&self, c: DVec2) -> [(usize, usize); 2] {
        let (at, reach) = ((c - self.first) / self.step, self.ball_mm / self.step);
        let range = |at: f64, count: usize| {
            let from = (at - reach).ceil().max(0.0);
            let to = (at + reach).floor().min(count as f64 - 1.0);
            (from as usize, if to < from { 0 } else { (to - from) as usize + 1 })
        };
        [range(at.x, self.size[0]), range(at.y, self.size[1])]
    }

    /// Writes the heights of the ball's centre over `c` on the nodes of one row.
    fn line(&self, c: DVec2, row: usize, (from, count): (usize, usize), out: &mut [f64]) {
        let dy = self.first.y + self.step * row as f64 - c.y;
        let left = self.ball_mm * self.ball_mm - dy * dy;
        let start = self.first.x - c.x;
        let heights = &self.heights[row * self.size[0] + from..][..count];
        for (k, (value, &z)) in out.iter_mut().zip(heights).enumerate() {
            let dx = start + self.step * (from + k) as f64;
            // No number becomes no height.
            *value = (z + (left - dx * dx).sqrt()).max(f64::NEG_INFINITY);
        }
    }

    /// The least Z of a ball's centre over `c` that clears the nodes of the grid.
    pub fn over_nodes(&self, c: DVec2) -> f64 {
        let [columns, rows] = self.window(c);
        let mut line = vec![0.0; columns.1];
        let mut most = f64::NEG_INFINITY;
        for row in rows.0..rows.0 + rows.1 {
            self.line(c, row, columns, &mut line);
            most = line.iter().copied().fold(most, f64::max);
        }
        most
    }

    /// The nodes next to tops under a ball over `c`, with the centre's height on them, the highest first.
    pub fn seeds(&self, c: DVec2) -> Vec<(f64, Seed)> {
        let [columns, rows] = self.window(c);
        let width = columns.1 + 2;
        let mut values = vec![f64::NEG_INFINITY; width * (rows.1 + 2)];
        for k in 0..rows.1 {
            let out = &mut values[(k + 1) * width + 1..][..columns.1];
            self.line(c, rows.0 + k, columns, out);
        }
        let mut found = Vec::new();
        let around = [1, width - 1, width, width + 1];
        for k in 0..rows.1 {
            for n in (k + 1) * width + 1..(k + 1) * width + 1 + columns.1 {
                let value = values[n];
                let top = value > f64::NEG_INFINITY
                    && around.iter().all(|d| value >= values[n - d] && value >= values[n + d]);
                if top {
                    let node = (rows.0 + k, columns.0 + n - (k + 1) * width - 1);
                    found.extend(self.node(node).into_iter().map(|seed| (value, seed)));
                }
            }
        }
        for (nodes, edge, reflected) in &self.rim {
            let value = |n: usize| self.top(c, nodes[n]).unwrap_or(f64::NEG_INFINITY);
            let last = nodes.len() - 1;
            for n in 0..=last {
                let here = value(n);
                let top = here > f64::NEG_INFINITY
                    && here >= value(n.saturating_sub(1))
                    && here >= value((n + 1).min(last));
                if top {
                    let spot = Spot::Rim(*edge, n as f64);
                    found.push((here, Seed { spot, reflected: *reflected }));
                }
            }
        }
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        found
    }

    /// The node in this row and column, on each panel that it belongs to.
    fn node(&self, (row, column): (usize, usize)) -> Vec<Seed> {
        let xy = self.first + self.step * DVec2::new(column as f64, row as f64);
        let z = self.heights[row * self.size[0] + column];
        let (q, _) = self.mirror.chart.coordinates(xy.extend(z));
        let side = self.mirror.outline.bounds().centre().y;
        let spot = |reflected: bool| {
            let q = if reflected { q * DVec2::new(1.0, -1.0) } else { q };
            Seed { spot: Spot::Within(self.mirror.outline.nearest(q)), reflected }
        };
        match (self.mirror.folded, q.y.abs() < 1e-9 * self.step) {
            (false, _) => vec![spot(false)],
            (true, true) => vec![spot(false), spot(true)],
            (true, false) => vec![spot(q.y * side < 0.0)],
        }
    }

    /// The tops under a ball over `c`, the highest first.
    pub fn contacts(&self, c: DVec2) -> Vec<Contact> {
        let seeds = self.seeds(c);
        let climbed = seeds.iter().take(TOPS).filter_map(|(_, seed)| self.ascend(c, seed));
        let mut all: Vec<Contact> = climbed.collect();
        all.sort_by(|a, b| b.top.total_cmp(&a.top));
        let mut apart: Vec<Contact> = Vec::new();
        for contact in all {
            let near = |other: &Contact| (other.at - contact.at).length() < 1e-4 * self.step;
            if !apart.iter().any(near) {
                apart.push(contact);
            }
        }
        apart
    }

    /// The top next to `seed` under a ball over `c`; none out of its reach.
    pub fn ascend(&self, c: DVec2, seed: &Seed) -> Option<Contact> {
        let Seed { mut spot, reflected } = *seed;
        let own = flipped(c.extend(0.0), reflected).truncate();
        let mut found = None;
        // From the inside to the rim and back.
        for _ in 0..4 {
            let (contact, next) = match spot {
                Spot::Within(q) => self.within(own, q)?,
                Spot::Rim(edge, t) => self.along(own, edge, t)?,
            };
            // As high on the rim counts as there.
            let hair = if matches!(spot, Spot::Rim(..)) { 1e-12 * self.ball_mm } else { 0.0 };
            let better = found.is_none_or(|old: Contact| contact.top + hair > old.top);
            if better {
                found = Some(contact);
            }
            match next {
                Some(next) if better => spot = next,
                _ => break,
            }
        }
        let Contact { seed, at, top, rise, bend } = found?;
        let Hessian { xx, xy, yy } = bend;
        let sign = if reflected { -1.0 } else { 1.0 };
        Some(Contact {
            seed: Seed { reflected, ..seed },
            at: flipped(at, reflected),
            top,
            rise: rise * DVec2::new(1.0, sign),
            bend: Hessian { xx, xy: sign * xy, yy },
        })
    }

    /// Newton's method from `q` of the designed panel, and the rim where that ends on it.
    fn within(&self, c: DVec2, mut q: DVec2) -> Option<(Contact, Option<Spot>)> {
        let (mut place, mut jacobian) = self.mirror.extended_surface_and_jacobian(q);
        let mut top = self.top(c, place.at)?;
        let (mut held, mut bend) = (false, None);
        for _ in 0..30 {
            let (off, root) = (place.at.truncate() - c, top - place.at.z);
            let (under, ground) = (lower_side(off, root), place.hessian);
            let left = Hessian {
                xx: under.xx - ground.xx,
                xy: under.xy - ground.xy,
                yy: under.yy - ground.yy,
            };
            let rise = place.slope - off / root;
            bend = left.is_positive_definite().then_some((under, left));
            let mut d = match bend {
                Some(_) => left.solve(rise),
                None => rise.normalize_or_zero() * self.step,
            };
            d *= (2.0 * self.step / d.length()).min(1.0);
            let mut better = None;
            for _ in 0..8 {
                let wanted = q + jacobian.step(d);
                let next = self.mirror.outline.nearest(wanted);
                held = (next - wanted).length() > 1e-12 * self.step;
                let moved = self.mirror.extended_surface_and_jacobian(next);
                better = self.top(c, moved.0.at).filter(|t| *t > top).map(|t| (t, next, moved));
                if better.is_some() {
                    break;
                }
                d *= 0.25;
            }
            let Some((t, next, moved)) = better else { break };
            let gain = t - top;
            (top, q, (place, jacobian)) = (t, next, moved);
            if gain < 1e-12 * self.ball_mm {
                break;
            }
        }
        let rise = (place.at.truncate() - c) / (top - place.at.z);
        let bend = bend.map_or(Hessian { xx: 0.0, xy: 0.0, yy: 0.0 }, |(under, left)| {
            // As the contact moves with the centre: A (A - B)^-1 A - A.
            let image = |d: DVec2| under.times(left.solve(under.times(d)));
            let (x, y) = (image(DVec2::X), image(DVec2::Y));
            Hessian { xx: x.x - under.xx, xy: x.y - under.xy, yy: y.y - under.yy }
        });
        let seed = Seed { spot: Spot::Within(q), reflected: false };
        let rim = if held { self.rim_at(q) } else { None };
        Some((Contact { seed, at: place.at, top, rise, bend }, rim))
    }

    /// Parabolas along an edge from `t`, and where to go on from there: inwards, or along the next edge.
    fn along(&self, c: DVec2, number: usize, t: f64) -> Option<(Contact, Option<Spot>)> {
        let edge = self.edges[number];
        let last = edge.steps as f64;
        let at = |t: f64| self.mirror.extended_surface(edge.at(t)).at;
        let value = |t: f64| self.top(c, at(t)).unwrap_or(f64::NEG_INFINITY);
        let mut best = (value(t), t);
        let (mut reach, mut fall) = (1.0, 0.0);
        for _ in 0..64 {
            let middle = if edge.closed() { best.1 } else { best.1.clamp(reach, last - reach) };
            let all = [middle - reach, middle, middle + reach].map(|t| (value(t), t));
            let [a, b, d] = all.map(|found| found.0);
            let second = a + d - 2.0 * b;
            fall = -second / (reach * reach);
            let vertex = middle + reach * (0.5 * (a - d) / second).clamp(-1.0, 1.0);
            let vertex = if second < 0.0 { vertex } else { middle };
            for found in all.into_iter().chain([(value(vertex), vertex)]) {
                if found.0 > best.0 {
                    best = found;
                }
            }
            // On with the same reach while the top is not between its ends.
            let end = !edge.closed() && (best.1 <= 0.0 || best.1 >= last);
            if end || (best.1 - middle).abs() < 0.999 * reach {
                reach *= 0.2;
            }
            if reach < 1e-3 {
                break;
            }
        }
        let (top, t) = best;
        if top == f64::NEG_INFINITY {
            return None;
        }
        let place = self.mirror.extended_surface(edge.at(t));
        let (off, root) = (place.at.truncate() - c, top - place.at.z);
        let under = lower_side(off, root);
        let small = 0.01;
        let end = !edge.closed() && (t < small || t > last - small);
        // On an edge the contact moves along it alone, in a corner not at all.
        let image = if end || !(fall > 0.0) {
            DVec2::ZERO
        } else {
            let tangent = (at(t + small) - at(t - small)).truncate() / (2.0 * small);
            under.times(tangent) / fall.sqrt()
        };
        let bend = Hessian {
            xx: image.x * image.x - under.xx,
            xy: image.x * image.y - under.xy,
            yy: image.y * image.y - under.yy,
        };
        let seed = Seed { spot: Spot::Rim(number, t), reflected: false };
        let contact = Contact { seed, at: place.at, top, rise: off / root, bend };
        // A hair inwards, if that is upwards.
        let inner = self.inwards(edge.at(t)) * (1e-3 * self.step) + edge.at(t);
        let inwards =
            self.top(c, self.mirror.extended_surface(inner).at).filter(|found| *found > top);
        let count = self.edges.len();
        let next = match inwards {
            Some(_) => Some(Spot::Within(inner)),
            None if end && t < small => {
                let before = (number + count - 1) % count;
                Some(Spot::Rim(before, self.edges[before].steps as f64))
            }
            None if end => Some(Spot::Rim((number + 1) % count, 0.0)),
            None => None,
        };
        Some((contact, next))
    }

    /// From a place of the rim into the panel, of about unit length.
    fn inwards(&self, q: DVec2) -> DVec2 {
        match self.mirror.outline {
            Outline::Rect(Rect { min, max }) => {
                let hair = 1e-9 * self.step;
                let way = |q: f64, lo: f64, hi: f64| {
                    if q - lo < hair {
                        1.0
                    } else if hi - q < hair {
                        -1.0
                    } else {
                        0.0
                    }
                };
                DVec2::new(way(q.x, min.x, max.x), way(q.y, min.y, max.y))
            }
            Outline::Ring { inner, outer } => {
                let out = q.normalize_or_zero();
                if q.length() > 0.5 * (inner + outer) { -out } else { out }
            }
        }
    }

    /// The edge that `q` is on.
    fn rim_at(&self, q: DVec2) -> Option<Spot> {
        let on = |(k, edge): (usize, &Edge)| {
            let steps = edge.steps as f64;
            let (t, off) = match edge.path {
                Path::Line(from, to) => {
                    let way = to - from;
                    let share = ((q - from).dot(way) / way.length_squared()).clamp(0.0, 1.0);
                    (share, (from.lerp(to, share) - q).length())
                }
                Path::Circle(radius) => {
                    (atan2(q.y, q.x).rem_euclid(TAU) / TAU, (q.length() - radius).abs())
                }
            };
            (off, Spot::Rim(k, t * steps))
        };
        let nearest = self.edges.iter().enumerate().map(on).min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.filter(|(off, _)| *off < 1e-9 * self.step).map(|(_, spot)| spot)
    }

    /// The place over `xy` where that is on the face.
    pub fn place(&self, xy: DVec2) -> Option<LocalSurface> {
        over_face(self.mirror, xy)
    }
}

/// The place of `mirror` over `xy`; none off the face.
pub(super) fn over_face(mirror: &Mirror, xy: DVec2) -> Option<LocalSurface> {
    let place = mirror.extended_surface_over(xy)?;
    let q = mirror.chart.coordinates(place.at).0;
    // A rounding error beyond the rim is on it.
    (mirror.full_outline().distance_outside(q)
        <= 1e-9 * mirror.outline.bounds().size().max_element())
    .then_some(place)
}

fn flipped(p: DVec3, reflected: bool) -> DVec3 {
    if reflected { p * DVec3::new(1.0, -1.0, 1.0) } else { p }
}
