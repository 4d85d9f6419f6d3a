//! What rays of a mirror look at: directions, and places of a floor.

use crate::geom::Ray;
use crate::num::{asin, atan2, degrees};

/// A direction by its angles, degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Direction {
    /// From Y towards X.
    pub azimuth_deg: f64,
    /// Above the plane of X and Y, towards Z, where the camera is.
    pub elevation_deg: f64,
}

impl Direction {
    /// That of a ray.
    #[must_use]
    pub fn of(ray: &Ray) -> Self {
        let [x, y, z] = ray.direction.to_array();
        Self { azimuth_deg: degrees(atan2(x, y)), elevation_deg: degrees(asin(z.clamp(-1.0, 1.0))) }
    }
}

/// The pole from which directions are projected stereographically.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pole {
    /// The direction -Z: what looks along Z is at the origin.
    Below,
    /// The direction Z.
    Above,
}

impl Pole {
    /// The one that is farther from all rays.
    #[must_use]
    pub fn away_from<'r>(rays: impl Iterator<Item = &'r Ray>) -> Self {
        let most = rays
            .map(|ray| ray.direction.z)
            .fold([1.0, -1.0], |[low, high], z: f64| [f64::min(low, z), f64::max(high, z)]);
        if most[0] + 1.0 >= 1.0 - most[1] { Self::Below } else { Self::Above }
    }

    /// 1 or -1: u = x / (1 + s z), v = y / (1 + s z).
    #[must_use]
    pub fn sign(self) -> f64 {
        match self {
            Self::Below => 1.0,
            Self::Above => -1.0,
        }
    }

    /// Stereographic coordinates of a ray's direction.
    #[must_use]
    pub fn project(self, ray: &Ray) -> [f64; 2] {
        let [x, y, z] = ray.direction.to_array();
        let shrink = 1.0 + self.sign() * z;
        [x / shrink, y / shrink]
    }
}

/// A plane across the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FloorPlane {
    /// Its Z in the part's frame, mm.
    pub z_mm: f64,
    /// Places farther from the axis are not told, mm.
    pub range_mm: f64,
}

impl FloorPlane {
    /// X and Y at which a ray meets the plane within its range, mm.
    #[must_use]
    pub fn meets(&self, ray: &Ray) -> Option<[f64; 2]> {
        let way = (self.z_mm - ray.origin.z) / ray.direction.z;
        let at = ray.origin + ray.direction * way;
        let near = at.truncate().length() <= self.range_mm;
        (way > 0.0 && near).then(|| at.truncate().to_array())
    }
}
