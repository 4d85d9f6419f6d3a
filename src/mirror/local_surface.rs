//! The surface point: place, slope and second derivatives of a mirror as the graph Z(X, Y) of the part frame.

use super::height_field::{HeightAndSlope, Hessian};
use crate::geom::{Chart, DVec2, DVec3};
use crate::num::{Dual, Scalar};

/// A point of a mirror with the first and second derivatives of Z over X and Y there, whatever its chart.
/// First derivatives of reflected rays, and the fit of a tool, depend on nothing else.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalSurface {
    /// The point, mm.
    pub at: DVec3,
    /// (Z_X, Z_Y).
    pub slope: DVec2,
    /// Z_XX, Z_XY and Z_YY, 1/mm: positive where the surface is hollow, seen from above.
    pub hessian: Hessian,
}

/// The Jacobian matrix of (X, Y) by coordinates of a mirror: the chart's, or X and Y themselves of a surface beside it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanJacobian {
    /// Derivatives of X.
    pub x: DVec2,
    /// Derivatives of Y.
    pub y: DVec2,
}

impl PlanJacobian {
    /// Newton's step of the coordinates for a motion `by` in X and Y, mm.
    #[must_use]
    pub fn step(&self, by: DVec2) -> DVec2 {
        let Self { x, y } = *self;
        DVec2::new(by.perp_dot(DVec2::new(x.y, y.y)), DVec2::new(x.x, y.x).perp_dot(by))
            / x.perp_dot(y)
    }

    /// Area of the plan over that of the coordinates.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.x.perp_dot(self.y)
    }

    /// The Jacobian matrix at the reflected points, of a mirror reflected in the plane Y = 0.
    pub(super) fn reflected(self) -> Self {
        Self { x: self.x * DVec2::new(1.0, -1.0), y: self.y * DVec2::new(-1.0, 1.0) }
    }
}

impl LocalSurface {
    /// From the height over image point `q` of `chart` and its derivatives there.
    #[must_use]
    pub fn new(chart: &Chart, q: DVec2, point: &HeightAndSlope, hessian: &Hessian) -> Self {
        Self::with_jacobian(chart, q, point, hessian).0
    }

    /// The same with the derivatives of X and Y: (X, Y) and the slope are functions of q, and the
    /// derivative of one by the other is the Hessian.
    #[must_use]
    pub fn with_jacobian(
        chart: &Chart,
        q: DVec2,
        point: &HeightAndSlope,
        hessian: &Hessian,
    ) -> (Self, PlanJacobian) {
        let Hessian { xx, xy, yy } = *hessian;
        let q = [Dual::<2>::variable(q.x, 0), Dual::variable(q.y, 1)];
        let f = Dual { value: point.f, slope: point.slope.to_array() };
        let s = [
            Dual { value: point.slope.x, slope: [xx, xy] },
            Dual { value: point.slope.y, slope: [xy, yy] },
        ];
        let [x, y, z] = chart.position(q, f);
        let p = chart.slope(q, s);
        let det = x.slope[0] * y.slope[1] - x.slope[1] * y.slope[0];
        // dp/dq times the inverse of d(X, Y)/dq.
        let by_plan = |p: Dual<2>| {
            let [a, b] = p.slope;
            [(a * y.slope[1] - b * y.slope[0]) / det, (b * x.slope[0] - a * x.slope[1]) / det]
        };
        let [[xx, xy], [yx, yy]] = p.map(by_plan);
        let surface = Self {
            at: DVec3::new(x.value, y.value, z.value),
            slope: DVec2::new(p[0].value, p[1].value),
            hessian: Hessian { xx, xy: 0.5 * (xy + yx), yy },
        };
        let [x, y] = [x, y].map(|x| DVec2::from_array(x.slope));
        (surface, PlanJacobian { x, y })
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

    /// Area of the mirror over its area in the plan: sqrt(1 + |slope|^2).
    #[must_use]
    pub fn stretch(&self) -> f64 {
        (1.0 + self.slope.length_squared()).sqrt()
    }

    /// The unit normal towards +Z.
    #[must_use]
    pub fn normal(&self) -> DVec3 {
        (-self.slope).extend(1.0) / self.stretch()
    }

    /// The second fundamental form less 1/`radius_mm` of the first, over X and Y, 1/mm: the curvature
    /// relative to a ball's. It is negative definite exactly where a ball of that radius, from above,
    /// fits closely.
    #[must_use]
    pub fn relative_curvature(&self, radius_mm: f64) -> Hessian {
        let (g, p, k) = (self.stretch(), self.slope, 1.0 / radius_mm);
        Hessian {
            xx: self.hessian.xx / g - k * (1.0 + p.x * p.x),
            xy: self.hessian.xy / g - k * p.x * p.y,
            yy: self.hessian.yy / g - k * (1.0 + p.y * p.y),
        }
    }

    /// The larger principal curvature, 1/mm: positive where some normal section is hollow. A ball fits
    /// closely where its radius is below the inverse.
    #[must_use]
    pub fn largest_curvature(&self) -> f64 {
        self.curvatures()[1]
    }

    /// The principal curvatures, 1/mm, the lesser one first: positive where the normal section is hollow, seen from above.
    #[must_use]
    pub fn curvatures(&self) -> [f64; 2] {
        let g = self.stretch();
        // Tangents of unit length, up the slope and square to it.
        let way = self.slope.try_normalize().unwrap_or(DVec2::X);
        let (up, level) = (way / g, way.perp());
        let curvature = |a: DVec2, b: DVec2| a.dot(self.hessian.times(b)) / g;
        let (a, b, c) = (curvature(up, up), curvature(up, level), curvature(level, level));
        let half = 0.5 * (a - c);
        let (mean, apart) = (0.5 * (a + c), (half * half + b * b).sqrt());
        [mean - apart, mean + apart]
    }

    /// Where a ray meets the mirror, and the mirror's slope there: exact with their first
    /// derivatives for rays through the point, to which they belong. The ray leaves (X, Y) = `from`
    /// at height `top_mm` and moves by `tangent` for every mm that it falls.
    #[inline]
    pub fn meet<S: Scalar>(&self, from: [S; 2], top_mm: f64, tangent: [S; 2]) -> ([S; 3], [S; 2]) {
        let Self { at, slope, hessian: Hessian { xx, xy, yy } } = *self;
        let fall = top_mm - at.z;
        let beside = [0, 1].map(|k| from[k] + tangent[k] * fall - at[k]);
        let rise = (beside[0] * slope.x + beside[1] * slope.y)
            / (tangent[0] * slope.x + tangent[1] * slope.y + 1.0);
        let [x, y] = [0, 1].map(|k| beside[k] - tangent[k] * rise);
        let normal = [x * xx + y * xy + slope.x, x * xy + y * yy + slope.y];
        ([x + at.x, y + at.y, rise + at.z], normal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Outline, Rect};
    use crate::mirror::{Mirror, Surface, TensorLegendre};
    use crate::num::legendre::{Series, values};
    use crate::num::log;
    use crate::num::quadrature::gauss_legendre;

    /// A bumpy folded mirror over [-20, 20] x [0, 30].
    fn mirror(vergence: f64) -> Mirror {
        let wave =
            |i: usize, j: usize| 0.3 / (1.0 + i as f64 + 2.0 * j as f64) * [1.0, -1.0][i % 2];
        let (centre, half) = (DVec2::new(0.0, 15.0), DVec2::new(20.0, 15.0));
        let series = Series::from_fn(5, 4, wave);
        Mirror {
            surface: Surface::Tensor(TensorLegendre { series, centre, half, scale_mm: 3.0 }),
            chart: Chart::on_axis(vergence, 8.0),
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
                let surface = mirror.local_surface(q);
                let at = surface.at.truncate();
                let (z, slope) = over(&mirror, at);
                assert!((surface.at.z - z).abs() < 1e-11);
                assert!((surface.slope - slope).length() < 1e-11);
                let change = |way: DVec2| {
                    (over(&mirror, at + way * h).1 - over(&mirror, at - way * h).1) / (2.0 * h)
                };
                let (x, y) = (change(DVec2::X), change(DVec2::Y));
                let off = [surface.hessian.xx - x.x, surface.hessian.xy - x.y];
                let more = [surface.hessian.xy - y.x, surface.hessian.yy - y.y];
                let worst = off.iter().chain(&more).fold(0.0, |m: f64, e| m.max(e.abs()));
                assert!(worst < 1e-8, "{vergence} {q}: {worst:e} of {:?}", surface.hessian);
            }
        }
    }

    #[test]
    fn rays_meet_it_as_they_meet_the_mirror_up_to_second_order() {
        let mirror = mirror(0.012);
        let surface = mirror.local_surface(DVec2::new(7.0, 11.0));
        let (top, tangent) = (70.0, DVec2::new(0.1, 0.2));
        let from = surface.at.truncate() - tangent * (top - surface.at.z);
        let off = |size: f64| {
            let (from, tangent) =
                (from + DVec2::new(0.3, -0.4) * size, tangent + DVec2::new(0.004, 0.003) * size);
            let (place, slope) = surface.meet(from.to_array(), top, tangent.to_array());
            // On the ray to rounding, on the mirror to second order.
            let [x, y, z] = place;
            assert!((from + tangent * (top - z) - DVec2::new(x, y)).length() < 1e-12);
            let (height, exact) = over(&mirror, DVec2::new(x, y));
            (z - height).abs() + (DVec2::from_array(slope) - exact).length()
        };
        let [coarse, fine] = [0.1, 0.05].map(off);
        assert!(fine < 1e-3 && (3.7..4.3).contains(&(coarse / fine)), "{coarse:e} {fine:e}");
    }

    /// The upper half of a sphere of radius 60 mm about `centre`, seen by a pinhole 100 mm above its reference
    /// plane, over [-20, 20] x [0, 30] and folded: the Legendre series of its height, to rounding.
    fn sphere(centre: DVec3, chart: Chart) -> Mirror {
        const TERMS: usize = 28;
        let (middle, half) = (DVec2::new(0.0, 15.0), DVec2::new(20.0, 15.0));
        let pupil = DVec3::Z * (chart.plane_mm + 1.0 / chart.vergence);
        let height = |u: f64, v: f64| {
            // The nearer point of the ray pupil + s (q, -1/k), at height -log(s) / k.
            let q = middle + half * DVec2::new(u, v);
            let (way, from) = (q.extend(-1.0 / chart.vergence), pupil - centre);
            let (a, b, c) = (way.dot(way), way.dot(from), from.dot(from) - 60.0 * 60.0);
            -log((-b - (b * b - a * c).sqrt()) / a) / chart.vergence
        };
        let (nodes, weights) = gauss_legendre(2 * TERMS);
        let basis: Vec<Vec<f64>> = nodes.iter().map(|&u| values(TERMS, u)).collect();
        let samples: Vec<Vec<f64>> =
            nodes.iter().map(|&u| nodes.iter().map(|&v| height(u, v)).collect()).collect();
        let series = Series::from_fn(TERMS, TERMS, |i, j| {
            let scale = 0.25 * ((2 * i + 1) * (2 * j + 1)) as f64;
            let term = |k: usize, l: usize| {
                weights[k] * weights[l] * samples[k][l] * basis[k][i] * basis[l][j]
            };
            let rows = (0..nodes.len()).map(|k| (0..nodes.len()).map(|l| term(k, l)).sum::<f64>());
            scale * rows.sum::<f64>()
        });
        Mirror {
            surface: Surface::Tensor(TensorLegendre {
                series,
                centre: middle,
                half,
                scale_mm: 1.0,
            }),
            chart,
            outline: Outline::Rect(Rect { min: middle - half, max: middle + half }),
            folded: true,
            mirror_symmetric: [false; 2],
        }
    }

    /// With w = Z - Z_centre and d = (X, Y) - (X, Y)_centre: Z_i = -d_i / w, Z_ij = -(delta_ij + Z_i Z_j) / w.
    #[test]
    fn derivatives_under_a_pinhole_are_those_of_a_sphere_in_closed_form() {
        let centre = DVec3::new(3.0, 12.0, -55.0);
        let chart = Chart::on_axis(0.01, 8.0);
        let mirror = sphere(centre, chart);
        for q in [DVec2::new(7.0, 11.0), DVec2::new(-19.0, -29.0), DVec2::new(18.0, 28.0)] {
            let flip = DVec3::new(1.0, if q.y < 0.0 { -1.0 } else { 1.0 }, 1.0);
            let surface = mirror.local_surface(q);
            let d = surface.at - centre * flip;
            assert!((d.length() - 60.0).abs() < 1e-12, "{q}: {:e}", d.length() - 60.0);
            let p = -d.truncate() / d.z;
            assert!((surface.slope - p).length() < 1e-12, "{q}: {} {p}", surface.slope);
            let exact = [1.0 + p.x * p.x, p.x * p.y, 1.0 + p.y * p.y].map(|x| -x / d.z);
            let Hessian { xx, xy, yy } = surface.hessian;
            for (found, exact) in [xx, xy, yy].into_iter().zip(exact) {
                assert!((found - exact).abs() < 1e-11, "{q}: {:e}", found - exact);
            }
            assert!((surface.largest_curvature() + 1.0 / 60.0).abs() < 1e-11);
            // The same over X and Y, by the vertical ray.
            let over = mirror.local_surface_over(surface.at.truncate(), surface.at.z).unwrap();
            assert!((over.at - surface.at).length() < 1e-11 && (over.slope - p).length() < 1e-12);
        }
    }

    #[test]
    fn the_largest_curvature_of_a_bowl_is_its_own_wherever_it_is_steep() {
        // Z = R - sqrt(R^2 - r^2) for R = 10 at X = 6, by hand: slope 3/4.
        let surface = LocalSurface {
            at: DVec3::new(6.0, 0.0, 2.0),
            slope: DVec2::new(0.75, 0.0),
            hessian: Hessian { xx: 100.0 / 512.0, xy: 0.0, yy: 0.125 },
        };
        assert!((surface.largest_curvature() - 0.1).abs() < 1e-15);
        let relative = |radius: f64| surface.relative_curvature(radius);
        assert!(relative(9.99).det() > 0.0 && relative(9.99).xx < 0.0);
        assert!(relative(10.0).xx.abs() + relative(10.0).yy.abs() < 1e-15);
    }
}
