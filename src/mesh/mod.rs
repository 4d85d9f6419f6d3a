//! The meshing stage: `Mirror` + tolerances -> optical face with proven bounds.
//!
//! A lattice sized to the tolerances proposes points, spade triangulates them, every facet's error
//! is bounded over its whole area (`proof`), and facets whose bound is over the limit are split
//! until none is left. All of that happens in the mirror's chart, where facets are flat too
//! (`geom::Chart`). A symmetric panel is meshed on one half or quarter, a folded mirror on one
//! panel: displacements of the image are the same in all of them.

mod deviation;
mod lattice;
mod optimum;
mod proof;
mod refine;
mod region;
mod rim;
#[cfg(test)]
mod tests;
mod tight;
mod tighten;

pub use optimum::Optimum;
pub use proof::{Bound, Prover, Vertex};

use crate::geom::{Chart, DVec2, Precision, Rect, TriMesh};
use crate::mirror::Mirror;
use crate::optics::View;
use thiserror::Error;

/// Largest number of facets of the whole face: about 15 GB in all stages.
const MOST_FACETS: f64 = 4e7;

/// The errors that no facet may exceed; an absent one does not rule.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Distance between facet and mirror along the rays of the mirror's chart, mm.
    pub chord_mm: Option<f64>,
    /// Displacement of the image that flat facets cause, mm on the mirror.
    pub facet_mm: Option<f64>,
    /// Digits of the file for which they must hold.
    pub precision: Precision,
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
    /// Facets in the part frame. In the chart of parallel rays X and Y are single-precision
    /// numbers.
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

/// Meshes `mirror` so that every facet keeps `limits` as the camera of chart `camera` sees it, whose
/// image must show `view`. The camera's chart is the mirror's, or the mirror's is that of parallel
/// rays (a given mirror under a pinhole). Without a view `facet_mm` of the face's bound is 0.
///
/// # Errors
/// [`MeshError`] when no such mesh exists in single precision or in memory.
///
/// # Panics
/// When `limits` ask for a facet error without a view.
pub fn mesh(
    mirror: &Mirror,
    camera: &Chart,
    view: Option<&View>,
    limits: Limits,
) -> Result<Face, MeshError> {
    assert!(view.is_some() || limits.facet_mm.is_none(), "a facet error needs a view");
    let domain = domain(mirror);
    let prover = Prover::over(domain, mirror, camera, view, limits.precision);
    let twice = [mirror.even[0], mirror.even[1], mirror.folded];
    let copies = 1 << twice.iter().filter(|&&twice| twice).count();
    let proposal = lattice::propose(&prover, domain, copies, limits)?;
    let (mut mesh, bound) = refine::triangulate(&prover, proposal, copies, limits)?;
    for axis in [0, 1] {
        if mirror.even[axis] {
            mesh = mesh.with_reflection(axis);
        }
    }
    let designed = mesh.triangles.len();
    if mirror.folded {
        mesh = mesh.with_reflection(1);
    }
    Ok(Face { mesh, designed, bound, optimum: Optimum::new(mirror, camera, view) })
}

/// The bounds of the part of the panel that is meshed: where x >= 0 or y >= 0 if the rest is its
/// mirror image.
fn domain(mirror: &Mirror) -> Rect {
    let Rect { mut min, max } = mirror.outline.bounds();
    for axis in [0, 1] {
        if mirror.even[axis] {
            min[axis] = 0.0;
        }
    }
    Rect { min, max }
}
