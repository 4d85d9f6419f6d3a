//! The size of a mirror, and how far errors move the places that pixels see on it.

use super::error_source::{ErrorSource, misalignment_per_unit};
use super::texture::TextureShape;
use crate::geom::{DVec2, Outline};
use crate::mirror::Mirror;
use crate::optics::Camera;
use crate::tolerance_terms::MisalignmentField;

/// Shares of the mirror's size that the reach has at least and at most.
const LEAST_REACH: f64 = 0.003;
const MOST_REACH: f64 = 0.02;
/// Standard deviations of the way, along both axes together, in the reach; the few hits that go farther
/// take their time.
const REACH_SIGMAS: f64 = 2.5;

/// Middle and half sides, mm, of the rectangle around the mirror in X and Y of the part.
#[must_use]
pub fn extent(mirror: &Mirror) -> ([f64; 2], [f64; 2]) {
    let bounds = mirror.full_outline().bounds();
    let rim = match mirror.outline {
        Outline::Ring { outer, .. } => vec![DVec2::new(outer, 0.0)],
        Outline::Rect(_) => {
            let middle = bounds.centre();
            let xs = [bounds.min.x, middle.x, bounds.max.x];
            let ys = [bounds.min.y, middle.y, bounds.max.y];
            xs.iter().flat_map(|&x| ys.map(|y| DVec2::new(x, y))).collect()
        }
    };
    let places: Vec<DVec2> =
        rim.into_iter().map(|q| mirror.position(q, &mirror.row(q.y).at(q.x)).truncate()).collect();
    if let ([rim], Outline::Ring { .. }) = (places.as_slice(), mirror.outline) {
        return ([0.0; 2], [rim.x; 2]);
    }
    let lo = places.iter().fold(DVec2::INFINITY, |a, b| a.min(*b));
    let hi = places.iter().fold(DVec2::NEG_INFINITY, |a, b| a.max(*b));
    ((0.5 * (lo + hi)).to_array(), (0.5 * (hi - lo)).to_array())
}

/// Distance, mm, by which hits move over a mirror of this size, roughly: half the side of the squares on
/// which polynomials stand for it.
pub(super) fn reach(
    sources: &[ErrorSource],
    texture: &TextureShape,
    camera: &Camera,
    size: f64,
) -> f64 {
    let mut square = 0.0;
    for source in sources {
        let found = misalignment_per_unit(source.kind, camera.pixel_mm, texture);
        let Some((field, unit)) = found else { continue };
        let lever = match field {
            MisalignmentField::ShiftX
            | MisalignmentField::ShiftY
            | MisalignmentField::PrincipalX
            | MisalignmentField::PrincipalY => 1.0,
            MisalignmentField::ShiftZ => 0.5,
            _ => 0.5 * size,
        };
        let far = source.limit * unit * lever;
        square += far * far * source.distribution.mean_square();
    }
    (REACH_SIGMAS * f64::sqrt(square)).clamp(LEAST_REACH * size, MOST_REACH * size)
}
