//! Round rims: their points, and which of them are neighbours.

use crate::geom::{DVec2, Outline, turn};
use crate::mirror::Mirror;
use crate::num::{atan, atan2, cos, sin};
use std::collections::HashSet;
use std::f64::consts::{FRAC_PI_2, PI};

/// The part of a circle about the axis that bounds the meshed part of a mirror.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arc {
    /// mm.
    pub radius: f64,
    /// Angles of its ends.
    pub ends: [f64; 2],
    /// Whether it is the whole circle, and its ends one point.
    pub closed: bool,
    /// Whether points are single-precision numbers.
    pub single: bool,
}

impl Arc {
    /// The rims of `mirror`, the outer one last; none of a rectangle.
    pub fn all(mirror: &Mirror) -> Vec<Self> {
        let Outline::Ring { inner, outer } = mirror.outline else { return Vec::new() };
        let ends = match mirror.even {
            [true, true] => [0.0, FRAC_PI_2],
            [true, false] => [-FRAC_PI_2, FRAC_PI_2],
            [false, true] => [0.0, PI],
            [false, false] => [-PI, PI],
        };
        let closed = mirror.even == [false; 2];
        let single = mirror.chart.vergence == 0.0;
        let radii = [inner, outer].into_iter().filter(|&radius| radius > 0.0);
        radii.map(|radius| Self { radius, ends, closed, single }).collect()
    }

    /// The largest angle that a chord may span.
    pub fn widest() -> f64 {
        // Rounding takes a little of what a chord may cut off.
        let cut = 0.98 * Outline::EDGE;
        // 1 - cos a = 2 sin^2 (a / 2) for half the chord's angle a.
        4.0 * atan((cut / (2.0 - cut)).sqrt())
    }

    /// The point at an angle.
    pub fn at(&self, angle: f64) -> DVec2 {
        let way = DVec2::new(cos(angle), sin(angle));
        // Ends lie on an axis, exactly.
        let way = DVec2::select(way.abs().cmplt(DVec2::splat(1e-12)), DVec2::ZERO, way);
        self.round(way * self.radius)
    }

    /// The point half-way between two others.
    pub fn between(&self, a: DVec2, b: DVec2) -> DVec2 {
        self.round((a + b).normalize() * self.radius)
    }

    fn round(&self, p: DVec2) -> DVec2 {
        if self.single { p.as_vec2().as_dvec2() } else { p }
    }
}

/// One arc and the vertices on it, by angle.
#[derive(Debug, Clone)]
pub struct Rim {
    /// Where they lie.
    pub arc: Arc,
    vertices: Vec<(f64, u32)>,
}

impl Rim {
    fn pairs(&self) -> impl Iterator<Item = [u32; 2]> {
        let wrap = self.arc.closed.then(|| {
            let ends = [self.vertices.len() - 1, 0];
            ends.map(|k| self.vertices[k].1)
        });
        self.vertices.windows(2).map(|w| [w[0].1, w[1].1]).chain(wrap)
    }
}

/// All rims of a mesh.
#[derive(Debug, Clone, Default)]
pub struct Rims {
    rims: Vec<Rim>,
    /// For every vertex 0, or 1 + the number of its rim.
    of: Vec<u8>,
    neighbours: HashSet<[u32; 2]>,
}

impl Rims {
    /// The rims of a mesh whose last vertices are those of `arcs`, of the given numbers.
    pub fn new(arcs: &[(Arc, usize)], points: &[DVec2]) -> Self {
        let mut first = points.len() - arcs.iter().map(|arc| arc.1).sum::<usize>();
        let mut rims = Self { of: vec![0; first], ..Self::default() };
        for (k, &(arc, count)) in arcs.iter().enumerate() {
            rims.rims.push(Rim { arc, vertices: Vec::new() });
            for q in &points[first..first + count] {
                rims.push(*q, Some(k));
            }
            first += count;
        }
        rims.settle();
        rims
    }

    /// Takes note of a new vertex, on a rim or on none.
    pub fn push(&mut self, q: DVec2, rim: Option<usize>) {
        if let Some(k) = rim {
            self.rims[k].vertices.push((atan2(q.y, q.x), self.of.len() as u32));
        }
        if !self.rims.is_empty() {
            self.of.push(rim.map_or(0, |k| k as u8 + 1));
        }
    }

    /// Brings the neighbours up to date.
    pub fn settle(&mut self) {
        self.neighbours.clear();
        for rim in &mut self.rims {
            rim.vertices.sort_by(|a, b| a.0.total_cmp(&b.0));
            self.neighbours.extend(rim.pairs());
        }
    }

    /// The rim on which two vertices are neighbours.
    pub fn joining(&self, a: u32, b: u32) -> Option<usize> {
        let is_edge = self.neighbours.contains(&[a, b]) || self.neighbours.contains(&[b, a]);
        is_edge.then(|| usize::from(self.of[a as usize]) - 1)
    }

    /// The arc of a rim.
    pub fn arc(&self, rim: usize) -> &Arc {
        &self.rims[rim].arc
    }

    /// Neighbours around the hole, if there is one.
    pub fn hole(&self) -> impl Iterator<Item = [u32; 2]> {
        self.rims.iter().rev().skip(1).flat_map(Rim::pairs)
    }

    /// Whether a facet of the convex hull's triangulation is one of the mirror: it is not when all
    /// its corners are on the rim of the hole, nor when it fills the dent that rounding made of
    /// three points on the outer rim.
    #[inline]
    pub fn keeps(&self, facet: &[u32; 3], at: impl Fn(u32) -> DVec2) -> bool {
        if self.rims.is_empty() {
            return true;
        }
        let [a, b, c] = facet.map(|v| self.of[v as usize]);
        if a == 0 || a != b || b != c {
            return true;
        }
        let [a, b, c] = facet.map(|v| at(v).normalize());
        usize::from(self.of[facet[0] as usize]) == self.rims.len() && turn(a, b, c) > 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chords_of_the_widest_angle_cut_what_they_may() {
        let cut = 1.0 - cos(0.5 * Arc::widest());
        assert!(cut < Outline::EDGE && cut > 0.97 * Outline::EDGE);
    }

    #[test]
    fn ends_lie_on_the_axes_and_dents_are_no_facets() {
        let arc = Arc { radius: 3.0, ends: [0.0, FRAC_PI_2], closed: false, single: true };
        assert_eq!((arc.at(0.0), arc.at(FRAC_PI_2)), (DVec2::X * 3.0, DVec2::Y * 3.0));
        let points = [arc.at(0.0), arc.at(0.5), arc.at(1.0), arc.at(FRAC_PI_2)];
        let rims = Rims::new(&[(arc, 4)], &points);
        let at = |v: u32| points[v as usize];
        assert!(rims.keeps(&[0, 1, 2], at) && !rims.keeps(&[0, 2, 1], at));
        assert_eq!((rims.joining(2, 1), rims.joining(0, 2)), (Some(0), None));
        let ring = Rims::new(&[(arc, 2), (arc, 2)], &points);
        assert_eq!(ring.hole().collect::<Vec<_>>(), [[0, 1]]);
    }
}
