//! Rims of the designed panel as curves of one parameter, for the search of contacts on them.

use crate::geom::{DVec2, Outline, Rect};
use crate::num::{atan2, cos, sin};
use std::f64::consts::TAU;

/// Least number of steps along an edge.
const LEAST_STEPS: f64 = 4.0;

/// The course of an edge in the chart's coordinates.
#[derive(Debug, Clone, Copy)]
enum Course {
    /// A straight side, from one corner to the next.
    Line(DVec2, DVec2),
    /// A circle of this radius about the axis, from the X axis counter-clockwise.
    Circle(f64),
}

/// A side of the designed panel's outline, or a round rim, divided evenly.
#[derive(Debug, Clone, Copy)]
pub(super) struct RimEdge {
    course: Course,
    pub steps: usize,
}

impl RimEdge {
    /// The edges of `outline`, in steps of at most `step` mm: sides in their order counter-clockwise.
    pub(super) fn all(outline: &Outline, step: f64) -> Vec<Self> {
        let steps = |length: f64| (length / step).ceil().max(LEAST_STEPS) as usize;
        match *outline {
            Outline::Rect(Rect { min, max }) => {
                let corners = [min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)];
                let side = |k: usize| {
                    let (from, to) = (corners[k], corners[(k + 1) % 4]);
                    Self { course: Course::Line(from, to), steps: steps((to - from).length()) }
                };
                (0..4).map(side).collect()
            }
            Outline::Ring { inner, outer } => [outer, inner]
                .into_iter()
                .filter(|radius| *radius > 0.0)
                .map(|radius| Self { course: Course::Circle(radius), steps: steps(TAU * radius) })
                .collect(),
        }
    }

    /// The place of the chart `t` steps along the edge.
    pub(super) fn at(&self, t: f64) -> DVec2 {
        let share = t / self.steps as f64;
        match self.course {
            Course::Line(from, to) => from.lerp(to, share),
            Course::Circle(radius) => DVec2::new(cos(TAU * share), sin(TAU * share)) * radius,
        }
    }

    pub(super) fn is_closed(&self) -> bool {
        matches!(self.course, Course::Circle(_))
    }

    /// The place of the edge nearest to `q`, in steps, and its distance, mm.
    pub(super) fn nearest(&self, q: DVec2) -> (f64, f64) {
        let (share, off) = match self.course {
            Course::Line(from, to) => {
                let way = to - from;
                let share = ((q - from).dot(way) / way.length_squared()).clamp(0.0, 1.0);
                (share, (from.lerp(to, share) - q).length())
            }
            Course::Circle(radius) => {
                (atan2(q.y, q.x).rem_euclid(TAU) / TAU, (q.length() - radius).abs())
            }
        };
        (share * self.steps as f64, off)
    }
}

/// The direction from `q` on the rim into the region, of about unit length; what is nearer to a side than `hair` mm
/// is on it.
pub(super) fn inward_direction(outline: &Outline, q: DVec2, hair: f64) -> DVec2 {
    match *outline {
        Outline::Rect(Rect { min, max }) => {
            let away = |q: f64, lo: f64, hi: f64| {
                if q - lo < hair {
                    1.0
                } else if hi - q < hair {
                    -1.0
                } else {
                    0.0
                }
            };
            DVec2::new(away(q.x, min.x, max.x), away(q.y, min.y, max.y))
        }
        Outline::Ring { inner, outer } => {
            let out = q.normalize_or_zero();
            if q.length() > 0.5 * (inner + outer) { -out } else { out }
        }
    }
}
