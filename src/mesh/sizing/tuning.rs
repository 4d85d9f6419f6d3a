//! Constants of the sizing that were chosen by measurement or trial.
//!
//! Where a field names no measurement, it was chosen by trial for the fewest triangles on the surfaces of
//! `benches/mesh.rs` (`cargo bench --bench mesh -- --economy`).

/// Constants that tune sizes and shapes of cells.
pub(crate) struct SizingTuning {
    /// Cells to the side of the table of local models, which is interpolated linearly: a table that costs milliseconds
    /// and whose error is far below what refinement repairs.
    pub table_cells: usize,
    /// Share of the largest tilt by rounding that occurs in most facets: rounding errors of three vertices seldom add
    /// up at their worst.
    pub likely_tilt: f64,
    /// Longest cells, in widths (theory, T44). Nearly developable mirrors would do with longer ones, in which
    /// neighbouring rows of facets no longer fit each other.
    pub longest_cell: f64,
    /// Share of the quadratic model's oversize that counts beside what the vertices of a facet say: between the
    /// vertices long facets do not keep what these say.
    pub model_share: f64,
    /// Table cells that are looked at closely where the mirror is flattest, for the least error of rounding.
    pub flattest_cells: usize,
    /// Places to the side of each of these.
    pub places_per_cell: usize,
    /// Places along each side of a rectangle that are looked at for the same.
    pub places_per_side: usize,
    /// Growth of the size of neighbouring coarse cells per unit of distance (theory, after T44).
    pub grading: f64,
    /// Share by which a cell may exceed its graded size, so that grading does not bind where it hardly would.
    pub grading_slack: f64,
    /// Largest cell, in sizes of the domain.
    pub largest_cell: f64,
    /// Node intervals to the side of a frame field.
    pub nodes: usize,
    /// Node intervals while the kind of lattice is chosen: counts of facets need no more.
    pub nodes_for_kind: usize,
    /// Share of a coarse cell below which it is rounded to fewer fine cells: up to 1.7 times as many coarse cells as
    /// aimed at where they need not be cut, half as many where they are cut in two.
    pub parts_rounding: f64,
    /// Samples along a side, from which the number of cells on it is integrated.
    pub side_samples: usize,
}

/// The constants in use.
pub(crate) const TUNING: SizingTuning = SizingTuning {
    table_cells: 48,
    likely_tilt: 0.7,
    longest_cell: 4.0,
    model_share: 0.1,
    flattest_cells: 64,
    places_per_cell: 8,
    places_per_side: 512,
    grading: 0.3,
    grading_slack: 1.05,
    largest_cell: 1.0,
    nodes: 48,
    nodes_for_kind: 24,
    parts_rounding: 0.3,
    side_samples: 64,
};
