//! Places of a mirror in the part frame: where the tool touches, with slope and bend over X and Y.

use crate::geom::{Chart, DVec2, DVec3, Outline};
use crate::mirror::{HeightAndSlope, Hessian, Mirror};
use crate::num::Dual;

/// A place of the mirror as the graph Z(X, Y) of the part frame, whatever its chart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// X, Y, Z, mm.
    pub at: DVec3,
    /// (Z_X, Z_Y).
    pub slope: DVec2,
    /// Second derivatives of Z, 1/mm: positive where the ground is hollow.
    pub bend: Hessian,
}

impl Place {
    /// The place over `q` of the chart, on any panel. Beyond the outline the surface goes on as the
    /// parabola that it has on the rim nearest to `q`.
    #[must_use]
    pub fn of(mirror: &Mirror, q: DVec2) -> Self {
        Self::moving(mirror, q).0
    }

    /// The same with the derivatives of X and of Y by q.
    pub(super) fn moving(mirror: &Mirror, q: DVec2) -> (Self, [DVec2; 2]) {
        let reflected = mirror.reflects(q);
        let q = if reflected { DVec2::new(q.x, -q.y) } else { q };
        let known = nearest(&mirror.outline, q);
        let (point, curvature) = (mirror.surface.at(known), mirror.surface.hessian(known));
        let (beyond, turn) = (q - known, curvature.times(q - known));
        let f = point.f + beyond.dot(point.slope + 0.5 * turn);
        let point = HeightAndSlope { f, slope: point.slope + turn };
        let (place, [x, y]) = lifted(&mirror.chart, q, &point, &curvature);
        if reflected {
            return (place.reflected(), [x * DVec2::new(1.0, -1.0), y * DVec2::new(-1.0, 1.0)]);
        }
        (place, [x, y])
    }

    /// The place over (X, Y) = `xy`; none where Newton's method finds none.
    #[must_use]
    pub fn over(mirror: &Mirror, xy: DVec2) -> Option<Self> {
        if mirror.chart.vergence == 0.0 {
            return Some(Self::of(mirror, xy));
        }
        let size = mirror.full_outline().bounds().size().max_element();
        let mut q = xy;
        for _ in 0..32 {
            let (place, [x, y]) = Self::moving(mirror, q);
            let off = xy - place.at.truncate();
            if off.length() <= 1e-12 * size {
                return Some(place);
            }
            q += DVec2::new(off.perp_dot(DVec2::new(x.y, y.y)), DVec2::new(x.x, y.x).perp_dot(off))
                / x.perp_dot(y);
        }
        None
    }

    /// The same place reflected in the plane Y = 0.
    #[must_use]
    pub fn reflected(self) -> Self {
        let flip = DVec3::new(1.0, -1.0, 1.0);
        let Hessian { xx, xy, yy } = self.bend;
        Self {
            at: self.at * flip,
            slope: self.slope * flip.truncate(),
            bend: Hessian { xx, xy: -xy, yy },
        }
    }

    /// sqrt(1 + |slope|^2): area of the mirror over its area in the plan.
    #[must_use]
    pub fn stretch(&self) -> f64 {
        (1.0 + self.slope.length_squared()).sqrt()
    }

    /// The unit normal towards the tool.
    #[must_use]
    pub fn normal(&self) -> DVec3 {
        (-self.slope).extend(1.0) / self.stretch()
    }

    /// The second fundamental form less 1/`radius_mm` of the first, over X and Y. It is negative for
    /// every direction exactly where a ball of that radius, from above, fits closely.
    #[must_use]
    pub fn under_ball(&self, radius_mm: f64) -> Hessian {
        let (g, p, k) = (self.stretch(), self.slope, 1.0 / radius_mm);
        Hessian {
            xx: self.bend.xx / g - k * (1.0 + p.x * p.x),
            xy: self.bend.xy / g - k * p.x * p.y,
            yy: self.bend.yy / g - k * (1.0 + p.y * p.y),
        }
    }

    /// The larger principal curvature, 1/mm: positive where some normal section is hollow. A ball fits
    /// closely where its radius is below the inverse.
    #[must_use]
    pub fn hollow(&self) -> f64 {
        let g = self.stretch();
        // Tangents of unit length, up the slope and square to it.
        let way = self.slope.try_normalize().unwrap_or(DVec2::X);
        let (up, level) = (way / g, way.perp());
        let bent = |a: DVec2, b: DVec2| a.dot(self.bend.times(b)) / g;
        let (a, b, c) = (bent(up, up), bent(up, level), bent(level, level));
        let half = 0.5 * (a - c);
        0.5 * (a + c) + (half * half + b * b).sqrt()
    }
}

/// The point of the outline nearest to `q`, or along its radius for a ring.
fn nearest(outline: &Outline, q: DVec2) -> DVec2 {
    match *outline {
        Outline::Rect(rect) => q.clamp(rect.min, rect.max),
        Outline::Ring { inner, outer } => {
            let radius = q.length();
            if (inner..=outer).contains(&radius) {
                q
            } else {
                q.try_normalize().unwrap_or(DVec2::X) * radius.clamp(inner, outer)
            }
        }
    }
}

/// How far `q` lies outside the outline, mm: 0 or less within.
pub fn beyond(outline: &Outline, q: DVec2) -> f64 {
    match *outline {
        Outline::Rect(rect) => (q - q.clamp(rect.min, rect.max)).length(),
        Outline::Ring { inner, outer } => (q.length() - outer).max(inner - q.length()),
    }
}

/// From the chart to the part frame, with the derivatives of X and of Y by q: (X, Y) and the slope are
/// functions of q, and the derivative of one over that of the other is the Hessian.
fn lifted(chart: &Chart, q: DVec2, point: &HeightAndSlope, c: &Hessian) -> (Place, [DVec2; 2]) {
    let [x, y] = [Dual::variable(q.x, 0), Dual::variable(q.y, 1)];
    let f = Dual { value: point.f, slope: point.slope.to_array() };
    let slope = [
        Dual { value: point.slope.x, slope: [c.xx, c.xy] },
        Dual { value: point.slope.y, slope: [c.xy, c.yy] },
    ];
    let at: [Dual<2>; 3] = chart.position([x, y], f);
    let p = chart.slope([x, y], slope);
    let [[a, b], [c, d]] = [at[0].slope, at[1].slope];
    let det = a * d - b * c;
    // dp/dq times the inverse of d(X, Y)/dq.
    let over = |[u, v]: [f64; 2]| [(u * d - v * c) / det, (v * a - u * b) / det];
    let [[xx, xy], [yx, yy]] = [over(p[0].slope), over(p[1].slope)];
    let place = Place {
        at: DVec3::from_array(at.map(|x| x.value)),
        slope: DVec2::new(p[0].value, p[1].value),
        bend: Hessian { xx, xy: 0.5 * (xy + yx), yy },
    };
    (place, [DVec2::new(a, b), DVec2::new(c, d)])
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::geom::Rect;
    use crate::mirror::{Surface, TensorLegendre};
    use crate::num::legendre::Series;

    /// f = a x^2 + b x y + c y^2 over [-4, 4]^2, under a camera of this vergence.
    pub fn quadric(terms: [f64; 3], vergence: f64) -> Mirror {
        sloping([0.0; 2], terms, vergence)
    }

    /// The same and d x + e y.
    pub fn sloping([d, e]: [f64; 2], [a, b, c]: [f64; 3], vergence: f64) -> Mirror {
        let half = DVec2::splat(4.0);
        // x = 4 u, u^2 = (2 P2 + 1) / 3.
        let terms = [
            [16.0 * (a + c) / 3.0, 4.0 * e, 32.0 * c / 3.0],
            [4.0 * d, 16.0 * b, 0.0],
            [32.0 * a / 3.0, 0.0, 0.0],
        ];
        let series = Series::from_fn(3, 3, |i, j| terms[i][j]);
        Mirror {
            surface: Surface::Tensor(TensorLegendre {
                series,
                centre: DVec2::ZERO,
                half,
                scale_mm: 1.0,
            }),
            chart: Chart { vergence, plane_mm: 7.0 },
            outline: Outline::Rect(Rect { min: -half, max: half }),
            folded: false,
            mirror_symmetric: [false; 2],
        }
    }

    /// Z = 7 + |Y| tan of an angle over [-4, 4]^2: two panels and their valley.
    pub fn roof(degrees: f64) -> Mirror {
        let steep = crate::num::tan(crate::num::radians(degrees));
        let (centre, half) = (DVec2::new(0.0, 2.0), DVec2::new(4.0, 2.0));
        let series = Series::from_fn(1, 2, |_, _| 2.0 * steep);
        Mirror {
            surface: Surface::Tensor(TensorLegendre { series, centre, half, scale_mm: 1.0 }),
            chart: Chart { vergence: 0.0, plane_mm: 7.0 },
            outline: Outline::Rect(Rect { min: centre - half, max: centre + half }),
            folded: true,
            mirror_symmetric: [true, false],
        }
    }

    #[test]
    fn slopes_and_bends_are_those_of_z_over_x_and_y() {
        for vergence in [0.0, 0.03] {
            let mirror = quadric([-0.06, 0.02, 0.05], vergence);
            let e = 1e-4;
            for xy in [DVec2::new(1.3, -2.1), DVec2::new(-3.0, 0.4), DVec2::ZERO] {
                let place = Place::over(&mirror, xy).unwrap();
                assert!((place.at.truncate() - xy).length() < 1e-10);
                let near = |d: DVec2| Place::over(&mirror, xy + d * e).unwrap();
                for (d, row) in [
                    (DVec2::X, DVec2::new(place.bend.xx, place.bend.xy)),
                    (DVec2::Y, DVec2::new(place.bend.xy, place.bend.yy)),
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
        assert!((Place::of(&mirror, q).at.z - exact).abs() < 1e-12);
    }

    #[test]
    fn the_hollow_of_a_bowl_is_its_curvature_wherever_it_is_steep() {
        // Z = R - sqrt(R^2 - r^2) for R = 10 at X = 6, by hand: slope 3/4.
        let place = Place {
            at: DVec3::new(6.0, 0.0, 2.0),
            slope: DVec2::new(0.75, 0.0),
            bend: Hessian { xx: 100.0 / 512.0, xy: 0.0, yy: 0.125 },
        };
        assert!((place.hollow() - 0.1).abs() < 1e-15);
        assert!(place.under_ball(9.99).det() > 0.0 && place.under_ball(9.99).xx < 0.0);
        assert!(place.under_ball(10.0).xx.abs() + place.under_ball(10.0).yy.abs() < 1e-15);
    }
}
