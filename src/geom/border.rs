//! What a part has around its mirror: a flat rim to clamp it by, holes, marks.

use super::{DVec2, DVec3};
use crate::num::{cos, sin};
use std::f64::consts::{FRAC_PI_2, PI};

/// Material around the mirror, in the part frame, mm. Seen from above it lies between the foot of the mirror's
/// skirt and the contour; its flat top is below the mirror's lowest point, so that a skirt goes all around the mirror.
#[derive(Debug, Clone, PartialEq)]
pub struct Border {
    /// The part's outer side, a vertical wall.
    pub contour: Contour,
    /// Z of the flat top, positive.
    pub top_mm: f64,
    /// Through holes, from the base to the flat top.
    pub holes: Vec<Drilled>,
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
    pub holes: Vec<Drilled>,
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

/// A round feature in the flat top.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drilled {
    /// X and Y of its centre.
    pub at: DVec2,
    /// Its diameter in the flat top.
    pub diameter_mm: f64,
}

impl Border {
    /// The most by which the chords of a meshed circle cut inside it, mm. The chords' ends lie on
    /// the circle.
    pub const CHORD_MM: f64 = 2e-3;

    /// Its volume, mm^3, around a part that holds `footprint_mm2` of each horizontal plane below its flat top, in the mean.
    #[must_use]
    pub fn volume(&self, footprint_mm2: f64) -> f64 {
        let cut = self.cut(|round| PI * round.radius() * round.radius());
        self.top_mm * (self.contour.area() - footprint_mm2) - cut
    }

    /// What chords in the place of its circles may change its volume by, mm^3.
    #[must_use]
    pub fn chords_mm3(&self) -> f64 {
        let polygon = area(&self.contour.polygon());
        let cut = self
            .cut(|round| PI * round.radius() * round.radius() - area(&round.polygon(DVec2::ZERO)));
        self.top_mm * (self.contour.area() - polygon) + cut
    }

    /// The volume of all holes and marks, of such areas: a cone's is a third of its depth, which is
    /// its radius, times its area.
    fn cut(&self, area: impl Fn(&Drilled) -> f64) -> f64 {
        let holes: f64 = self.through().map(|(hole, z)| z * area(hole)).sum();
        holes + self.marks.iter().map(|mark| mark.radius() / 3.0 * area(mark)).sum::<f64>()
    }

    /// All through holes, each with the Z of its upper end: those of the flat top, then those of the
    /// land.
    pub fn through(&self) -> impl Iterator<Item = (&Drilled, f64)> {
        let land = self.land.iter().flat_map(|l| l.holes.iter().map(|hole| (hole, l.z_mm)));
        self.holes.iter().map(|hole| (hole, self.top_mm)).chain(land)
    }

    /// How far `v` is from the border's surfaces, mm: flat top, side, base, holes, marks and a land
    /// with holes. `beside` is how far outside the mirror's rim it is; under the mirror base and
    /// holes alone count, and the land if `v` is `over_land`.
    #[must_use]
    pub fn distance(&self, v: DVec3, beside: f64, over_land: bool) -> f64 {
        let p = v.truncate();
        let inset = self.contour.inset(p);
        let off = |across: f64, along: f64| DVec2::new(across, along).length();
        let upright = |across: f64, top: f64| off(across, v.z - v.z.clamp(0.0, top));
        // How far out of the base and of the flat top, in the plane.
        let mut off_base = (-inset).max(0.0);
        let mut least = upright(inset, self.top_mm);
        for (hole, top) in self.through() {
            let inside = hole.radius() - p.distance(hole.at);
            off_base = off_base.max(inside);
            least = least.min(upright(inside, top));
        }
        if let Some(land) = self.land.as_ref().filter(|_| over_land) {
            least = least.min(off(off_base, v.z - land.z_mm));
        }
        let mut off_top = off_base.max(-beside);
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

/// A quarter of a circle from the X axis to the Y axis, both ends included, in chords that cut
/// no more than [`Border::CHORD_MM`].
fn arc(radius: f64) -> Vec<DVec2> {
    if radius == 0.0 {
        return vec![DVec2::ZERO];
    }
    // 1 - cos(t) <= t^2 / 2 for half a chord's angle t.
    let chords = (FRAC_PI_2 * f64::sqrt(radius / (8.0 * Border::CHORD_MM))).ceil().max(2.0);
    let at = |k: usize| {
        let angle = FRAC_PI_2 * k as f64 / chords;
        radius * DVec2::new(cos(angle), sin(angle))
    };
    let count = chords as usize;
    let between = (1..count).map(at);
    [DVec2::new(radius, 0.0)].into_iter().chain(between).chain([DVec2::new(0.0, radius)]).collect()
}

/// The points after so many quarter turns, to the last bit.
fn turned(points: &[DVec2], quarters: usize) -> impl Iterator<Item = DVec2> + '_ {
    points.iter().map(move |&p| (0..quarters).fold(p, |p, _| p.perp()) + DVec2::ZERO)
}

fn circle(radius: f64) -> Vec<DVec2> {
    let mut quarter = arc(radius);
    quarter.pop();
    (0..4).flat_map(|k| turned(&quarter, k).collect::<Vec<_>>()).collect()
}

/// The area inside a polygon, mm^2.
fn area(corners: &[DVec2]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(a, b)| 0.5 * a.perp_dot(*b)).sum()
}

#[cfg(test)]
mod tests {
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
                assert!((-1e-14..=Border::CHORD_MM).contains(&cut), "{contour:?}: {cut}");
                assert!(a.perp_dot(*b) > 0.0);
            }
            let lost = contour.area() - area(&corners);
            let rounded = contour.area() < 100.0 || corners.len() > 4;
            assert!((-1e-12..60.0 * Border::CHORD_MM).contains(&lost), "{contour:?}: {lost}");
            assert_eq!(lost > 1e-6, rounded, "{contour:?}: {lost}");
        }
        let Contour::Rect { .. } = contours()[4] else { panic!() };
        assert_eq!(contours()[4].polygon().len(), circle(5.0).len());
        assert_eq!(contours()[1].polygon().len(), 4);
    }

    #[test]
    fn chords_are_no_finer_than_needed() {
        for radius in [0.05, 0.5, 3.0, 40.0, 1e5] {
            let corners = circle(radius);
            let cut = radius - (0.5 * (corners[0] + corners[1])).length();
            assert!(cut <= Border::CHORD_MM, "{radius}: {cut}");
            assert!(cut > 0.5 * Border::CHORD_MM || corners.len() < 40, "{radius}: {cut}");
            assert_eq!(corners[corners.len() / 2], DVec2::new(-radius, 0.0));
        }
    }

    /// A plate with everything, by hand.
    #[test]
    fn volumes_and_distances_are_those_of_a_plate() {
        let drilled = |x, y, diameter_mm| Drilled { at: DVec2::new(x, y), diameter_mm };
        let stock = Border {
            contour: Contour::Rect { half: DVec2::new(20.0, 10.0), corner_mm: 3.0 },
            top_mm: 4.0,
            holes: vec![drilled(16.0, 0.0, 4.0)],
            marks: vec![drilled(-16.0, 2.0, 2.0)],
            land: Some(Land { z_mm: 6.0, holes: vec![drilled(0.0, 0.0, 2.0)] }),
        };
        let exact = 4.0 * (800.0 - 9.0 * (4.0 - PI) - 200.0 - 4.0 * PI) - PI / 3.0 - 6.0 * PI;
        assert!((stock.volume(200.0) - exact).abs() < 1e-11);
        assert!(stock.chords_mm3() > 0.0 && stock.chords_mm3() < 4.0 * 32.0 * Border::CHORD_MM);
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
            let found = stock.distance(DVec3::new(x, y, z), beside, x.abs().max(y.abs()) < 4.0);
            assert!((found - off).abs() < 1e-13, "({x}, {y}, {z}): {found}, not {off}");
        }
    }
}
