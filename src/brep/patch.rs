//! Pieces of surfaces in Bezier's form, and where a ray meets them.
//!
//! Two planes through a ray turn a piece into a polynomial map of the unit square into the plane, whose zeros are
//! where the ray meets it. The control points' images bound it: where they lie to one side, there is no zero. Where
//! the derivatives' control points show that the map is one to one, Newton's method finds the only zero; otherwise
//! the piece is halved (docs/theory.md, T120).

use super::b_spline::{SplineSurface, Weighted};
use super::curve::Curve;
use super::surface::{FaceSurface, Frame};
use super::trim::bounds;
use crate::geom::{DVec2, DVec3, Ray};
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

/// A piece of a surface: control points along v for the first of u's, then for the next.
#[derive(Debug, Clone)]
pub(super) struct Patch {
    pub points: Vec<Weighted>,
    pub degrees: [usize; 2],
    /// The surface's parameters at both ends of each axis.
    ranges: [[f64; 2]; 2],
    /// Least and largest coordinates of its control points, mm.
    pub bounds: [DVec3; 2],
}

/// A zero of a patch's map: distance along the ray, mm, the parameters in [0, 1] and the place, mm.
#[derive(Debug, Clone, Copy)]
pub(super) struct PatchHit {
    pub t: f64,
    pub q: [f64; 2],
    pub at: DVec3,
}

/// Halvings of a patch along each axis: a piece is then as small as rounding.
const MOST_DEPTH: usize = 40;
/// Steps of Newton's method.
const STEPS: usize = 12;
/// How far a zero may be beyond the unit square: rounding, so that none is lost between two patches.
const BEYOND: f64 = 1e-10;

impl Patch {
    fn new(points: Vec<Weighted>, degrees: [usize; 2], ranges: [[f64; 2]; 2]) -> Self {
        let bounds = bounds(points.iter().map(|point| point.project()));
        Self { points, degrees, ranges, bounds }
    }

    /// The patches of a surface: of one of revolution between two places on its meridian. A plane has none.
    pub(super) fn of(surface: &FaceSurface, range_v: [f64; 2]) -> Vec<Self> {
        match surface {
            FaceSurface::Plane(_) => Vec::new(),
            FaceSurface::Spline(spline) => of_spline(spline),
            FaceSurface::Revolved { frame, meridian } => of_revolved(frame, meridian, range_v),
        }
    }

    /// The surface's parameters at those of the patch, in [0, 1], where the surface is at the place `at`.
    pub(super) fn parameters(&self, surface: &FaceSurface, q: [f64; 2], at: DVec3) -> [f64; 2] {
        let along = |axis: usize| {
            let [from, to] = self.ranges[axis];
            from + (to - from) * q[axis].clamp(0.0, 1.0)
        };
        match surface {
            // The angle is no linear function of the parameter.
            FaceSurface::Revolved { meridian: Curve::Ellipse { .. }, .. } => {
                surface.inverse(at, None)
            }
            FaceSurface::Revolved { frame, .. } => {
                let at = frame.components(at - frame.at);
                [crate::num::atan2(at.y, at.x), along(1)]
            }
            _ => [along(0), along(1)],
        }
    }

    /// Directions from the axis of a surface of revolution to where the patch begins and ends.
    pub(super) fn quarter(&self, frame: &Frame) -> [DVec3; 2] {
        quarter_axes(frame, (self.ranges[0][0] / FRAC_PI_2).round() as usize)
    }

    /// Ranges of the surface's parameters that hold those of a part of the patch.
    pub(super) fn ranges_of(&self, surface: &FaceSurface, part: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
        // Where a parameter is no linear function of the patch's, that of the whole patch.
        let linear = match surface {
            FaceSurface::Plane(_) | FaceSurface::Spline(_) => [true; 2],
            FaceSurface::Revolved { meridian: Curve::Ellipse { .. }, .. } => [false; 2],
            FaceSurface::Revolved { .. } => [false, true],
        };
        [0, 1].map(|axis| {
            let [from, to] = self.ranges[axis];
            if linear[axis] { part[axis].map(|x| from + (to - from) * x) } else { [from, to] }
        })
    }

    /// Adds where the ray's line meets the patch to `hits`.
    pub(super) fn meet(&self, ray: &Ray, [n, m]: [DVec3; 2], hits: &mut Vec<PatchHit>) {
        let image = |point: &Weighted| {
            let off = point.p - ray.origin * point.w;
            DVec2::new(off.dot(n), off.dot(m))
        };
        let net: Vec<DVec2> = self.points.iter().map(image).collect();
        let [p, q] = self.degrees;
        if excludes_zero(&net) {
            return;
        }
        let mut zeros = Vec::new();
        zeros_of(&net, [p, q], [[0.0, 1.0]; 2], 0, &mut zeros);
        for q in zeros {
            let at = self.at(q);
            hits.push(PatchHit { t: (at - ray.origin).dot(ray.direction), q, at });
        }
    }

    /// The point at parameters in [0, 1].
    pub(super) fn at(&self, [u, v]: [f64; 2]) -> DVec3 {
        let [p, q] = self.degrees;
        let ([a, _], [b, _]) = (bernstein(p, u), bernstein(q, v));
        let mut sum = Weighted::ZERO;
        for (row, a) in self.points.chunks_exact(q + 1).zip(&a) {
            let line = row.iter().zip(&b).fold(Weighted::ZERO, |sum, (&point, &b)| sum + point * b);
            sum = sum + line * *a;
        }
        sum.project()
    }
}

fn of_spline(spline: &SplineSurface) -> Vec<Patch> {
    let is_polynomial = spline.is_polynomial();
    let [rows, columns] = [0, 1].map(|axis| {
        let knots = &spline.knots[axis];
        let piece = |ends: &[f64]| {
            let span = knots.span(0.5 * (ends[0] + ends[1]));
            ([ends[0], ends[1]], span - knots.degree, knots.bezier(span))
        };
        knots.breaks().windows(2).map(piece).collect::<Vec<_>>()
    });
    let length = spline.knots[1].count();
    let mut patches = Vec::with_capacity(rows.len() * columns.len());
    for (us, i, a) in &rows {
        for (vs, j, b) in &columns {
            let point = |k: usize| {
                let (a, b) = (&a[k / b.len()], &b[k % b.len()]);
                let line = |r: usize| {
                    let row = &spline.points[(i + r) * length + j..];
                    b.iter().zip(row).fold(Weighted::ZERO, |sum, (w, p)| sum + *p * *w)
                };
                (0..a.len()).fold(Weighted::ZERO, |sum, r| sum + line(r) * a[r])
            };
            let points = (0..a.len() * b.len()).map(point);
            // Equal weights leave quotients of polynomials but for rounding: they are made 1.
            let points = match is_polynomial {
                true => points.map(|point| Weighted::new(point.project(), 1.0)).collect(),
                false => points.collect(),
            };
            patches.push(Patch::new(points, [a.len() - 1, b.len() - 1], [*us, *vs]));
        }
    }
    patches
}

fn of_revolved(frame: &Frame, meridian: &Curve, range_v: [f64; 2]) -> Vec<Patch> {
    let mut patches = Vec::new();
    for (line, vs) in meridian.pieces(range_v) {
        for quarter in 0..4 {
            let [a, b] = quarter_axes(frame, quarter);
            let arc = [(a, 1.0), (a + b, FRAC_1_SQRT_2), (b, 1.0)];
            let point = |(out, weight): (DVec3, f64)| {
                line.iter().map(move |point| {
                    let w = weight * point.w;
                    let at = frame.at * w + (frame.z * point.p.z + out * point.p.x) * weight;
                    Weighted { p: at, w }
                })
            };
            let us = [quarter, quarter + 1].map(|k| FRAC_PI_2 * k as f64);
            let points = arc.into_iter().flat_map(point).collect();
            patches.push(Patch::new(points, [2, line.len() - 1], [us, vs]));
        }
    }
    patches
}

/// Where a quarter of a turn begins and ends.
fn quarter_axes(frame: &Frame, quarter: usize) -> [DVec3; 2] {
    let axes = [frame.x, frame.y, -frame.x, -frame.y];
    [axes[quarter % 4], axes[(quarter + 1) % 4]]
}

/// Whether the images of the control points lie to one side of an axis through the origin.
fn excludes_zero(net: &[DVec2]) -> bool {
    let one_side =
        |f: fn(&DVec2) -> f64| net.iter().all(|p| f(p) > 0.0) || net.iter().all(|p| f(p) < 0.0);
    one_side(|p| p.x) || one_side(|p| p.y)
}

/// Adds the zeros of the map with these control points over a part of the unit square.
fn zeros_of(
    net: &[DVec2],
    degrees: [usize; 2],
    part: [[f64; 2]; 2],
    depth: usize,
    zeros: &mut Vec<[f64; 2]>,
) {
    // The rows of the inverse derivative at the middle make the map nearly the identity.
    let [_, along_u, along_v] = value(net, degrees, [0.5; 2]);
    let det = along_u.perp_dot(along_v);
    let turned: Vec<DVec2> = match det {
        0.0 => net.to_vec(),
        _ => net
            .iter()
            .map(|p| DVec2::new(p.perp_dot(along_v), along_u.perp_dot(*p)) / det)
            .collect(),
    };
    if widened_excludes(&turned) {
        return;
    }
    let to_part = |q: [f64; 2]| [0, 1].map(|k| part[k][0] + (part[k][1] - part[k][0]) * q[k]);
    if is_one_to_one(&turned, degrees) {
        zeros.extend(newton(&turned, degrees).map(to_part));
    } else if depth == MOST_DEPTH {
        // The ray touches the surface as far as rounding can tell.
        zeros.push(to_part([0.5; 2]));
    } else {
        let axis = depth % 2;
        for (own, half) in halves(net, degrees, axis).iter().zip(halves_of(part, axis)) {
            zeros_of(own, degrees, half, depth + 1, zeros);
        }
    }
}

/// Both halves along an axis of a part of a patch, given by the ranges of u and v.
pub(super) fn halves_of(part: [[f64; 2]; 2], axis: usize) -> [[[f64; 2]; 2]; 2] {
    let middle = 0.5 * (part[axis][0] + part[axis][1]);
    [0, 1].map(|half| {
        let mut part = part;
        part[axis][1 - half] = middle;
        part
    })
}

/// Whether no zero is in the unit square nor beside it by rounding.
fn widened_excludes(net: &[DVec2]) -> bool {
    let margin = BEYOND;
    let one_side = |f: fn(&DVec2) -> f64| {
        net.iter().all(|p| f(p) > margin) || net.iter().all(|p| f(p) < -margin)
    };
    one_side(|p| p.x) || one_side(|p| p.y)
}

/// Whether the derivatives' control points show that no two points of the square have one image: the derivative is
/// everywhere nearer to the identity than 1 in the sum of rows.
fn is_one_to_one(net: &[DVec2], [p, q]: [usize; 2]) -> bool {
    let (mut off_u, mut off_v) = (DVec2::ZERO, DVec2::ZERO);
    let columns = q + 1;
    for i in 0..=p {
        for j in 0..=q {
            let at = net[i * columns + j];
            if i < p {
                let d = (net[(i + 1) * columns + j] - at) * p as f64;
                off_u = off_u.max((d - DVec2::X).abs());
            }
            if j < q {
                let d = (net[i * columns + j + 1] - at) * q as f64;
                off_v = off_v.max((d - DVec2::Y).abs());
            }
        }
    }
    let rows = off_u + off_v;
    rows.x < 0.5 && rows.y < 0.5
}

/// The zero in the unit square of a map that is one to one and near the identity; its steps shrink at least by half.
fn newton(net: &[DVec2], degrees: [usize; 2]) -> Option<[f64; 2]> {
    let mut at = DVec2::splat(0.5);
    for _ in 0..STEPS {
        let [f, u, v] = value(net, degrees, at.to_array());
        let det = u.perp_dot(v);
        let step = DVec2::new(f.perp_dot(v), u.perp_dot(f)) / det;
        // Beyond the square by its own size nothing is known of the map.
        at = (at - step).clamp(DVec2::splat(-0.5), DVec2::splat(1.5));
        if step.abs().max_element() < 1e-15 {
            break;
        }
    }
    let is_inside = at.min_element() >= -BEYOND && at.max_element() <= 1.0 + BEYOND;
    is_inside.then(|| at.to_array())
}

/// Value and derivatives of a map.
fn value(net: &[DVec2], [p, q]: [usize; 2], [u, v]: [f64; 2]) -> [DVec2; 3] {
    let ([a, da], [b, db]) = (bernstein(p, u), bernstein(q, v));
    let [mut at, mut along_u, mut along_v] = [DVec2::ZERO; 3];
    for (i, row) in net.chunks_exact(q + 1).enumerate() {
        let (mut sum, mut slope) = (DVec2::ZERO, DVec2::ZERO);
        for (j, &point) in row.iter().enumerate() {
            sum += point * b[j];
            slope += point * db[j];
        }
        at += sum * a[i];
        along_u += sum * da[i];
        along_v += slope * a[i];
    }
    [at, along_u, along_v]
}

/// Bernstein's polynomials of a degree and their derivatives.
fn bernstein(degree: usize, t: f64) -> [[f64; super::b_spline::MOST_DEGREE + 1]; 2] {
    let mut b = [0.0; super::b_spline::MOST_DEGREE + 1];
    let mut d = b;
    b[0] = 1.0;
    for k in 1..=degree {
        if k == degree {
            for i in 0..=degree {
                let [before, own] =
                    [if i > 0 { b[i - 1] } else { 0.0 }, if i < k { b[i] } else { 0.0 }];
                d[i] = degree as f64 * (before - own);
            }
        }
        let mut carried = 0.0;
        for value in &mut b[..k] {
            let own = *value;
            *value = carried + (1.0 - t) * own;
            carried = t * own;
        }
        b[k] = carried;
    }
    [b, d]
}

/// The control points of both halves along an axis (de Casteljau).
fn halves(net: &[DVec2], [p, q]: [usize; 2], axis: usize) -> [Vec<DVec2>; 2] {
    let (mut low, mut high) = (net.to_vec(), net.to_vec());
    let columns = q + 1;
    let (degree, lines, step, across) =
        if axis == 0 { (p, columns, columns, 1) } else { (q, p + 1, 1, columns) };
    for line in 0..lines {
        let at = |k: usize| line * across + k * step;
        for round in 1..=degree {
            for k in 0..=degree - round {
                high[at(k)] = 0.5 * (high[at(k)] + high[at(k + 1)]);
            }
            low[at(round)] = high[at(0)];
        }
        // What remains in `high` runs from the middle to the end.
    }
    [low, high]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brep::b_spline::Knots;

    #[test]
    fn halves_are_the_map_over_halves() {
        let net: Vec<DVec2> =
            (0..12).map(|k| DVec2::new(f64::from(k * k % 7), f64::from(k * 5 % 11))).collect();
        for axis in 0..2 {
            let [low, high] = halves(&net, [2, 3], axis);
            for t in [0.0, 0.3, 1.0] {
                let at = |x: f64| if axis == 0 { [x, 0.4] } else { [0.4, x] };
                let [a, ..] = value(&low, [2, 3], at(t));
                let [b, ..] = value(&high, [2, 3], at(t));
                assert!((a - value(&net, [2, 3], at(0.5 * t))[0]).length() < 1e-13);
                assert!((b - value(&net, [2, 3], at(0.5 + 0.5 * t))[0]).length() < 1e-13);
            }
        }
    }

    /// Blossoms of equal weights are equal but for rounding, which would make each piece a quotient.
    #[test]
    fn patches_of_equal_weights_have_weights_of_one() {
        let knots = || {
            let ends = |x: f64| [0.0, 0.7, 1.1, 1.9, 2.0].map(|knot| knot + x);
            Knots::new(3.0, &[4.0, 1.0, 1.0, 1.0, 4.0], &ends(0.3), 7).unwrap()
        };
        for weight in [1.0, 0.7] {
            let at = |k: usize| DVec3::new((k / 7) as f64, (k % 7) as f64, (k * k % 11) as f64);
            let points = (0..49).map(|k| Weighted::new(at(k), weight)).collect();
            let spline = SplineSurface::new([knots(), knots()], points);
            let patches = of_spline(&spline);
            assert_eq!(patches.len(), 16);
            for patch in &patches {
                assert!(patch.points.iter().all(|point| point.w == 1.0));
                let [us, vs] = patch.ranges;
                let middle = |[from, to]: [f64; 2]| 0.5 * (from + to);
                let [at, ..] = spline.at(middle(us), middle(vs));
                assert!((patch.at([0.5; 2]) - at).length() < 1e-13);
            }
        }
    }
}
