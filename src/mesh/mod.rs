//! The meshing stage: `Mirror` + tolerances -> optical face with proven bounds.
//!
//! A lattice sized to the tolerances proposes points, spade triangulates them, every facet's error
//! is bounded over its whole area (`proof`), and facets whose bound is over the limit are split
//! until none is left. A symmetric panel is meshed on one half, a folded mirror on one panel.

mod lattice;
mod optimum;
mod proof;
mod refine;

pub use optimum::Optimum;
pub use proof::{Bound, Prover, Vertex};

use crate::geom::{DVec2, Rect, TriMesh};
use crate::mirror::Mirror;
use crate::optics::Strip;
use thiserror::Error;

/// Largest number of facets of the whole face: about 15 GB in all stages.
const MOST_FACETS: f64 = 4e7;

/// The errors that no facet may exceed; an absent one does not rule.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Height between facet and mirror, mm.
    pub chord_mm: Option<f64>,
    /// Displacement of the image that flat facets cause, mm on the mirror.
    pub facet_mm: Option<f64>,
}

impl Limits {
    /// Whether `bound` is within both.
    #[must_use]
    pub fn hold(&self, bound: &Bound) -> bool {
        self.chord_mm.is_none_or(|limit| bound.chord_mm <= limit)
            && self.facet_mm.is_none_or(|limit| bound.facet_mm <= limit)
    }
}

/// The meshed mirror: all panels, without skirt and base.
#[derive(Debug, Clone)]
pub struct Face {
    /// Facets in the part frame. X and Y are single-precision numbers; Z is the sag there.
    pub mesh: TriMesh,
    /// The first this many facets belong to the designed panel, the rest to its reflection.
    pub designed: usize,
    /// What holds on every facet, for the mesh as it is and rounded to single precision.
    pub bound: Bound,
    /// How few triangles could do, by theory.
    pub optimum: Optimum,
}

/// Why no mesh within the limits could be made.
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
    /// Facets miss a limit that splitting them does not bring nearer, or that single precision is too
    /// coarse for.
    #[error(
        "at X {:.4} mm, Y {:.4} mm a facet of {size_mm:.1e} mm still has a bound of {:.3e} mm \
         (chord) and {:.3e} mm (image); loosen chord_um or facet_px, or keep the elevation range \
         further from +-90 degrees", at.x, at.y, bound.chord_mm, bound.facet_mm
    )]
    Floor {
        /// Where.
        at: DVec2,
        /// Longest edge, mm.
        size_mm: f64,
        /// What could be proven there.
        bound: Bound,
    },
    /// The slope may vanish: there the mirror looks along the axis, and no image point is near.
    #[error(
        "near X {:.4} mm, Y {:.4} mm the designed mirror may look straight along its axis, where \
         facet_px has no meaning; raise the degree, narrow the elevation range, or give chord_um \
         alone", at.x, at.y
    )]
    Pole {
        /// Where.
        at: DVec2,
    },
    /// spade refused a point.
    #[error("the point ({x}, {y}) cannot be triangulated: {reason}")]
    Point {
        /// X, mm.
        x: f64,
        /// Y, mm.
        y: f64,
        /// spade's account.
        reason: String,
    },
}

/// Meshes `mirror` so that every facet keeps `limits`; `strip` is the designed panel's image.
///
/// # Errors
/// [`MeshError`] when no such mesh exists in single precision or in memory.
pub fn mesh(mirror: &Mirror, strip: &Strip, limits: Limits) -> Result<Face, MeshError> {
    let prover = Prover::new(mirror, *strip);
    let domain = half_of(mirror);
    let copies = 1 << [mirror.even_x, mirror.folded].iter().filter(|&&twice| twice).count();
    let points = lattice::propose(&prover, domain, copies, limits)?;
    let (part, bound) = refine::triangulate(&prover, points, copies, limits)?;
    let panel = if mirror.even_x { part.with_reflection(0) } else { part };
    let designed = panel.triangles.len();
    let mesh = if mirror.folded { panel.with_reflection(1) } else { panel };
    Ok(Face { mesh, designed, bound, optimum: Optimum::new(mirror) })
}

/// The part of the panel that is meshed: X >= 0 where the rest is its mirror image.
fn half_of(mirror: &Mirror) -> Rect {
    let min_x = if mirror.even_x { 0.0 } else { mirror.panel.min.x };
    Rect { min: DVec2::new(min_x, mirror.panel.min.y), max: mirror.panel.max }
}
