//! Constants of the refinement that were chosen by measurement or trial.
//!
//! Where a field names no measurement, it was chosen by trial for few facets and little time on the surfaces of
//! `benches/mesh.rs` and on random mirrors.

/// Constants that tune edits of a triangulation, its repair, and the refinement probe.
pub(crate) struct RefinementTuning {
    /// Share of the worse oversize of two triangles that a flip, or a collapse, may leave at most: less gain is mostly
    /// rounding, and flips would go round in circles.
    pub flip_gain: f64,
    /// Share of the sum of powers of oversizes around a vertex that a move may leave at most.
    pub move_gain: f64,
    /// Share of that gain which a quadratic model has to foresee for a move to be tried.
    pub foreseen_gain: f64,
    /// Trial step of a move, in cells.
    pub move_step: f64,
    /// Longest move along an axis of the cell, in trial steps.
    pub longest_move: f64,
    /// Shares of the foreseen move that are tried in turn.
    pub move_shares: [f64; 3],
    /// Share of the mean area, of two triangles or of those around a vertex, under which one of them is a sliver: the
    /// errors that vertices foresee do not mind slivers that lie right, but rounding does.
    pub sliver_area: f64,
    /// Share of a triangle's longest edge under which an edge is not split.
    pub short_edge: f64,
    /// Edges looked at for each that is to be flipped, after which flipping ends: each flip gains, but by how much
    /// depends on the place that is asked, so that circles are possible.
    pub edges_per_flip: usize,
    /// Passes of smoothing in a round of repair.
    pub smoothing_passes: usize,
    /// Oversize foreseen at a vertex of a failed facet, over which it is moved.
    pub movable_oversize: f64,
    /// Oversize under which a changed facet is left to the proof before it is split: 0.96 is 2 % in the error, about
    /// what the proof adds.
    pub mended_oversize: f64,
    /// Share of the facet limit that rounding takes by tilting a facet, over which the facet is not made smaller before
    /// there is no other way: the smaller it is, the more rounding tilts it (theory, T48).
    pub tilted_share: f64,
    /// Length of an edge, in steps of the digits of single precision, under which it is not split: its halves would not
    /// keep their shape.
    pub shortest_edge_steps: f64,
    /// Facets for every one proposed, at most. Proposals that suit their mirror need a few in a hundred more; past this
    /// refinement does not bring the bounds down.
    pub most_growth: usize,
    /// Facets beyond that for every one proposed, within `spare_facets`: proposals of a few facets need up to eight
    /// times as many.
    pub spare_growth: usize,
    /// Least and largest number of the facets that `spare_growth` gives.
    pub spare_facets: [usize; 2],
    /// Rounds in a row with more failed facets each, after which repair may be given up.
    pub rising_rounds: usize,
    /// Failed facets for every one proposed, over which it then is: numbers that are still small may fall again.
    pub risen_share: usize,
    /// Failed facets beyond that, for small proposals.
    pub risen_spare: usize,
    /// The round in which failures are seen to spread or not.
    pub rounds_to_spread: usize,
    /// Share of the facets that failed at first over which, then, failures spread: 0.16 to 0.26 where repairs add up to
    /// nine facets for each that failed at first, at most 0.1 where they add two.
    pub spreading_share: f64,
    /// Failed facets in that round up to which a repair takes less than a second, whether they spread or not.
    pub few_failed: usize,
    /// Rounds in which vertices are moved and edges split where that is best, though neighbours may fail by it; after
    /// them shapes are kept by longest-edge bisection, which ends.
    pub optimising_rounds: usize,
    /// Such rounds since fewest facets failed: as long as fewer and fewer fail, shapes are improved.
    pub optimising_patience: usize,
    /// Halvings of a facet that the probe tries.
    pub probe_halvings: u32,
    /// Oversize up to which that of a shrinking facet falls with its size, so that no probe is needed.
    pub linear_oversize: f64,
    /// Oversize over which snapping of vertices does not help a facet that rounding tilts.
    pub beyond_snapping: f64,
}

/// The constants in use.
pub(crate) const TUNING: RefinementTuning = RefinementTuning {
    flip_gain: 0.996,
    move_gain: 0.97,
    foreseen_gain: 0.5,
    move_step: 0.06,
    longest_move: 2.5,
    move_shares: [1.0, 0.5, 0.2],
    sliver_area: 0.12,
    short_edge: 0.55,
    edges_per_flip: 20,
    smoothing_passes: 4,
    movable_oversize: 0.81,
    mended_oversize: 0.96,
    tilted_share: 0.3,
    shortest_edge_steps: 64.0,
    most_growth: 3,
    spare_growth: 20,
    spare_facets: [2_000, 40_000],
    rising_rounds: 4,
    risen_share: 4,
    risen_spare: 200,
    rounds_to_spread: 3,
    spreading_share: 0.125,
    few_failed: 400,
    optimising_rounds: 40,
    optimising_patience: 12,
    probe_halvings: 5,
    linear_oversize: 2.0,
    beyond_snapping: 1.5,
};
