//! Alignment of points that a coordinate measuring machine took: on the part, or as centres of its ball.

use super::normal_equations::{AlignmentResidual, residuals};
use super::reference_surface::ReferenceSurface;
use super::{AlignError, Alignment, FACE, OUTLIER, VertexPatch, aligned};
use crate::geom::{DVec2, DVec3};
use crate::mirror::Mirror;

/// A measured point beside the designed mirror, in the part's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointResidual {
    /// The place of the designed mirror that it is above or below, mm.
    pub at: DVec3,
    /// The mirror's unit normal there.
    pub normal: DVec3,
    /// Distance of the made surface from the designed one along it, mm: positive where there is too much material.
    pub distance: f64,
}

/// The pose of measured points, and how far each is off.
#[derive(Debug, Clone, PartialEq)]
pub struct PointAlignment {
    /// The pose.
    pub alignment: Alignment,
    /// What each point says of the mirror, in their order; none of a point beside it, or so far from it that it belongs to
    /// another face.
    pub residuals: Vec<Option<PointResidual>>,
    /// Distance from which on a point is an outlier, mm.
    pub reach_mm: f64,
}

/// Cells along each side of the mirror in one of which a point is to be looked for, at least and at most; points
/// spread evenly have this many to a cell.
const CELLS: [usize; 2] = [2, 12];
const PER_CELL: usize = 6;

/// Aligns points on a part of `mirror`, mm, from any pose within 20 degrees of the part frame's and a fifth of the
/// mirror's width. With `ball_mm` above 0 they are centres of a ball of that radius that touched the part. A twentieth
/// of them may be outliers of any size.
///
/// # Errors
/// [`AlignError`] when the points do not determine a pose.
pub fn align_points(
    mirror: &Mirror,
    points: &[DVec3],
    ball_mm: f64,
) -> Result<PointAlignment, AlignError> {
    let reference = ReferenceSurface::new(mirror).touched_by(ball_mm);
    // Each stands for as much of the plan.
    let area = DVec3::Z * (mirror.full_outline().area() / points.len().max(1) as f64);
    let patches: Vec<VertexPatch> = points.iter().map(|&at| VertexPatch { at, area }).collect();
    let covered = |all: &[Option<AlignmentResidual>], reach: f64| covered(mirror, all, reach);
    let alignment = aligned(&patches, &reference, covered)?;
    let found = residuals(&patches, &alignment.pose, |p| reference.project(p, 0.0));
    let residual = |found: AlignmentResidual| PointResidual {
        at: found.at - (ball_mm + found.distance) * found.normal,
        normal: found.normal,
        distance: found.distance,
    };
    let face_mm = FACE * reference.width;
    let of_face = |found: &AlignmentResidual| found.distance.abs() < face_mm;
    let residuals = found.into_iter().map(|found| found.filter(of_face).map(residual)).collect();
    let reach_mm = OUTLIER * alignment.scale_mm;
    Ok(PointAlignment { alignment, residuals, reach_mm })
}

/// Share of the cells of the mirror that have a point within `reach` of it.
fn covered(mirror: &Mirror, all: &[Option<AlignmentResidual>], reach: f64) -> f64 {
    let outline = mirror.full_outline();
    let bounds = outline.bounds();
    let side = ((all.len() / PER_CELL) as f64).sqrt() as usize;
    let side = side.clamp(CELLS[0], CELLS[1]);
    let mut met = vec![false; side * side];
    let near = all.iter().flatten().filter(|residual| residual.distance.abs() < reach);
    for residual in near {
        let q = (mirror.chart.coordinates(residual.at).0 - bounds.min) / bounds.size();
        let [x, y] = q.to_array().map(|share| (share * side as f64) as usize);
        met[y.min(side - 1) * side + x.min(side - 1)] = true;
    }
    let middle = |k: usize| DVec2::new((k % side) as f64 + 0.5, (k / side) as f64 + 0.5);
    let inside = |k: usize| outline.contains(bounds.min + bounds.size() * middle(k) / side as f64);
    let cells: Vec<usize> = (0..side * side).filter(|&k| inside(k)).collect();
    let found = cells.iter().filter(|&&k| met[k]).count();
    found as f64 / cells.len().max(1) as f64
}
