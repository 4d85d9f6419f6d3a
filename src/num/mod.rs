//! The one door to mathematics.
//!
//! Platform `sin`, `exp` and their kin differ in the last bit between machines, and "same input,
//! same bytes" would break with them; the functions here are `libm`'s software versions, equal
//! everywhere. `sqrt`, `abs` and rounding are exact in IEEE 754 and may be called directly.

pub mod bernstein;
mod elementary;
pub mod least_squares;
pub mod legendre;
pub mod quadrature;
pub mod stats;

pub use elementary::*;
