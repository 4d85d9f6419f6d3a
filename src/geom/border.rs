//! What a part has around its mirror: a flat rim to clamp it by, holes, marks.

use super::circle_polygon::{arc, area, circle, turned};
use super::{DVec2, DVec3, Hole, HoleMeridian};
use std::f64::consts::PI;

/// Material around the mirror, in the part frame, mm. Seen from above it lies between the foot of the mirror's
/// skirt and the contour; its flat top is below the mirror's lowest point, so that a skirt goes all around the mirror.
#[derive(Debug, Clone, PartialEq)]
pub struct Border {
    /// The part's outer side, a vertical wall.
    pub contour: Contour,
    /// Z of the flat top, positive.
    pub top_mm: f64,
    /// Through holes, from the base to the flat top.
    pub holes: Vec<Hole>,
    /// Conical dimples of 90 degrees in the flat top: half as deep as wide.
    pub marks: Vec<Drilled>,
    /// The flat land inside a ring, where holes go through it.
    pub land: Option<Land>,
}

/// A flat land with holes, through which a camera may look.
#[derive(Debug, Clone, PartialEq)]
pub struct Land {
    /// Its Z.
    pub z_mm: f64,
    /// Through holes, from the base to the land; at least one.
    pub holes: Vec<Hole>,
}

/// A contour about the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Contour {
    /// A rectangle.
    Rect {
        /// Half its width and half its height.
        half: DVec2,
        /// The radius that its corners are rounded with; 0 for sharp ones.
        corner_mm: f64,
    },
    /// A circle.
    Circle {
        /// Its radius.
        radius_mm: f64,
    },
}

/// A mark in the flat top.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drilled {
    /// X and Y of its centre.
    pub at: DVec2,
    /// Its diameter in the flat top.
    pub diameter_mm: f64,
}

impl Border {
    /// Its volume, mm^3, around a part that holds `footprint_mm2` of each horizontal plane below its flat top, in the mean.
    #[must_use]
    pub fn volume(&self, footprint_mm2: f64) -> f64 {
        let marks = self.marks_with(|mark| PI * mark.radius() * mark.radius());
        let cut = self.through().map(|hole| hole.volume()).sum::<f64>() + marks;
        self.top_mm * (self.contour.area() - footprint_mm2) - cut
    }

    /// What chords in the place of its circles may change its volume by, mm^3.
    #[must_use]
    pub fn chords_mm3(&self) -> f64 {
        let polygon = area(&self.contour.polygon());
        let marks = self.marks_with(|mark| {
            PI * mark.radius() * mark.radius() - area(&mark.polygon(DVec2::ZERO))
        });
        let cut = self.through().map(|hole| hole.chords_mm3()).sum::<f64>() + marks;
        self.top_mm * (self.contour.area() - polygon) + cut
    }

    /// The volume of all marks, of such areas: a cone's is a third of its depth, which is its radius, times its area.
    fn marks_with(&self, area: impl Fn(&Drilled) -> f64) -> f64 {
        self.marks.iter().map(|mark| mark.radius() / 3.0 * area(mark)).sum()
    }

    /// The surfaces of all through holes: those of the flat top, then those of the land.
    pub fn through(&self) -> impl Iterator<Item = HoleMeridian> + '_ {
        let land = self.land.iter().flat_map(|l| l.holes.iter().map(|hole| hole.meridian(l.z_mm)));
        self.holes.iter().map(|hole| hole.meridian(self.top_mm)).chain(land)
    }

    /// How far `v` is from the border's surfaces, mm: flat top, side, base, holes, marks and a land
    /// with holes; blind holes open in the base. `beside` is how far outside the mirror's rim it is; under the mirror
    /// base and holes alone count, and the land if `v` is `over_land`.
    #[must_use]
    pub fn distance(&self, v: DVec3, beside: f64, over_land: bool, blind: &[HoleMeridian]) -> f64 {
        let p = v.truncate();
        let inset = self.contour.inset(p);
        let off = |across: f64, along: f64| DVec2::new(across, along).length();
        let upright = |across: f64, top: f64| off(across, v.z - v.z.clamp(0.0, top));
        // How far out of the base and of the planes above, in the plane.
        let mut off_base = (-inset).max(0.0);
        let mut off_upper = off_base;
        let mut least = upright(inset, self.top_mm);
        for hole in self.through().chain(blind.iter().copied()) {
            let from_axis = p.distance(hole.axis);
            off_base = off_base.max(hole.mouth_radius() - from_axis);
            off_upper = off_upper.max(hole.upper_radius() - from_axis);
            least = least.min(hole.distance(v));
        }
        if let Some(land) = self.land.as_ref().filter(|_| over_land) {
            least = least.min(off(off_upper, v.z - land.z_mm));
        }
        let mut off_top = off_upper.max(-beside);
        for mark in &self.marks {
            let from_axis = p.distance(mark.at);
            let inside = mark.radius() - from_axis;
            off_top = off_top.max(inside);
            let cone = self.top_mm - inside.max(0.0);
            least = least.min(off((-inside).max(0.0), v.z - cone));
        }
        least.min(off(off_base, v.z)).min(off(off_top, v.z - self.top_mm))
    }
}

impl Contour {
    /// Area, mm^2.
    #[must_use]
    pub fn area(&self) -> f64 {
        match *self {
            Self::Rect { half, corner_mm } => {
                4.0 * half.x * half.y - (4.0 - PI) * corner_mm * corner_mm
            }
            Self::Circle { radius_mm } => PI * radius_mm * radius_mm,
        }
    }

    /// How far inside it `p` is, mm; negative outside.
    #[must_use]
    pub fn inset(&self, p: DVec2) -> f64 {
        match *self {
            Self::Rect { half, corner_mm } => {
                let past = p.abs() - half + corner_mm;
                corner_mm - past.max(DVec2::ZERO).length() - past.max_element().min(0.0)
            }
            Self::Circle { radius_mm } => radius_mm - p.length(),
        }
    }

    /// It as a polygon, counter-clockwise, its corners on it.
    #[must_use]
    pub fn polygon(&self) -> Vec<DVec2> {
        let Self::Rect { half, corner_mm } = *self else {
            let Self::Circle { radius_mm } = *self else { unreachable!("two kinds") };
            return circle(radius_mm);
        };
        let signs = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
        let around = signs.iter().enumerate().flat_map(|(quarter, &(x, y))| {
            let centre = (half - corner_mm) * DVec2::new(x, y);
            turned(&arc(corner_mm), quarter).map(move |p| centre + p).collect::<Vec<_>>()
        });
        // Arcs that take up a whole side meet in one corner.
        let mut corners: Vec<DVec2> = around.collect();
        corners.dedup();
        if corners.first() == corners.last() {
            corners.pop();
        }
        corners
    }
}

impl Drilled {
    /// Half its diameter, mm.
    #[must_use]
    pub fn radius(&self) -> f64 {
        0.5 * self.diameter_mm
    }

    /// Its circle about `centre` as a polygon, counter-clockwise, its corners on it.
    #[must_use]
    pub fn polygon(&self, centre: DVec2) -> Vec<DVec2> {
        circle(self.radius()).into_iter().map(|p| centre + p).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::CHORD_MM;
    use super::*;

    fn contours() -> [Contour; 5] {
        let rect = |x, y, corner_mm| Contour::Rect { half: DVec2::new(x, y), corner_mm };
        [
            Contour::Circle { radius_mm: 7.0 },
            rect(9.0, 5.0, 0.0),
            rect(9.0, 5.0, 2.0),
            rect(9.0, 5.0, 5.0),
            rect(5.0, 5.0, 5.0),
        ]
    }

    #[test]
    fn polygons_keep_to_their_contours() {
        for contour in contours() {
            let corners = contour.polygon();
            let next = corners.iter().cycle().skip(1);
            for (a, b) in corners.iter().zip(next) {
                assert!(contour.inset(*a).abs() < 1e-14 && a != b, "{contour:?} {a}");
                let cut = contour.inset(0.5 * (*a + *b));
                assert!((-1e-14..=CHORD_MM).contains(&cut), "{contour:?}: {cut}");
                assert!(a.perp_dot(*b) > 0.0);
            }
            let lost = contour.area() - area(&corners);
            let rounded = contour.area() < 100.0 || corners.len() > 4;
            assert!((-1e-12..60.0 * CHORD_MM).contains(&lost), "{contour:?}: {lost}");
            assert_eq!(lost > 1e-6, rounded, "{contour:?}: {lost}");
        }
        let Contour::Rect { .. } = contours()[4] else { panic!() };
        assert_eq!(contours()[4].polygon().len(), circle(5.0).len());
        assert_eq!(contours()[1].polygon().len(), 4);
    }

    /// A plate with everything, by hand.
    #[test]
    fn volumes_and_distances_are_those_of_a_plate() {
        let drilled = |x, y, diameter_mm| Drilled { at: DVec2::new(x, y), diameter_mm };
        let stock = Border {
            contour: Contour::Rect { half: DVec2::new(20.0, 10.0), corner_mm: 3.0 },
            top_mm: 4.0,
            holes: vec![Hole::plain(DVec2::new(16.0, 0.0), 4.0)],
            marks: vec![drilled(-16.0, 2.0, 2.0)],
            land: Some(Land { z_mm: 6.0, holes: vec![Hole::plain(DVec2::ZERO, 2.0)] }),
        };
        let exact = 4.0 * (800.0 - 9.0 * (4.0 - PI) - 200.0 - 4.0 * PI) - PI / 3.0 - 6.0 * PI;
        assert!((stock.volume(200.0) - exact).abs() < 1e-11);
        assert!(stock.chords_mm3() > 0.0 && stock.chords_mm3() < 4.0 * 32.0 * CHORD_MM);
        for (x, y, z, beside, off) in [
            // On the flat top, the base, the side, a hole's wall, a mark's tip and flank.
            (0.0, 8.0, 4.0, 3.0, 0.0),
            (0.0, 3.0, 0.0, -5.0, 0.0),
            (20.0, 0.0, 1.0, 10.0, 0.0),
            (14.0, 0.0, 3.0, 4.0, 0.0),
            (-16.0, 2.0, 3.0, 6.0, 0.0),
            (-15.5, 2.0, 3.5, 6.0, 0.0),
            // Above the top; in a hole; at the mouth of a mark; under the mirror; past a corner.
            (0.0, 8.0, 4.25, 3.0, 0.25),
            (15.0, 0.0, 4.0, 5.0, 1.0),
            (-16.0, 2.0, 4.0, 6.0, 1.0),
            (0.0, 5.0, 4.0, -2.5, 2.5),
            // On the land and its hole's wall; above it; in the hole.
            (3.0, 0.0, 6.0, -5.0, 0.0),
            (0.0, -1.0, 5.0, -5.0, 0.0),
            (3.0, 0.0, 6.5, -5.0, 0.5),
            (0.0, 0.5, 6.0, -5.0, 0.5),
            (17.0 + 3.0, 7.0 + 4.0, 2.0, 9.0, 2.0),
        ] {
            let over_land = f64::max(f64::abs(x), f64::abs(y)) < 4.0;
            let found = stock.distance(DVec3::new(x, y, z), beside, over_land, &[]);
            assert!((found - off).abs() < 1e-13, "({x}, {y}, {z}): {found}, not {off}");
        }
    }
}
