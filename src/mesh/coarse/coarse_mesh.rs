//! The coarse mesh, each triangle of which is cut into as many equal facets, and the estimate of what comes of it.

use super::boundary_nodes::BoundaryNodes;
use super::delaunay;
use super::point_placement::PointPlacement;
use super::tuning::TUNING;
use crate::geom::{DVec2, Rect};
use crate::mesh::bound::error_bound::Limits;
use crate::mesh::bound::error_bounder::ErrorBounder;
use crate::mesh::error::MeshError;
use crate::mesh::refine::boundary_arcs::BoundaryArcs;
use crate::mesh::refine::probe::{ProbeOutcome, RefinementProbe};
use crate::mesh::refine::repair_progress::{FailureSpread, most_facets};
use crate::mesh::refine::triangulation::EditableTriangulation;
use crate::mesh::sizing::frame_field::FrameField;
use crate::mirror::Mirror;
use crate::parallel;

/// Growth and cost of a coarse mesh, by the bounds of some of its facets.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct GrowthEstimate {
    /// Facets after all repairs, for every one proposed.
    pub growth: f64,
    /// Growth with the cost of repairs counted in facets.
    pub cost: f64,
    /// Factor on the cells at which the cost is least.
    pub best_scale: f64,
    /// The cost at that factor.
    pub least_cost: f64,
}

impl GrowthEstimate {
    /// Whether no other size is worth a try.
    pub(crate) fn is_near_best(&self) -> bool {
        self.cost <= TUNING.cost_tolerance * self.least_cost
    }

    /// The estimate from the shrinkages that sampled facets require, sorted.
    fn new(shrinkages: &[f64], spread: FailureSpread) -> Self {
        let repair = match spread {
            FailureSpread::Local => TUNING.local_repair,
            FailureSpread::Wide => TUNING.spreading_repair,
        };
        let count = shrinkages.len();
        // The cost of repairing a facet is as its area.
        let squares: Vec<f64> = shrinkages.iter().map(|e| e * e).collect();
        let mut after = vec![0.0; count + 1];
        for k in (0..count).rev() {
            after[k] = after[k + 1] + squares[k];
        }
        let share = |sum: f64| repair.cost * sum / count as f64;
        // For a facet to hold just so, all must be the smaller by its oversize.
        let least = |k: usize| squares[k] + share(after[k + 1]);
        let best = (count / 2..count).min_by(|&a, &b| least(a).total_cmp(&least(b)));
        let of = |k: usize| (1.0 / shrinkages[k], least(k));
        let is_sound = |(scale, _): &(f64, f64)| scale.is_finite() && *scale > 0.0;
        let (best_scale, least_cost) = best.map(of).filter(is_sound).unwrap_or((1.0, 1.0));
        let repaired = share(after[shrinkages.partition_point(|&e| e <= 1.0)]);
        let growth = 1.0 + repair.facets / repair.cost * repaired;
        Self { growth, cost: 1.0 + repaired, best_scale, least_cost }
    }
}

/// A coarse mesh of the meshed part of a mirror.
pub(crate) struct CoarseMesh {
    /// The cells of its lattice.
    pub frames: FrameField,
    /// The arcs of its boundary.
    pub arcs: BoundaryArcs,
    /// Its triangles.
    pub net: EditableTriangulation,
    /// Estimate of the facets that come of it; zero before [`Self::estimate_growth`].
    pub estimate: GrowthEstimate,
    samples: Vec<FacetSample>,
}

/// One facet of a coarse mesh.
#[derive(Debug, Clone, Copy)]
struct FacetSample {
    /// Its corners in the chart, mm.
    corners: [DVec2; 3],
    /// Factor by which it must shrink to keep the limits.
    shrinkage: f64,
    /// The outcome of its refinement probe, where there was one.
    probed: Option<ProbeOutcome>,
}

impl CoarseMesh {
    /// The part `domain` of `mirror` covered with the cells of `frames`.
    ///
    /// # Errors
    /// [`MeshError::SizeContrast`] where cells shrink without end, [`MeshError::PointRejected`] by spade.
    pub(crate) fn new(
        mirror: &Mirror,
        domain: Rect,
        frames: FrameField,
    ) -> Result<Self, MeshError> {
        let contrast = |at| MeshError::SizeContrast { at };
        let boundary = BoundaryNodes::new(mirror, domain, &frames).map_err(contrast)?;
        let placed = PointPlacement::new(&frames, &boundary).map_err(contrast)?;
        let net = delaunay::triangulate(placed, &boundary, &frames)?;
        let estimate = GrowthEstimate::default();
        Ok(Self { frames, arcs: boundary.arcs, net, estimate, samples: Vec::new() })
    }

    /// Estimated number of facets that come of it.
    pub(crate) fn facets(&self) -> f64 {
        self.proposed() * self.estimate.growth
    }

    /// Whether a forecast has to make the mesh of which the face holds `copies`: samples are far from sure.
    pub(crate) fn must_be_made_to_count(&self, copies: usize) -> bool {
        let facets = self.facets() * copies as f64;
        facets <= TUNING.few_facets
            || (self.estimate.growth > TUNING.steady_growth
                && facets <= TUNING.most_made_for_forecast)
    }

    /// Number of facets that its triangles are cut into.
    pub(crate) fn proposed(&self) -> f64 {
        let parts = self.frames.parts as f64;
        self.net.triangles.len() as f64 * parts * parts
    }

    /// The mesh with its growth estimated from the bounds of one facet in each of some triangles.
    pub(crate) fn estimate_growth(
        mut self,
        bounder: &ErrorBounder,
        limits: Limits,
        spread: FailureSpread,
    ) -> Self {
        let probe = RefinementProbe::new(bounder, limits);
        let facets = self.sample_facets().collect::<Vec<_>>();
        self.samples = parallel::map_slice(&facets, 1, |&corners| {
            let (shrinkage, probed) = probe.required_shrinkage(corners);
            FacetSample { corners, shrinkage, probed }
        });
        let mut shrinkages: Vec<f64> = self.samples.iter().map(|sample| sample.shrinkage).collect();
        shrinkages.sort_by(f64::total_cmp);
        self.estimate = GrowthEstimate::new(&shrinkages, spread);
        self
    }

    /// The same where `known` may have the same facets, whose samples then serve for both.
    pub(crate) fn estimate_growth_beside(
        self,
        known: &CoarseMesh,
        bounder: &ErrorBounder,
        limits: Limits,
        spread: FailureSpread,
    ) -> Self {
        if self.has_facets_of(known) {
            return Self { estimate: known.estimate, samples: known.samples.clone(), ..self };
        }
        self.estimate_growth(bounder, limits, spread)
    }

    /// Whether both are cut into the same facets: where cells are as large as they may be, other sizes change nothing.
    fn has_facets_of(&self, other: &CoarseMesh) -> bool {
        self.frames.parts == other.frames.parts
            && self.net.triangles == other.net.triangles
            && self.net.vertices == other.net.vertices
    }

    /// Checks that refinement meets the limits without too many facets, if many facets would have to be split; the mesh
    /// with its growth estimated more closely then.
    ///
    /// # Errors
    /// [`MeshError`] where it does not.
    pub(crate) fn check_refinable(
        mut self,
        bounder: &ErrorBounder,
        limits: Limits,
        copies: usize,
    ) -> Result<Self, MeshError> {
        if self.estimate.growth <= TUNING.doubtful_growth {
            return Ok(self);
        }
        // A mesh of few facets is checked facet by facet soon enough.
        if limits.facet_mm.is_some() && self.proposed() > TUNING.slow_proof {
            self.check_axis(bounder)?;
        }
        let probe = RefinementProbe::new(bounder, limits);
        let outcome =
            |sample: &FacetSample| sample.probed.unwrap_or_else(|| probe.probe(sample.corners));
        let outcomes = parallel::map_slice(&self.samples, 1, outcome);
        let diverges = |outcome: &ProbeOutcome| *outcome == ProbeOutcome::Diverges;
        let diverging = outcomes.iter().filter(|outcome| diverges(outcome)).count();
        if diverging as f64 > TUNING.most_diverging * outcomes.len() as f64 {
            return Err(self.worst(&probe, &outcomes, diverges).expect("there are some"));
        }
        // A sample of unknown outcome counts as one facet.
        let facets = |outcome: &ProbeOutcome| match *outcome {
            ProbeOutcome::Converges(facets) => facets,
            ProbeOutcome::Diverges | ProbeOutcome::Unknown => 1.0,
        };
        let growth = outcomes.iter().map(facets).sum::<f64>() / outcomes.len() as f64;
        self.estimate.growth = growth;
        MeshError::check_facets(
            self.proposed() * TUNING.neighbours_split * growth * copies as f64,
        )?;
        if self.facets() > TUNING.overrated * most_facets(self.proposed() as usize) as f64 {
            return Err(self.worst(&probe, &outcomes, |_| true).expect("there are facets"));
        }
        Ok(self)
    }

    /// The error of the sample with the largest oversize, of those whose outcome is as asked for.
    fn worst(
        &self,
        probe: &RefinementProbe,
        outcomes: &[ProbeOutcome],
        is_asked: impl Fn(&ProbeOutcome) -> bool,
    ) -> Option<MeshError> {
        let asked = self.samples.iter().zip(outcomes).filter(|(_, outcome)| is_asked(outcome));
        let oversizes =
            asked.map(|(sample, _)| (probe.oversize(sample.corners, 1.0), sample.corners));
        let worst = oversizes.max_by(|a, b| a.0.total_cmp(&b.0));
        worst.map(|(_, corners)| probe.not_refinable(corners))
    }

    /// Checks that no facet is near places where the mirror may look along its axis.
    fn check_axis(&self, bounder: &ErrorBounder) -> Result<(), MeshError> {
        let on_axis = |t: &[u32; 3]| {
            let mut parts = vec![(t.map(|v| self.net.vertices[v as usize]), 1)];
            while let Some(([a, b, c], size)) = parts.pop() {
                if !bounder.may_be_on_axis(&[a, b, c].map(|q| bounder.vertex_at(q))) {
                    continue;
                }
                if size >= self.frames.parts {
                    return Some(a);
                }
                let [ab, bc, ca] = [(a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5];
                let quarters = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]];
                parts.extend(quarters.map(|part| (part, 2 * size)));
            }
            None
        };
        let triangles = &self.net.triangles;
        let found = parallel::gather(triangles.len(), 1, |part| {
            triangles[part].iter().find_map(on_axis).into_iter().collect()
        });
        match found.into_iter().next() {
            Some(at) => Err(MeshError::OnAxis { at }),
            None => Ok(()),
        }
    }

    /// The corners of one facet in the middle of each of some triangles, mm.
    fn sample_facets(&self) -> impl Iterator<Item = [DVec2; 3]> {
        let step = self.net.triangles.len().div_ceil(TUNING.samples);
        let share = 1.0 / self.frames.parts as f64;
        self.net.triangles.iter().step_by(step).map(move |t| {
            let corners = t.map(|v| self.net.vertices[v as usize]);
            let centre = (corners[0] + corners[1] + corners[2]) / 3.0;
            corners.map(|p| centre + (p - centre) * share)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Precision;
    use crate::mesh::bound::imaging_problem::ImagingProblem;
    use crate::mesh::sizing::field::SizingField;
    use crate::mirror::fixtures::quadric;

    #[test]
    fn cells_as_large_as_they_may_be_make_the_same_facets_at_any_size() {
        let mirror = quadric([0.01, 0.0, 0.01], 0.0);
        let (chart, outline) = (mirror.chart, mirror.outline);
        let problem = ImagingProblem { mirror: &mirror, camera: chart, view: None };
        let domain = outline.bounds();
        for (chord_mm, same) in [(10.0, true), (1e-4, false)] {
            let precision = Precision::Double;
            let limits = Limits { chord_mm: Some(chord_mm), facet_mm: None, precision };
            let bounder = ErrorBounder::new(&mirror, &chart, None, precision);
            let sizing = SizingField::new(&problem, domain, limits);
            let drawn = |size: f64| {
                let frames = FrameField::new(&sizing, &outline, size, TUNING.triangles);
                CoarseMesh::new(&mirror, domain, frames).unwrap()
            };
            let first = drawn(1.0).estimate_growth(&bounder, limits, FailureSpread::Local);
            let other = drawn(0.8);
            assert_eq!(other.has_facets_of(&first), same, "{chord_mm}");
            let spread = FailureSpread::Local;
            let known = other.estimate_growth_beside(&first, &bounder, limits, spread);
            let afresh = drawn(0.8).estimate_growth(&bounder, limits, spread);
            assert_eq!(known.estimate.best_scale, afresh.estimate.best_scale);
            assert_eq!(known.samples.len(), afresh.samples.len());
        }
    }
}
