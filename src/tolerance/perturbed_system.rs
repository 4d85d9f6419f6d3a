//! One made system.

use super::model::PerturbedState;
use crate::num::random::RandomStream;
use crate::tolerance_terms::Perturbation;

/// One made system: its errors, and the patterns that it draws.
#[derive(Debug, Clone, PartialEq)]
pub struct PerturbedSystem {
    /// Its errors.
    pub state: PerturbedState<f64>,
    /// Radius of the disc over which facets displace pixels evenly, px.
    pub facets_px: f64,
    /// Random numbers of what differs from pixel to pixel.
    pub stream: RandomStream,
}

impl PerturbedSystem {
    /// Displacement of sample `k` by facets, px: evenly over a disc, by rejection from the square.
    #[inline]
    pub(super) fn noise(&self, k: usize) -> [f64; 2] {
        if self.facets_px == 0.0 {
            return [0.0; 2];
        }
        let place = |attempt: u32| {
            let draw = 1 + k as u32 + (attempt << 24);
            let [u, v] =
                self.stream.pair(Perturbation::Facets.row().stream, draw).map(|u| 2.0 * u - 1.0);
            (u * u + v * v < 1.0).then_some([u, v])
        };
        let [u, v] = (0..128).find_map(place).unwrap_or_default();
        [self.facets_px * u, self.facets_px * v]
    }
}
