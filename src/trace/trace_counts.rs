//! How rays were traced.

use std::ops::Add;

/// Numbers of rays by how they were traced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TraceCounts {
    /// Camera rays whose facet was found by the rasterizer, or whose curved face was met with those of its neighbours.
    pub rasterized: usize,
    /// Camera rays whose facet or face was searched for.
    pub searched: usize,
    /// Reflected rays that were proven unoccluded.
    pub proven: usize,
    /// Reflected rays that were followed.
    pub followed: usize,
}

impl Add for TraceCounts {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            rasterized: self.rasterized + other.rasterized,
            searched: self.searched + other.searched,
            proven: self.proven + other.proven,
            followed: self.followed + other.followed,
        }
    }
}
