//! Mirrors beyond their outline: the osculating paraboloid of the nearest point of the rim.
//!
//! A series grows without bound beyond its rectangle. Tools and probes reach over the rim, where all that counts
//! is that the surface goes on smoothly.

use super::{HeightAndSlope, LocalSurface, Mirror, PlanJacobian};
use crate::geom::DVec2;

/// Steps of Newton's method, which converges in a handful.
const MOST_STEPS: usize = 32;

impl Mirror {
    /// The mirror's point over `q` of the chart, on any panel. Beyond the outline the surface goes on as the
    /// parabola that it has on the rim nearest to `q`.
    #[must_use]
    pub fn extended_surface(&self, q: DVec2) -> LocalSurface {
        self.extended_surface_and_jacobian(q).0
    }

    /// The same with the derivatives of X and of Y by q.
    #[must_use]
    pub fn extended_surface_and_jacobian(&self, q: DVec2) -> (LocalSurface, PlanJacobian) {
        let reflected = self.reflects(q);
        let q = if reflected { DVec2::new(q.x, -q.y) } else { q };
        let known = self.outline.nearest(q);
        let (point, hessian) = self.surface.at_with_hessian(known);
        let (beyond, turn) = (q - known, hessian.times(q - known));
        let f = point.f + beyond.dot(point.slope + 0.5 * turn);
        let point = HeightAndSlope { f, slope: point.slope + turn };
        let (surface, jacobian) = LocalSurface::with_jacobian(&self.chart, q, &point, &hessian);
        if reflected { (surface.reflected(), jacobian.reflected()) } else { (surface, jacobian) }
    }

    /// The mirror's point over (X, Y) = `xy`; none where Newton's method finds none.
    #[must_use]
    pub fn extended_surface_over(&self, xy: DVec2) -> Option<LocalSurface> {
        Some(self.extended_surface_near(xy, xy)?.0)
    }

    /// The same, searched for from `near` of the chart on, and its coordinates on the chart.
    #[must_use]
    pub fn extended_surface_near(&self, xy: DVec2, near: DVec2) -> Option<(LocalSurface, DVec2)> {
        if self.chart.is_plan() {
            return Some((self.extended_surface(xy), xy));
        }
        let size = self.full_outline().bounds().size().max_element();
        let mut q = near;
        for _ in 0..MOST_STEPS {
            let (surface, jacobian) = self.extended_surface_and_jacobian(q);
            let off = xy - surface.at.truncate();
            if off.length() <= 1e-12 * size {
                return Some((surface, q));
            }
            q += jacobian.step(off);
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::{quadric, roof};
    use super::*;

    #[test]
    fn slopes_and_hessians_are_those_of_z_over_x_and_y() {
        for vergence in [0.0, 0.03] {
            let mirror = quadric([-0.06, 0.02, 0.05], vergence);
            let e = 1e-4;
            for xy in [DVec2::new(1.3, -2.1), DVec2::new(-3.0, 0.4), DVec2::ZERO] {
                let place = mirror.extended_surface_over(xy).unwrap();
                assert!((place.at.truncate() - xy).length() < 1e-10);
                let near = |d: DVec2| mirror.extended_surface_over(xy + d * e).unwrap();
                for (d, row) in [
                    (DVec2::X, DVec2::new(place.hessian.xx, place.hessian.xy)),
                    (DVec2::Y, DVec2::new(place.hessian.xy, place.hessian.yy)),
                ] {
                    let (a, b) = (near(d), near(-d));
                    assert!(((a.at.z - b.at.z) / (2.0 * e) - place.slope.dot(d)).abs() < 1e-7);
                    assert!(((a.slope - b.slope) / (2.0 * e) - row).length() < 1e-7, "{vergence}");
                }
            }
        }
    }

    #[test]
    fn beyond_the_rim_the_surface_goes_on_smoothly() {
        let mirror = quadric([-0.06, 0.02, 0.05], 0.0);
        let q = DVec2::new(4.7, -4.3);
        let exact = -0.06 * q.x * q.x + 0.02 * q.x * q.y + 0.05 * q.y * q.y + 7.0;
        assert!((mirror.extended_surface(q).at.z - exact).abs() < 1e-12);
    }

    #[test]
    fn single_places_have_the_bits_of_rows_on_both_panels() {
        for mirror in [quadric([-0.06, 0.02, 0.05], 0.03), roof(17.0)] {
            for q in [[1.3, -2.1], [-3.0, 0.4], [0.7, 0.0], [2.0, 3.9], [2.0, -3.9]] {
                let q = DVec2::from_array(q);
                assert_eq!(mirror.at(q), mirror.row(q.y).at(q.x), "{q}");
            }
        }
    }
}
