//! Constants of the bounds that were chosen by measurement or trial.
//!
//! None of them decides whether a bound holds; they trade the tightness of bounds against time and memory. Where a
//! field names no measurement, it was chosen by trial on the surfaces of `benches/mesh.rs`.

use std::ops::Range;

/// Constants that tune the tightness and the cost of bounds.
pub(crate) struct BoundTuning {
    /// Parts of the radius of a round mirror in its bound table: bounds over a part lose some per cent only, and a
    /// table that is filled as it is asked for costs some milliseconds.
    pub axis_columns: usize,
    /// Facet diameter of the finest level of that table, in parts. Levels double it.
    pub finest_level: f64,
    /// Number of those levels: the last one is `finest_level * 2^12` = 512 parts, beyond the mirror's diameter.
    pub levels: usize,
    /// Distance around a facet for which the table's bounds hold, in sizes of the mirror: rounded corners and the
    /// parallax of good facets stay within it, and it is far below a part.
    pub table_margin: f64,
    /// Cells to the side of one cell of the mirror's bound grid. 4 makes tables that take twice as long as all else of a mesh
    /// of 40 000 facets, 2 bounds so loose before a near floor that a mesh of a million facets takes an eighth longer.
    pub cells_per_grid_cell: usize,
    /// Cells for parts of `coarser_for_facets`.
    pub coarser_cells_per_grid_cell: usize,
    /// Facets of parts whose table is coarser: the other one takes longer than all else of a mesh of some thousand facets, which 2 cells nearly
    /// halve. Fewer facets are as large as some cells, and what those reach beyond them loosens bounds: four views took 12 % more facets.
    pub coarser_for_facets: Range<f64>,
    /// Share of the range of the mirror's gradient by which the range of facet gradients is wider at each end, where the mirror's is that of all
    /// places which facets reach: these are means over edges and leave the mirror's range by a little.
    pub gradient_margin: f64,
    /// That share where the mirror's range is that of a cell: facets as large as cells reach a whole cell beyond it on either side. What facets
    /// themselves add to second derivatives is some thousandths of all.
    pub gradient_reach: f64,
    /// Distance in h by which facets may lie off the mirror for the table's bounds of their contents, in sizes of the mirror: many times the
    /// chord error of all but the coarsest, which are looked at closely.
    pub height_reach: f64,
    /// Second derivative of the content, in units of one over the mirror's size, from which on a box is divided: so
    /// much costs facets of a pixel in a thousand some per cent.
    pub loose_second_derivative: f64,
    /// Number of times that such a box is divided. Where bounds are loose after that, each facet is looked at closely.
    pub box_divisions: usize,
    /// Parts to the side of a divided box.
    pub box_parts: usize,
    /// Largest ratio of a quick facet error to the one at the corners that is not looked at more closely: few facets
    /// are over it, near poles and where they are as large as grid cells.
    pub quick_ratio: f64,
    /// Largest share by which a bound should exceed an error that is attained (theory, after T47).
    pub tightness: f64,
    /// Divisions of one facet, at most.
    pub most_divisions: usize,
    /// Divisions of one facet, at most, when only the limits are to be decided.
    pub most_divisions_to_decide: usize,
    /// Divisions of one facet, at most, where formulas over intervals bound parts of which the table tells too little: these take long.
    pub most_slow_divisions_to_decide: usize,
    /// Divisions after which a facet without any finite bound is given up.
    pub most_divisions_unbounded: usize,
    /// Largest ratio of a quick bound to its limit for which division is tried: bounds over it seldom come down to the
    /// limit.
    pub decidable_ratio: f64,
    /// Divisions of one facet, at most, for a rough bound.
    pub most_rough_divisions: usize,
    /// Ratio of a rough bound to its limit under which its exact size does not matter: such a facet is not the one
    /// that decides on the size of cells.
    pub well_below_limit: f64,
    /// Share of a part's error that the interpolation may add before second derivatives are looked up closely: a table's are nearly as close,
    /// and a division makes that share a quarter, in a tenth of the time that a close look takes.
    pub small_remainder: f64,
    /// Facets that are divided before the errors they attain decide about the others. Fixed, so that results do not
    /// depend on the number of threads.
    pub mesh_batch: usize,
    /// Batches after which the bound of a mesh is left as it is where division is slow.
    pub most_slow_batches: usize,
    /// Divisions of one facet of such a batch.
    pub most_slow_batch_divisions: usize,
    /// Positions that are tried on each side of a vertex to be snapped: with two directions about a hundred in all, of
    /// which one is mostly within `snap_near` (theory, after T48).
    pub snap_positions: i32,
    /// Farthest that a vertex is moved for that, in sizes of the mirror: a two-hundredth of a facet when as many as fit
    /// in memory cover it.
    pub snap_farthest: f64,
    /// Distance of a rounded vertex from the mirror, in steps of the digits of Z, at which no other position is tried.
    /// Without snapping a quarter of a step is usual.
    pub snap_near: f64,
    /// Least share of a rounding error that snapping leaves, as sizes of facets are foreseen. Half of all vertices are
    /// better than `snap_near`; some have no good position.
    pub least_rounding_left: f64,
}

/// The constants in use.
pub(crate) const TUNING: BoundTuning = BoundTuning {
    axis_columns: 192,
    finest_level: 0.125,
    levels: 13,
    table_margin: 1e-6,
    cells_per_grid_cell: 3,
    coarser_cells_per_grid_cell: 2,
    coarser_for_facets: 2e3..2e4,
    gradient_margin: 0.25,
    gradient_reach: 1.0,
    height_reach: 1e-3,
    loose_second_derivative: 100.0,
    box_divisions: 1,
    box_parts: 4,
    quick_ratio: 1.5,
    tightness: 0.04,
    most_divisions: 400,
    most_divisions_to_decide: 64,
    most_slow_divisions_to_decide: 24,
    most_divisions_unbounded: 40,
    decidable_ratio: 4.0,
    most_rough_divisions: 12,
    well_below_limit: 0.7,
    small_remainder: 1.0,
    mesh_batch: 32,
    most_slow_batches: 64,
    most_slow_batch_divisions: 48,
    snap_positions: 24,
    snap_farthest: 1e-6,
    snap_near: 0.02,
    least_rounding_left: 0.05,
};
