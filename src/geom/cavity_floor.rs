//! The floor of a cavity in a part, with drains through it.

use super::{Hole, HoleMeridian};

/// The plane floor of a cavity over the base, mm, and what leads through it.
#[derive(Debug, Clone, PartialEq)]
pub struct CavityFloor {
    /// Its Z.
    pub z_mm: f64,
    /// Holes from the base through the floor; at least one.
    pub drains: Vec<Hole>,
}

impl CavityFloor {
    /// The surfaces of the drains.
    pub fn meridians(&self) -> impl Iterator<Item = HoleMeridian> + '_ {
        self.drains.iter().map(|drain| drain.meridian(self.z_mm))
    }
}
