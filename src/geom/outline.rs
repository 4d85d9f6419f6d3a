//! Outlines of mirrors in image coordinates: rectangles and rings.

use super::{DVec2, Rect};
use crate::num::quadrature::clenshaw_curtis;
use crate::num::{cos, sin};
use std::f64::consts::PI;

/// The region of the image that a mirror's panel covers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outline {
    /// A rectangle.
    Rect(Rect),
    /// The points whose distance from the axis lies between two radii, mm; a disc when the inner
    /// one is 0.
    Ring {
        /// Inner radius.
        inner: f64,
        /// Outer radius.
        outer: f64,
    },
}

impl Outline {
    /// The share of its radius by which the chords of a meshed round rim may cut inside it.
    pub const EDGE: f64 = 1e-4;

    /// The smallest rectangle around it.
    #[must_use]
    pub fn bounds(&self) -> Rect {
        match *self {
            Self::Rect(rect) => rect,
            Self::Ring { outer, .. } => {
                Rect { min: DVec2::splat(-outer), max: DVec2::splat(outer) }
            }
        }
    }

    /// Whether `p` lies inside or on the rim.
    #[must_use]
    pub fn contains(&self, p: DVec2) -> bool {
        match *self {
            Self::Rect(rect) => rect.contains(p),
            Self::Ring { inner, outer } => (inner..=outer).contains(&p.length()),
        }
    }

    /// The point of the region nearest to `q`, of a ring's along the radius of `q`.
    #[must_use]
    pub fn nearest(&self, q: DVec2) -> DVec2 {
        match *self {
            Self::Rect(rect) => q.clamp(rect.min, rect.max),
            Self::Ring { inner, outer } => {
                let radius = q.length();
                if (inner..=outer).contains(&radius) {
                    q
                } else {
                    q.try_normalize().unwrap_or(DVec2::X) * radius.clamp(inner, outer)
                }
            }
        }
    }

    /// How far `q` lies outside the region, mm: within, how far inside its rim, negative.
    #[must_use]
    pub fn distance_outside(&self, q: DVec2) -> f64 {
        match *self {
            Self::Rect(rect) if rect.contains(q) => (rect.min - q).max(q - rect.max).max_element(),
            Self::Rect(rect) => (q - q.clamp(rect.min, rect.max)).length(),
            Self::Ring { inner, outer } => (q.length() - outer).max(inner - q.length()),
        }
    }

    /// Whether a meshed face with this outline surely lies under `p`: off a round rim by more than
    /// its chords cut.
    #[must_use]
    pub fn aims(&self, p: DVec2) -> bool {
        match *self {
            Self::Rect(rect) => rect.contains(p),
            Self::Ring { inner, outer } => {
                let r = p.length();
                let inside = r <= outer * (1.0 - 1.01 * Self::EDGE);
                inside && (inner == 0.0 || r >= inner * (1.0 + 1e-6))
            }
        }
    }

    /// The distance from the axis, which it must lie around, to the outer rim in direction `way`
    /// (of any length; X for none), mm.
    #[must_use]
    pub fn reach(&self, way: DVec2) -> f64 {
        let way = if way == DVec2::ZERO { DVec2::X } else { way.normalize() };
        match *self {
            Self::Rect(rect) => {
                let to = |d: f64, lo: f64, hi: f64| if d < 0.0 { lo / d } else { hi / d };
                let along_x = to(way.x, rect.min.x, rect.max.x);
                let along_y = to(way.y, rect.min.y, rect.max.y);
                along_x.min(along_y)
            }
            Self::Ring { outer, .. } => outer,
        }
    }

    /// Area, mm^2.
    #[must_use]
    pub fn area(&self) -> f64 {
        match *self {
            Self::Rect(rect) => rect.area(),
            Self::Ring { inner, outer } => PI * (outer - inner) * (outer + inner),
        }
    }

    /// Its rims, the outer one first, counter-clockwise, each as so many places a side or a quarter of a turn.
    #[must_use]
    pub fn rims(&self, places: usize) -> Vec<Vec<DVec2>> {
        let share = |k: usize| k as f64 / places as f64;
        match *self {
            Self::Rect(Rect { min, max }) => {
                let corners = [min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)];
                let side = |k: usize| {
                    let (from, to) = (corners[k], corners[(k + 1) % 4]);
                    (0..places).map(move |j| from.lerp(to, share(j)))
                };
                vec![(0..4).flat_map(side).collect()]
            }
            Self::Ring { inner, outer } => {
                let round = |radius: f64| {
                    let turns = (0..4 * places).map(|k| 0.5 * PI * share(k));
                    turns.map(|turn| DVec2::new(cos(turn), sin(turn)) * radius).collect()
                };
                [outer, inner].into_iter().filter(|radius| *radius > 0.0).map(round).collect()
            }
        }
    }

    /// Samples of the region, the rim among them, and their weights (mm^2; they sum to the area),
    /// which integrate smooth functions: Clenshaw and Curtis' rule for `n` steps (an even number)
    /// in each direction, for rings along each of n / 4 radii (at least 4). Lines of n + 1 points in
    /// fixed order.
    #[must_use]
    pub fn samples(&self, n: usize) -> Vec<Vec<(DVec2, f64)>> {
        let (nodes, weights) = clenshaw_curtis(n);
        let line = |lo: f64, hi: f64| -> Vec<(f64, f64)> {
            let (mid, half) = (0.5 * (lo + hi), 0.5 * (hi - lo));
            let at = |k: usize| match k {
                0 => lo,
                _ if k == n => hi,
                _ => mid + half * nodes[k],
            };
            (0..=n).map(|k| (at(k), half * weights[k])).collect()
        };
        match *self {
            Self::Rect(Rect { min, max }) => {
                let columns = line(min.x, max.x);
                let row = |(y, b): (f64, f64)| {
                    columns.iter().map(|&(x, a)| (DVec2::new(x, y), a * b)).collect()
                };
                line(min.y, max.y).into_iter().map(row).collect()
            }
            Self::Ring { inner, outer } => {
                let radii = line(inner, outer);
                let spokes = (n / 4).max(4);
                let wedge = 2.0 * PI / spokes as f64;
                let spoke = |k: usize| {
                    let angle = wedge * (k as f64 + 0.5);
                    let way = DVec2::new(cos(angle), sin(angle));
                    radii.iter().map(|&(r, w)| (way * r, wedge * w * r)).collect()
                };
                (0..spokes).map(spoke).collect()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reach_ends_on_the_rim() {
        let rect = Rect { min: DVec2::new(-1.0, -2.0), max: DVec2::new(3.0, 5.0) };
        for (way, exact) in [
            (DVec2::X, 3.0),
            (DVec2::NEG_X * 7.0, 1.0),
            (DVec2::Y, 5.0),
            (DVec2::new(3.0, -2.0), f64::sqrt(13.0)),
            (DVec2::new(-1.0, -1.0), f64::sqrt(2.0)),
        ] {
            assert!((Outline::Rect(rect).reach(way) - exact).abs() < 1e-14);
        }
    }

    /// Where the nearest place of the rim is a corner, the middle of a side, or of either circle.
    #[test]
    fn distances_have_a_sign() {
        let rect = Rect { min: DVec2::new(-1.0, -2.0), max: DVec2::new(3.0, 5.0) };
        let ring = Outline::Ring { inner: 1.0, outer: 3.0 };
        for (outline, at, exact) in [
            (Outline::Rect(rect), [6.0, 9.0], 5.0),
            (Outline::Rect(rect), [1.0, 5.5], 0.5),
            (Outline::Rect(rect), [3.0, 1.0], 0.0),
            (Outline::Rect(rect), [2.5, 1.0], -0.5),
            (Outline::Rect(rect), [0.0, -1.75], -0.25),
            (ring, [0.0, 4.0], 1.0),
            (ring, [0.0, 2.75], -0.25),
            (ring, [1.25, 0.0], -0.25),
            (ring, [0.5, 0.0], 0.5),
        ] {
            assert_eq!(outline.distance_outside(DVec2::from_array(at)), exact, "{at:?}");
        }
    }

    #[test]
    fn weights_sum_to_the_area_and_samples_reach_the_rim() {
        let rect = Rect { min: DVec2::new(-1.0, 2.0), max: DVec2::new(3.0, 5.0) };
        for outline in [
            Outline::Rect(rect),
            Outline::Ring { inner: 0.0, outer: 3.0 },
            Outline::Ring { inner: 1.0, outer: 3.0 },
        ] {
            let samples = outline.samples(20).concat();
            let sum: f64 = samples.iter().map(|s| s.1).sum();
            assert!((sum / outline.area() - 1.0).abs() < 1e-12);
            let farthest = samples.iter().map(|s| s.0.length()).fold(0.0, f64::max);
            let corner = if let Outline::Rect(rect) = outline { rect.max.length() } else { 3.0 };
            assert!((farthest - corner).abs() < 1e-12);
        }
    }

    #[test]
    fn weights_integrate_smooth_functions() {
        let rect = Rect { min: DVec2::new(-1.0, 2.0), max: DVec2::new(3.0, 5.0) };
        // The integrals of |p|^2.
        let ring = |a: f64, b: f64| 0.5 * PI * (b * b * b * b - a * a * a * a);
        for (outline, exact) in [
            (Outline::Rect(rect), 28.0 + 156.0),
            (Outline::Ring { inner: 0.0, outer: 3.0 }, ring(0.0, 3.0)),
            (Outline::Ring { inner: 1.0, outer: 3.0 }, ring(1.0, 3.0)),
        ] {
            let sum: f64 =
                outline.samples(4).concat().iter().map(|s| s.1 * s.0.length_squared()).sum();
            assert!((sum / exact - 1.0).abs() < 1e-14, "{outline:?}: {sum} {exact}");
        }
    }
}
