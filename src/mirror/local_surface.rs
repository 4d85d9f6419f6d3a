//! A mirror near one of its points: all that first derivatives of reflected rays depend on.

use super::{HeightAndSlope, Hessian};
use crate::geom::{Chart, DVec2, DVec3};
use crate::num::{Dual, Scalar};

/// A point of a mirror with the first and second derivatives of Z over X and Y there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalSurface {
    /// The point, mm.
    pub at: DVec3,
    /// (Z_X, Z_Y).
    pub slope: DVec2,
    /// Z_XX, Z_XY and Z_YY, 1/mm.
    pub hessian: Hessian,
}

impl LocalSurface {
    /// From the height over image point `q` of `chart` and its derivatives there.
    #[must_use]
    pub fn new(chart: &Chart, q: DVec2, point: &HeightAndSlope, curvature: &Hessian) -> Self {
        let Hessian { xx, xy, yy } = *curvature;
        let q = [Dual::<2>::variable(q.x, 0), Dual::variable(q.y, 1)];
        let f = Dual { value: point.f, slope: point.slope.to_array() };
        let s = [
            Dual { value: point.slope.x, slope: [xx, xy] },
            Dual { value: point.slope.y, slope: [xy, yy] },
        ];
        let [x, y, z] = chart.position(q, f);
        let p = chart.slope(q, s);
        // Derivatives along X and Y from those along q.
        let size = x.slope[0] * y.slope[1] - x.slope[1] * y.slope[0];
        let across = |p: Dual<2>| {
            let [a, b] = p.slope;
            [(a * y.slope[1] - b * y.slope[0]) / size, (b * x.slope[0] - a * x.slope[1]) / size]
        };
        let [[xx, xy], [yx, yy]] = p.map(across);
        Self {
            at: DVec3::new(x.value, y.value, z.value),
            slope: DVec2::new(p[0].value, p[1].value),
            hessian: Hessian { xx, xy: 0.5 * (xy + yx), yy },
        }
    }

    /// The reflection in the plane Y = 0.
    #[must_use]
    pub fn reflected(self) -> Self {
        let Hessian { xx, xy, yy } = self.hessian;
        Self {
            at: self.at * DVec3::new(1.0, -1.0, 1.0),
            slope: self.slope * DVec2::new(1.0, -1.0),
            hessian: Hessian { xx, xy: -xy, yy },
        }
    }

    /// Where a ray meets the mirror, and the mirror's slope there: exact with their first
    /// derivatives for rays through the point, to which they belong. The ray leaves (X, Y) = `from`
    /// at height `top_mm` and moves by `tangent` for every mm that it falls.
    #[inline]
    pub fn meet<S: Scalar>(&self, from: [S; 2], top_mm: f64, tangent: [S; 2]) -> ([S; 3], [S; 2]) {
        let Self { at, slope, hessian: bend } = *self;
        let fall = top_mm - at.z;
        let beside = [0, 1].map(|k| from[k] + tangent[k] * fall - at[k]);
        let rise = (beside[0] * slope.x + beside[1] * slope.y)
            / (tangent[0] * slope.x + tangent[1] * slope.y + 1.0);
        let [x, y] = [0, 1].map(|k| beside[k] - tangent[k] * rise);
        let normal = [x * bend.xx + y * bend.xy + slope.x, x * bend.xy + y * bend.yy + slope.y];
        ([x + at.x, y + at.y, rise + at.z], normal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Outline, Rect};
    use crate::mirror::{Mirror, Surface, TensorLegendre};
    use crate::num::legendre::Series;

    /// A bumpy folded mirror over [-20, 20] x [0, 30].
    fn mirror(vergence: f64) -> Mirror {
        let wave =
            |i: usize, j: usize| 0.3 / (1.0 + i as f64 + 2.0 * j as f64) * [1.0, -1.0][i % 2];
        let (centre, half) = (DVec2::new(0.0, 15.0), DVec2::new(20.0, 15.0));
        let series = Series::from_fn(5, 4, wave);
        Mirror {
            surface: Surface::Tensor(TensorLegendre { series, centre, half, scale_mm: 3.0 }),
            chart: Chart { vergence, plane_mm: 8.0 },
            outline: Outline::Rect(Rect { min: centre - half, max: centre + half }),
            folded: true,
            mirror_symmetric: [false; 2],
        }
    }

    /// The place and the slope of the mirror over (X, Y), by Newton's method in the chart.
    fn over(mirror: &Mirror, at: DVec2) -> (f64, DVec2) {
        let mut q = at;
        for _ in 0..60 {
            let point = mirror.row(q.y).at(q.x);
            q += at - mirror.position(q, &point).truncate();
        }
        let point = mirror.row(q.y).at(q.x);
        (mirror.position(q, &point).z, mirror.slope(q, &point))
    }

    #[test]
    fn derivatives_are_those_over_x_and_y_on_both_panels() {
        let h = 1e-4;
        for vergence in [0.0, 0.012] {
            let mirror = mirror(vergence);
            for q in [DVec2::new(7.0, 11.0), DVec2::new(-13.0, -22.0), DVec2::new(1.0, 3.0)] {
                let quadric = mirror.local_surface(q);
                let at = quadric.at.truncate();
                let (z, slope) = over(&mirror, at);
                assert!((quadric.at.z - z).abs() < 1e-11);
                assert!((quadric.slope - slope).length() < 1e-11);
                let change = |way: DVec2| {
                    (over(&mirror, at + way * h).1 - over(&mirror, at - way * h).1) / (2.0 * h)
                };
                let (x, y) = (change(DVec2::X), change(DVec2::Y));
                let off = [quadric.hessian.xx - x.x, quadric.hessian.xy - x.y];
                let more = [quadric.hessian.xy - y.x, quadric.hessian.yy - y.y];
                let worst = off.iter().chain(&more).fold(0.0, |m: f64, e| m.max(e.abs()));
                assert!(worst < 1e-8, "{vergence} {q}: {worst:e} of {:?}", quadric.hessian);
            }
        }
    }

    #[test]
    fn rays_meet_it_as_they_meet_the_mirror_up_to_second_order() {
        let mirror = mirror(0.012);
        let quadric = mirror.local_surface(DVec2::new(7.0, 11.0));
        let (top, tangent) = (70.0, DVec2::new(0.1, 0.2));
        let from = quadric.at.truncate() - tangent * (top - quadric.at.z);
        let off = |size: f64| {
            let (from, tangent) =
                (from + DVec2::new(0.3, -0.4) * size, tangent + DVec2::new(0.004, 0.003) * size);
            let (place, slope) = quadric.meet(from.to_array(), top, tangent.to_array());
            // On the ray to rounding, on the mirror to second order.
            let [x, y, z] = place;
            assert!((from + tangent * (top - z) - DVec2::new(x, y)).length() < 1e-12);
            let (height, exact) = over(&mirror, DVec2::new(x, y));
            (z - height).abs() + (DVec2::from_array(slope) - exact).length()
        };
        let [coarse, fine] = [0.1, 0.05].map(off);
        assert!(fine < 1e-3 && (3.7..4.3).contains(&(coarse / fine)), "{coarse:e} {fine:e}");
    }
}
