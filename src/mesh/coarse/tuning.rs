//! Constants of the coarse mesh that were chosen by measurement or trial.
//!
//! Where a field names no measurement, it was chosen by trial for the fewest triangles on the surfaces of
//! `benches/mesh.rs` (`cargo bench --bench mesh -- --economy`), or for time where it says so.

/// What the repair of one facet takes.
pub(crate) struct RepairCost {
    /// Its cost in facets: its time counts, too.
    pub cost: f64,
    /// Facets that come of it.
    pub facets: f64,
}

/// Constants that tune placement, smoothing and size of the coarse mesh.
pub(crate) struct CoarseTuning {
    /// Coarse triangles of the meshed part, about: so many that few of them are at the rim and that curvature hardly
    /// changes within one.
    pub triangles: f64,
    /// Coarse triangles from which on a first candidate has half as many to the side, to save time.
    pub halve_first_from: f64,
    /// Points of a coarse mesh, and nodes of each of its sides, at most: ten times what is aimed at.
    pub most_points: usize,
    /// Size of facets of the quadratic model relative to the one that the limits allow, in the first candidate.
    pub first_size: f64,
    /// Factor by which squares for the image come out smaller than the model has them: they suffer where cells turn.
    pub image_square_size: f64,
    /// Factor by which squares for the chord error come out smaller.
    pub square_size: f64,
    /// Factor by which the facets of a candidate of half as many cells to the side are found too large: its cells are
    /// strained twice as much.
    pub halved_strain: f64,
    /// Largest ratio of a mesh's cost to that of the best size for which no other size is tried.
    pub cost_tolerance: f64,
    /// Meshes that are drawn again, at most: where all places are alike, the least difference decides whether all
    /// facets fail together.
    pub redraws: usize,
    /// The repair of a facet that is hardly too large, where it makes few others fail.
    pub local_repair: RepairCost,
    /// That repair where failures spread. Of costs 6, 8, 10, 12 and 24, 8 left the fewest facets on a mirror of saddles
    /// whose repair took four seconds of five.
    pub spreading_repair: RepairCost,
    /// Facets that are bounded to find the size; at least half as many.
    pub samples: usize,
    /// Growth (facets that come of each) over which it is probed whether refinement helps.
    pub doubtful_growth: f64,
    /// Share of facets that refinement makes worse, over which the limits are refused.
    pub most_diverging: f64,
    /// Factor on the growth that probes foresee, for neighbours that are split along.
    pub neighbours_split: f64,
    /// Factor by which probes overrate the number of facets where facets are far too large.
    pub overrated: f64,
    /// Facets from which on the proof takes seconds, so that the axis is looked for beforehand.
    pub slow_proof: f64,
    /// Growth up to which samples tell the number of facets closely.
    pub steady_growth: f64,
    /// Number of facets of the face up to which samples tell little.
    pub few_facets: f64,
    /// Number of facets of the face, by samples, up to which a forecast makes the mesh where samples are far from sure:
    /// some seconds, for samples may tell three times as many as there are.
    pub most_made_for_forecast: f64,
    /// Samples along a side of the boundary, from which its nodes are integrated.
    pub boundary_samples: usize,
    /// Distance (in cells) within which a proposed point is an existing one. Neighbouring rows are from this much to
    /// one and this much times their right distance apart.
    pub occupied: f64,
    /// Distance (in cells) within which a proposed point is a boundary node: the lattice need not fit these.
    pub occupied_by_boundary: f64,
    /// Distance (in cells) between a point and its proposal, within which it continues the lattice.
    pub continues: f64,
    /// Distance (in cells) between a boundary node and a proposal, within which it continues the lattice.
    pub continues_at_boundary: f64,
    /// Distance of the lattice from the boundary, in cells.
    pub clearance: f64,
    /// Distance (in cells) from every point, beyond which a place has been left out.
    pub uncovered: f64,
    /// Rounds of relaxation, at most.
    pub relaxation_rounds: usize,
    /// Overrelaxation: the step of a point, in steps to the mean of where its neighbours would have it.
    pub overrelaxation: f64,
    /// Step (in cells) under which relaxation has converged.
    pub relaxed_step: f64,
    /// Rounds of flips and moves after triangulation.
    pub smoothing_rounds: usize,
    /// Oversize, in shares of the one aimed at, over which vertices are moved then.
    pub movable_oversize: f64,
}

/// The constants in use.
pub(crate) const TUNING: CoarseTuning = CoarseTuning {
    triangles: 11_000.0,
    halve_first_from: 6_000.0,
    most_points: 100_000,
    first_size: 0.985,
    image_square_size: 0.86,
    square_size: 0.93,
    halved_strain: 1.015,
    cost_tolerance: 1.03,
    redraws: 3,
    local_repair: RepairCost { cost: 3.0, facets: 1.0 },
    spreading_repair: RepairCost { cost: 8.0, facets: 3.0 },
    samples: 1200,
    doubtful_growth: 1.3,
    most_diverging: 0.01,
    neighbours_split: 1.2,
    overrated: 8.0,
    slow_proof: 1e6,
    steady_growth: 1.1,
    few_facets: 10_000.0,
    most_made_for_forecast: 5e6,
    boundary_samples: 128,
    occupied: 0.7,
    occupied_by_boundary: 0.35,
    continues: 0.35,
    continues_at_boundary: 0.12,
    clearance: 0.25,
    uncovered: 1.3,
    relaxation_rounds: 25,
    overrelaxation: 1.5,
    relaxed_step: 2e-3,
    smoothing_rounds: 8,
    movable_oversize: 1.04,
};
