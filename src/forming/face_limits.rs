//! Where a sheet cannot follow a mirror: beside a place that is more curved than the sheet is thick.

use super::ParallelSurface;
use crate::geom::DVec3;
use crate::mirror::{LocalSurface, Mirror, SurfaceSamples};
use thiserror::Error;

/// Least length of a parallel surface over that of its mirror: below a hundredth facets and feeds shrink as much, and the
/// radius of curvature is a hundredth of the mirror's.
const LEAST_STRETCH: f64 = 0.01;

/// Reason why no tool forms a mirror.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FormingFault {
    /// The sheet is thicker than the mirror's radius of curvature on that side.
    #[error(
        "a sheet of {sheet_mm} mm cannot follow the mirror at X {:.3}, Y {:.3}, Z {:.3} mm, whose radius of curvature \
         is {radius_mm:.3} mm on that side; set forming.sheet_mm = {:.3} or less",
        at.x, at.y, at.z, 0.9 * radius_mm
    )]
    Curved {
        /// Thickness, mm.
        sheet_mm: f64,
        /// Place of the mirror, mm.
        at: DVec3,
        /// Radius of curvature, mm.
        radius_mm: f64,
    },
    /// The tool's face does not stand out of its flat rim, or base.
    #[error(
        "the tool's face must stand above Z = {foot_mm:.3} mm, where its walls end, found it down to {lowest_mm:.3} mm; \
         set part.base_mm = {:.3} or more",
        enough_mm
    )]
    Low {
        /// Z of the foot in the part's frame, mm.
        foot_mm: f64,
        /// Z of the lowest place of the face in the part's frame, mm.
        lowest_mm: f64,
        /// Material under the mirror with which it does, mm.
        enough_mm: f64,
    },
}

/// Extent and curvature of the face of a tool.
pub(super) struct FaceLimits {
    /// Least and largest Z in the part's frame, mm.
    pub heights_mm: [f64; 2],
    /// Least length of the sheet's other side, or of the tool's face if that is less, over that of the mirror.
    pub least_stretch: f64,
    /// Largest length of the tool's face over that of the mirror.
    pub most_stretch: f64,
}

impl FaceLimits {
    /// Those beside `mirror`, with the sheet between the distances `offset_mm` and `other_mm` from it.
    ///
    /// # Errors
    /// [`FormingFault::Curved`] where the sheet is thicker than the mirror's radius of curvature: where a principal
    /// curvature k on the side of d leaves 1 - d k at or below [`LEAST_STRETCH`].
    pub(super) fn new(
        mirror: &Mirror,
        offset_mm: f64,
        other_mm: f64,
    ) -> Result<Self, FormingFault> {
        let samples = SurfaceSamples::new(mirror);
        let sides = [offset_mm, other_mm];
        let least = |place: &LocalSurface| {
            let stretches = sides.map(|d| place.curvatures().map(|k| 1.0 - d * k));
            stretches.as_flattened().iter().fold(f64::INFINITY, |least, s| least.min(*s))
        };
        let (narrowest, place) = samples.largest(|place| -least(place));
        if !(-narrowest > LEAST_STRETCH) {
            let sheet_mm = offset_mm.abs().max(other_mm.abs());
            // (1 + narrowest) is the thickness times the curvature.
            let radius_mm = sheet_mm / (1.0 + narrowest);
            return Err(FormingFault::Curved { sheet_mm, at: place.at, radius_mm });
        }
        let most = |place: &LocalSurface| {
            let [least, most] = place.curvatures().map(|k| 1.0 - offset_mm * k);
            least.max(most)
        };
        let face = ParallelSurface { mirror, offset_mm };
        let high = samples.largest(|place| face.beside(place).z).0;
        let low = -samples.largest(|place| -face.beside(place).z).0;
        let (most_stretch, _) = samples.largest(most);
        Ok(Self { heights_mm: [low, high], least_stretch: -narrowest, most_stretch })
    }
}
