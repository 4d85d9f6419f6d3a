//! Constants of the budget search that were chosen by measurement or trial.
//!
//! Where a field names no measurement, it was chosen by trial on the shipped profiles: most of the budget used, in few
//! meshes.

/// Share of a budget of triangles below which a search for more goes on, whatever the budget, and a build warns.
pub const LEAST_USED: f64 = 0.95;

/// Constants that tune the search of a limit for a number of triangles.
pub(super) struct BudgetTuning {
    /// Share of the budget that is aimed at.
    pub target: f64,
    /// Share of the budget that must be used for the search to end, for a small and for a large budget: 2 % more of a large one are 1 % of the
    /// facet error (2 % of the chord error), and a mesh more doubles the time of most.
    pub enough: [f64; 2],
    /// Forecasts for an aim, at most.
    pub most_forecasts: usize,
    /// Relative distance to the target at which the last forecast may be, for a small and for a large budget: limits on the grid are a
    /// hundredth apart, numbers of triangles two, and most meshes have as many as foreseen or up to 4 % fewer.
    pub near_target: [f64; 2],
    /// Meshes that are made to use a budget well, at most, for budgets below so many triangles. The numbers of rows and
    /// columns of small meshes go in steps, and large ones take seconds.
    pub most_meshes: [(usize, usize); 2],
    /// Meshes that are made, at most, for larger budgets.
    pub most_large_meshes: usize,
    /// Factor by which a limit changes from mesh to mesh, at most.
    pub longest_step: f64,
    /// Factor by which the limit grows, ever faster, when that many meshes did not keep the budget.
    pub growth: f64,
    /// Meshes refused by rounding, after which finer ones are not tried.
    pub most_refusals: usize,
    /// Loosest limit, over the mirror's size: pictures of near targets may be off by more than their width.
    pub loosest: f64,
    /// Strictest limit in double precision, over the mirror's size.
    pub strictest: f64,
    /// Strictest limit in single precision, whose numbers are 6e-8 apart.
    pub strictest_single: f64,
    /// Ratio of one loose limit to the next where the fewest triangles are looked for.
    pub loose_step: f64,
    /// Step of the limit's logarithm whose change of the number is to be trusted as much as what is known of the power: numbers rise and
    /// fall by chance by some hundredths.
    pub chance: f64,
    /// Least power of the limit that the number of triangles is taken to follow, as a share of theory's power.
    pub least_power: f64,
    /// Share of the budget above which the fewest triangles are made before anything is aimed at: often they are too
    /// many.
    pub close_to_fewest: f64,
    /// Ratio of a limit that may be tried to the next one, the same for all budgets: limits that a budget can choose
    /// from, a larger one can, too.
    pub grid: f64,
    /// Relative distance by which rounding may take a limit off that grid.
    pub grid_rounding: f64,
    /// Finer limits that are tried after the search, for budgets below so many triangles: numbers of triangles rise and
    /// fall by some in a hundred from limit to limit, the less, the larger they are.
    pub finer_limits: [(usize, usize); 2],
    /// Factor on the triangles that theory needs at least, for the first guess.
    pub guess: f64,
    /// Factor on the budget up to which a forecast of the fewest triangles counts as within it: forecasts may be off by
    /// some per cent.
    pub forecast_error: f64,
}

/// The constants in use.
pub(super) const TUNING: BudgetTuning = BudgetTuning {
    target: 0.985,
    enough: [0.97, LEAST_USED],
    most_forecasts: 80,
    near_target: [0.03, 0.015],
    most_meshes: [(20_000, 20), (200_000, 8)],
    most_large_meshes: 5,
    longest_step: 4.0,
    growth: 1.5,
    most_refusals: 2,
    loosest: 10.0,
    strictest: 1e-10,
    strictest_single: 1e-8,
    loose_step: 10.0,
    chance: 0.04,
    least_power: 0.125,
    close_to_fewest: 0.5,
    grid: 1.01,
    grid_rounding: 1e-6,
    finer_limits: [(20_000, 8), (200_000, 3)],
    guess: 1.5,
    forecast_error: 1.1,
};
