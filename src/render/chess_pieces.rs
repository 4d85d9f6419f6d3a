//! Chess pieces after Staunton's, as turned solids; lengths in squares of the board.

use super::solid_of_revolution::{Generatrix, SolidOfRevolution, SurfaceHit};
use crate::geom::{DVec3, Ray};
use crate::num::{asin, cos, sin};
use std::f64::consts::FRAC_PI_2;

/// The kinds of pieces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PieceKind {
    /// 0.84 high.
    Pawn,
    /// 0.90 high.
    Rook,
    /// 1.1 high; looks along +Y.
    Knight,
    /// 1.2 high.
    Bishop,
    /// 1.45 high.
    Queen,
    /// 1.68 high with its cross.
    King,
}

/// Height of the king's head under its cross, in squares.
pub(super) const KINGS_HEAD: f64 = 1.5;

/// A piece that stands on Z = 0 with the foot's centre at the origin.
#[derive(Debug, Clone)]
pub(super) struct ChessPiece {
    parts: Vec<SolidOfRevolution>,
    centre: DVec3,
    /// Of a sphere around everything.
    radius: f64,
}

impl ChessPiece {
    /// Turns a piece.
    #[must_use]
    pub(super) fn new(kind: PieceKind) -> Self {
        let upright = |outline: Generatrix| SolidOfRevolution::new(DVec3::ZERO, DVec3::Z, &outline);
        let parts = match kind {
            PieceKind::Pawn => vec![upright(
                [foot(0.27, 0.085, 0.5), collar(0.085, 0.16, 0.5), ball(0.69, 0.15, 0.09)].concat(),
            )],
            PieceKind::Rook => vec![upright(rook())],
            PieceKind::Knight => knight(),
            PieceKind::Bishop => vec![upright(bishop())],
            PieceKind::Queen => vec![upright(queen())],
            PieceKind::King => king(),
        };
        // About the sphere's centre half way up the tallest part.
        let reach = |centre: DVec3| {
            let far = |part: &SolidOfRevolution| {
                let (middle, radius) = part.bounding_sphere();
                (middle - centre).length() + radius
            };
            parts.iter().map(far).fold(0.0, f64::max)
        };
        let centre = parts[0].bounding_sphere().0;
        Self { radius: reach(centre), centre, parts }
    }

    /// The first place ahead of the ray's origin, nearer than `within`, where it meets the piece.
    #[must_use]
    pub(super) fn intersect(&self, ray: &Ray, within: f64) -> Option<SurfaceHit> {
        let away = self.centre - ray.origin;
        let along = away.dot(ray.direction);
        let aside = away.length_squared() - along * along;
        if aside > self.radius * self.radius || along < -self.radius || along - self.radius > within
        {
            return None;
        }
        let mut nearest: Option<SurfaceHit> = None;
        for part in &self.parts {
            let end = nearest.map_or(within, |contact| contact.t);
            nearest = part.intersect(ray, end).or(nearest);
        }
        nearest
    }
}

/// A foot of radius `wide` and the stem that tapers from it to `neck` at height `up`.
fn foot(wide: f64, neck: f64, up: f64) -> Generatrix {
    let h = |share: f64| 0.2 + share * (up - 0.2);
    let r = |share: f64| neck + share * (0.62 * wide - neck);
    vec![
        vec![[wide, 0.0], [wide, 0.06]],
        vec![[wide, 0.06], [0.99 * wide, 0.09], [0.94 * wide, 0.12], [0.78 * wide, 0.16]],
        vec![[0.78 * wide, 0.16], [0.8 * wide, 0.175], [0.76 * wide, 0.195]],
        vec![
            [0.72 * wide, 0.2],
            [r(0.45), h(0.2)],
            [r(0.16), h(0.5)],
            [r(0.02), h(0.85)],
            [neck, up],
        ],
    ]
}

/// A ring of radius `wide` around a neck at height `up`.
fn collar(neck: f64, wide: f64, up: f64) -> Generatrix {
    let mid = 0.5 * (neck + wide);
    vec![
        vec![[neck, up], [mid, up + 0.005]],
        vec![[mid, up + 0.005], [wide, up + 0.025], [mid, up + 0.05]],
        vec![[mid, up + 0.05], [neck, up + 0.08]],
    ]
}

/// A ball around height `up`, from a neck of radius `neck` below to its top.
fn ball(up: f64, radius: f64, neck: f64) -> Generatrix {
    let start = asin((neck / radius).min(1.0)) - FRAC_PI_2;
    let arc = |k: usize| {
        let angle = start + (FRAC_PI_2 - start) * k as f64 / 10.0;
        [(radius * cos(angle)).max(0.0), up + radius * sin(angle)]
    };
    vec![(0..=10).map(arc).collect()]
}

fn rook() -> Generatrix {
    let head = vec![
        vec![[0.15, 0.60], [0.21, 0.61]],
        vec![[0.21, 0.61], [0.215, 0.64], [0.205, 0.66]],
        vec![[0.205, 0.66], [0.2, 0.72], [0.215, 0.76]],
        vec![[0.215, 0.76], [0.215, 0.90]],
        vec![[0.215, 0.90], [0.15, 0.90]],
        vec![[0.15, 0.90], [0.15, 0.82]],
        vec![[0.15, 0.82], [0.0, 0.82]],
    ];
    [foot(0.30, 0.15, 0.60), head].concat()
}

fn bishop() -> Generatrix {
    let mitre = vec![vec![
        [0.08, 0.79],
        [0.13, 0.85],
        [0.145, 0.92],
        [0.12, 1.01],
        [0.07, 1.09],
        [0.03, 1.125],
    ]];
    let neck = [collar(0.08, 0.17, 0.66), collar(0.08, 0.14, 0.72)].concat();
    [foot(0.29, 0.08, 0.66), neck, mitre, ball(1.16, 0.042, 0.03)].concat()
}

fn queen() -> Generatrix {
    let crown = vec![
        vec![[0.1, 1.03], [0.12, 1.12], [0.16, 1.23], [0.215, 1.33]],
        vec![[0.215, 1.33], [0.19, 1.35]],
        vec![[0.19, 1.35], [0.17, 1.32]],
        vec![[0.17, 1.32], [0.12, 1.36], [0.045, 1.385]],
    ];
    let neck = [collar(0.095, 0.19, 0.88), collar(0.095, 0.155, 0.95)].concat();
    [foot(0.32, 0.095, 0.88), neck, crown, ball(1.41, 0.05, 0.045)].concat()
}

fn king() -> Vec<SolidOfRevolution> {
    let crown = vec![
        vec![[0.105, 1.10], [0.13, 1.2], [0.17, 1.33], [0.205, 1.4]],
        vec![[0.205, 1.4], [0.2, 1.42], [0.17, 1.44]],
        vec![[0.17, 1.44], [0.13, 1.48], [0.06, KINGS_HEAD], [0.035, KINGS_HEAD + 0.01]],
    ];
    let neck = [collar(0.1, 0.2, 0.95), collar(0.1, 0.165, 1.02)].concat();
    let stem = vec![vec![[0.03, KINGS_HEAD], [0.03, 1.68]], vec![[0.03, 1.68], [0.0, 1.68]]];
    let bar = vec![
        vec![[0.0, 0.0], [0.028, 0.0]],
        vec![[0.028, 0.0], [0.028, 0.16]],
        vec![[0.028, 0.16], [0.0, 0.16]],
    ];
    vec![
        SolidOfRevolution::new(
            DVec3::ZERO,
            DVec3::Z,
            &[foot(0.33, 0.1, 0.95), neck, crown].concat(),
        ),
        SolidOfRevolution::new(DVec3::ZERO, DVec3::Z, &stem),
        SolidOfRevolution::new(DVec3::new(-0.08, 0.0, 1.6), DVec3::X, &bar),
    ]
}

/// A foot, a neck that leans forward, a head across it, and two ears.
fn knight() -> Vec<SolidOfRevolution> {
    let pedestal = [foot(0.29, 0.2, 0.24), vec![vec![[0.2, 0.24], [0.0, 0.26]]]].concat();
    let neck = vec![vec![
        [0.2, 0.0],
        [0.19, 0.15],
        [0.155, 0.35],
        [0.14, 0.55],
        [0.11, 0.68],
        [0.0, 0.74],
    ]];
    let head = vec![vec![
        [0.0, 0.0],
        [0.09, 0.02],
        [0.13, 0.1],
        [0.125, 0.2],
        [0.09, 0.34],
        [0.08, 0.42],
        [0.05, 0.46],
        [0.0, 0.47],
    ]];
    let ear = vec![vec![[0.05, 0.0], [0.0, 0.17]]];
    let lean = |y: f64, z: f64| DVec3::new(0.0, y, z).normalize();
    let ears = [-0.06, 0.06]
        .map(|x| SolidOfRevolution::new(DVec3::new(x, 0.05, 0.93), lean(0.1, 1.0), &ear));
    let [left, right] = ears;
    vec![
        SolidOfRevolution::new(DVec3::ZERO, DVec3::Z, &pedestal),
        SolidOfRevolution::new(DVec3::new(0.0, -0.05, 0.2), lean(0.14, 1.0), &neck),
        SolidOfRevolution::new(DVec3::new(0.0, -0.04, 0.95), lean(0.8, -0.5), &head),
        left,
        right,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [(PieceKind, f64); 6] = [
        (PieceKind::Pawn, 0.84),
        (PieceKind::Rook, 0.9),
        (PieceKind::Knight, 1.1),
        (PieceKind::Bishop, 1.2),
        (PieceKind::Queen, 1.46),
        (PieceKind::King, 1.68),
    ];

    #[test]
    fn pieces_are_as_high_as_told_and_stay_in_their_square() {
        for (kind, height) in ALL {
            let piece = ChessPiece::new(kind);
            let mut top = 0.0_f64;
            for k in -60..=60 {
                for z in 1..180 {
                    let (y, z) = (f64::from(k) / 120.0, f64::from(z) / 100.0);
                    let ray = Ray { origin: DVec3::new(-3.0, y, z), direction: DVec3::X };
                    let Some(contact) = piece.intersect(&ray, 6.0) else { continue };
                    let at = ray.at(contact.t);
                    assert!(at.truncate().abs().max_element() < 0.5, "{kind:?}: {at}");
                    assert!(contact.normal.x < 1e-9, "{kind:?} shows its inside at {at}");
                    top = top.max(z);
                }
            }
            assert!((top - height).abs() < 0.012, "{kind:?}: {top}");
        }
    }

    #[test]
    fn no_ray_through_the_middle_of_a_foot_passes() {
        for (kind, _) in ALL {
            let piece = ChessPiece::new(kind);
            for k in 0..360 {
                let angle = crate::num::radians(f64::from(k));
                let way = DVec3::new(cos(angle), sin(angle), 0.0);
                let ray = Ray { origin: DVec3::new(0.0, 0.0, 0.1) - 2.0 * way, direction: way };
                assert!(piece.intersect(&ray, 4.0).is_some_and(|c| c.t < 2.0), "{kind:?} {k}");
            }
        }
    }
}
