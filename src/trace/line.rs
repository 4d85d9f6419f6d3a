//! The intersection of a ray's line with a triangle, without gaps between neighbours.
//!
//! After Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection" (2013): every vertex is
//! sheared, once and alike for all its facets, into a plane across the ray, where the facets tile
//! without gaps; on which side of an edge the ray passes is then decided exactly.

use crate::geom::{DVec2, DVec3, Ray};

/// A ray with its shear into the plane across it.
#[derive(Debug, Clone, Copy)]
pub struct Line {
    origin: DVec3,
    /// Indices of the two lesser axes of the direction and of the greatest.
    axes: [usize; 3],
    shear: DVec2,
    per_depth: f64,
}

/// A vertex as seen along the ray.
#[derive(Debug, Clone, Copy)]
pub struct Across {
    /// Position across the ray.
    at: DVec2,
    /// Distance along the ray.
    depth: f64,
}

impl Line {
    /// Prepares `ray`.
    #[inline]
    pub fn new(ray: &Ray) -> Self {
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

    /// Shears a vertex.
    #[inline]
    pub fn project(&self, v: DVec3) -> Across {
        let p = v - self.origin;
        let along = p[self.axes[2]];
        Across {
            at: DVec2::new(p[self.axes[0]], p[self.axes[1]]) - self.shear * along,
            depth: along * self.per_depth,
        }
    }

    /// Distance and barycentric weights of the place where the line meets the triangle, rim
    /// included; `None` also for a triangle seen edge-on, whose neighbours then meet the line.
    #[inline]
    pub fn meet(&self, a: Across, b: Across, c: Across) -> Option<(f64, [f64; 3])> {
        let sides = [side(b.at, c.at), side(c.at, a.at), side(a.at, b.at)];
        let least = sides[0].min(sides[1]).min(sides[2]);
        let largest = sides[0].max(sides[1]).max(sides[2]);
        let sum = sides[0] + sides[1] + sides[2];
        if (least < 0.0 && largest > 0.0) || sum == 0.0 {
            return None;
        }
        let weights = sides.map(|s| s / sum);
        let t = weights[0] * a.depth + weights[1] * b.depth + weights[2] * c.depth;
        Some((t, weights))
    }
}

/// On which side of the edge pq the origin lies: p.x q.y - p.y q.x, with its exact sign.
#[inline]
fn side(p: DVec2, q: DVec2) -> f64 {
    let (m, n) = (p.x * q.y, p.y * q.x);
    if m != n {
        // Rounding is monotonic, so the rounded products compare as the exact ones do.
        return m - n;
    }
    // Equal when rounded: what rounding took from each decides, and is itself exact.
    p.x.mul_add(q.y, -m) - p.y.mul_add(q.x, -n)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn side_is_exact_one_ulp_beside_an_edge() {
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
            assert_eq!(side(p, q).signum() as i128, exact(q).signum());
            assert_eq!(side(q, p), -side(p, q));
        }
    }
}
