//! Reasons why there is no mesh within the limits.

use super::bound::error_bound::ErrorBound;
use crate::geom::DVec2;
use crate::mirror::WallFault;
use thiserror::Error;

/// Largest number of facets of the whole face: about 15 GB in all stages.
pub(super) const MOST_FACETS: f64 = 4e7;

/// Directions near which a small turn of the mirror moves its image far.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum ImageSingularity {
    /// Directions along the target plane.
    #[error(
        "the mirror shows elevation {elevation_deg:.2} degrees there: keep the picture further from the \
         horizon, where no direction meets the target plane"
    )]
    Horizon {
        /// The elevation that the mirror shows, degrees.
        elevation_deg: f64,
    },
    /// Directions along the axis.
    #[error(
        "the mirror shows elevation {elevation_deg:.2} degrees there: keep the picture further from \
         +-90 degrees of elevation"
    )]
    Pole {
        /// The elevation that the mirror shows, degrees.
        elevation_deg: f64,
    },
}

/// A reason why there is no mesh within the limits.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MeshError {
    /// The limits ask for more facets than fit in memory.
    #[error(
        "the limits ask for about {facets:.2e} facets, over the {most:.0e} that fit in memory; \
         loosen chord_um or facet_px"
    )]
    TooMany {
        /// Estimated number of facets.
        facets: f64,
        /// Most that are made.
        most: f64,
    },
    /// A facet misses a limit that refinement does not bring nearer, or for which single precision is too coarse.
    #[error(
        "at X {:.4} mm, Y {:.4} mm a facet of {size_mm:.1e} mm still has a bound of {} (chord) and \
         {} (image); {}", at.x, at.y, bound_in_words(bound.chord_mm), bound_in_words(bound.facet_mm),
        advice(*singularity)
    )]
    NotRefinable {
        /// Middle of the facet in the chart, mm.
        at: DVec2,
        /// Length of its longest edge, mm.
        size_mm: f64,
        /// Bounds of its errors.
        bound: ErrorBound,
        /// Whether refinement would succeed in double precision.
        holds_in_double: bool,
        /// The singularity of the image that makes its errors large, if it is near one.
        singularity: Option<ImageSingularity>,
    },
    /// Rounding to single precision alone exceeds a limit.
    #[error(
        "single precision carries no better than {} at X {:.4} mm, Y {:.4} mm; loosen the limit",
        errors_in_words(*chord_mm, *facet_mm), at.x, at.y
    )]
    PrecisionLimit {
        /// Place in the chart, mm.
        at: DVec2,
        /// Least chord error in single precision there, mm, if that limit cannot be kept.
        chord_mm: Option<f64>,
        /// Least facet error in single precision there, mm, if that limit cannot be kept.
        facet_mm: Option<f64>,
    },
    /// No mesh has so few triangles as the budget.
    #[error(
        "max_triangles = {most} is too few: the coarsest mesh of this mirror comes to {least} \
         triangles; raise max_triangles to that"
    )]
    BudgetTooSmall {
        /// The budget.
        most: usize,
        /// The fewest triangles that were reached.
        least: usize,
    },
    /// The mirror may look along its axis, where there is no image point.
    #[error(
        "near X {:.4} mm, Y {:.4} mm the designed mirror may look straight along its axis, where \
         facet_px has no meaning; raise the degree, narrow the elevation range, or give chord_um \
         alone", at.x, at.y
    )]
    OnAxis {
        /// Place in the chart, mm.
        at: DVec2,
    },
    /// The sizes of facets that the limits ask for differ so much that no coarse mesh grades between them.
    #[error(
        "near X {:.4} mm, Y {:.4} mm the limits ask for facets that are boundlessly smaller than \
         elsewhere; narrow the elevation range or keep it further from +-90 degrees, or give \
         chord_um alone", at.x, at.y
    )]
    SizeContrast {
        /// Place of the smallest ones in the chart, mm.
        at: DVec2,
    },
    /// A wall between panels cannot be made.
    #[error(transparent)]
    Wall(#[from] WallFault),
    /// The Delaunay triangulation (spade) refused a point.
    #[error("the point ({x}, {y}) cannot be triangulated: {reason}")]
    PointRejected {
        /// X, mm.
        x: f64,
        /// Y, mm.
        y: f64,
        /// spade's account.
        reason: String,
    },
}

impl MeshError {
    /// Checks that so many facets of the whole face fit in memory.
    ///
    /// # Errors
    /// [`MeshError::TooMany`] if they do not.
    pub(crate) fn check_facets(facets: f64) -> Result<(), Self> {
        if !(facets <= MOST_FACETS) {
            return Err(Self::TooMany { facets, most: MOST_FACETS });
        }
        Ok(())
    }
}

/// Advice to a user whose limits refinement does not meet.
fn advice(singularity: Option<ImageSingularity>) -> String {
    let loosen = "loosen chord_um or facet_px";
    singularity.map_or_else(|| loosen.to_owned(), |near| format!("{near}, or {loosen}"))
}

/// A bound in words.
fn bound_in_words(mm: f64) -> String {
    if mm.is_finite() { format!("{mm:.3e} mm") } else { "none".to_owned() }
}

/// The least errors of single precision in words.
fn errors_in_words(chord_mm: Option<f64>, facet_mm: Option<f64>) -> String {
    let chord = chord_mm.map(|mm| format!("{mm:.3e} mm (chord)"));
    let facet = facet_mm.map(|mm| format!("{mm:.3e} mm (image)"));
    chord.into_iter().chain(facet).collect::<Vec<_>>().join(" and ")
}
