//! Slopes that a face has and its facets have not.

use super::ray_end::{Outcome, RayEnd};
use crate::geom::{DVec2, DVec3, Ray};
use crate::optics::reflect;
use std::fmt::Debug;

/// Slopes of a face that is rougher than its facets can tell, as one that was cut is: they turn reflected rays, where facets only
/// tell where rays meet it, and what hides what.
pub trait FaceSlopes: Debug + Sync {
    /// The slope (Z_X, Z_Y) of the face over a place of the plan, mm, on a facet; none where the facet's own counts.
    fn slope_on(&self, facet: u32, at: DVec2) -> Option<DVec2>;
}

/// The direction of the reflected ray of `ray`, which ends as `end`, at a face with these slopes.
pub(super) fn reflected(slopes: Option<&dyn FaceSlopes>, ray: &Ray, end: &RayEnd) -> DVec3 {
    let slope = slopes
        .filter(|_| end.outcome == Outcome::Hit)
        .and_then(|slopes| slopes.slope_on(end.facet, end.hit_point(ray).truncate()));
    let normal = slope.map(|slope| (-slope).extend(1.0));
    // (Not at the back of a slope.)
    let normal = normal.filter(|normal| normal.dot(ray.direction) < 0.0);
    normal.map_or(end.direction, |normal| reflect(ray.direction, normal))
}
