//! A face: a trimmed surface with its normal out of the body, and its share of the body's volume.

use super::b_spline::SplineSurface;
use super::curve::Curve;
use super::patch::{Patch, PatchHit};
use super::surface::FaceSurface;
use super::trim::{Travel, Trim, bounds};
use crate::geom::{DVec3, Ray};
use crate::num::quadrature::gauss_legendre;

/// Nodes of Gauss' rule beyond twice the degree where the integrand is no polynomial: for circles and for weights.
const MORE_NODES: usize = 8;
/// Nodes of Gauss' rule on each part of a whole turn, a quarter of which a rational spline may be.
const TURN_NODES: usize = 16;
/// Nodes of Gauss' rule on each piece of an edge.
const EDGE_NODES: usize = 8;

/// How much of a part of a surface belongs to a face.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Share {
    /// None.
    None,
    /// Perhaps some.
    Some,
    /// All.
    All,
}

/// A face of a closed shell.
#[derive(Debug)]
pub(super) struct TrimmedFace {
    surface: FaceSurface,
    /// Whether the surface's normal leads out of the body.
    pub same: bool,
    pub trim: Trim,
    /// Whether all of the surface belongs to it.
    whole: bool,
    pub patches: Vec<Patch>,
    /// Least and largest coordinates, mm.
    pub bounds: [DVec3; 2],
}

impl TrimmedFace {
    /// The face of `surface` between `edges`.
    ///
    /// # Errors
    /// What is wrong with the edges.
    pub(super) fn new(surface: FaceSurface, same: bool, edges: &[Travel]) -> Result<Self, String> {
        // Only u may close where v does not: crossings are counted along v.
        let is_across = matches!(surface.periods(), [None, Some(_)]);
        let (surface, same) =
            if is_across { (surface.transposed(), !same) } else { (surface, same) };
        let trim = Trim::new(&surface, edges, same)?;
        let whole = match &surface {
            FaceSurface::Spline(spline) => trim.is_whole([0, 1].map(|k| spline.knots[k].domain())),
            _ => false,
        };
        let patches = Patch::of(&surface, Self::extent_v(&surface, &trim));
        let hull = patches.iter().flat_map(|patch| patch.bounds);
        let bounds = bounds(hull.chain(edges.iter().flat_map(|edge| edge.curve.hull(edge.range))));
        Ok(Self { surface, same, trim, whole, patches, bounds })
    }

    /// The range of v of the face: between its edges, and to the surface's end where it reaches it.
    fn extent_v(surface: &FaceSurface, trim: &Trim) -> [f64; 2] {
        if let Some(cut) = trim.cut() {
            return cut;
        }
        let ([least, most], [low, high]) = (surface.range_v(), trim.reach_v());
        let finite = |end: f64, edge: f64| if end.is_finite() { end } else { edge };
        [finite(least, low), finite(most, high)]
    }

    /// Unit normal out of the body at parameters.
    fn normal(&self, q: [f64; 2]) -> DVec3 {
        let [_, u, v] = self.surface.at(q);
        let normal = u.cross(v).normalize_or_zero();
        if self.same { normal } else { -normal }
    }

    /// The least distance of more than `least` mm at which a ray meets the plane or the patch of this number within the
    /// face, with the normal there. Both vectors `across` the ray are at right angles to it and to each other.
    pub(super) fn meet(
        &self,
        ray: &Ray,
        across: [DVec3; 2],
        patch: usize,
        least: f64,
    ) -> Option<(f64, DVec3)> {
        let mut hits = Vec::new();
        match (&self.surface, self.patches.get(patch)) {
            (FaceSurface::Plane(frame), _) => {
                let t = (frame.at - ray.origin).dot(frame.z) / ray.direction.dot(frame.z);
                if t.is_finite() {
                    hits.push(PatchHit { t, q: [0.0; 2], at: ray.at(t) });
                }
            }
            (_, Some(patch)) => patch.meet(ray, across, &mut hits),
            (_, None) => {}
        }
        hits.retain(|hit| hit.t > least);
        hits.sort_by(|a, b| a.t.total_cmp(&b.t));
        hits.iter().find_map(|hit| {
            let q = self.parameters(patch, hit.q, hit.at);
            let is_own = self.whole || self.trim.contains(&self.surface, q);
            is_own.then(|| (hit.t, self.normal(q)))
        })
    }

    /// The surface's parameters of a place, at parameters in [0, 1] of the patch of this number.
    fn parameters(&self, patch: usize, q: [f64; 2], at: DVec3) -> [f64; 2] {
        match (&self.surface, self.patches.get(patch)) {
            (FaceSurface::Plane(_), _) | (_, None) => self.surface.inverse(at, None),
            (surface, Some(patch)) => patch.parameters(surface, q, at),
        }
    }

    /// Whether the place at these parameters of the patch of this number belongs to the face.
    pub(super) fn holds(&self, patch: usize, q: [f64; 2], at: DVec3) -> bool {
        self.whole || self.trim.contains(&self.surface, self.parameters(patch, q, at))
    }

    /// How much of a part of the patch of this number, from 0 to 1 along both axes, belongs to the face.
    pub(super) fn share(&self, patch: usize, part: [[f64; 2]; 2]) -> Share {
        if self.whole {
            return Share::All;
        }
        let own = &self.patches[patch];
        if self.trim.may_part(own.ranges_of(&self.surface, part)) {
            return Share::Some;
        }
        let middle = part.map(|[from, to]| 0.5 * (from + to));
        if self.holds(patch, middle, own.at(middle)) { Share::All } else { Share::None }
    }

    /// The place at parameters in [0, 1] of the patch of this number, or of the rectangle around a plane face; none where
    /// it does not belong to the face.
    pub(super) fn place(&self, patch: usize, q: [f64; 2]) -> Option<DVec3> {
        let at = match (self.patches.get(patch), &self.surface) {
            (Some(patch), _) => patch.at(q),
            (None, surface) => {
                let [[u0, u1], [v0, v1]] = self.trim.extent();
                surface.at([u0 + (u1 - u0) * q[0], v0 + (v1 - v0) * q[1]])[0]
            }
        };
        self.holds(patch, q, at).then_some(at)
    }

    /// Axes of the patch of this number on a surface of revolution: outwards where it begins, the way it turns, and the
    /// axis; none on other surfaces.
    pub(super) fn turn_of(&self, patch: usize) -> Option<[DVec3; 3]> {
        let FaceSurface::Revolved { frame, .. } = &self.surface else { return None };
        let [out, across] = self.patches[patch].quarter(frame);
        Some([out, across, frame.z])
    }

    /// A place on a plane face and its normal out of the body; none of other faces.
    pub(super) fn plane(&self) -> Option<(DVec3, DVec3)> {
        let FaceSurface::Plane(frame) = &self.surface else { return None };
        Some((frame.at, if self.same { frame.z } else { -frame.z }))
    }

    /// Integral over the face of a third of its place times its normal, mm^3: with the other faces' the volume.
    pub(super) fn volume_share(&self) -> f64 {
        let surface = &self.surface;
        let density = |q: [f64; 2]| {
            let [at, u, v] = surface.at(q);
            at.dot(u.cross(v)) / 3.0
        };
        let sum = match surface {
            FaceSurface::Spline(spline) if self.whole => whole_integral(spline, density),
            _ => self.trimmed_integral(density),
        };
        if self.same { sum } else { -sum }
    }

    /// Integral of a density over the parameters of the face.
    fn trimmed_integral(&self, density: impl Fn([f64; 2]) -> f64) -> f64 {
        let surface = &self.surface;
        let [start, end] = Self::extent_v(surface, &self.trim);
        let breaks = breaks_v(surface, [start, end]);
        let (nodes, weights) = gauss_legendre(nodes_v(surface));
        let up_to = |[u, v]: [f64; 2]| {
            let mut sum = 0.0;
            let last = breaks.len() - 2;
            for (part, ends) in breaks.windows(2).enumerate() {
                // (Between its sampled places an edge may pass the first and the last.)
                let (from, to) = (ends[0], if part == last { v } else { ends[1].min(v) });
                if part > 0 && to <= from {
                    break;
                }
                let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
                let at = |(x, w): (&f64, &f64)| w * density([u, middle + half * x]);
                sum += half * nodes.iter().zip(&weights).map(at).sum::<f64>();
            }
            sum
        };
        let (nodes, weights) = gauss_legendre(EDGE_NODES);
        // Green's theorem: the integral of f over what is left of the edges is that of -F du along them, F's
        // derivative by v being f.
        let sum = -self.trim.integral(surface, (&nodes, &weights), up_to);
        let mut sum = if self.same { sum } else { -sum };
        let period = surface.periods()[0];
        if let (true, Some(period)) = (self.trim.reaches_end(), period) {
            let (nodes, weights) = gauss_legendre(TURN_NODES);
            for ends in surface.breaks_u([0.0, period]).windows(2) {
                let (middle, half) = (0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0]));
                let at = |(x, w): (&f64, &f64)| w * up_to([middle + half * x, end]);
                sum += half * nodes.iter().zip(&weights).map(at).sum::<f64>();
            }
        }
        sum
    }
}

/// Integral of a density over all parameters of a spline.
fn whole_integral(spline: &SplineSurface, density: impl Fn([f64; 2]) -> f64) -> f64 {
    let rules = [0, 1].map(|axis| gauss_legendre(spline_nodes(spline, axis)));
    let mut sum = 0.0;
    for us in spline.knots[0].breaks().windows(2) {
        for vs in spline.knots[1].breaks().windows(2) {
            let middle = [us, vs].map(|ends| 0.5 * (ends[0] + ends[1]));
            let half = [us, vs].map(|ends| 0.5 * (ends[1] - ends[0]));
            let [(u_nodes, u_weights), (v_nodes, v_weights)] = &rules;
            for (x, w) in u_nodes.iter().zip(u_weights) {
                let u = middle[0] + half[0] * x;
                let at = |(y, w): (&f64, &f64)| w * density([u, middle[1] + half[1] * y]);
                let line = v_nodes.iter().zip(v_weights).map(at).sum::<f64>();
                sum += half[0] * half[1] * w * line;
            }
        }
    }
    sum
}

/// Nodes of Gauss' rule for the integral along v.
fn nodes_v(surface: &FaceSurface) -> usize {
    match surface {
        FaceSurface::Plane(_) => 1,
        FaceSurface::Spline(spline) => spline_nodes(spline, 1),
        FaceSurface::Revolved { meridian: Curve::Spline(line), .. } => {
            2 * line.knots.degree + MORE_NODES
        }
        FaceSurface::Revolved { .. } => 4 + MORE_NODES,
    }
}

/// Nodes of Gauss' rule along an axis of a spline.
fn spline_nodes(spline: &SplineSurface, axis: usize) -> usize {
    let degree = spline.knots[axis].degree;
    if spline.is_polynomial() {
        // For place times normal, of three times the degree less one.
        return (3 * degree).div_ceil(2);
    }
    2 * degree + MORE_NODES
}

/// Where the integral along v is cut: knots of the surface or its meridian.
fn breaks_v(surface: &FaceSurface, [start, end]: [f64; 2]) -> Vec<f64> {
    let ends = [start, end];
    match surface {
        FaceSurface::Plane(_) => ends.to_vec(),
        FaceSurface::Spline(spline) => spline.knots[1].breaks(),
        FaceSurface::Revolved { meridian, .. } => meridian.breaks(ends),
    }
}
