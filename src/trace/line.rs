//! The intersection of a ray's line with a triangle, without gaps between neighbours.
//!
//! After Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection" (2013): every vertex is
//! sheared, once and alike for all its facets, into a plane across the ray, where the facets tile
//! without gaps; on which side of an edge the ray passes is then decided exactly. Shearing rounds:
//! a vertex may move by a few units in the last place of its distance from the ray's origin, but
//! with all its facets, so nothing opens.

use crate::geom::{DVec2, DVec3, Ray};

/// A ray that vertices can be sheared along.
pub trait Shear {
    /// Shears a vertex into the plane across the ray.
    fn project(&self, v: DVec3) -> Across;
}

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
}

impl Shear for Line {
    #[inline]
    fn project(&self, v: DVec3) -> Across {
        let p = v - self.origin;
        let along = p[self.axes[2]];
        Across {
            at: DVec2::new(p[self.axes[0]], p[self.axes[1]]) - self.shear * along,
            depth: along * self.per_depth,
        }
    }
}

/// The [`Line`] of a ray along -Z, to the last bit: nothing is left of its shear.
#[derive(Debug, Clone, Copy)]
pub struct Plumb {
    /// Where the ray starts.
    pub origin: DVec3,
}

impl Shear for Plumb {
    #[inline]
    fn project(&self, v: DVec3) -> Across {
        let p = v - self.origin;
        Across { at: p.truncate(), depth: -p.z }
    }
}

/// Whether a line meets the triangle of these corners, rim included, and, if so, at which distance. A
/// triangle seen edge-on is not met; its neighbours then are.
#[inline]
pub fn crossing(a: Across, b: Across, c: Across) -> (bool, f64) {
    let all = sides(a.at, b.at, c.at);
    let met = if all[0] * all[1] * all[2] == 0.0 {
        within_rim(all)
    } else {
        let [a, b, c] = all.map(f64::to_bits);
        ((a ^ b) | (a ^ c)) >> 63 == 0
    };
    let t = (all[0] * a.depth + all[1] * b.depth + all[2] * c.depth) / (all[0] + all[1] + all[2]);
    (met, t)
}

/// Whether the sides, of which some vanish, are neither of both signs nor all zero.
#[cold]
fn within_rim(sides: [f64; 3]) -> bool {
    sides.iter().any(|&side| side < 0.0) != sides.iter().any(|&side| side > 0.0)
}

/// Barycentric weights of the place where a line meets the triangle of these corners.
#[inline]
pub fn weights(a: Across, b: Across, c: Across) -> [f64; 3] {
    let sides = sides(a.at, b.at, c.at);
    let sum = sides[0] + sides[1] + sides[2];
    sides.map(|side| side / sum)
}

/// [`side`] of the edges opposite to each corner.
#[inline]
fn sides(a: DVec2, b: DVec2, c: DVec2) -> [f64; 3] {
    // Rounding is monotonic, so rounded products that differ compare as the exact ones do.
    let sides = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
    // (Some zero, or so small that it does not matter.)
    if sides[0] * sides[1] * sides[2] == 0.0 {
        return [side(b, c), side(c, a), side(a, b)];
    }
    sides
}

/// On which side of the edge pq the origin lies: p.x q.y - p.y q.x, with its exact sign.
#[cold]
fn side(p: DVec2, q: DVec2) -> f64 {
    let (m, n) = (p.x * q.y, p.y * q.x);
    if m != n {
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
