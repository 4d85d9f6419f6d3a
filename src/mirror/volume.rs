//! Volume between a mirror and the base plane.

use super::{HeightAndSlope, Mirror};
use crate::geom::{Chart, DVec2, DVec3, Outline, Rect};
use crate::num::quadrature::gauss_legendre;
use crate::num::{asin, cos, sin};
use crate::parallel;
use std::f64::consts::{FRAC_PI_2, PI};

/// Gauss nodes per direction: exact for every polynomial sag up to degree 120, and far beyond
/// rounding for the smooth integrands of the other charts.
const NODES: usize = 64;
/// Least number of nodes across a disc.
const ACROSS: usize = 256;
/// Places along a rim.
const RIM: usize = 512;

/// What is integrated: a function of the place (X, Y, Z) mm and of the slope (Z_X, Z_Y) there.
type Of<'a> = &'a (dyn Fn(DVec3, DVec2) -> f64 + Sync);

impl Mirror {
    /// Volume between all panels, the skirt and the base plane Z = 0, mm^3, with a land inside a ring that
    /// rises from the inner rim to the rim's mean height in the middle: flat where the rim is.
    ///
    /// Exact to rounding, but for splines in round outlines: their patches are cut by the rim,
    /// which leaves some 1e-9 of it.
    #[must_use]
    pub fn volume(&self) -> f64 {
        if self.has_steps() {
            let heights = self
                .panels()
                .into_iter()
                .map(|panel| panel.over_chart(&|z| self.along_rays([0.0, z])));
            return heights.sum();
        }
        let panels = if self.folded { 2.0 } else { 1.0 };
        let land = match self.outline {
            Outline::Ring { inner, .. } if inner > 0.0 => {
                let square = |p: DVec3| p.truncate().length_squared();
                PI * self.rim_mean(inner, square) * self.rim_mm(inner)
            }
            _ => 0.0,
        };
        panels * self.under_panel(&|at, _| at.z) + land
    }

    /// Mean area, mm^2, of what mirror and skirt hold of horizontal planes from Z = 0 up to `top_mm`, which is below the
    /// mirror; a land inside a ring is within it.
    #[must_use]
    pub fn footprint(&self, top_mm: f64) -> f64 {
        if self.has_steps() {
            let area = self.outline.area();
            let square = |z: f64| self.chart.view_scale(z) * self.chart.view_scale(z);
            let rise = self.along_rays([0.0, top_mm]);
            return area * if top_mm > 0.0 { rise / top_mm } else { square(0.0) };
        }
        let panels = if self.folded { 2.0 } else { 1.0 };
        let land = match self.outline {
            Outline::Ring { inner, .. } => {
                PI * self.rim_mean(inner, |p| p.truncate().length_squared())
            }
            Outline::Rect(_) => 0.0,
        };
        panels * self.under_panel(&|_, _| 1.0) + land
    }

    /// The volume, mm, over a unit of the chart's area between two heights, mm: the integral of the view's width squared.
    fn along_rays(&self, [low, high]: [f64; 2]) -> f64 {
        let [low_scale, high_scale] = [low, high].map(|z| self.chart.view_scale(z));
        let squares = low_scale * low_scale + low_scale * high_scale + high_scale * high_scale;
        (high - low) * squares / 3.0
    }

    /// The integral of a function of Z, mm, over the chart's area of a rectangular panel.
    fn over_chart(&self, of: &(dyn Fn(f64) -> f64 + Sync)) -> f64 {
        let Rect { min, max } = self.outline.bounds();
        let along = self.nodes(0, min.x, max.x);
        let line = |&(y, w): &(f64, f64)| {
            let row = self.row(y);
            let at = |&(x, w): &(f64, f64)| w * of(self.position(DVec2::new(x, y), &row.at(x)).z);
            w * along.iter().map(at).sum::<f64>()
        };
        parallel::map_slice(&self.nodes(1, min.y, max.y), 1, line).iter().sum()
    }

    /// Mean of Z over equal angles at `radius` from the axis, mm.
    #[must_use]
    pub fn rim_mm(&self, radius: f64) -> f64 {
        self.rim_mean(radius, |p| p.z)
    }

    fn rim_mean(&self, radius: f64, of: impl Fn(DVec3) -> f64) -> f64 {
        let at = |k: usize| {
            let angle = 2.0 * PI * (k as f64 + 0.5) / RIM as f64;
            let q = DVec2::new(cos(angle), sin(angle)) * radius;
            of(self.position(q, &self.surface.at(q)))
        };
        (0..RIM).map(at).sum::<f64>() / RIM as f64
    }

    /// Z at the geometric mean of the mirror's depths below the pinhole of `camera`, the mean being
    /// over the panel's picture, mm; under parallel rays, mean of Z over the plan. Not a number where
    /// the mirror reaches up to the pinhole.
    #[must_use]
    pub fn mean_mm(&self, camera: &Chart) -> f64 {
        // The area that a unit of the plan covers in the picture.
        let density = |at: DVec3, slope: DVec2| {
            let shrink = camera.view_scale(at.z);
            let along = camera.vergence * at.truncate().dot(slope) - camera.lean.dot(slope);
            (1.0 + along / shrink) / (shrink * shrink)
        };
        let sum = self.under_panel(&|at, slope| density(at, slope) * camera.coordinates(at).1);
        camera.point(DVec2::ZERO, sum / self.under_panel(&density)).z
    }

    /// The integral of a function of place and slope over what the designed panel covers of the (X, Y) plane.
    fn under_panel(&self, of: Of) -> f64 {
        match self.outline {
            Outline::Rect(panel) => {
                let along = self.nodes(0, panel.min.x, panel.max.x);
                let across = self.nodes(1, panel.min.y, panel.max.y);
                let rows = parallel::map_slice(&across, 1, |&(y, w)| w * self.line(y, &along, of));
                rows.iter().sum()
            }
            Outline::Ring { inner, outer } if self.surface.is_axisymmetric() => {
                let row = self.row(0.0);
                let ring = self.nodes(0, inner, outer).into_iter().map(|(r, w)| {
                    w * 2.0 * PI * r * self.column(DVec2::new(r, 0.0), &row.at(r), of)
                });
                ring.sum()
            }
            Outline::Ring { inner, outer } => self.disc(outer, of) - self.disc(inner, of),
        }
    }

    /// The same under a disc about the axis: along its chords, the chords at y = radius sin(angle),
    /// for which their length is smooth.
    fn disc(&self, radius: f64, of: Of) -> f64 {
        if radius == 0.0 {
            return 0.0;
        }
        let angle =
            |y: f64| if y.abs() < radius { asin(y / radius) } else { FRAC_PI_2.copysign(y) };
        let breaks = self.surface.breaks(1, -radius, radius);
        let breaks: Vec<f64> = breaks.into_iter().map(angle).collect();
        let count = (ACROSS / (breaks.len() - 1)).max(2);
        let chords = parallel::map_slice(&composite(&breaks, count), 1, |&(angle, w)| {
            let half = radius * cos(angle);
            w * half * self.line(radius * sin(angle), &self.nodes(0, -half, half), of)
        });
        chords.iter().sum()
    }

    /// The integral along a line of constant y.
    fn line(&self, y: f64, along: &[(f64, f64)], of: Of) -> f64 {
        let row = self.row(y);
        along.iter().map(|&(x, w)| w * self.column(DVec2::new(x, y), &row.at(x), of)).sum()
    }

    /// Places and weights along an axis: a cubic takes two between breaks.
    fn nodes(&self, axis: usize, lo: f64, hi: f64) -> Vec<(f64, f64)> {
        let cubic = self.surface.is_bicubic() && self.chart.is_plan();
        composite(&self.surface.breaks(axis, lo, hi), if cubic { 2 } else { NODES })
    }

    /// The function of place and slope times the area that a unit of the chart's area covers in the (X, Y) plane.
    fn column(&self, q: DVec2, point: &HeightAndSlope, of: Of) -> f64 {
        let k = self.chart.vergence;
        let at = self.position(q, point);
        let shrink = 1.0 - k * (at.z - self.chart.plane_mm);
        of(at, self.slope(q, point))
            * shrink
            * shrink
            * self.chart.normal_scale(q.to_array(), point.slope.to_array())
    }
}

/// Gauss' rule with `count` nodes between each two of the breaks.
fn composite(breaks: &[f64], count: usize) -> Vec<(f64, f64)> {
    let (nodes, weights) = gauss_legendre(count);
    let part = |ends: &[f64]| {
        let (middle, half) = (0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0]));
        let scaled = |(u, w): (&f64, &f64)| (middle + half * u, half * w);
        nodes.iter().zip(&weights).map(scaled).collect::<Vec<_>>()
    };
    breaks.windows(2).flat_map(part).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{BicubicSpline, Chart, GridAxis};
    use crate::mirror::{HeightField, RadialLegendre, Surface, TensorLegendre};
    use crate::num::legendre::Series;
    use crate::num::sample::Draws;

    #[test]
    fn a_tilted_plane_has_the_volume_of_its_prism() {
        // f = 3 u on a rectangle off the axis.
        let series = Series::from_fn(2, 1, |i, _| [0.0, 3.0][i]);
        let (centre, half) = (DVec2::new(3.0, -2.0), DVec2::new(4.0, 5.0));
        let surface = Surface::Tensor(TensorLegendre { series, centre, half, scale_mm: 1.0 });
        let outline = Outline::Rect(Rect { min: centre - half, max: centre + half });
        let chart = Chart::on_axis(0.0, 10.0);
        let mirror =
            Mirror { surface, chart, outline, folded: false, mirror_symmetric: [false; 2] };
        assert!((mirror.volume() - 800.0).abs() < 1e-10);
        assert!((mirror.footprint(1.0) - 80.0).abs() < 1e-12);
    }

    #[test]
    fn flat_lids_of_every_camera_have_the_volume_of_a_cylinder() {
        for vergence in [0.0, 0.02] {
            for inner in [0.0, 4.0] {
                // f = -2 everywhere: Z and the rim's radius follow from the chart alone.
                let series = Series::from_fn(1, 1, |_, _| -2.0);
                let surface = Surface::Radial(RadialLegendre::new(series, [inner, 10.0], 1.0));
                let chart = Chart::on_axis(vergence, 10.0);
                let outline = Outline::Ring { inner, outer: 10.0 };
                let mirror =
                    Mirror { surface, chart, outline, folded: false, mirror_symmetric: [true; 2] };
                let rim = chart.point(DVec2::new(10.0, 0.0), -2.0);
                let exact = PI * rim.x * rim.x * rim.z;
                assert!((mirror.volume() / exact - 1.0).abs() < 1e-13);
                assert!((mirror.footprint(1.0) / (exact / rim.z) - 1.0).abs() < 1e-13);
            }
        }
    }

    /// The same quartic, as a spline on a fine grid and as a polynomial, over every outline.
    #[test]
    fn splines_and_polynomials_agree_over_every_outline() {
        // f = 2 + x^2 y^2 / 16 + x / 4 on [-4, 4]^2, u = x / 4: x^2 y^2 / 16 = 16 u^2 v^2.
        let square = [1.0 / 3.0, 0.0, 2.0 / 3.0];
        let series = Series::from_fn(3, 3, |i, j| {
            16.0 * square[i] * square[j] + [2.0, 1.0, 0.0][i] * if j == 0 { 1.0 } else { 0.0 }
        });
        let sheet =
            TensorLegendre { series, centre: DVec2::ZERO, half: DVec2::splat(4.0), scale_mm: 1.0 };
        let knots = GridAxis { first_mm: -4.1, step_mm: 8.2 / 50.0, count: 51 };
        let values: Vec<f64> = (0..51 * 51)
            .map(|k| sheet.at(DVec2::new(knots.at(k % 51), knots.at(k / 51))).f)
            .collect();
        let spline = BicubicSpline::new(knots, knots, &values).unwrap();
        let volume = |surface: Surface, outline| {
            let chart = Chart::on_axis(0.0, 0.0);
            let mirror =
                Mirror { surface, chart, outline, folded: false, mirror_symmetric: [false; 2] };
            mirror.volume()
        };
        let rect = Rect { min: DVec2::new(-1.7, -4.0), max: DVec2::new(4.0, 3.3) };
        // Integral of x^2 y^2 over a disc: pi R^6 / 24.
        let disc = |r: f64| PI * r * r * (2.0 + r * r * r * r / 384.0);
        let third = |lo: f64, hi: f64| (hi * hi * hi - lo * lo * lo) / 3.0;
        let over_rect = 2.0 * rect.area()
            + third(-1.7, 4.0) * third(-4.0, 3.3) / 16.0
            + 0.125 * (16.0 - 1.7 * 1.7) * 7.3;
        // The rim's mean of x^2 y^2 is R^4 / 8.
        let land = PI * 2.25 * (2.0 + 1.5 * 1.5 * 2.25 / 128.0);
        for (outline, exact) in [
            (Outline::Rect(rect), over_rect),
            (Outline::Ring { inner: 0.0, outer: 4.0 }, disc(4.0)),
            (Outline::Ring { inner: 1.5, outer: 4.0 }, disc(4.0) - disc(1.5) + land),
        ] {
            let smooth = volume(Surface::Tensor(sheet.clone()), outline);
            assert!((smooth / exact - 1.0).abs() < 1e-13, "{smooth} {exact}");
            let knotted = volume(Surface::Spline(spline.clone()), outline);
            assert!((knotted / exact - 1.0).abs() < 1e-10, "{knotted} {exact}");
        }
    }

    /// A rough spline: its rule alone decides.
    #[test]
    fn cut_patches_are_integrated_to_their_rim() {
        let mut r = Draws::new(3);
        let knots = GridAxis { first_mm: -4.0, step_mm: 1.0, count: 9 };
        let values: Vec<f64> = (0..81).map(|_| r.inside([2.0, 3.0])).collect();
        let spline = BicubicSpline::new(knots, knots, &values).unwrap();
        let (n, rings) = (1024, 64);
        let mut by_rings = 0.0;
        for (radius, w) in composite(&[0.0, 0.8, 1.6, 2.4, 3.2, 4.0], rings) {
            for k in 0..n {
                let angle = 2.0 * PI * f64::from(k) / f64::from(n);
                let q = DVec2::new(cos(angle), sin(angle)) * radius;
                by_rings += w * radius * spline.at(q).f * 2.0 * PI / f64::from(n);
            }
        }
        let chart = Chart::on_axis(0.0, 0.0);
        let outline = Outline::Ring { inner: 0.0, outer: 4.0 };
        let surface = Surface::Spline(spline);
        let mirror =
            Mirror { surface, chart, outline, folded: false, mirror_symmetric: [false; 2] };
        let off = mirror.volume() / by_rings - 1.0;
        assert!(off.abs() < 1e-8, "{off:e}");
    }
}
