//! What a machine has to travel.

use thiserror::Error;

/// That a machine is too small for its programs.
#[derive(Debug, Clone, PartialEq, Error)]
#[error(
    "the programs travel {needed_mm:.1} mm along {axis}, and program.travel_mm has {travel_mm} mm: take a larger machine, a smaller \
     part, or less program.stock_mm or safe_mm"
)]
pub struct TravelExceeded {
    /// The axis.
    pub axis: &'static str,
    /// What the programs need, mm.
    pub needed_mm: f64,
    /// What there is, mm.
    pub travel_mm: f64,
}
