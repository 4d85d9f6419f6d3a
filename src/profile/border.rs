//! The flat rim around a mirror, and what is drilled into it.

use crate::num::hypot;

/// A flat rim around the mirror, below it.
#[derive(Clone, Debug, PartialEq)]
pub struct BorderSpec {
    /// Width of the rim around the rectangle or circle that holds the mirror, in millimetres.
    pub width_mm: f64,
    /// Height of the rim over the base plane in millimetres; less than the part's base.
    pub rim_mm: f64,
    /// The radius of a rectangular part's corners in millimetres; 0 for sharp ones.
    pub corner_radius_mm: f64,
    /// Through holes, in the flat rim or in the land of an annulus.
    pub holes: Vec<Spot>,
    /// Conical dimples of 90 degrees, half as deep as wide.
    pub marks: Vec<Spot>,
}

/// A round feature in the flat rim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// X of its centre in millimetres.
    pub x_mm: f64,
    /// Y of its centre in millimetres.
    pub y_mm: f64,
    /// Its diameter in millimetres.
    pub diameter_mm: f64,
}

impl Spot {
    /// The distance of its centre from the axis, mm.
    #[must_use]
    pub fn from_axis_mm(&self) -> f64 {
        (self.x_mm * self.x_mm + self.y_mm * self.y_mm).sqrt()
    }
}

/// What the mirror covers of the (X, Y) plane, or the part does: a shape about the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Footprint {
    /// A rectangle, or one around it.
    Rect {
        /// Half its width and half its height in millimetres.
        half_mm: [f64; 2],
    },
    /// A circle.
    Round {
        /// Its radius in millimetres.
        radius_mm: f64,
        /// The radius of the land inside it; 0 for none.
        land_mm: f64,
    },
}

/// What of a border does not fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BorderFeature {
    /// The rounding of the corners.
    Corners,
    /// A hole, by its place in the list.
    Hole(usize),
    /// A mark, by its place in the list.
    Mark(usize),
}

/// Why a border does not fit around a mirror.
#[derive(Clone, Debug, PartialEq)]
pub struct BorderConflict {
    /// What is to blame.
    pub feature: BorderFeature,
    /// What must hold and what was found.
    pub message: String,
    /// What to do about it.
    pub hint: String,
}

impl BorderSpec {
    /// The least material between a hole or a mark and anything else, in millimetres.
    pub const CLEAR_MM: f64 = 0.1;
    /// What differs by less is the same but for rounding, mm.
    pub const ROUNDING_MM: f64 = 1e-6;
    /// The least width of a border and the least diameter or radius of anything in it, in
    /// millimetres.
    pub const LEAST_MM: f64 = 0.1;

    /// Everything that does not fit around a mirror with this footprint.
    pub fn conflicts(&self, mirror: &Footprint) -> Vec<BorderConflict> {
        let mut conflicts: Vec<BorderConflict> = self.corners(mirror).into_iter().collect();
        let holes = self.holes.iter().enumerate().map(|(k, spot)| (BorderFeature::Hole(k), spot));
        let marks = self.marks.iter().enumerate().map(|(k, spot)| (BorderFeature::Mark(k), spot));
        let mut before: Vec<(BorderFeature, &Spot)> = Vec::new();
        for (feature, spot) in holes.chain(marks) {
            conflicts.extend(self.misplaced(mirror, &before, feature, spot));
            before.push((feature, spot));
        }
        conflicts
    }

    /// The part's outer side.
    fn side(&self, mirror: &Footprint) -> Footprint {
        match *mirror {
            Footprint::Rect { half_mm: [x, y] } => {
                Footprint::Rect { half_mm: [x + self.width_mm, y + self.width_mm] }
            }
            Footprint::Round { radius_mm, .. } => {
                Footprint::Round { radius_mm: radius_mm + self.width_mm, land_mm: 0.0 }
            }
        }
    }

    fn corners(&self, mirror: &Footprint) -> Option<BorderConflict> {
        let (Footprint::Rect { half_mm }, Footprint::Rect { half_mm: [x, y] }) =
            (mirror, self.side(mirror))
        else {
            return None;
        };
        let radius = self.corner_radius_mm;
        let beside = -self.side(mirror).outside(*half_mm, radius);
        let what = if radius > x.min(y) + Self::ROUNDING_MM {
            format!("be at most half the part's shorter side, {:.3} mm", x.min(y))
        } else if tight(beside) {
            format!("leave the mirror's corners {} mm of material", Self::CLEAR_MM)
        } else {
            return None;
        };
        Some(BorderConflict {
            feature: BorderFeature::Corners,
            message: format!("part.corner_radius_mm must {what}, found {radius}"),
            hint: "take a smaller radius or a wider border_mm".to_owned(),
        })
    }

    /// What is wrong with the place of a hole or mark.
    fn misplaced(
        &self,
        mirror: &Footprint,
        before: &[(BorderFeature, &Spot)],
        feature: BorderFeature,
        spot: &Spot,
    ) -> Option<BorderConflict> {
        let (key, name) = match feature {
            BorderFeature::Hole(_) => ("part.holes_mm", "hole"),
            _ => ("part.marks_mm", "mark"),
        };
        let (at, radius) = ([spot.x_mm, spot.y_mm], 0.5 * spot.diameter_mm);
        let side = self.side(mirror);
        let conflict = |of: &str, gap: f64, hint: String| BorderConflict {
            feature,
            message: format!(
                "{key} must stay {} mm clear of {of}, found {}, which {}",
                Self::CLEAR_MM,
                spot.text(),
                if gap < 0.0 {
                    format!("cuts {:.3} mm into it", -gap)
                } else {
                    format!("leaves {gap:.3} mm")
                }
            ),
            hint,
        };
        let gap = mirror.outside(at, 0.0) - radius;
        if let (BorderFeature::Hole(_), Footprint::Round { land_mm, .. }, true) =
            (feature, mirror, mirror.has_in_land(spot))
        {
            let gap = land_mm - hypot(spot.x_mm, spot.y_mm) - radius;
            if tight(gap) {
                let hint = format!(
                    "the land inside the mirror reaches {land_mm:.3} mm from the axis; make the hole \
                     smaller"
                );
                return Some(conflict("the mirror", gap, hint));
            }
        } else if tight(gap) {
            let hint = format!(
                "the mirror reaches {}; move the {name} outwards or make it smaller",
                mirror.reach()
            );
            return Some(conflict("the mirror", gap, hint));
        }
        let gap = -side.outside(at, self.corner_radius_mm) - radius;
        if tight(gap) {
            let hint = format!(
                "the part reaches {}; move the {name} inwards, make it smaller or widen border_mm",
                side.reach()
            );
            return Some(conflict("the part's side", gap, hint));
        }
        before.iter().find_map(|(other, there)| {
            let gap = spot.distance(there) - radius - 0.5 * there.diameter_mm;
            let other = if matches!(other, BorderFeature::Hole(_)) { "hole" } else { "mark" };
            let hint = "move one of them or make it smaller".to_owned();
            tight(gap).then(|| conflict(&format!("the {other} {}", there.text()), gap, hint))
        })
    }
}

/// Whether a gap is smaller than the clearance by more than rounding.
fn tight(gap: f64) -> bool {
    !(gap >= BorderSpec::CLEAR_MM - BorderSpec::ROUNDING_MM)
}

impl Spot {
    fn text(&self) -> String {
        format!("[{}, {}, {}]", self.x_mm, self.y_mm, self.diameter_mm)
    }

    fn distance(&self, other: &Self) -> f64 {
        hypot(self.x_mm - other.x_mm, self.y_mm - other.y_mm)
    }
}

impl Footprint {
    /// How far outside a place is, negative inside; a rectangle's corners are rounded with this
    /// radius.
    fn outside(&self, [x, y]: [f64; 2], corner: f64) -> f64 {
        match *self {
            Self::Rect { half_mm: [half_x, half_y] } => {
                let (x, y) = (x.abs() - half_x + corner, y.abs() - half_y + corner);
                hypot(x.max(0.0), y.max(0.0)) + x.max(y).min(0.0) - corner
            }
            Self::Round { radius_mm, .. } => hypot(x, y) - radius_mm,
        }
    }

    /// Whether the centre of a hole is in the land inside the mirror.
    pub fn has_in_land(&self, hole: &Spot) -> bool {
        let Self::Round { land_mm, .. } = *self else { return false };
        hypot(hole.x_mm, hole.y_mm) < land_mm
    }

    /// How far it reaches, in words.
    fn reach(&self) -> String {
        match self {
            Self::Rect { half_mm: [x, y] } => format!("X = +-{x:.3} and Y = +-{y:.3} mm"),
            Self::Round { radius_mm, .. } => format!("{radius_mm:.3} mm from the axis"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn border(corner_radius_mm: f64, holes: &[[f64; 3]], marks: &[[f64; 3]]) -> BorderSpec {
        let spots = |list: &[[f64; 3]]| {
            let spot = |&[x_mm, y_mm, diameter_mm]: &[f64; 3]| Spot { x_mm, y_mm, diameter_mm };
            list.iter().map(spot).collect()
        };
        let (holes, marks) = (spots(holes), spots(marks));
        BorderSpec { width_mm: 8.0, rim_mm: 2.0, corner_radius_mm, holes, marks }
    }

    const RECT: Footprint = Footprint::Rect { half_mm: [30.0, 20.0] };
    const ROUND: Footprint = Footprint::Round { radius_mm: 30.0, land_mm: 5.0 };

    /// Each is just far enough away, and a little larger one is not.
    #[test]
    fn the_clearance_is_the_same_on_all_sides() {
        let on_diagonal = (30.0 + 4.0) / f64::sqrt(2.0);
        for (mirror, corner, [x, y], widest) in [
            (RECT, 0.0, [34.0, 0.0], 7.8),
            (RECT, 0.0, [-33.0, 19.0], 5.8),
            (RECT, 0.0, [0.0, -25.0], 5.8),
            (RECT, 0.0, [33.0, 24.0], 7.8),
            // Across the rounded corner: 5 mm from the arc's centre towards it.
            (RECT, 8.0, [33.0, 24.0], 2.0 * (8.0 - 5.0 - 0.1)),
            (ROUND, 0.0, [on_diagonal, -on_diagonal], 7.8),
            (ROUND, 0.0, [0.0, 33.0], 5.8),
            (ROUND, 0.0, [0.0, 0.0], 9.8),
            (ROUND, 0.0, [-3.0, 1.0], 2.0 * (4.9 - f64::sqrt(10.0))),
        ] {
            let found = |d: f64| {
                let holes = border(corner, &[[x, y, d]], &[]).conflicts(&mirror);
                let marks = border(corner, &[], &[[x, y, d]]).conflicts(&mirror);
                // Nobody sees a mark in the land.
                assert!(holes.len() == marks.len() || marks.len() == 1 && f64::abs(x) < 5.0);
                holes.first().map(|conflict| conflict.feature)
            };
            assert_eq!(found(widest - 1e-5), None, "{x} {y}");
            assert_eq!(found(widest + 1e-5), Some(BorderFeature::Hole(0)), "{x} {y}");
        }
    }

    #[test]
    fn misfits_say_where_and_what_to_do() {
        let found = |holes: &[[f64; 3]], marks: &[[f64; 3]]| -> Vec<String> {
            let conflicts = border(0.0, holes, marks).conflicts(&RECT);
            conflicts
                .into_iter()
                .map(|m| format!("{:?}: {}; {}", m.feature, m.message, m.hint))
                .collect()
        };
        assert_eq!(
            found(&[[20.0, 3.0, 4.0], [34.0, 0.0, 4.0]], &[[34.0, 3.05, 2.0], [37.5, 20.0, 1.0]]),
            [
                "Hole(0): part.holes_mm must stay 0.1 mm clear of the mirror, found [20, 3, 4], which \
                 cuts 12.000 mm into it; the mirror reaches X = +-30.000 and Y = +-20.000 mm; move the \
                 hole outwards or make it smaller",
                "Mark(0): part.marks_mm must stay 0.1 mm clear of the hole [34, 0, 4], found \
                 [34, 3.05, 2], which leaves 0.050 mm; move one of them or make it smaller",
                "Mark(1): part.marks_mm must stay 0.1 mm clear of the part's side, found \
                 [37.5, 20, 1], which leaves 0.000 mm; the part reaches X = +-38.000 and Y = \
                 +-28.000 mm; move the mark inwards, make it smaller or widen border_mm",
            ]
        );
    }

    #[test]
    fn corners_are_rounded_as_far_as_the_mirror_allows() {
        // The mirror's corner is (c - 8) sqrt(2) from an arc's centre.
        let most = (8.0 * f64::sqrt(2.0) - 0.1) / (f64::sqrt(2.0) - 1.0);
        let conflict =
            |c: f64| border(c, &[], &[]).conflicts(&RECT).pop().map(|conflict| conflict.message);
        assert_eq!(conflict(most - 1e-4), None);
        assert!(conflict(most + 1e-4).unwrap().contains("leave the mirror's corners 0.1 mm"));
        assert!(
            conflict(28.1).unwrap().contains("at most half the part's shorter side, 28.000 mm")
        );
        assert_eq!(border(99.0, &[], &[]).conflicts(&ROUND), []);
    }
}
