//! Candidates of the coarse mesh, and the choice of the size at which the fewest facets do.

use super::coarse_mesh::CoarseMesh;
use super::tuning::TUNING;
use crate::geom::{DVec2, Rect};
use crate::mesh::bound::error_bound::Limits;
use crate::mesh::bound::error_bounder::ErrorBounder;
use crate::mesh::error::MeshError;
use crate::mesh::refine::repair_progress::FailureSpread;
use crate::mesh::sizing::field::SizingField;
use crate::mesh::sizing::frame_field::FrameField;
use crate::mesh::sizing::lattice::LatticeKind;
use crate::mirror::Mirror;

/// Factor by which the facets of a lattice mostly come out smaller than the model has them.
fn usual_size(kind: LatticeKind) -> f64 {
    match kind {
        LatticeKind::ImageSquares => TUNING.image_square_size,
        LatticeKind::Squares => TUNING.square_size,
        LatticeKind::Triangles | LatticeKind::ImageTriangles => 1.0,
    }
}

/// Change of size along the axes below which fitting left the cells as they were.
const SAME_SIZE: f64 = 1e-9;

/// The mean of the sizes of cells along the axes.
fn mean(size: DVec2) -> f64 {
    (size.x * size.y).sqrt()
}

/// The cells of the mesh that is wanted, of which none has been drawn yet.
pub(crate) struct WantedCells {
    frames: FrameField,
    domain: Rect,
    copies: usize,
    /// Estimated number of facets of the part.
    facets: f64,
}

impl WantedCells {
    /// The cells for the part `domain` of `mirror`, of which the face holds `copies`.
    ///
    /// # Errors
    /// [`MeshError`] where rounding alone exceeds the limits, or there would be too many facets.
    pub(crate) fn new(
        mirror: &Mirror,
        sizing: &SizingField,
        domain: Rect,
        copies: usize,
    ) -> Result<Self, MeshError> {
        sizing.check_chord_rounding(mirror)?;
        let frames = FrameField::new(sizing, &mirror.outline, TUNING.first_size, TUNING.triangles);
        let facets = frames.facet_count(&mirror.outline);
        MeshError::check_facets(facets * copies as f64)?;
        sizing.check_facet_tilt(&mirror.outline, |model| frames.facet_edges(model))?;
        Ok(Self { frames, domain, copies, facets })
    }

    /// Estimated number of facets of the part.
    pub(crate) fn facets(&self) -> f64 {
        self.facets
    }
}

/// The first candidate of a coarse mesh, of which no facet has been bounded yet.
pub(crate) struct CoarseCandidate {
    /// The cells of the mesh that is wanted.
    frames: FrameField,
    domain: Rect,
    copies: usize,
    first: CoarseMesh,
}

impl CoarseCandidate {
    /// A candidate for a mesh of these cells on `mirror`.
    ///
    /// # Errors
    /// [`MeshError`] where cells shrink without end, or points cannot be triangulated.
    pub(crate) fn new(mirror: &Mirror, wanted: WantedCells) -> Result<Self, MeshError> {
        let WantedCells { frames, domain, copies, facets } = wanted;
        let (mut first, usual) = (frames.clone(), usual_size(frames.kind));
        if facets > TUNING.halve_first_from {
            first.coarsen(2);
        } else if usual < 1.0 {
            first.rescale(TUNING.first_size * usual);
        }
        let first = CoarseMesh::new(mirror, domain, first)?;
        Ok(Self { frames, domain, copies, first })
    }

    /// The mesh of the size at which, as far as bounds of some facets tell, the fewest facets do where failures spread so
    /// far.
    ///
    /// # Errors
    /// [`MeshError`] where refinement of its facets is seen not to meet the limits.
    pub(crate) fn choose_size(
        self,
        bounder: &ErrorBounder,
        limits: Limits,
        spread: FailureSpread,
    ) -> Result<CoarseMesh, MeshError> {
        let Self { mut frames, domain, copies, first } = self;
        let draw = |frames: &FrameField, known: &CoarseMesh| {
            let mesh = CoarseMesh::new(bounder.mirror(), domain, frames.clone())?;
            Ok::<_, MeshError>(mesh.estimate_growth_beside(known, bounder, limits, spread))
        };
        let first = first.estimate_growth(bounder, limits, spread);
        let is_whole = first.frames.parts == frames.parts;
        if is_whole && first.estimate.is_near_best() {
            return first.check_refinable(bounder, limits, copies);
        }
        let strain = if is_whole { 1.0 } else { TUNING.halved_strain };
        let size = mean(first.frames.fitted_size()) * first.estimate.best_scale * strain;
        frames.rescale(size);
        let mut best = draw(&frames, &first)?;
        drop(first);
        let mut estimate = best.estimate;
        for _ in 0..TUNING.redraws {
            if estimate.is_near_best() {
                break;
            }
            let before = frames.fitted_size();
            frames.rescale(mean(before) * estimate.best_scale);
            // Whole numbers of cells may leave no other size.
            if frames.fitted_size().abs_diff_eq(before, SAME_SIZE) {
                break;
            }
            let next = draw(&frames, &best)?;
            estimate = next.estimate;
            if next.proposed() * estimate.cost < best.proposed() * best.estimate.cost {
                best = next;
            }
        }
        best.check_refinable(bounder, limits, copies)
    }
}
