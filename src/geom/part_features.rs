//! What a part has around and below its mirror: the border, blind holes from the base, and a cavity's floor.

use super::{
    BlindHole, Border, CavityFloor, DVec2, Hole, HoleBottom, HoleKind, HoleMeridian, h7_upper_mm,
};

/// Features of a part beside its mirror and the walls below it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PartFeatures<'a> {
    /// The material around the mirror.
    pub border: Option<&'a Border>,
    /// Holes from the base that end in the material, below the mirror or the border.
    pub blind_holes: &'a [BlindHole],
    /// The floor of the cavity of a hollow part.
    pub floor: Option<&'a CavityFloor>,
}

/// A hole of a part, with its number among all of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NumberedHole {
    /// From 1: holes of the land inside the mirror, those of the flat rim, blind ones.
    pub number: usize,
    /// Its mouth and its cylinder.
    pub hole: Hole,
    /// Depth of its cylinder, mm, and its ground; none of a through hole.
    pub blind: Option<(f64, HoleBottom)>,
    /// Its surface.
    pub meridian: HoleMeridian,
}

impl<'a> PartFeatures<'a> {
    /// A body that is the mirror, walls and a base.
    pub const NONE: PartFeatures<'static> =
        PartFeatures { border: None, blind_holes: &[], floor: None };

    /// A body with this border and no blind holes.
    #[must_use]
    pub fn bordered(border: Option<&'a Border>) -> Self {
        Self { border, ..Self::default() }
    }

    /// All holes in the order of their numbers.
    pub fn holes(self) -> impl Iterator<Item = NumberedHole> + 'a {
        let through = |(hole, top_mm): (&Hole, f64)| (*hole, None, hole.meridian(top_mm));
        let border = self.border.into_iter();
        let land = border.clone().filter_map(|border| border.land.as_ref());
        let in_land = land.flat_map(|land| land.holes.iter().map(|hole| (hole, land.z_mm)));
        let in_rim =
            border.flat_map(|border| border.holes.iter().map(|hole| (hole, border.top_mm)));
        let blind = self
            .blind_holes
            .iter()
            .map(|blind| (blind.hole, Some((blind.depth_mm, blind.bottom)), blind.meridian()));
        let all = in_land.chain(in_rim).map(through).chain(blind);
        all.enumerate().map(|(k, (hole, blind, meridian))| NumberedHole {
            number: k + 1,
            hole,
            blind,
            meridian,
        })
    }

    /// Number of ways through: through holes, and from drain to drain by the cavity.
    #[must_use]
    pub fn through(self) -> usize {
        let drains = self.floor.map_or(0, |floor| floor.drains.len());
        self.border.map_or(0, |border| border.through().count()) + drains.saturating_sub(1)
    }

    /// The surfaces of blind holes and of drains, which both open in the base and not in the flat top.
    #[must_use]
    pub fn from_below(self) -> Vec<HoleMeridian> {
        let drains = self.floor.into_iter().flat_map(CavityFloor::meridians);
        self.blind_holes.iter().map(BlindHole::meridian).chain(drains).collect()
    }

    /// Z of the plane on which the walls below the mirror stand, mm.
    #[must_use]
    pub fn foot_mm(self) -> f64 {
        self.border.map_or(0.0, |border| border.top_mm)
    }

    /// Volume of the blind holes, mm^3.
    #[must_use]
    pub fn blind_mm3(self) -> f64 {
        self.blind_holes.iter().map(|blind| blind.meridian().volume()).sum()
    }

    /// What polygons in the place of circles may change the volume by, mm^3.
    #[must_use]
    pub fn chords_mm3(self) -> f64 {
        let below: f64 = self.from_below().iter().map(HoleMeridian::chords_mm3).sum();
        self.border.map_or(0.0, Border::chords_mm3) + below
    }
}

impl NumberedHole {
    /// Whether it is a cylinder through the part and nothing more.
    #[must_use]
    pub fn is_plain(&self) -> bool {
        let Hole { at, diameter_mm, .. } = self.hole;
        self.blind.is_none() && self.hole == Hole::plain(at, diameter_mm)
    }

    /// X and Y of its axis, mm.
    #[must_use]
    pub fn at(&self) -> DVec2 {
        self.hole.at
    }

    /// What a drawing says of it, diameters and depths in mm without a unit, as in
    /// `M3 x 0.5 - 6H, 6 deep, pilot 2.5, 8 deep`.
    #[must_use]
    pub fn words(&self) -> String {
        match self.hole.kind {
            HoleKind::Plain => {
                format!("diameter {}, {}", figure(self.hole.diameter_mm), self.remarks())
            }
            _ => self.remarks(),
        }
    }

    /// The same beside the diameter of a plain hole.
    #[must_use]
    pub fn remarks(&self) -> String {
        let Hole { diameter_mm, kind, counterbore, chamfer_mm, .. } = self.hole;
        let deep = |depth: Option<f64>| match depth {
            Some(depth) => format!("{} deep", figure(depth)),
            None => "through".to_owned(),
        };
        let depth = deep(self.blind.map(|(depth, _)| depth));
        let drilled = figure(diameter_mm);
        let mut words = match kind {
            HoleKind::Plain => depth,
            HoleKind::Thread { size, depth_mm } => match (depth_mm, self.blind) {
                (None, None) => format!("{size} - 6H, through, pilot {drilled}"),
                (thread, _) => {
                    format!("{size} - 6H, {}, pilot {drilled}, {depth}", deep(thread))
                }
            },
            HoleKind::Screw(size) => {
                format!("diameter {drilled}, {depth}, for a screw M{}", size.diameter_mm())
            }
            HoleKind::Dowel => {
                let upper = h7_upper_mm(diameter_mm).unwrap_or_default();
                format!("diameter {drilled} H7 (+{upper:.3}/0), {depth}")
            }
        };
        if matches!(self.blind, Some((_, HoleBottom::Flat))) {
            words += ", flat";
        }
        if let Some(counterbore) = counterbore {
            let wide = figure(counterbore.diameter_mm);
            words += &format!(", counterbore {wide}, {} deep", figure(counterbore.depth_mm));
        }
        if chamfer_mm > 0.0 {
            words += &format!(", chamfer {} x 45 deg", figure(chamfer_mm));
        }
        words
    }
}

/// A length to a micrometre, without digits that are 0.
fn figure(mm: f64) -> String {
    format!("{}", (mm * 1e3).round() / 1e3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Contour, Counterbore, Land, MetricThread};

    /// One hole of each kind, in land, rim and base.
    #[test]
    fn holes_are_numbered_from_the_land_outwards_and_said_in_words() {
        let at =
            |x: f64, kind, diameter_mm| Hole { kind, ..Hole::plain(DVec2::X * x, diameter_mm) };
        let thread = |depth_mm| HoleKind::Thread { size: MetricThread::M3, depth_mm };
        let counterbore = Some(Counterbore { diameter_mm: 6.5, depth_mm: 3.4 });
        let screw = Hole { counterbore, ..at(3.0, HoleKind::Screw(MetricThread::M3), 3.4) };
        let tapped = Hole { chamfer_mm: 0.25, ..at(2.0, thread(None), 2.5) };
        let border = Border {
            contour: Contour::Circle { radius_mm: 20.0 },
            top_mm: 5.0,
            edge_chamfer_mm: 0.0,
            holes: vec![tapped, screw],
            marks: Vec::new(),
            land: Some(Land { z_mm: 4.0, holes: vec![Hole::plain(DVec2::ZERO, 3.2)] }),
        };
        let blind = |hole, depth_mm, bottom| BlindHole { hole, depth_mm, bottom };
        let blind_holes = [
            blind(at(4.0, thread(Some(6.0)), 2.5), 8.0, HoleBottom::DrillPoint),
            blind(at(5.0, HoleKind::Dowel, 3.0), 7.5, HoleBottom::DrillPoint),
            blind(at(6.0, HoleKind::Plain, 5.0), 3.1, HoleBottom::Flat),
        ];
        let features =
            PartFeatures { border: Some(&border), blind_holes: &blind_holes, floor: None };
        let told: Vec<String> = features
            .holes()
            .map(|hole| format!("{} at X {}: {}", hole.number, hole.at().x, hole.words()))
            .collect();
        assert_eq!(
            told,
            [
                "1 at X 0: diameter 3.2, through",
                "2 at X 2: M3 x 0.5 - 6H, through, pilot 2.5, chamfer 0.25 x 45 deg",
                "3 at X 3: diameter 3.4, through, for a screw M3, counterbore 6.5, 3.4 deep",
                "4 at X 4: M3 x 0.5 - 6H, 6 deep, pilot 2.5, 8 deep",
                "5 at X 5: diameter 3 H7 (+0.010/0), 7.5 deep",
                "6 at X 6: diameter 5, 3.1 deep, flat",
            ]
        );
        let plain: Vec<usize> =
            features.holes().filter(NumberedHole::is_plain).map(|hole| hole.number).collect();
        assert_eq!(plain, [1]);
        assert_eq!((features.through(), features.foot_mm()), (3, 5.0));
        let volumes: f64 = features.holes().skip(3).map(|hole| hole.meridian.volume()).sum();
        assert_eq!(features.blind_mm3(), volumes);
        assert!(features.chords_mm3() > border.chords_mm3());
        assert_eq!(PartFeatures::NONE.holes().count(), 0);
    }
}
