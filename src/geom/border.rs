//! What a part has around its mirror: a flat rim to clamp it by, holes, marks.

use super::circle_polygon::{area, circle};
use super::{Contour, DVec2, DVec3, Hole, HoleMeridian};
use std::f64::consts::PI;

/// Material around the mirror, in the part frame, mm. Seen from above it lies between the foot of the mirror's
/// skirt and the contour; its flat top is below the mirror's lowest point, so that a skirt goes all around the mirror.
#[derive(Debug, Clone, PartialEq)]
pub struct Border {
    /// The part's outer side, a vertical wall between the chamfers of its edges.
    pub contour: Contour,
    /// Z of the flat top, positive.
    pub top_mm: f64,
    /// Leg of the chamfers of 45 degrees along the upper and the lower edge of the side, mm; 0 for sharp edges.
    pub edge_chamfer_mm: f64,
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
        let edges = 2.0 * self.chamfer_with(|inset| self.contour.shrunk(inset).area());
        self.top_mm * (self.contour.area() - footprint_mm2) - cut - edges
    }

    /// What chords in the place of its circles may change its volume by, mm^3.
    #[must_use]
    pub fn chords_mm3(&self) -> f64 {
        let polygon = area(&self.contour.polygon());
        let marks = self.marks_with(|mark| {
            PI * mark.radius() * mark.radius() - area(&mark.polygon(DVec2::ZERO))
        });
        let cut = self.through().map(|hole| hole.chords_mm3()).sum::<f64>() + marks;
        let lost = |inset: f64| {
            self.contour.shrunk(inset).area() - area(&self.contour.shrunk_polygon(inset))
        };
        self.top_mm * (self.contour.area() - polygon) + cut - 2.0 * self.chamfer_with(lost)
    }

    /// What a chamfer takes off an edge of the side, mm^3, if the contour that is so far inside the part's has such an area,
    /// which is a polynomial of second degree: Simpson's rule is exact for it.
    fn chamfer_with(&self, area: impl Fn(f64) -> f64) -> f64 {
        let leg = self.edge_chamfer_mm;
        if leg == 0.0 {
            return 0.0;
        }
        let [outer, middle, inner] = [0.0, 0.5, 1.0].map(|share| area(share * leg));
        leg / 6.0 * (5.0 * outer - 4.0 * middle - inner)
    }

    /// The contour of the flat top and of the base: that of the side without the chamfers of its edges.
    #[must_use]
    pub fn flat_contour(&self) -> Contour {
        self.contour.shrunk(self.edge_chamfer_mm)
    }

    /// The edges of side and chamfers from the flat top down to the base: how far inside the contour, and Z, mm.
    #[must_use]
    pub fn side_edges(&self) -> Vec<DVec2> {
        let (leg, top) = (self.edge_chamfer_mm, self.top_mm);
        let [above, below] = [DVec2::new(leg, top), DVec2::new(leg, 0.0)];
        if leg == 0.0 {
            return vec![above, below];
        }
        vec![above, DVec2::new(0.0, top - leg), DVec2::new(0.0, leg), below]
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

    /// How far `v` is from the border's surfaces, mm: flat top, side with its chamfers, base, holes, marks and a land
    /// with holes; blind holes open in the base. `beside` is how far outside the mirror's rim it is; under the mirror
    /// base and holes alone count, and the land if `v` is `over_land`.
    #[must_use]
    pub fn distance(&self, v: DVec3, beside: f64, over_land: bool, blind: &[HoleMeridian]) -> f64 {
        let p = v.truncate();
        let leg = self.edge_chamfer_mm;
        let off = |across: f64, along: f64| DVec2::new(across, along).length();
        // How far out of the base and of the planes above, in the plane.
        let mut off_base = (-self.flat_contour().inset(p)).max(0.0);
        let mut off_upper = off_base;
        let mut least = off(self.contour.inset(p), v.z - v.z.clamp(leg, self.top_mm - leg));
        for height in [v.z, self.top_mm - v.z].into_iter().filter(|_| leg > 0.0) {
            least = least.min(self.contour.chamfer_distance(p, height, leg));
        }
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
    use super::super::{CHORD_MM, circle_polygon};
    use super::*;

    /// A plate with everything, by hand.
    #[test]
    fn volumes_and_distances_are_those_of_a_plate() {
        let drilled = |x, y, diameter_mm| Drilled { at: DVec2::new(x, y), diameter_mm };
        let stock = Border {
            contour: Contour::Rect { half: DVec2::new(20.0, 10.0), corner_mm: 3.0 },
            top_mm: 4.0,
            edge_chamfer_mm: 0.0,
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

    fn chamfered(contour: Contour) -> Border {
        Border {
            contour,
            top_mm: 4.0,
            edge_chamfer_mm: 0.75,
            holes: Vec::new(),
            marks: Vec::new(),
            land: None,
        }
    }

    /// Prisms along straight sides, less what they share at mitres; rings about round corners by Pappus' theorem, whose
    /// centre of mass is a third of the leg from the side.
    #[test]
    fn chamfers_take_off_prisms_and_rings() {
        let c: f64 = 0.75;
        let ring = |radius: f64| 2.0 * PI * (radius - c / 3.0) * 0.5 * c * c;
        for (x, y, corner_mm) in
            [(9.0, 5.0, 0.0), (9.0, 5.0, 2.0), (9.0, 5.0, 5.0), (5.0, 5.0, 5.0)]
        {
            let half = DVec2::new(x, y);
            let stock = chamfered(Contour::Rect { half, corner_mm });
            let straight = 4.0 * (x + y - 2.0 * corner_mm) * 0.5 * c * c;
            // Two wedges overlap at a sharp corner in a pyramid over a square of side c, c high.
            let corners = if corner_mm > 0.0 { ring(corner_mm) } else { -4.0 * c * c * c / 3.0 };
            let plate = 4.0 * stock.contour.area();
            let exact = plate - 2.0 * (straight + corners);
            let found = stock.volume(0.0);
            assert!(
                (found - exact).abs() < 1e-13 * exact,
                "{half} {corner_mm}: {found}, not {exact}"
            );
        }
        let stock = chamfered(Contour::Circle { radius_mm: 7.0 });
        let exact = 4.0 * PI * 49.0 - 2.0 * ring(7.0);
        assert!((stock.volume(0.0) - exact).abs() < 1e-13 * exact);
        // A polygon of n corners has the share sin(2 pi / n) n / (2 pi) of its circle at every height.
        let n = 4.0 * circle_polygon::circle_chords(7.0) as f64;
        let lost = 1.0 - crate::num::sin(2.0 * PI / n) * n / (2.0 * PI);
        assert!((stock.chords_mm3() / (lost * exact) - 1.0).abs() < 1e-9, "{lost:e}");
    }

    #[test]
    fn distances_from_chamfered_edges_are_those_by_hand() {
        let stock = chamfered(Contour::Rect { half: DVec2::new(9.0, 5.0), corner_mm: 2.0 });
        let diagonal = std::f64::consts::FRAC_1_SQRT_2;
        for (x, y, z, off) in [
            // Ends and middles of both chamfers, the side between them, the flat top and the base beside them.
            (9.0, 0.0, 0.75, 0.0),
            (8.25, 0.0, 0.0, 0.0),
            (9.0 - 0.25, 0.0, 3.5, 0.0),
            (9.0, 1.0, 2.0, 0.0),
            (8.0, 1.0, 4.0, 0.0),
            (8.0, 1.0, 0.0, 0.0),
            // On the cone about (7, 3), and the corner that was cut off.
            (7.0 + 1.5 * diagonal, 3.0 + 1.5 * diagonal, 0.25, 0.0),
            (9.0, 0.0, 0.0, 0.75 * diagonal),
            (9.0, 0.0, 4.0, 0.75 * diagonal),
            // Beside the side's ends and over the flat top's.
            (9.5, 0.0, 3.25, 0.5),
            (8.25, 0.0, 4.5, 0.5),
        ] {
            let found = stock.distance(DVec3::new(x, y, z), 5.0, false, &[]);
            assert!((found - off).abs() < 1e-14, "({x}, {y}, {z}): {found}, not {off}");
        }
        let sharp = chamfered(Contour::Rect { half: DVec2::new(9.0, 5.0), corner_mm: 0.0 });
        // The mitre leads from (9, 5) to (8.25, 4.25); the corner is as far from it as from the cube's diagonal.
        let corner = sharp.distance(DVec3::new(9.0, 5.0, 0.0), 5.0, false, &[]);
        assert!((corner - 0.75 * f64::sqrt(2.0 / 3.0)).abs() < 1e-14, "{corner}");
        assert_eq!(sharp.distance(DVec3::new(8.5, 4.5, 3.75), 5.0, false, &[]), 0.0);
    }
}
