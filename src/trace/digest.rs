//! Numbers and errors of the pixels of a piece of a strip.

use super::pixel_trace::{PixelTrace, RayErrors};
use super::ray_end::Outcome;

/// Errors of some rays, one after the other.
#[derive(Debug, Clone, Default)]
pub(super) struct ErrorList {
    /// Angles, radians.
    pub angle_rad: Vec<f64>,
    /// Distances in the image from where the content belongs, mm.
    pub image_mm: Vec<f64>,
    /// Distances from what the designed mirror shows, mm.
    pub facet_mm: Vec<f64>,
}

impl ErrorList {
    fn with_room_for(rays: usize) -> Self {
        let [angle_rad, image_mm, facet_mm] = [(); 3].map(|()| Vec::with_capacity(rays));
        Self { angle_rad, image_mm, facet_mm }
    }

    fn push(&mut self, errors: Option<RayErrors>) {
        if let Some(RayErrors { angle_rad, image_mm, facet_mm }) = errors {
            self.angle_rad.push(angle_rad);
            self.image_mm.push(image_mm);
            self.facet_mm.push(facet_mm);
        }
    }
}

/// What a piece of a strip holds.
#[derive(Debug, Clone, Default)]
pub(super) struct Digest {
    /// Rays aimed at the mirror.
    pub aimed: usize,
    /// Of these, reflected into the world.
    pub hit: usize,
    /// Meeting nothing.
    pub missed: usize,
    /// Reflected against the part itself.
    pub shadowed: usize,
    /// Meeting the back of a facet.
    pub back_face: usize,
    /// Hidden by an obstacle.
    pub obstructed: usize,
    /// Errors by facets.
    pub facet: ErrorList,
    /// Errors by the file's own normals.
    pub smooth: ErrorList,
}

impl Digest {
    /// Nothing yet, with room for the errors of so many pixels: by facets, and by the file's normals.
    pub(super) fn with_room_for(pixels: usize, facet: bool, smooth: bool) -> Self {
        let room = |asked: bool| ErrorList::with_room_for(if asked { pixels } else { 0 });
        Self { facet: room(facet), smooth: room(facet && smooth), ..Self::default() }
    }

    /// What some pixels hold.
    pub(super) fn of(pixels: &[PixelTrace]) -> Self {
        let mut digest = Self::default();
        digest.add(pixels);
        digest
    }

    /// Adds pixels.
    pub(super) fn add(&mut self, pixels: &[PixelTrace]) {
        for pixel in pixels.iter().filter(|pixel| pixel.aimed) {
            self.aimed += 1;
            match pixel.outcome {
                Outcome::Hit => {
                    self.hit += 1;
                    self.facet.push(pixel.errors);
                    self.smooth.push(pixel.smooth);
                }
                Outcome::Missed => self.missed += 1,
                Outcome::Shadowed(_) => self.shadowed += 1,
                Outcome::BackFace => self.back_face += 1,
                Outcome::Obstructed(_) => self.obstructed += 1,
            }
        }
    }
}
