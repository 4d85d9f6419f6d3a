//! The surface everywhere beside a mirror by the same distance.

use crate::geom::{DVec2, DVec3};
use crate::mirror::{Hessian, LocalSurface, Mirror, PlanJacobian};

/// Steps of Newton's method for the place of a mirror beside a point.
const MOST_STEPS: usize = 32;
/// What ends them, as a share of the mirror's size.
const CLOSE: f64 = 1e-12;
/// Halvings of a step that does not come nearer: beside a crest, where the mirror is curved nearly as the parallel surface is
/// far, whole steps go across it and back.
const HALVINGS: i32 = 12;

/// A mirror's parallel surface S = P + d n: the points `offset_mm` from the mirror along its unit normals.
#[derive(Debug, Clone, Copy)]
pub struct ParallelSurface<'a> {
    /// The mirror.
    pub mirror: &'a Mirror,
    /// d, mm: positive on the camera's side.
    pub offset_mm: f64,
}

impl ParallelSurface<'_> {
    /// The point beside a place of the mirror, mm.
    #[must_use]
    pub fn beside(&self, place: &LocalSurface) -> DVec3 {
        if self.offset_mm == 0.0 {
            return place.at;
        }
        place.at + self.offset_mm * place.normal()
    }

    /// Derivatives of X and of Y of that point by X and by Y of the place: I + d dn/d(X, Y), with
    /// n = -p / g for the slope p and g = sqrt(1 + p p).
    #[must_use]
    pub fn plan_jacobian(&self, place: &LocalSurface) -> PlanJacobian {
        let (g, p) = (place.stretch(), place.slope);
        let Hessian { xx, xy, yy } = place.hessian;
        let turn = place.hessian.times(p) / (g * g);
        let by = |row: DVec2, p: f64| -self.offset_mm / g * (row - p * turn);
        PlanJacobian {
            x: DVec2::X + by(DVec2::new(xx, xy), p.x),
            y: DVec2::Y + by(DVec2::new(xy, yy), p.y),
        }
    }

    /// The place of the mirror beside which the surface has X and Y `xy`, on the mirror or on what goes on beyond its
    /// rim; none where Newton's method finds none.
    #[must_use]
    pub fn place_over(&self, xy: DVec2) -> Option<LocalSurface> {
        let size = self.mirror.full_outline().bounds().size().max_element();
        let off = |place: &LocalSurface| xy - self.beside(place).truncate();
        let mut at = xy;
        let mut place = self.mirror.extended_surface_over(at)?;
        for _ in 0..MOST_STEPS {
            let left = off(&place);
            if left.length() <= CLOSE * size {
                return Some(place);
            }
            let step = self.plan_jacobian(&place).step(left);
            let over = |share: f64| {
                let to = at + share * step;
                Some((to, self.mirror.extended_surface_over(to)?))
            };
            let is_nearer =
                |(_, place): &(DVec2, LocalSurface)| off(place).length() < left.length();
            let shares = (0..HALVINGS).map(|k| 1.0 / f64::from(1 << k));
            let nearer = shares.filter_map(over).find(is_nearer);
            // Where only rounding is left, none is.
            (at, place) = nearer.or_else(|| over(1.0))?;
        }
        None
    }
}
