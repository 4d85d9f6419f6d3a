//! The parametric surface that a spline is fitted to, over a whole rectangle of parameters.
//!
//! A mirror in a rectangle has its chart's coordinates for parameters. A round one has X and Y,
//! whatever its camera, and is continued beyond its rim by Taylor's polynomial in the squared
//! distance from the axis.

use super::FitError;
use crate::forming::ParallelSurface;
use crate::geom::{DVec2, DVec3, Outline, Rect};
use crate::mirror::{HeightField, HeightRow, LocalSurface, Mirror, Surface};
use crate::parallel;

/// How far the parameters of a round mirror reach beyond its rim: a rim curve should not touch the
/// edge of its surface.
const MARGIN: f64 = 1.02;

/// Steps of the table of a round surface. Hermite's cubics between miss it by h^4 f''''/384: a
/// millionth of what splines on a hundredth as many knots do.
const STEPS: usize = 4096;

/// A mirror's designed panel as a function of two parameters.
pub(super) struct ParametricSurface<'a> {
    mirror: &'a Mirror,
    /// The parameters' domain.
    pub domain: Rect,
    /// Inner and outer radius in the part frame of a round mirror.
    pub ring: Option<[f64; 2]>,
    /// The axisymmetric part, if there is one.
    radial: Option<RadialProfile>,
    /// Whether it is even in x and in y.
    pub even: [bool; 2],
    /// Whether each side is kept in its plane through the pinhole, to the last digit.
    plane_sides: bool,
    /// Distance from the mirror along its normals, mm.
    offset_mm: f64,
}

/// Height along the radius of a surface of revolution: a table out to its rim, and what continues it.
struct RadialProfile {
    /// Heights and slopes at even steps of the radius.
    table: Vec<(f64, f64)>,
    from: f64,
    step: f64,
    outside: TaylorContinuation,
}

/// Taylor's polynomial beyond a rim, in the distance of t = rho^2 from that of the rim.
struct TaylorContinuation {
    rho: f64,
    /// Coefficients, of the constant term first.
    powers: [f64; TaylorContinuation::TERMS],
}

impl<'a> ParametricSurface<'a> {
    /// The panel of `mirror`.
    pub(super) fn new(mirror: &'a Mirror) -> Result<Self, FitError> {
        let mut surface = Self {
            mirror,
            domain: mirror.outline.bounds(),
            ring: None,
            radial: None,
            even: mirror.mirror_symmetric,
            plane_sides: false,
            offset_mm: 0.0,
        };
        let Outline::Ring { inner, outer } = mirror.outline else { return Ok(surface) };
        let out = |r: f64| {
            let q = DVec2::new(r, 0.0);
            mirror.position(q, &mirror.surface.at(q)).x
        };
        let axisymmetric = mirror.surface.is_axisymmetric();
        let ring = match axisymmetric {
            true => [inner, outer].map(out),
            false if !mirror.chart.is_plan() => return Err(FitError::Chart),
            false => [inner, outer],
        };
        surface.ring = Some(ring);
        surface.domain = Outline::Ring { inner: 0.0, outer: rounded_up(ring[1] * MARGIN) }.bounds();
        if axisymmetric {
            surface.even = [true; 2];
        }
        if axisymmetric || matches!(mirror.surface, Surface::Sum(_)) {
            surface.radial = Some(surface.radial(ring)?);
        }
        Ok(surface)
    }

    /// The same panel under a pinhole, each of its sides in the plane through the pinhole.
    pub(super) fn with_plane_sides(self) -> Self {
        Self { plane_sides: true, ..self }
    }

    /// The surface beside the panel by `offset_mm` along its normals.
    ///
    /// # Errors
    /// [`FitError::RoundTool`] of a round outline with a mirror that is not round.
    pub(super) fn beside(mut self, offset_mm: f64) -> Result<Self, FitError> {
        self.offset_mm = offset_mm;
        let Outline::Ring { inner, outer } = self.mirror.outline else { return Ok(self) };
        if !self.is_round() {
            return Err(FitError::RoundTool);
        }
        let parallel = ParallelSurface { mirror: self.mirror, offset_mm };
        let ring = [inner, outer].map(|r| {
            let place = self.mirror.extended_surface(DVec2::new(r, 0.0));
            parallel.beside(&place).x
        });
        self.ring = Some(ring);
        self.radial = Some(self.radial(ring)?);
        Ok(self)
    }

    /// A control point of the first or the last line along the axes of `ends`: in the planes of the sides, if they are kept.
    pub(super) fn on_plane_sides(&self, mut p: DVec3, ends: [[bool; 2]; 2]) -> DVec3 {
        let Rect { min, max } = self.domain;
        for axis in (0..2).filter(|_| self.plane_sides) {
            let side = match ends[axis] {
                [true, _] => min[axis],
                [_, true] => max[axis],
                _ => continue,
            };
            p[axis] = self.mirror.chart.ray_at(DVec2::splat(side), p.z)[axis];
        }
        p
    }

    /// Whether X and Y are the parameters themselves.
    pub(super) fn is_direct(&self) -> bool {
        self.ring.is_some() || self.mirror.chart.is_plan() && self.offset_mm == 0.0
    }

    /// Whether `q` belongs to the mirror.
    pub(super) fn contains(&self, q: DVec2) -> bool {
        self.ring.is_none_or(|[inner, outer]| (inner..=outer).contains(&q.length()))
    }

    /// Where a surface that is less smooth breaks along an axis, ends included.
    pub(super) fn breaks(&self, axis: usize) -> Option<Vec<f64>> {
        let [lo, hi] = [self.domain.min, self.domain.max].map(|end| end[axis]);
        let surface = &self.mirror.surface;
        surface.is_bicubic().then(|| surface.breaks(axis, lo, hi))
    }

    /// Whether the same knots suit both axes.
    pub(super) fn is_round(&self) -> bool {
        self.mirror.surface.is_axisymmetric()
    }

    /// The round part's Z (of a sum: its height) and slope at distance `rho` from the axis.
    fn radius(&self, rho: f64) -> Option<(f64, f64)> {
        let place = DVec2::new(rho, 0.0);
        if self.offset_mm != 0.0 {
            let parallel = ParallelSurface { mirror: self.mirror, offset_mm: self.offset_mm };
            let surface = parallel.place_over(place)?;
            return Some((parallel.beside(&surface).z, surface.slope.x));
        }
        if let Surface::Sum(sum) = &self.mirror.surface {
            let point = sum.radial.at(place);
            return Some((point.f, point.slope.x));
        }
        let surface = match self.mirror.surface.radii() {
            Some([inner, outer]) if inner > 0.0 => self.between_rims(place, [inner, outer]),
            _ => self.mirror.local_surface_over(place, self.mirror.chart.plane_mm),
        }?;
        Some((surface.at.z, surface.slope.x))
    }

    /// The point of an annulus over `place`, if it has one between its rims, image radii. The search for it begins where
    /// the reference plane is seen, which may be inside of the inner rim: the mirror's series may grow without bound in
    /// there, the parabola by which it is extended does not.
    fn between_rims(&self, place: DVec2, [inner, outer]: [f64; 2]) -> Option<LocalSurface> {
        /// Share of the outer radius by which a rim's own point may be off.
        const OFF: f64 = 1e-11;
        let surface = self.mirror.extended_surface_over(place)?;
        let r = self.mirror.chart.coordinates(surface.at).0.length();
        (inner - OFF * outer..=outer + OFF * outer).contains(&r).then_some(surface)
    }

    /// Whether the distance from the axis does not grow all the way from rim to rim of the image.
    fn hangs_over(&self) -> bool {
        let Outline::Ring { inner, outer } = self.mirror.outline else { return false };
        let distance = |k: usize| {
            let q = DVec2::new(inner + (outer - inner) * k as f64 / STEPS as f64, 0.0);
            self.mirror.position(q, &self.mirror.surface.at(q)).x
        };
        (0..STEPS).any(|k| !(distance(k) < distance(k + 1)))
    }

    /// The round part; that of a sum is smooth inside an annulus too.
    fn radial(&self, [inner, rim]: [f64; 2]) -> Result<RadialProfile, FitError> {
        if self.is_round() && self.hangs_over() {
            return Err(FitError::Overhang);
        }
        let from = if self.is_round() { inner } else { 0.0 };
        let step = (rim - from) / STEPS as f64;
        let at = |rho: f64| self.radius(rho).ok_or(FitError::Overhang);
        let at_step = |k: usize| self.radius(from + step * k as f64);
        let inwards = -0.02 * (rim - from) * (rim + from);
        let mut slopes = [at(rim)?.1 / (2.0 * rim); TaylorContinuation::TERMS - 1];
        for (k, slope) in slopes.iter_mut().enumerate().skip(1) {
            let rho = (rim * rim + inwards * k as f64).sqrt();
            *slope = at(rho)?.1 / (2.0 * rho);
        }
        Ok(RadialProfile {
            table: parallel::try_map(STEPS + 1, 1, at_step).ok_or(FitError::Overhang)?,
            from,
            step,
            outside: TaylorContinuation::new(rim, at(rim)?.0, inwards, slopes),
        })
    }

    /// The points at all of `us` for each of `vs`.
    pub(super) fn grid(&self, us: &[f64], vs: &[f64]) -> Vec<Vec<DVec3>> {
        let mirrored = |x: &[f64]| {
            let last = x.len() - 1;
            (0..=last).all(|k| (x[k] + x[last - k]).abs() <= 1e-13 * x[last].abs())
        };
        let half = |k: usize, x: &[f64]| {
            let even = self.even[k] && mirrored(x);
            if even { x.len().div_ceil(2) } else { x.len() }
        };
        let (wide, high) = (half(0, us), half(1, vs));
        let row = |&v: &f64| -> Vec<DVec3> {
            let mut row = self.row(&us[..wide], v);
            for k in (0..us.len() - wide).rev() {
                let p = row[k];
                row.push(DVec3::new(-p.x, p.y, p.z));
            }
            row
        };
        let mut rows: Vec<_> = parallel::map_slice(&vs[..high], 1, row);
        for k in (0..vs.len() - high).rev() {
            let flip = |p: &DVec3| DVec3::new(p.x, -p.y, p.z);
            rows.push(rows[k].iter().map(flip).collect());
        }
        rows
    }

    /// The points on a line of constant `v`.
    fn row(&self, us: &[f64], v: f64) -> Vec<DVec3> {
        let plane_mm = self.mirror.chart.plane_mm;
        let Some(radial) = &self.radial else {
            let row = self.mirror.surface.row(v);
            let point = |&u: &f64| {
                let (q, point) = (DVec2::new(u, v), row.at(u));
                let at = self.mirror.position(q, &point);
                match self.offset_mm {
                    0.0 => at,
                    d => at + d * self.mirror.normal(q, &point).normalize(),
                }
            };
            return us.iter().map(point).collect();
        };
        let rest = match &self.mirror.surface {
            Surface::Sum(sum) => Some(sum.tensor.row(v)),
            _ => None,
        };
        let point = |&u: &f64| {
            let q = DVec2::new(u, v);
            let z = radial.at(q.length());
            q.extend(rest.as_ref().map_or(z, |rest| z + rest.at(u).f + plane_mm))
        };
        us.iter().map(point).collect()
    }
}

impl RadialProfile {
    /// Z, or a sum's height.
    fn at(&self, rho: f64) -> f64 {
        if rho > self.outside.rho {
            return self.outside.at(rho);
        }
        let steps = (rho - self.from) / self.step;
        let k = (steps.max(0.0) as usize).min(STEPS - 1);
        let (t, ((a, a1), (b, b1))) = (steps - k as f64, (self.table[k], self.table[k + 1]));
        let (r, rise) = (1.0 - t, b - a);
        // Hermite's cubic.
        a + t * (rise + r * (r * (self.step * a1 - rise) - t * (self.step * b1 - rise)))
    }
}

impl TaylorContinuation {
    /// Terms of the polynomial.
    const TERMS: usize = 6;

    /// The polynomial of height `z` at `rho` whose slopes by t are `slopes` there and at steps of t
    /// from there.
    fn new(rho: f64, z: f64, step: f64, mut slopes: [f64; Self::TERMS - 1]) -> Self {
        let last = slopes.len() - 1;
        // Newton's divided differences, and from the innermost out to powers of the distance.
        for order in 1..=last {
            for k in (order..=last).rev() {
                slopes[k] = (slopes[k] - slopes[k - 1]) / (step * order as f64);
            }
        }
        let mut rate = [0.0; Self::TERMS - 1];
        for (k, &slope) in slopes.iter().enumerate().rev() {
            let node = step * k as f64;
            for power in (0..last).rev() {
                rate[power + 1] = rate[power] - node * rate[power + 1];
            }
            rate[0] = slope - node * rate[0];
        }
        let mut powers = [z; Self::TERMS];
        for (k, rate) in rate.iter().enumerate() {
            powers[k + 1] = rate / (k + 1) as f64;
        }
        Self { rho, powers }
    }

    fn at(&self, rho: f64) -> f64 {
        let s = (rho - self.rho) * (rho + self.rho);
        self.powers.iter().rev().fold(0.0, |sum, c| sum * s + c)
    }
}

/// `x` or up to half a per cent more, with few digits.
fn rounded_up(x: f64) -> f64 {
    let mut per = 1e-6;
    while x * per < 200.0 {
        per *= 10.0;
    }
    (x * per).ceil() / per
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Chart;
    use crate::mirror::{RadialLegendre, RadialTensorSum, TensorLegendre};
    use crate::num::legendre::Series;

    fn mirror(surface: Surface, vergence: f64, ring: [f64; 2]) -> Mirror {
        Mirror {
            surface,
            chart: Chart::on_axis(vergence, 20.0),
            outline: Outline::Ring { inner: ring[0], outer: ring[1] },
            folded: false,
            mirror_symmetric: [false; 2],
        }
    }

    /// f = 2 - 4 t / 25 + t^2 / 625 with t = r^2, u = 2 t / 25 - 1.
    fn bowl() -> RadialLegendre {
        // t = 12.5 (u + 1), u^2 = (2 P2 + 1) / 3.
        let c = [0.25 + 0.25 / 3.0, -2.0 + 0.5, 0.25 * 2.0 / 3.0];
        RadialLegendre::new(Series::from_fn(3, 1, |i, _| c[i]), [0.0, 5.0], 1.0)
    }

    /// Rounding of the slopes grows with the fifth power of the distance from the rim.
    fn allowed(rho: f64) -> f64 {
        if rho <= 5.0 { 1e-12 } else { 1e-9 }
    }

    fn exact(rho: f64) -> f64 {
        let t = rho * rho;
        22.0 - 4.0 * t / 25.0 + t * t / 625.0
    }

    #[test]
    fn polynomials_go_on_as_they_are() {
        let mirror = mirror(Surface::Radial(bowl()), 0.0, [0.0, 5.0]);
        let surface = ParametricSurface::new(&mirror).unwrap();
        assert!(surface.is_direct() && surface.is_round() && surface.even == [true; 2]);
        assert!((5.1..5.13).contains(&surface.domain.max.x) && surface.domain.min.y < -5.09);
        let places = [-5.1, -4.2, -1.0, 1.0, 4.2, 5.1];
        for (row, y) in surface.grid(&places, &places).iter().zip(places) {
            for (p, x) in row.iter().zip(places) {
                assert_eq!(p.truncate(), DVec2::new(x, y));
                let rho = p.truncate().length();
                assert!((p.z - exact(rho)).abs() < allowed(rho), "{p}");
            }
        }
    }

    #[test]
    fn another_camera_sees_the_same_heights() {
        let mirror = mirror(Surface::Radial(bowl()), 0.02, [0.0, 5.0]);
        let surface = ParametricSurface::new(&mirror).unwrap();
        let [_, rim] = surface.ring.unwrap();
        for k in 0..=20 {
            let q = DVec2::new(0.6, -0.8) * (5.0 * f64::from(k) / 20.0);
            let wanted = mirror.position(q, &mirror.surface.at(q));
            assert!(wanted.truncate().length() <= rim + 1e-14);
            let found = surface.grid(&[wanted.x], &[wanted.y])[0][0];
            assert!((found - wanted).length() < 1e-12, "{found} {wanted}");
        }
    }

    #[test]
    fn sums_go_on_too_and_other_charts_are_refused() {
        let series = Series::from_fn(2, 2, |i, j| (i * j) as f64);
        let (centre, half) = (DVec2::ZERO, DVec2::splat(5.0));
        let sheet = TensorLegendre { series, centre, half, scale_mm: 1.0 };
        let sum = Surface::Sum(RadialTensorSum { radial: bowl(), tensor: sheet });
        let tilted = mirror(sum.clone(), 0.0, [1.0, 5.0]);
        let surface = ParametricSurface::new(&tilted).unwrap();
        for (x, y) in [(0.1, 0.2), (3.0, -2.0), (5.0, 5.0)] {
            let found = surface.grid(&[x], &[y])[0][0].z;
            let rho = f64::sqrt(x * x + y * y);
            assert!((found - exact(rho) - x * y / 25.0).abs() < allowed(rho));
        }
        let seen = mirror(sum, 0.02, [0.0, 5.0]);
        assert_eq!(ParametricSurface::new(&seen).err(), Some(FitError::Chart));
    }
}
