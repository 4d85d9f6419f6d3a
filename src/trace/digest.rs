//! Numbers, errors and classes of the pixels of a piece of a strip.

use super::expected_ray::ExpectedRay;
use super::filled_range::FilledRange;
use super::outcome_counts::OutcomeCounts;
use super::pixel_class::{PixelClass, own_class};
use super::pixel_trace::{PixelTrace, RayErrors};

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
    fn clear(&mut self) {
        let Self { angle_rad, image_mm, facet_mm } = self;
        [angle_rad, image_mm, facet_mm].into_iter().for_each(Vec::clear);
    }

    pub(super) fn push(&mut self, errors: Option<RayErrors>) {
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
    /// Numbers of its pixels.
    pub counts: OutcomeCounts,
    /// Errors by facets.
    pub facet: ErrorList,
    /// Errors by the file's own normals: one entry a pixel, or none where the file has no normals.
    pub smooth: Vec<Option<RayErrors>>,
    /// Classes of the pixels as far as each alone tells: without a picture of no use.
    pub classes: Vec<Option<PixelClass>>,
    /// What the filled pixels show.
    pub filled: FilledRange,
}

impl Digest {
    /// Forgets all pixels but their errors by the file's normals. Filled pixels that show what is in `filled` add nothing
    /// to that.
    pub(super) fn empty(&mut self, filled: FilledRange) {
        (self.counts, self.filled) = (OutcomeCounts::default(), filled);
        self.facet.clear();
        self.classes.clear();
    }

    /// Forgets the errors of a pixel by the file's normals.
    pub(super) fn forget_smooth(&mut self, pixel: usize) {
        if let Some(smooth) = self.smooth.get_mut(pixel) {
            *smooth = None;
        }
    }

    /// Adds pixels, with their expected rays; they show their content up to `tolerance_mm` from where it belongs.
    pub(super) fn add(
        &mut self,
        pixels: &[PixelTrace],
        expected: &[ExpectedRay],
        tolerance_mm: f64,
    ) {
        for (pixel, expected) in pixels.iter().zip(expected) {
            self.counts.count(pixel);
            self.facet.push(pixel.errors);
            let class = own_class(pixel, tolerance_mm);
            self.classes.push(class);
            if class == Some(PixelClass::Filled) {
                self.filled.add(pixel.direction, expected.direction);
            }
        }
    }
}
