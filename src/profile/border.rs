//! The flat rim around a mirror, and what is drilled into it.

use crate::geom::{Contour, DVec2, Drilled, Outline};

/// A flat rim around the mirror, below it.
#[derive(Clone, Debug, PartialEq)]
pub struct BorderSpec {
    /// Width of the rim around the rectangle or circle that holds the mirror, in millimetres.
    pub width_mm: f64,
    /// Height of the rim over the base plane in millimetres; less than the part's base.
    pub rim_mm: f64,
    /// The radius of a rectangular part's corners in millimetres; 0 for sharp ones.
    pub corner_radius_mm: f64,
    /// Leg of the chamfers of 45 degrees along the outer edges in millimetres; 0 for sharp edges.
    pub edge_chamfer_mm: f64,
    /// Through holes, in the flat rim or in the land of an annulus.
    pub holes: Vec<Drilled>,
    /// Conical dimples of 90 degrees, half as deep as wide.
    pub marks: Vec<Drilled>,
}

/// Part of a border that does not fit around a mirror.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BorderFeature {
    /// The rounding of the corners.
    Corners,
    /// The chamfers of the outer edges.
    Edges,
    /// A hole, by its place in the list.
    Hole(usize),
    /// A mark, by its place in the list.
    Mark(usize),
    /// A hole of a table of its own, by its place among those.
    Drilling(usize),
}

/// A feature of a border that does not fit around a mirror, and what to do about it.
#[derive(Clone, Debug, PartialEq)]
pub struct BorderConflict {
    /// The feature to blame.
    pub feature: BorderFeature,
    /// The rule, and the value found.
    pub message: String,
    /// The remedy.
    pub hint: String,
}

impl BorderSpec {
    /// The least material between a hole or a mark and anything else, in millimetres.
    pub const CLEAR_MM: f64 = 0.1;
    /// Largest difference that is called rounding, mm.
    pub const ROUNDING_MM: f64 = 1e-6;
    /// The least width of a border and the least diameter or radius of anything in it, in
    /// millimetres.
    pub const LEAST_MM: f64 = 0.1;

    /// Everything that does not fit around a mirror with this outline, a rectangle or a ring about the axis.
    pub fn conflicts(&self, mirror: &Outline) -> Vec<BorderConflict> {
        // Where the edges leave nothing, the rest cannot be told.
        if let Some(conflict) = self.edges() {
            return vec![conflict];
        }
        let mut conflicts: Vec<BorderConflict> = self.corners(mirror).into_iter().collect();
        let holes = self.holes.iter().enumerate().map(|(k, spot)| (BorderFeature::Hole(k), spot));
        let marks = self.marks.iter().enumerate().map(|(k, spot)| (BorderFeature::Mark(k), spot));
        let mut before: Vec<(BorderFeature, &Drilled)> = Vec::new();
        for (feature, spot) in holes.chain(marks) {
            conflicts.extend(self.misplaced(mirror, &before, feature, spot));
            before.push((feature, spot));
        }
        conflicts
    }

    /// The part's outer side around a mirror with this outline.
    pub fn contour(&self, mirror: &Outline) -> Contour {
        match rim(mirror) {
            Contour::Rect { half, .. } => {
                let half = half + self.width_mm;
                let (corner, most) = (self.corner_radius_mm, half.min_element());
                // Arcs that meet but for rounding meet.
                let meet = (corner - most).abs() <= Self::ROUNDING_MM;
                Contour::Rect { half, corner_mm: if meet { most } else { corner } }
            }
            Contour::Circle { radius_mm } => {
                Contour::Circle { radius_mm: radius_mm + self.width_mm }
            }
        }
    }

    /// The edge of the flat rim and of the base around a mirror with this outline: within the chamfers of the part's edges.
    pub fn flat_contour(&self, mirror: &Outline) -> Contour {
        self.contour(mirror).shrunk(self.edge_chamfer_mm)
    }

    /// That edge, and what is within it, in words.
    pub(super) fn edge_words(&self) -> [&'static str; 2] {
        match self.edge_chamfer_mm > 0.0 {
            true => ["the chamfer of the part's edge", "flat rim and base reach"],
            false => ["the part's side", "the part reaches"],
        }
    }

    /// The conflict of the edges' chamfers with the rim's height, the border's width or the radius of rounded corners.
    pub(super) fn edges(&self) -> Option<BorderConflict> {
        let (leg, corner) = (self.edge_chamfer_mm, self.corner_radius_mm);
        // Each with what its chamfers take, and what has to be left.
        let mut rules = vec![
            ("rim_mm", self.rim_mm, 2.0, Self::CLEAR_MM, "side between them"),
            ("border_mm", self.width_mm, 1.0, Self::CLEAR_MM, "flat rim"),
        ];
        // (Sharp corners are mitred.)
        if corner > 0.0 {
            let least = Self::LEAST_MM;
            rules.push(("corner_radius_mm", corner, 1.0, least, "radius of the corners"));
        }
        let tight = |found: f64, share: f64, left: f64| {
            leg > 0.0 && !(found - share * leg >= left - Self::ROUNDING_MM)
        };
        let (key, found, _, left, what) =
            *rules.iter().find(|(_, found, share, left, _)| tight(*found, *share, *left))?;
        let room = rules.iter().map(|(_, found, share, left, _)| (found - left) / share);
        let most = room.fold(f64::INFINITY, f64::min);
        let most = ((most + Self::ROUNDING_MM) * 1e3).floor() / 1e3;
        Some(BorderConflict {
            feature: BorderFeature::Edges,
            message: format!(
                "part.edge_chamfer_mm must leave {left} mm of {what}, found {leg} for {key} = {found}"
            ),
            hint: match most >= Self::LEAST_MM {
                true => format!("set edge_chamfer_mm = {most}"),
                false => "leave edge_chamfer_mm out".to_owned(),
            },
        })
    }

    /// The conflict of the corners' rounding, with the part's sides or with the mirror's corners.
    fn corners(&self, mirror: &Outline) -> Option<BorderConflict> {
        let side = self.contour(mirror);
        let (Contour::Rect { half: corner, .. }, Contour::Rect { half, .. }) = (rim(mirror), side)
        else {
            return None;
        };
        let (radius, most) = (self.corner_radius_mm, half.min_element());
        let what = if radius > most + Self::ROUNDING_MM {
            format!("be at most half the part's shorter side, {most:.3} mm")
        } else if is_tight(self.flat_contour(mirror).inset(corner)) {
            format!("leave the mirror's corners {} mm of material", Self::CLEAR_MM)
        } else {
            return None;
        };
        Some(BorderConflict {
            feature: BorderFeature::Corners,
            message: format!("part.corner_radius_mm must {what}, found {radius}"),
            hint: match self.edge_chamfer_mm > 0.0 {
                true => "take a smaller radius, a smaller edge_chamfer_mm or a wider border_mm",
                false => "take a smaller radius or a wider border_mm",
            }
            .to_owned(),
        })
    }

    /// The conflict of a hole or mark with the mirror, with the part's side, or with those `before` it.
    pub(super) fn misplaced(
        &self,
        mirror: &Outline,
        before: &[(BorderFeature, &Drilled)],
        feature: BorderFeature,
        spot: &Drilled,
    ) -> Option<BorderConflict> {
        let conflict = |of: &str, gap: f64, hint: String| {
            is_tight(gap).then(|| too_close(feature, spot, of, gap, hint))
        };
        let name = feature.name();
        let (gap, hint) = self.gap_to_mirror(mirror, feature, spot);
        conflict("the mirror", gap, hint)
            .or_else(|| {
                let (flat, [edge, reaches]) = (self.flat_contour(mirror), self.edge_words());
                let hint = format!(
                    "{reaches} {}; move the {name} inwards, make it smaller or widen border_mm",
                    extent_text(&flat)
                );
                conflict(edge, flat.inset(spot.at) - spot.radius(), hint)
            })
            .or_else(|| {
                before.iter().find_map(|(other, there)| overlap((feature, spot), (*other, there)))
            })
    }

    /// Material between a feature and the mirror, mm, and what to do about too little of it.
    fn gap_to_mirror(
        &self,
        mirror: &Outline,
        feature: BorderFeature,
        spot: &Drilled,
    ) -> (f64, String) {
        match mirror {
            Outline::Ring { inner, .. }
                if !matches!(feature, BorderFeature::Mark(_)) && is_in_land(mirror, spot.at) =>
            {
                let hint = format!(
                    "the land inside the mirror reaches {inner:.3} mm from the axis; make the hole \
                     smaller"
                );
                (inner - spot.at.length() - spot.radius(), hint)
            }
            _ => {
                let rim = rim(mirror);
                let hint = format!(
                    "the mirror reaches {}; move the {} outwards or make it smaller",
                    extent_text(&rim),
                    feature.name()
                );
                (-rim.inset(spot.at) - spot.radius(), hint)
            }
        }
    }
}

impl BorderFeature {
    /// Its name in a complaint.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Corners => "corners",
            Self::Edges => "edges",
            Self::Hole(_) | Self::Drilling(_) => "hole",
            Self::Mark(_) => "mark",
        }
    }

    /// The key that says where it is.
    fn key(self) -> &'static str {
        match self {
            Self::Corners => "part.corner_radius_mm",
            Self::Edges => "part.edge_chamfer_mm",
            Self::Hole(_) => "part.holes_mm",
            Self::Mark(_) => "part.marks_mm",
            Self::Drilling(_) => "hole.at_mm",
        }
    }
}

/// Whether the centre of a hole is in the land inside a mirror with this outline.
pub fn is_in_land(mirror: &Outline, at: DVec2) -> bool {
    matches!(mirror, Outline::Ring { inner, .. } if at.length() < *inner)
}

/// The conflict of a feature with another one.
pub(super) fn overlap(
    (feature, spot): (BorderFeature, &Drilled),
    (other, there): (BorderFeature, &Drilled),
) -> Option<BorderConflict> {
    let gap = spot.at.distance(there.at) - spot.radius() - there.radius();
    let other = format!("the {} {}", other.name(), spot_text(there));
    let hint = "move one of them or make it smaller".to_owned();
    is_tight(gap).then(|| too_close(feature, spot, &other, gap, hint))
}

/// The conflict of a feature that leaves `gap` mm to what it must stay clear `of`.
pub(super) fn too_close(
    feature: BorderFeature,
    spot: &Drilled,
    of: &str,
    gap: f64,
    hint: String,
) -> BorderConflict {
    let key = feature.key();
    let found = if gap < 0.0 {
        format!("cuts {:.3} mm into it", -gap)
    } else {
        format!("leaves {gap:.3} mm")
    };
    let message = format!(
        "{key} must stay {} mm clear of {of}, found {}, which {found}",
        BorderSpec::CLEAR_MM,
        spot_text(spot)
    );
    BorderConflict { feature, message, hint }
}

/// Whether a gap is smaller than the clearance by more than rounding.
pub(super) fn is_tight(gap: f64) -> bool {
    !(gap >= BorderSpec::CLEAR_MM - BorderSpec::ROUNDING_MM)
}

/// The outer rim of a mirror about the axis.
pub(super) fn rim(mirror: &Outline) -> Contour {
    match *mirror {
        Outline::Rect(rect) => Contour::Rect { half: rect.max, corner_mm: 0.0 },
        Outline::Ring { outer, .. } => Contour::Circle { radius_mm: outer },
    }
}

/// A feature as a profile writes it.
fn spot_text(spot: &Drilled) -> String {
    format!("[{}, {}, {}]", spot.at.x, spot.at.y, spot.diameter_mm)
}

/// The extent of a contour in words.
pub(super) fn extent_text(contour: &Contour) -> String {
    match contour {
        Contour::Rect { half, .. } => format!("X = +-{:.3} and Y = +-{:.3} mm", half.x, half.y),
        Contour::Circle { radius_mm } => format!("{radius_mm:.3} mm from the axis"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Rect;

    fn border(corner_radius_mm: f64, holes: &[[f64; 3]], marks: &[[f64; 3]]) -> BorderSpec {
        let spots = |list: &[[f64; 3]]| {
            let spot =
                |&[x, y, diameter_mm]: &[f64; 3]| Drilled { at: DVec2::new(x, y), diameter_mm };
            list.iter().map(spot).collect()
        };
        let (holes, marks) = (spots(holes), spots(marks));
        BorderSpec {
            width_mm: 8.0,
            rim_mm: 2.0,
            corner_radius_mm,
            edge_chamfer_mm: 0.0,
            holes,
            marks,
        }
    }

    const HALF: DVec2 = DVec2::new(30.0, 20.0);
    const RECT: Outline = Outline::Rect(Rect { min: DVec2::new(-30.0, -20.0), max: HALF });
    const ROUND: Outline = Outline::Ring { inner: 5.0, outer: 30.0 };

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

    fn chamfered(leg: f64, corner: f64) -> BorderSpec {
        BorderSpec { edge_chamfer_mm: leg, ..border(corner, &[], &[]) }
    }

    /// A rim 2 mm high and a border 8 mm wide; what the hint says fits.
    #[test]
    fn chamfers_leave_something_of_side_rim_and_corners() {
        let found = |spec: &BorderSpec| {
            let conflicts = spec.conflicts(&RECT);
            conflicts.into_iter().next().map(|c| (c.feature, c.message, c.hint))
        };
        let side = BorderSpec { rim_mm: 99.0, ..chamfered(7.9, 0.0) };
        let (rim, corner) = (chamfered(0.95, 0.0), chamfered(0.5, 0.6));
        for (spec, message, hint) in [
            (
                &rim,
                "0.1 mm of side between them, found 0.9501 for rim_mm = 2",
                "set edge_chamfer_mm = 0.95",
            ),
            (
                &side,
                "0.1 mm of flat rim, found 7.9001 for border_mm = 8",
                "set edge_chamfer_mm = 7.9",
            ),
            (
                &corner,
                "0.1 mm of radius of the corners, found 0.5001 for corner_radius_mm = 0.6",
                "set edge_chamfer_mm = 0.5",
            ),
        ] {
            assert_eq!(found(spec), None);
            let larger =
                BorderSpec { edge_chamfer_mm: spec.edge_chamfer_mm + 1e-4, ..spec.clone() };
            let wanted = format!("part.edge_chamfer_mm must leave {message}");
            assert_eq!(found(&larger), Some((BorderFeature::Edges, wanted, hint.to_owned())));
        }
        let thin = BorderSpec { rim_mm: 0.25, ..chamfered(0.2, 0.0) };
        assert_eq!(found(&thin).unwrap().2, "leave edge_chamfer_mm out");
    }

    /// Each is just far enough away from the chamfer of the edge, and a little larger one is not.
    #[test]
    fn holes_and_marks_stay_clear_of_chamfered_edges() {
        for (mirror, corner, [x, y], widest) in [
            (RECT, 0.0, [37.0, 0.0], 1.0),
            (RECT, 0.0, [36.5, 27.0], 1.0),
            // 5 mm from the arc's centre.
            (RECT, 8.0, [33.0, 24.0], 2.0 * (8.0 - 5.0 - 0.5)),
            (ROUND, 0.0, [0.0, 37.0], 1.0),
        ] {
            let fits = |clear: f64| {
                let d = widest - 2.0 * clear;
                let spots: &[[f64; 3]] = &[[x, y, d]];
                [(spots, &[][..]), (&[], spots)].map(|(holes, marks)| {
                    let spec = BorderSpec { edge_chamfer_mm: 0.5, ..border(corner, holes, marks) };
                    let conflicts = spec.conflicts(&mirror);
                    let said = conflicts.first().map(|conflict| conflict.message.clone());
                    said.is_none_or(|said| {
                        assert!(said.contains("clear of the chamfer of the part's edge"), "{said}");
                        false
                    })
                })
            };
            assert_eq!([fits(0.1 + 1e-5), fits(0.1 - 1e-5)], [[true; 2], [false; 2]], "{x} {y}");
        }
        // The mirror's corner is (c - 8) sqrt(2) from an arc's centre, and 0.5 mm nearer to the flat rim's edge.
        let most = (8.0 * f64::sqrt(2.0) - 0.6) / (f64::sqrt(2.0) - 1.0);
        let conflict = |c: f64| chamfered(0.5, c).conflicts(&RECT).pop().map(|c| c.feature);
        assert_eq!(conflict(most - 1e-4), None);
        assert_eq!(conflict(most + 1e-4), Some(BorderFeature::Corners));
    }
}
