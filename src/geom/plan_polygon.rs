//! A closed polygon in the plan.

use super::{DVec2, Rect};

/// A polygon, mm, by its corners in order.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanPolygon(pub Vec<DVec2>);

impl PlanPolygon {
    /// Distance of `p` inside it, mm; negative outside.
    #[must_use]
    pub fn inset(&self, p: DVec2) -> f64 {
        let next = self.0.iter().cycle().skip(1);
        let (mut nearest, mut is_inside) = (f64::INFINITY, false);
        for (&a, &b) in self.0.iter().zip(next) {
            let along = b - a;
            let square = along.length_squared();
            let share =
                if square > 0.0 { ((p - a).dot(along) / square).clamp(0.0, 1.0) } else { 0.0 };
            nearest = nearest.min(p.distance(a + along * share));
            // Sides that a ray from `p` towards +X crosses.
            if (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / along.y * along.x {
                is_inside = !is_inside;
            }
        }
        if is_inside { nearest } else { -nearest }
    }

    /// The rectangle along X and Y around it.
    #[must_use]
    pub fn bounds(&self) -> Rect {
        let none = Rect { min: DVec2::INFINITY, max: DVec2::NEG_INFINITY };
        let around = |all: Rect, p: &DVec2| Rect { min: all.min.min(*p), max: all.max.max(*p) };
        self.0.iter().fold(none, around)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn insets_are_distances_from_the_nearest_side() {
        let corners = [(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (2.0, 1.0), (0.0, 3.0)];
        let polygon = PlanPolygon(corners.map(DVec2::from).to_vec());
        for (x, y, inset) in [
            (2.0, 0.5, 0.5),
            (0.5, 1.0, 0.5),
            (2.0, 2.0, -f64::sqrt(0.5)),
            (-1.0, 1.0, -1.0),
            (2.0, 0.0, 0.0),
            (5.0, -1.0, -f64::sqrt(2.0)),
        ] {
            let found = polygon.inset(DVec2::new(x, y));
            assert!((found - inset).abs() < 1e-15, "({x}, {y}): {found}, not {inset}");
        }
        let Rect { min, max } = polygon.bounds();
        assert_eq!((min, max), (DVec2::ZERO, DVec2::new(4.0, 3.0)));
    }
}
