//! Alignment of a measured part: the motion that brings a mesh of unknown pose onto the designed mirror,
//! and the form error that remains.
//!
//! The fit makes the distances of the mesh's vertices from the mirror small, each measured along the
//! mirror's normal and weighted by its share of the facets as the camera sees them, so that walls and
//! bases have no weight: "point to plane" with exact projections on the designed surface instead of
//! nearest neighbours (Y. Chen and G. Medioni, *Object modelling by registration of multiple range
//! images*, 1992). Tukey's biweight with a scale from the median distance leaves outliers out (P. J.
//! Huber, *Robust Statistics*, 1981).

mod coarse_search;
mod form;
mod normal_equations;
mod points;
mod pose;
mod reference_surface;
mod unit;
mod vertex_patch;

pub use form::{FormError, FormMap, FormMapBuilder, FormStatistics};
pub use points::{PointAlignment, PointResidual, align_points};
pub use pose::Pose;
pub use unit::{LengthUnit, SizeRange};
pub use vertex_patch::VertexPatch;

use crate::geom::{DVec3, TriMesh};
use crate::mirror::Mirror;
use coarse_search::coarse_search;
use normal_equations::{AlignmentResidual, GaussNewtonStep, NormalEquations, biweight, residuals};
use reference_surface::ReferenceSurface;
use serde::Serialize;
use thiserror::Error;
use vertex_patch::{is_upside_down, patches};

/// Pose of a measured mesh, with the quality of its determination.
#[derive(Debug, Clone, PartialEq)]
pub struct Alignment {
    /// Motion from the file's frame to the part frame.
    pub pose: Pose,
    /// Whether the facets show the camera their backs and have to be reversed.
    pub turned_over: bool,
    /// Weighted RMS distance of the vertices from the mirror, outliers left out, mm.
    pub rms_mm: f64,
    /// Share of outliers: of the area around vertices within a twentieth of the width from the
    /// mirror.
    pub outliers: f64,
    /// Standard deviation of normal noise with the residuals' median, mm.
    pub scale_mm: f64,
    /// Share of the mirror's area that the other vertices stand for.
    pub covered: f64,
    /// Number of vertices that determine the pose.
    pub vertices: usize,
    /// Number of Gauss-Newton steps with all vertices.
    pub steps: usize,
    /// Condition number of the fit, without the free motions.
    pub condition: f64,
    /// Motions that move the mirror along itself, in which the pose is the file's.
    pub free: Vec<FreeMotion>,
}

/// A motion that the mirror's shape does not determine: it moves the surface along itself.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct FreeMotion {
    /// Along this unit vector, or about an axis along it.
    #[cfg_attr(test, schemars(with = "[f64; 3]"))]
    pub direction: DVec3,
    /// A place on that axis, mm; none for a shift.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(with = "Option<[f64; 3]>"))]
    pub through_mm: Option<DVec3>,
}

/// Why a mesh could not be aligned.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum AlignError {
    /// There is hardly anything to go by.
    #[error(
        "only {found} vertices lie on the mirror after the best fit, {FEWEST} are needed: check \
         that the file is of this part, that its pose is within 20 degrees and a fifth of the \
         width of the part frame's, and its units (--units)"
    )]
    Few {
        /// Vertices.
        found: usize,
    },
    /// The mesh covers too little of the mirror.
    #[error(
        "the file covers {:.1} % of the mirror after the best fit, {:.0} % are needed: scan more \
         of the face, or check that its pose is within 20 degrees and a fifth of the width of the \
         part frame's, and its units (--units)", 100.0 * .covered, 100.0 * LEAST_COVERED
    )]
    Uncovered {
        /// Share of the mirror's area.
        covered: f64,
    },
    /// The mesh is of something else.
    #[error(
        "the file does not look like this mirror: after the best fit half of it is {:.3} mm off \
         and more; check the profile, that the pose is within 20 degrees and a fifth of the width \
         of the part frame's, and the units (--units)", .off_mm
    )]
    Unlike {
        /// Median distance, mm.
        off_mm: f64,
    },
    /// The steps did not become small.
    #[error(
        "the pose did not settle in {steps} steps (the last moved the part by {last_mm:e} mm): \
         remove what is not part of the mirror from the file"
    )]
    Unsettled {
        /// Steps.
        steps: usize,
        /// Length of the last, mm.
        last_mm: f64,
    },
}

/// Least number of vertices that determine a pose.
const FEWEST: usize = 30;
/// Least share of the mirror that the mesh has to cover.
const LEAST_COVERED: f64 = 0.25;
/// Median distance, as a share of the width, that no scan of the same part has.
const UNLIKE: f64 = 0.005;
/// Standard deviations from which on a vertex is an outlier: the biweight then keeps 95 % of least
/// squares' efficiency under normal noise.
pub(crate) const OUTLIER: f64 = 4.685;
/// Distance, as a share of the width, beyond which facets do not belong to the optical face.
const FACE: f64 = 0.05;
/// Width of the strip at rim and fold that is left out, as a share of the width: edges are rounded, their
/// vertices belong to the skirt as well, and across a fold the normal jumps.
const RIM: f64 = 0.004;
/// Share of a motion across the surface below which the motion is free.
const FLOOR: f64 = 1e-3;
/// Most steps while scale and vertices may change, and most with both fixed.
const ROBUST_STEPS: usize = 16;
const FIXED_STEPS: usize = 60;
/// The last step, and the least scale of the noise, as a share of the width.
const LAST_STEP: f64 = 1e-11;
const LEAST_SCALE: f64 = 1e-10;

impl Alignment {
    /// Brings the mesh that was aligned into the part frame.
    pub fn apply(&self, mesh: &mut TriMesh) {
        let (matrix, shift) = (self.pose.matrix(), self.pose.shift);
        mesh.vertices.iter_mut().for_each(|v| *v = matrix * *v + shift);
        if self.turned_over {
            mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
    }
}

/// Aligns `mesh` (millimetres), which holds the optical face of a part of `mirror`, alone or with
/// whatever is around it, from any pose within 20 degrees of the part frame's and a fifth of the
/// mirror's width. A twentieth of it may be outliers of any size.
///
/// # Errors
/// [`AlignError`] when the mesh does not determine a pose.
pub fn align(mirror: &Mirror, mesh: &TriMesh) -> Result<Alignment, AlignError> {
    let reference = ReferenceSurface::new(mirror);
    let mut patches = patches(mesh);
    let turned_over = is_upside_down(mesh);
    if turned_over {
        patches.iter_mut().for_each(|patch| patch.area = -patch.area);
    }
    let fit =
        aligned(&patches, &reference, |all, reach| (area(all, reach) / reference.area).min(1.0))?;
    Ok(Alignment { turned_over, ..fit })
}

/// The area, mm^2, that residuals below `reach` stand for.
fn area(all: &[Option<AlignmentResidual>], reach: f64) -> f64 {
    let within = all.iter().flatten().filter(|residual| residual.distance.abs() < reach);
    within.map(|residual| residual.area).sum()
}

/// Aligns patches with the reference; `covered`: the share of it that residuals below some reach stand for.
fn aligned(
    patches: &[VertexPatch],
    reference: &ReferenceSurface,
    covered: impl Fn(&[Option<AlignmentResidual>], f64) -> f64,
) -> Result<Alignment, AlignError> {
    let rough = coarse_search(patches, reference);
    let (pose, steps, last) = refine(patches, reference, rough)?;

    let at = |margin: f64| residuals(patches, &pose, |p| reference.project(p, margin));
    let reach = OUTLIER * last.scale;
    let covered = covered(&at(0.0), reach);
    // What stands on the rim may belong to what is beside it, and what is far off to what a pinhole
    // would see through the part.
    let inner = at(RIM * reference.width);
    let vertices = inner.iter().flatten().filter(|r| r.distance.abs() < reach).count();
    let outliers = 1.0 - area(&inner, reach) / area(&inner, reach.max(FACE * reference.width));
    if vertices < FEWEST {
        return Err(AlignError::Few { found: vertices });
    }
    if !(covered >= LEAST_COVERED) {
        return Err(AlignError::Uncovered { covered });
    }
    Ok(Alignment {
        pose,
        turned_over: false,
        rms_mm: last.rms_mm,
        scale_mm: last.scale,
        outliers,
        covered,
        vertices,
        steps,
        condition: last.step.condition,
        free: last.step.free(reference),
    })
}

/// The last step of the fit.
struct FinalStep {
    step: GaussNewtonStep,
    scale: f64,
    rms_mm: f64,
}

/// Gauss and Newton's steps with all vertices: first with weights that follow the residuals, then
/// with a fixed scale and fixed vertices, so that the steps converge to zero.
fn refine(
    patches: &[VertexPatch],
    reference: &ReferenceSurface,
    start: Pose,
) -> Result<(Pose, usize, FinalStep), AlignError> {
    let margin = RIM * reference.width;
    let near = |p: DVec3| reference.project(p, margin);
    let least = LEAST_SCALE * reference.width;
    let (mut pose, mut steps) = (start, 0);
    let mut taken = Vec::new();
    let mut scale = 0.0;
    while steps < ROBUST_STEPS {
        taken = residuals(patches, &pose, near);
        scale = normal_equations::robust_scale(&taken).max(least);
        let equations = weighted_equations(&taken, reference, scale);
        if !(equations.weight > 0.0) {
            return Err(AlignError::Few { found: 0 });
        }
        let step = equations.solve(FLOOR);
        pose = pose.then(&step.pose(reference, 0.1 * reference.width));
        steps += 1;
        if step.length() < 0.01 * scale {
            break;
        }
    }
    // The scale is that of normal noise with this median.
    let off_mm = scale / 1.4826;
    if off_mm > UNLIKE * reference.width {
        return Err(AlignError::Unlike { off_mm });
    }
    let chosen: Vec<VertexPatch> =
        patches.iter().zip(&taken).filter(|(_, taken)| taken.is_some()).map(|p| *p.0).collect();
    let anywhere = |p: DVec3| reference.project(p, 0.0);
    let mut last_mm = f64::INFINITY;
    for _ in 0..FIXED_STEPS {
        let equations = weighted_equations(&residuals(&chosen, &pose, anywhere), reference, scale);
        let step = equations.solve(FLOOR);
        pose = pose.then(&step.pose(reference, 0.1 * reference.width));
        steps += 1;
        let length = step.length();
        // Rounding keeps the steps from becoming smaller still.
        let rounded = length < 1e3 * LAST_STEP * reference.width && length >= 0.5 * last_mm;
        if length < LAST_STEP * reference.width || rounded {
            let rms_mm = (equations.squares / equations.weight).sqrt();
            return Ok((pose, steps, FinalStep { step, scale, rms_mm }));
        }
        last_mm = length;
    }
    Err(AlignError::Unsettled { steps, last_mm })
}

fn weighted_equations(
    residuals: &[Option<AlignmentResidual>],
    reference: &ReferenceSurface,
    scale: f64,
) -> NormalEquations {
    let reach = OUTLIER * scale;
    NormalEquations::of(residuals, reference, |residual| {
        residual.area * biweight(residual.distance, reach)
    })
}
