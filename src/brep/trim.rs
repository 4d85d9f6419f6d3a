//! The part of a surface that a face is: which parameters its edges enclose.
//!
//! From a point the line of constant u that rises in v is followed, and the edges that it crosses are counted by the
//! way they run. Counts of two points are equal if and only if no edge lies between them, whatever the surface does
//! at its poles and seams, so the points inside are those with the count of a point beside an edge.

use super::b_spline::Weighted;
use super::curve::Curve;
use super::surface::{FaceSurface, solve};
use crate::geom::DVec3;

/// An edge's curve from one vertex to the other, as a loop of a face runs along it.
#[derive(Debug, Clone)]
pub(super) struct Travel<'a> {
    pub curve: &'a Curve,
    /// First and last parameter; they may fall.
    pub range: [f64; 2],
}

/// Parameters of a place on an edge, and their derivatives along it.
#[derive(Debug, Clone, Copy)]
struct Place {
    /// The curve's parameter.
    t: f64,
    q: [f64; 2],
    /// Derivative of u by t.
    du: f64,
    /// Distance of the curve from the surface, mm.
    off: f64,
    /// Whether it is at a pole of the surface, where every u is the same point.
    is_pole: bool,
}

/// A piece of an edge along which u rises or falls.
#[derive(Debug, Clone, Copy)]
struct Piece {
    /// The edge; none at a pole, where a loop that comes to it at one u leaves it at another.
    edge: Option<usize>,
    ends: [Place; 2],
    /// How far v may be from the chord's.
    bulge: f64,
}

/// The edges of a face in the parameters of its surface, without seams: edges along which a face meets itself.
#[derive(Debug, Clone)]
pub(super) struct Trim {
    edges: Vec<(Curve, [f64; 2])>,
    pieces: Vec<Piece>,
    /// Ends of pieces of edges of one u: that, and the least and the largest v.
    upright: Vec<[f64; 3]>,
    /// Numbers of the pieces over each of equal parts of u's range.
    bins: Vec<Vec<u32>>,
    /// Least u, and the length of a part.
    first: [f64; 2],
    /// Increase of u once round.
    period: Option<f64>,
    /// Where v begins on a surface that closes along v.
    cut: Option<[f64; 2]>,
    /// Count of crossings of the points inside.
    inside: i32,
    /// Largest distance of an edge from the surface, mm.
    pub off_mm: f64,
}

/// Pieces of each part of an edge between its breaks.
const PIECES: usize = 4;
/// Parts of u's range.
const BINS: usize = 256;
/// Length of a line of constant v, mm, that is a point.
const POLE_MM: f64 = 1e-6;
/// Halvings in which a crossing is found: to rounding.
const HALVINGS: usize = 60;
/// Least length of a piece along u of whose sides one is inside, as a share of u's range.
const LEVEL: f64 = 1e-6;
/// Pieces of edges beside which the points inside are counted: one is enough where no edges cross.
const SAMPLES: usize = 16;

impl Trim {
    /// The trim of `surface` by these edges, with the face to the left of them if `left`, to the right otherwise.
    ///
    /// # Errors
    /// What is wrong with the edges.
    pub(super) fn new(surface: &FaceSurface, edges: &[Travel], left: bool) -> Result<Self, String> {
        let [period, period_v] = surface.periods();
        let mut trim = Self {
            edges: edges.iter().map(|edge| (edge.curve.clone(), edge.range)).collect(),
            pieces: Vec::new(),
            upright: Vec::new(),
            bins: Vec::new(),
            first: [0.0; 2],
            period,
            cut: None,
            inside: 0,
            off_mm: 0.0,
        };
        let mut traced: Vec<Vec<Place>> =
            edges.iter().map(|edge| trim.trace(surface, edge)).collect();
        if let Some(period) = period_v {
            trim.cut = Some(trim.cut_between(&mut traced, period)?);
        }
        for (edge, places) in traced.iter().enumerate() {
            for ends in places.windows(2) {
                trim.add(surface, Some(edge), [ends[0], ends[1]]);
            }
        }
        trim.cross_poles(surface, &traced, left);
        trim.sort();
        trim.inside = trim.count_inside(surface, left)?;
        // Without poles and seams what is of the face lies between edges.
        let wanted = if left { 1 } else { -1 };
        if period.is_none() && trim.inside != wanted {
            return Err("its edges run the wrong way round".into());
        }
        if !trim.edges.is_empty() && trim.pieces.is_empty() {
            return Err("its edges enclose nothing".into());
        }
        Ok(trim)
    }

    /// Places along an edge, so near each other that u rises or falls between neighbours.
    fn trace(&mut self, surface: &FaceSurface, edge: &Travel) -> Vec<Place> {
        let breaks = edge.curve.breaks(edge.range);
        let part = |ends: &[f64]| {
            let [from, to] = [ends[0], ends[1]];
            (0..PIECES).map(move |k| from + (to - from) * k as f64 / PIECES as f64)
        };
        let mut ts: Vec<f64> = breaks.windows(2).flat_map(part).collect();
        ts.extend(breaks.last());
        let mut places: Vec<Place> = Vec::with_capacity(ts.len());
        for t in ts {
            let before = places.last().copied();
            let place = self.place(surface, edge.curve, t, before);
            self.off_mm = self.off_mm.max(place.off);
            if let Some(before) = before
                && before.du * place.du < 0.0
            {
                places.push(self.turn(surface, edge.curve, [before, place]));
            }
            places.push(place);
        }
        leave_poles(&mut places);
        places
    }

    /// Adds what loops run along at poles: from the u at which an edge comes to one to that at which the next leaves it, with the
    /// face between them.
    fn cross_poles(&mut self, surface: &FaceSurface, traced: &[Vec<Place>], left: bool) {
        let ends = |at: fn(&[Place]) -> Option<&Place>| {
            traced.iter().filter_map(move |places| at(places)).filter(|place| place.is_pole)
        };
        let mut leaving: Vec<Place> = ends(<[Place]>::first).copied().collect();
        for from in ends(<[Place]>::last) {
            let [lowest, highest] = surface.range_v();
            let is_top = highest - from.q[1] < from.q[1] - lowest;
            let is_same = |to: &Place| (highest - to.q[1] < to.q[1] - lowest) == is_top;
            let Some(next) = leaving.iter().position(is_same) else { continue };
            let mut to = leaving.swap_remove(next).q[0];
            if let Some(period) = self.period {
                let way = if is_top == left { -1.0 } else { 1.0 };
                to = from.q[0] + way * (way * (to - from.q[0])).rem_euclid(period);
            }
            let breaks = surface.breaks_u([from.q[0], to]);
            let place = |u: &f64| Place { t: *u, q: [*u, from.q[1]], du: 1.0, ..*from };
            let places: Vec<Place> = breaks.iter().map(place).collect();
            for ends in places.windows(2) {
                self.add(surface, None, [ends[0], ends[1]]);
            }
        }
    }

    /// A place of a piece, or of an edge between `ends`.
    fn along(&self, surface: &FaceSurface, edge: Option<usize>, t: f64, near: Place) -> Place {
        match edge {
            Some(edge) => self.place(surface, &self.edges[edge].0, t, Some(near)),
            None => Place { t, q: [t, near.q[1]], ..near },
        }
    }

    /// Where on an edge u neither rises nor falls, between two places.
    fn turn(&self, surface: &FaceSurface, curve: &Curve, [mut a, mut b]: [Place; 2]) -> Place {
        for _ in 0..HALVINGS {
            let middle = self.place(surface, curve, 0.5 * (a.t + b.t), Some(a));
            if middle.du * a.du > 0.0 { a = middle } else { b = middle }
        }
        a
    }

    fn place(&self, surface: &FaceSurface, curve: &Curve, t: f64, near: Option<Place>) -> Place {
        let (at, along) = curve.at(t);
        let mut q = surface.inverse(at, near.map(|near| near.q));
        let [on, u, v] = surface.at(q);
        let step = solve([u, v], along);
        if let (Some(near), [period, period_v]) = (near, surface.periods()) {
            q[0] = turned(q[0], near.q[0], period);
            q[1] = turned(q[1], near.q[1], period_v);
        }
        let is_pole = u.length() * surface.length_u() <= POLE_MM;
        let du = if is_pole { 0.0 } else { step[0] };
        Place { t, q, du, off: on.distance(at), is_pole }
    }

    /// The range of v of a surface that closes along v, which begins where no edge is.
    fn cut_between(&self, traced: &mut [Vec<Place>], period: f64) -> Result<[f64; 2], String> {
        let all = || traced.iter().flatten().map(|place| place.q[1]);
        let mut values: Vec<f64> = all().map(|v| v.rem_euclid(period)).collect();
        values.sort_by(f64::total_cmp);
        let Some(&first) = values.first() else { return Ok([0.0, period]) };
        let mut widest = (first + period - values[values.len() - 1], first);
        for pair in values.windows(2) {
            if pair[1] - pair[0] > widest.0 {
                widest = (pair[1] - pair[0], pair[1]);
            }
        }
        let cut = widest.1 - 0.5 * widest.0;
        for places in traced.iter_mut() {
            let Some(first) = places.first() else { continue };
            let shift = cut + (first.q[1] - cut).rem_euclid(period) - first.q[1];
            places.iter_mut().for_each(|place| place.q[1] += shift);
            if places.iter().any(|place| place.q[1] < cut || place.q[1] > cut + period) {
                return Err("edges go all the way round a surface that closes both ways".into());
            }
        }
        Ok([cut, cut + period])
    }

    fn add(&mut self, surface: &FaceSurface, edge: Option<usize>, ends: [Place; 2]) {
        let [a, b] = ends;
        if a.q[0] == b.q[0] {
            let ([_, low], [_, high]) = (a.q, b.q);
            self.upright.push([a.q[0], low.min(high), low.max(high)]);
            return;
        }
        let middle = self.along(surface, edge, 0.5 * (a.t + b.t), a);
        let share = (middle.q[0] - a.q[0]) / (b.q[0] - a.q[0]);
        let chord = a.q[1] + (b.q[1] - a.q[1]) * share;
        let size = a.q[1].abs().max(b.q[1].abs());
        let mut off = (middle.q[1] - chord).abs();
        if let Some([from, to]) = self.cut {
            // (The place's v may be a whole turn off.)
            off = off.min((off - (to - from)).abs());
        }
        // The middle shows three quarters of the largest distance of a cubic, at least.
        self.pieces.push(Piece { edge, ends, bulge: 2.0 * off + 1e-12 * size });
    }

    /// Sorts the pieces into bins.
    fn sort(&mut self) {
        let us = || self.pieces.iter().flat_map(|piece| piece.ends.map(|end| end.q[0]));
        let first = us().fold(f64::INFINITY, f64::min);
        let last = us().fold(f64::NEG_INFINITY, f64::max);
        let length = self.period.unwrap_or(last - first).max(f64::MIN_POSITIVE);
        self.first = [if first.is_finite() { first } else { 0.0 }, length / BINS as f64];
        self.bins = vec![Vec::new(); BINS];
        for (number, piece) in self.pieces.iter().enumerate() {
            let [a, b] = piece.ends.map(|end| (end.q[0] - self.first[0]) / self.first[1]);
            let (from, to) = (a.min(b).floor() as i64, a.max(b).floor() as i64);
            for bin in from..=to.min(from + BINS as i64 - 1) {
                let bin = match self.period {
                    Some(_) => bin.rem_euclid(BINS as i64),
                    None => bin.clamp(0, BINS as i64 - 1),
                };
                let bin = &mut self.bins[bin as usize];
                if bin.last() != Some(&(number as u32)) {
                    bin.push(number as u32);
                }
            }
        }
    }

    /// Count of the points inside, from points on the edges: of an edge that runs to the right or to the left of the
    /// face's inside, those of the inside are above or below.
    fn count_inside(&self, surface: &FaceSurface, left: bool) -> Result<i32, String> {
        let mut found = None;
        // Pieces of constant u, to rounding, have no sides above and below.
        let least = LEVEL * BINS as f64 * self.first[1];
        let width = |piece: &Piece| piece.ends[1].q[0] - piece.ends[0].q[0];
        let numbers = (0..).zip(&self.pieces).filter(|(_, piece)| width(piece).abs() > least);
        let step = (numbers.clone().count() / SAMPLES).max(1);
        for (number, piece) in numbers.step_by(step) {
            let [a, b] = piece.ends;
            let middle = self.along(surface, piece.edge, 0.5 * (a.t + b.t), a);
            let rises = width(piece) > 0.0;
            let own = match (rises == left, rises) {
                (true, _) => 0,
                (false, true) => -1,
                (false, false) => 1,
            };
            let count = own + self.crossings(middle.q, surface, Some(number));
            if *found.get_or_insert(count) != count {
                return Err("its edges cross or run against each other".into());
            }
        }
        Ok(found.unwrap_or(0))
    }

    /// Edges above a point, without the piece `except`, each counted by the way it runs: 1 towards smaller u, -1
    /// towards larger u.
    fn crossings(&self, [u, v]: [f64; 2], surface: &FaceSurface, except: Option<u32>) -> i32 {
        let place = (u - self.first[0]) / self.first[1];
        let bin = match self.period {
            Some(_) => (place.floor() as i64).rem_euclid(BINS as i64),
            None => (place.floor() as i64).clamp(0, BINS as i64 - 1),
        };
        let crossing = |&number: &u32| {
            let piece = &self.pieces[number as usize];
            let [a, b] = piece.ends;
            let middle = 0.5 * (a.q[0] + b.q[0]);
            let u = self.period.map_or(u, |period| u - period * ((u - middle) / period).round());
            let is_beside = (a.q[0] <= u) == (b.q[0] <= u);
            if is_beside || except == Some(number) || !self.is_above(piece, [u, v], surface) {
                return 0;
            }
            if b.q[0] > a.q[0] { -1 } else { 1 }
        };
        self.bins[bin as usize].iter().map(crossing).sum()
    }

    /// Whether a piece is above a point whose u is among its own: by the chord where that decides, or by the curve.
    fn is_above(&self, piece: &Piece, [u, v]: [f64; 2], surface: &FaceSurface) -> bool {
        let [mut a, mut b] = piece.ends;
        let chord = a.q[1] + (b.q[1] - a.q[1]) * (u - a.q[0]) / (b.q[0] - a.q[0]);
        if (chord - v).abs() > piece.bulge {
            return chord > v;
        }
        for _ in 0..HALVINGS {
            let middle = self.along(surface, piece.edge, 0.5 * (a.t + b.t), a);
            if (middle.q[0] <= u) == (a.q[0] <= u) { a = middle } else { b = middle }
        }
        a.q[1] > v
    }

    /// Whether a point of the surface belongs to the face.
    pub(super) fn contains(&self, surface: &FaceSurface, [u, v]: [f64; 2]) -> bool {
        if self.edges.is_empty() {
            return true;
        }
        let v = self.cut.map_or(v, |[from, to]| from + (v - from).rem_euclid(to - from));
        self.crossings([u, v], surface, None) == self.inside
    }

    /// Whether an edge may come into these ranges of u and v: elsewhere all or none belongs to the face.
    pub(super) fn may_part(&self, [us, vs]: [[f64; 2]; 2]) -> bool {
        let turn = self.cut.map(|[from, to]| to - from);
        let meets = |[from, to]: [f64; 2], [lo, hi]: [f64; 2], period: Option<f64>| {
            // With as many whole turns as bring one's start just behind the other's.
            let shift = period.map_or(0.0, |period| period * ((lo - from) / period).floor());
            let is_over = |from: f64, to: f64| from <= hi && to >= lo;
            let later = period.unwrap_or(0.0);
            is_over(from + shift, to + shift) || is_over(from + shift + later, to + shift + later)
        };
        let of_piece = |piece: &Piece| {
            let [a, b] = piece.ends.map(|end| end.q);
            let [low, high] = [a[1].min(b[1]) - piece.bulge, a[1].max(b[1]) + piece.bulge];
            [[a[0].min(b[0]), a[0].max(b[0])], [low, high]]
        };
        let of_upright = |&[u, low, high]: &[f64; 3]| [[u, u], [low, high]];
        let mut all = self.pieces.iter().map(of_piece).chain(self.upright.iter().map(of_upright));
        all.any(|[u, v]| meets(u, us, self.period) && meets(v, vs, turn))
    }

    /// Least and largest v of the ends of the edges' pieces.
    fn extent_v(&self) -> [f64; 2] {
        self.widest_v(|_| 0.0)
    }

    /// Least and largest u and v of the ends of the edges' pieces.
    pub(super) fn extent(&self) -> [[f64; 2]; 2] {
        let us = self.pieces.iter().flat_map(|piece| piece.ends.map(|end| end.q[0]));
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        [us.fold(none, |[lo, hi], u| [lo.min(u), hi.max(u)]), self.extent_v()]
    }

    /// Boxes around pieces of the edges, mm.
    pub(super) fn edge_boxes(&self) -> Vec<[DVec3; 2]> {
        let of_edge = |(curve, [from, to]): &(Curve, [f64; 2])| {
            let pieces = curve.pieces([from.min(*to), from.max(*to)]);
            let of_piece = |(points, _): (Vec<Weighted>, _)| {
                bounds(points.iter().map(|point| point.project()))
            };
            pieces.into_iter().map(of_piece).collect::<Vec<_>>()
        };
        self.edges.iter().flat_map(of_edge).collect()
    }

    /// Bounds of v of the edges.
    pub(super) fn reach_v(&self) -> [f64; 2] {
        self.widest_v(|piece| piece.bulge)
    }

    fn widest_v(&self, beyond: impl Fn(&Piece) -> f64) -> [f64; 2] {
        let ends = |piece: &Piece| {
            piece.ends.map(|end| [end.q[1] - beyond(piece), end.q[1] + beyond(piece)])
        };
        let upright = self.upright.iter().map(|[_, low, high]| [*low, *high]);
        let all = self.pieces.iter().flat_map(ends).chain(upright);
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        all.fold(none, |[lo, hi], [low, high]| [lo.min(low), hi.max(high)])
    }

    /// Where v begins and ends on a surface that closes along v.
    pub(super) fn cut(&self) -> Option<[f64; 2]> {
        self.cut
    }

    /// Whether what is inside reaches the end of the surface at its largest v.
    pub(super) fn reaches_end(&self) -> bool {
        self.inside == 0
    }

    /// Sum over all edges of the integral of `f(u, v) du` by a rule of nodes and weights on [-1, 1].
    pub(super) fn integral(
        &self,
        surface: &FaceSurface,
        (nodes, weights): (&[f64], &[f64]),
        f: impl Fn([f64; 2]) -> f64,
    ) -> f64 {
        let of_piece = |piece: &Piece| {
            let [a, b] = piece.ends;
            let (middle, half) = (0.5 * (a.t + b.t), 0.5 * (b.t - a.t));
            let at = |(x, w): (&f64, &f64)| {
                let place = self.along(surface, piece.edge, middle + half * x, a);
                w * half * place.du * f(place.q)
            };
            nodes.iter().zip(weights).map(at).sum::<f64>()
        };
        self.pieces.iter().map(of_piece).sum()
    }

    /// Whether the edges are the whole border of a rectangle of parameters, whose corners these are.
    pub(super) fn is_whole(&self, [us, vs]: [[f64; 2]; 2]) -> bool {
        let [du, dv] = [us, vs].map(|[from, to]| 1e-9 * (to - from));
        let on = |q: [f64; 2]| {
            us.iter().any(|u| (q[0] - u).abs() <= du) || vs.iter().any(|v| (q[1] - v).abs() <= dv)
        };
        let [low, high] = self.extent_v();
        self.period.is_none()
            && self.pieces.iter().all(|piece| piece.ends.iter().all(|end| on(end.q)))
            && (low - vs[0]).abs() <= dv
            && (high - vs[1]).abs() <= dv
            && self.pieces.len() > 1
    }
}

/// Gives places at a pole the u at which the edge comes to it or leaves it.
fn leave_poles(places: &mut [Place]) {
    let last = places.len() - 1;
    for [at, beside] in [[0, 1], [last, last - 1]] {
        if places[at].is_pole {
            places[at].q[0] = places[beside].q[0];
            places[at].du = places[beside].du;
        }
    }
}

/// `x` with as many whole turns as bring it near `near`.
fn turned(x: f64, near: f64, period: Option<f64>) -> f64 {
    period.map_or(x, |period| x - period * ((x - near) / period).round())
}

/// Least and largest coordinates of places.
pub(super) fn bounds(places: impl Iterator<Item = DVec3>) -> [DVec3; 2] {
    let none = [DVec3::splat(f64::INFINITY), DVec3::splat(f64::NEG_INFINITY)];
    places.fold(none, |[lo, hi], p| [lo.min(p), hi.max(p)])
}
