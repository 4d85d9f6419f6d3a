//! Pieces of faces, each with bounds of its place and of its normals.

use super::bicubic::{Control, Net};
use super::face::{Share, TrimmedFace};
use super::patch::halves_of;
use crate::geom::{Chart, DVec3};
use crate::num::{Interval, atan2, cos, sin};
use std::f64::consts::FRAC_1_SQRT_2;

/// A piece of a body's surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePiece {
    /// Least and largest coordinates, mm.
    pub bounds: [DVec3; 2],
    /// Least and largest components of the unit normals out of the body.
    pub normals: [DVec3; 2],
}

/// Least and largest components of unit normals of which nothing is known.
const ANY: [DVec3; 2] = [DVec3::NEG_ONE, DVec3::ONE];
/// Range of a component of the normals within which a piece is not halved any more: a ray that leaves a mirror by
/// some ten degrees sees the back of such a piece, or is above it.
const NARROW: f64 = 0.06;
/// Halvings of a patch at most, along both axes together.
const MOST_DEPTH: usize = 10;
/// Z of a unit normal from which on a plane face is level: it is as high everywhere, nearly.
const LEVEL: f64 = 0.99;
/// By how much normals are widened: rounding is far below it.
const MARGIN: f64 = 1e-12;

/// A box of vectors.
type Vectors = [Interval; 3];

/// The pieces of a face, each at most `size` mm long along X and Y, but where it is level.
pub(super) fn of_face(face: &TrimmedFace, size: f64) -> Vec<SurfacePiece> {
    if let Some((_, normal)) = face.plane() {
        return of_plane(face, normal, size);
    }
    // Coordinates as they are.
    let space = Chart::on_axis(0.0, 0.0);
    let mut pieces = Vec::new();
    for (number, patch) in face.patches.iter().enumerate() {
        let Some(net) = Net::of(patch, &space) else {
            pieces.push(SurfacePiece { bounds: patch.bounds, normals: ANY });
            continue;
        };
        Cutter { face, number, net, size, pieces: &mut pieces }.cut([[0.0, 1.0]; 2], 0);
    }
    pieces
}

/// A patch that is cut into pieces.
struct Cutter<'a> {
    face: &'a TrimmedFace,
    number: usize,
    net: Net,
    size: f64,
    pieces: &'a mut Vec<SurfacePiece>,
}

impl Cutter<'_> {
    fn cut(&mut self, part: [[f64; 2]; 2], depth: usize) {
        if self.face.share(self.number, part) == Share::None {
            return;
        }
        let net = self.net.over(part);
        let normals = match self.face.turn_of(self.number) {
            // (Of the meridian at which the patch begins.)
            Some(axes) => turned(&self.net.over([[0.0; 2], part[1]]), part[0], axes),
            None => cross(tangents(&net)),
        };
        let unit = components(if self.face.same { normals } else { normals.map(|n| -n) });
        let points = net.controls().map(|&[x, y, z, w]| DVec3::new(x, y, z) / w);
        let bounds = super::trim::bounds(points);
        let wide = (bounds[1] - bounds[0]).truncate().max_element() > self.size;
        let is_whole = (unit[1] - unit[0]).max_element() <= NARROW && !wide;
        if is_whole || depth == MOST_DEPTH {
            self.pieces.push(SurfacePiece { bounds, normals: unit });
            return;
        }
        let axis = net.longer_axis();
        for half in halves_of(part, axis) {
            self.cut(half, depth + 1);
        }
    }
}

/// Slices of a plane face, upright if it is: nothing in one is higher than the edges there.
fn of_plane(face: &TrimmedFace, normal: DVec3, size: f64) -> Vec<SurfacePiece> {
    let [lo, hi] = face.bounds;
    let normals = [normal; 2];
    let length = hi - lo;
    let axis = usize::from(length.y > length.x);
    let count = (length[axis] / size).ceil();
    if !(count > 1.0) || normal.z.abs() > LEVEL {
        return vec![SurfacePiece { bounds: face.bounds, normals }];
    }
    let edges = face.trim.edge_boxes();
    let slice = |k: usize| {
        let end = |k: usize| lo[axis] + length[axis] * (k as f64 / count);
        let [from, to] = [end(k), end(k + 1)];
        let margin = MARGIN * (1.0 + lo.abs().max(hi.abs()).max_element());
        let own =
            edges.iter().filter(|[lo, hi]| lo[axis] <= to + margin && hi[axis] >= from - margin);
        let [mut least, mut most] = super::trim::bounds(own.flatten().copied());
        (least[axis], most[axis]) = (from, to);
        // (None of the face is where no edge is.)
        least.is_finite().then_some(SurfacePiece { bounds: [least, most], normals })
    };
    (0..count as usize).filter_map(slice).collect()
}

/// Bounds of the directions along u and v, of any length.
fn tangents(net: &Net) -> [Vectors; 2] {
    let place = |k: usize| hull(net.controls().map(|control| control[k] / control[3]));
    let places = [0, 1, 2].map(place);
    net.derivatives().map(|all| {
        let all: Vec<Control> = all.collect();
        let component = |k: usize| hull(all.iter().map(|control| control[k]));
        [0, 1, 2].map(|k| component(k) - places[k] * component(3))
    })
}

/// Normals of a piece of a surface of revolution: those of its meridian `line`, which every row of the net is, turned
/// about the last of the `axes` from the first towards the second, by the angles of a quarter's parameters. They are
/// known at a pole too.
fn turned(line: &Net, us: [f64; 2], [out, across, axis]: [DVec3; 3]) -> Vectors {
    let [_, along] = tangents(line);
    let dot = |d: DVec3| along[0] * d.x + along[1] * d.y + along[2] * d.z;
    let (rise, run) = (dot(axis), dot(out));
    let [from, to] = us.map(quarter_angle);
    let cosine = Interval::new(cos(to) - MARGIN, cos(from) + MARGIN);
    let sine = Interval::new(sin(from) - MARGIN, sin(to) + MARGIN);
    let [x, y] = [rise * cosine, rise * sine];
    [0, 1, 2].map(|k| x * out[k] + y * across[k] - run * axis[k])
}

/// Angle of the place at a parameter of a quarter of a circle in Bezier's form.
fn quarter_angle(u: f64) -> f64 {
    let middle = 2.0 * FRAC_1_SQRT_2 * u * (1.0 - u);
    atan2(u * u + middle, (1.0 - u) * (1.0 - u) + middle)
}

fn cross([u, v]: [Vectors; 2]) -> Vectors {
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

/// Least and largest components of the unit vectors of a box of vectors.
fn components(all: Vectors) -> [DVec3; 2] {
    let length =
        |of: fn(Interval) -> f64| all.iter().fold(0.0, |sum, &n| sum + of(n) * of(n)).sqrt();
    let [least, most] = [length(Interval::mignitude), length(Interval::magnitude)];
    if !(least > 0.0 && most.is_finite()) {
        return ANY;
    }
    let low = |n: Interval| n.lo / if n.lo > 0.0 { most } else { least };
    let high = |n: Interval| n.hi / if n.hi > 0.0 { least } else { most };
    let margin = DVec3::splat(MARGIN);
    let [lo, hi] = [DVec3::from_array(all.map(low)), DVec3::from_array(all.map(high))];
    [(lo - margin).max(ANY[0]), (hi + margin).min(ANY[1])]
}

fn hull(mut values: impl Iterator<Item = f64>) -> Interval {
    let first = values.next().unwrap_or(f64::NAN);
    let (lo, hi) = values.fold((first, first), |(lo, hi), x| (lo.min(x), hi.max(x)));
    Interval::new(lo, hi)
}
