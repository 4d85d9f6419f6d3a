//! Datum features of a part: the faces from which a shop sets it up and an inspector measures it.

use super::{Border, Contour, DVec2};
use crate::num::sort_by_number;
use std::fmt;

/// A face of the part from which places are measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DatumFeature {
    /// The plane base.
    Base,
    /// The plane outer side towards -Y.
    FrontSide,
    /// The plane outer side towards -X.
    LeftSide,
    /// The round outer side.
    Outside,
    /// A through hole of the flat rim: its number among all holes of the part, from 1.
    Hole(usize),
}

impl fmt::Display for DatumFeature {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Base => f.write_str("base"),
            Self::FrontSide => f.write_str("side towards -Y"),
            Self::LeftSide => f.write_str("side towards -X"),
            Self::Outside => f.write_str("round outside"),
            Self::Hole(k) => write!(f, "hole {k}"),
        }
    }
}

/// One to three datum features, the primary one, A, first: each takes what freedom those before it leave.
#[derive(Debug, Clone, PartialEq)]
pub struct DatumScheme(Vec<DatumFeature>);

impl DatumScheme {
    /// Shortest plane side that a part can be set against, mm.
    const LEAST_SIDE_MM: f64 = 1.0;

    /// The features of a part with this `border`, or whose own walls are upright over a contour: its base, then two
    /// holes of the rim, which pins find again, or else two sides, the longer one first, or a round outside and a hole.
    /// A part without a border whose walls are neither plane nor round has its base alone.
    #[must_use]
    pub fn new(border: Option<&Border>, walls: Option<Contour>) -> Self {
        let (drilled, inside) = border.map_or((0, 0), |border| {
            (border.holes.len(), border.land.as_ref().map_or(0, |land| land.holes.len()))
        });
        let holes = (1..=drilled).map(|k| DatumFeature::Hole(inside + k));
        let mut features = vec![DatumFeature::Base];
        match border.map(|border| border.contour).or(walls) {
            Some(Contour::Circle { .. }) => {
                features.push(DatumFeature::Outside);
                features.extend(holes.take(1));
            }
            Some(Contour::Rect { .. }) if drilled >= 2 => features.extend(holes.take(2)),
            Some(Contour::Rect { half, corner_mm }) => features.extend(sides(half, corner_mm)),
            None => {}
        }
        Self(features)
    }

    /// The features, each with its letter.
    pub fn lettered(&self) -> impl Iterator<Item = (char, DatumFeature)> {
        ('A'..='C').zip(self.0.iter().copied())
    }

    /// The features in words, each with its letter.
    #[must_use]
    pub fn words(&self) -> Vec<String> {
        self.lettered().map(|(letter, feature)| format!("{letter} {feature}")).collect()
    }
}

/// The sides of a rectangle that a part can be set against, the longer one first.
fn sides(half: DVec2, corner_mm: f64) -> impl Iterator<Item = DatumFeature> {
    let [along_x, along_y] = [half.x, half.y].map(|half| 2.0 * (half - corner_mm));
    let mut both = [(DatumFeature::FrontSide, along_x), (DatumFeature::LeftSide, along_y)];
    sort_by_number(&mut both, |side| -side.1);
    let long = |(_, length): &(DatumFeature, f64)| *length >= DatumScheme::LEAST_SIDE_MM;
    both.into_iter().filter(long).map(|(side, _)| side)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Hole, Land};

    fn words(border: Option<&Border>, walls: Option<Contour>) -> String {
        DatumScheme::new(border, walls).words().join(", ")
    }

    fn border(contour: Contour, holes: usize) -> Border {
        let hole = Hole::plain(DVec2::X, 3.0);
        Border {
            contour,
            top_mm: 2.0,
            edge_chamfer_mm: 0.0,
            holes: vec![hole; holes],
            marks: Vec::new(),
            land: None,
        }
    }

    #[test]
    fn holes_come_before_sides_and_the_longer_side_first() {
        let rect = |x, y, corner_mm| Contour::Rect { half: DVec2::new(x, y), corner_mm };
        let wide = border(rect(30.0, 20.0, 2.0), 4);
        assert_eq!(words(Some(&wide), None), "A base, B hole 1, C hole 2");
        let plain = border(rect(30.0, 20.0, 2.0), 1);
        assert_eq!(words(Some(&plain), None), "A base, B side towards -Y, C side towards -X");
        let tall = words(None, Some(rect(20.0, 30.0, 0.0)));
        assert_eq!(tall, "A base, B side towards -X, C side towards -Y");
        let stadium = border(rect(30.0, 20.0, 20.0), 0);
        assert_eq!(words(Some(&stadium), None), "A base, B side towards -Y");
        assert_eq!(words(None, None), "A base");
    }

    #[test]
    fn round_parts_are_centred_by_their_outside_and_clocked_by_a_hole_of_the_rim() {
        let circle = Contour::Circle { radius_mm: 20.0 };
        assert_eq!(words(None, Some(circle)), "A base, B round outside");
        let mut ring = border(circle, 3);
        assert_eq!(words(Some(&ring), None), "A base, B round outside, C hole 1");
        // Holes of the land inside count first.
        ring.land = Some(Land { z_mm: 1.0, holes: ring.holes.clone() });
        assert_eq!(words(Some(&ring), None), "A base, B round outside, C hole 4");
    }
}
