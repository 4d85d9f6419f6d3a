//! Watertight intersection of a ray's line with a triangle.
//!
//! After Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection" (2013): every vertex is
//! sheared, once and alike for all its facets, into a plane across the ray, where the facets tile
//! without gaps; on which side of an edge the ray passes is then decided exactly. Shearing rounds:
//! a vertex may move by a few units in the last place of its distance from the ray's origin, but
//! with all its facets, so nothing opens.

use crate::geom::{DVec2, DVec3, Ray};

/// A ray along which vertices are sheared into the plane across it.
pub(crate) trait Shear {
    /// A vertex sheared into the plane across the ray.
    fn project(&self, v: DVec3) -> ShearedVertex;
}

/// A ray of any direction, with its shear.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ShearedRay {
    origin: DVec3,
    /// Indices of the two lesser axes of the direction and of the greatest.
    axes: [usize; 3],
    shear: DVec2,
    per_depth: f64,
}

/// A vertex sheared along a ray into the plane across it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ShearedVertex {
    /// Position in that plane, mm.
    at: DVec2,
    /// Distance along the ray, mm.
    depth: f64,
}

impl ShearedRay {
    /// `ray` with its shear.
    #[inline]
    pub(crate) fn new(ray: &Ray) -> Self {
        let d = ray.direction;
        let size = d.abs();
        let axes = if size.z >= size.x && size.z >= size.y {
            [0, 1, 2]
        } else if size.x >= size.y {
            [1, 2, 0]
        } else {
            [2, 0, 1]
        };
        let main = d[axes[2]];
        let shear = DVec2::new(d[axes[0]], d[axes[1]]) / main;
        Self { origin: ray.origin, axes, shear, per_depth: 1.0 / main }
    }
}

impl Shear for ShearedRay {
    #[inline]
    fn project(&self, v: DVec3) -> ShearedVertex {
        let p = v - self.origin;
        let along = p[self.axes[2]];
        ShearedVertex {
            at: DVec2::new(p[self.axes[0]], p[self.axes[1]]) - self.shear * along,
            depth: along * self.per_depth,
        }
    }
}

/// A ray along -Z: equal to its [`ShearedRay`] to the last bit, for its shear vanishes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct VerticalRay {
    /// Origin of the ray, mm.
    pub origin: DVec3,
}

impl Shear for VerticalRay {
    #[inline]
    fn project(&self, v: DVec3) -> ShearedVertex {
        let p = v - self.origin;
        ShearedVertex { at: p.truncate(), depth: -p.z }
    }
}

/// Whether a line meets the triangle of these corners, edges included, and, if so, the distance along
/// it, mm. A triangle seen edge-on is not met; its neighbours then are.
#[inline]
pub(crate) fn intersect(a: ShearedVertex, b: ShearedVertex, c: ShearedVertex) -> (bool, f64) {
    let all = edge_functions(a.at, b.at, c.at);
    let met = if all[0] * all[1] * all[2] == 0.0 {
        on_edge(all)
    } else {
        let [a, b, c] = all.map(f64::to_bits);
        ((a ^ b) | (a ^ c)) >> 63 == 0
    };
    let t = (all[0] * a.depth + all[1] * b.depth + all[2] * c.depth) / (all[0] + all[1] + all[2]);
    (met, t)
}

/// Whether edge functions, some of which vanish, are neither of both signs nor all zero: the line meets
/// an edge or a corner.
#[cold]
fn on_edge(sides: [f64; 3]) -> bool {
    sides.iter().any(|&side| side < 0.0) != sides.iter().any(|&side| side > 0.0)
}

/// Barycentric coordinates of the point where a line meets the triangle of these corners.
#[inline]
pub(crate) fn barycentric(a: ShearedVertex, b: ShearedVertex, c: ShearedVertex) -> [f64; 3] {
    let sides = edge_functions(a.at, b.at, c.at);
    let sum = sides[0] + sides[1] + sides[2];
    sides.map(|side| side / sum)
}

/// [`edge_function`] of the edges opposite to each corner.
#[inline]
fn edge_functions(a: DVec2, b: DVec2, c: DVec2) -> [f64; 3] {
    // Rounding is monotonic, so rounded products that differ compare as the exact ones do.
    let sides = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
    // (Some zero, or so small that it does not matter.)
    if sides[0] * sides[1] * sides[2] == 0.0 {
        return [edge_function(b, c), edge_function(c, a), edge_function(a, b)];
    }
    sides
}

/// Edge function of pq at the origin, p.x q.y - p.y q.x, with its exact sign: the side of the edge on
/// which the ray passes.
#[cold]
fn edge_function(p: DVec2, q: DVec2) -> f64 {
    let (m, n) = (p.x * q.y, p.y * q.x);
    if m != n {
        return m - n;
    }
    // Equal when rounded: the rounding errors of both decide, and are themselves exact.
    p.x.mul_add(q.y, -m) - p.y.mul_add(q.x, -n)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edge_functions_are_exact_one_ulp_beside_an_edge() {
        let p = DVec2::new(0.1, 0.3);
        let q = p * -3.0;
        let ulp = f64::from_bits(q.y.to_bits() + 1);
        let beside = DVec2::new(q.x, ulp);
        // In exact arithmetic 0.1 * (0.3 * 3) differs from 0.3 * (0.1 * 3) by rounding of the
        // inputs; integers decide.
        let exact = |q: DVec2| {
            let whole = |x: f64| (x * (1u64 << 60) as f64) as i128;
            whole(p.x) * whole(q.y) - whole(p.y) * whole(q.x)
        };
        for q in [q, beside] {
            assert_eq!(edge_function(p, q).signum() as i128, exact(q).signum());
            assert_eq!(edge_function(q, p), -edge_function(p, q));
        }
    }
}
