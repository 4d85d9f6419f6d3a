//! The law of a strip whose slope field has the least curl.
//!
//! An exact mirror exists where W . curl W = 0 (paper, section 3.2), and on a strip the law of the
//! rows is free to choose. Between two elevations, isometric latitudes m0 < m1, this is the search
//! for the law with the least mean square of W . curl W / |W|^2 over the panel, at whatever height
//! of the strip that takes. Unknown is the inverse law
//!
//! ```text
//! z(m) = integral from m0 to m of exp(g) dm        g: a polynomial
//! ```
//!
//! which rises for every g; g = 0 is mercator's law, the exact one far away under parallel rays.
//! At fixed m the curl depends on the law only through z and its stretch dm/dz = exp(-g). The
//! mirror is not known yet: the curl is that on the camera's reference plane (f = 0).

use super::rising_law::{LatitudeNode, LatitudeNodes, ROWS};
use crate::num::least_squares::{self, RankDeficient};
use crate::num::quadrature::gauss_legendre;
use crate::num::{Dual, Jet2, Scalar, asinh, atan, degrees, exp, radians, tan};
use crate::optics::{SlopeField, TabulatedLaw, Target};
use nalgebra::{DMatrix, DVector};
use thiserror::Error;

/// Degree of g.
const DEGREE: usize = 10;
/// Places along each row where the curl is sampled.
const PLACES: usize = 20;
/// Largest change of g in the last step (here and below by the sum of its coefficients' changes).
const TOLERANCE: f64 = 1e-8;
/// Largest change of g in one step.
const LONGEST: f64 = 1.0;
/// Steps before giving up.
const MOST_STEPS: usize = 100;
/// Laws that are tried for one of a height, and how near to that it comes, as a share: beyond its ends a
/// law goes on linearly.
const MOST_HEIGHTS: usize = 30;
const SAME_HEIGHT: f64 = 1e-7;

/// Reason why no law was found.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum LeastCurlError {
    /// The curl does not tell laws apart.
    #[error(transparent)]
    Undetermined(#[from] RankDeficient),
    /// The steps did not become small, or the curl is not finite.
    #[error(
        "no convergence in {steps} steps (the last changed the law's stretch by {})",
        super::by(*last_step, "")
    )]
    NotConverged {
        /// Steps taken.
        steps: usize,
        /// Largest change of log(dz/dm) in the last step; not a number where the curl is not.
        last_step: f64,
    },
}

/// The panel that the law is for.
#[derive(Debug, Clone, Copy)]
pub(super) struct LeastCurlProblem<'a> {
    /// The camera and the target.
    pub field: SlopeField<'a>,
    /// mm per radian of azimuth.
    pub scale_mm: f64,
    /// Azimuth at X = 0, radians.
    pub azimuth: f64,
    /// Azimuth across the panel, radians.
    pub across: f64,
    /// Lowest and highest elevation, degrees.
    pub elevation_deg: [f64; 2],
    /// Share of the panel's height below Y = 0.
    pub below: f64,
}

/// The curl of a law at a point, paper's units (1/rad), and its derivatives by the height y in the
/// image and by dm/dz, both in the paper's units.
struct CurlDerivatives {
    value: f64,
    by_y: f64,
    by_rise: f64,
}

impl LeastCurlProblem<'_> {
    /// The law of least curl on the reference plane (f = 0), z = 0 at the lowest elevation, and its
    /// height in the paper's units.
    ///
    /// # Errors
    /// [`LeastCurlError`] when it is not found.
    pub(super) fn law(&self) -> Result<(TabulatedLaw, f64), LeastCurlError> {
        let rows = self.rows();
        let g = self.find(&rows, vec![0.0; DEGREE + 1])?;
        let broken = LeastCurlError::NotConverged { steps: 0, last_step: f64::NAN };
        rows.table(&g).ok_or(broken)
    }

    /// The law whose height is `high`, about the middle isometric latitude of the elevations.
    ///
    /// # Errors
    /// [`LeastCurlError`] when it, or one on the way, is not found.
    pub(super) fn filling(&self, high: f64) -> Result<(TabulatedLaw, f64), LeastCurlError> {
        let [low, top] = self.rows().ends;
        let (middle, mut half) = (0.5 * (low + top), 0.5 * (top - low));
        let mut last_step = f64::NAN;
        for _ in 0..MOST_HEIGHTS {
            let elevation_deg =
                [middle - half, middle + half].map(|m| degrees(atan(0.5 * (exp(m) - exp(-m)))));
            let (table, height) = LeastCurlProblem { elevation_deg, ..*self }.law()?;
            // The height is nearly as the range of latitudes.
            last_step = high / height - 1.0;
            if last_step.abs() < SAME_HEIGHT {
                return Ok((table, height));
            }
            half *= high / height;
        }
        Err(LeastCurlError::NotConverged { steps: MOST_HEIGHTS, last_step })
    }

    fn rows(&self) -> LatitudeNodes {
        LatitudeNodes::new(self.elevation_deg.map(|e| asinh(tan(radians(e)))))
    }

    /// The coefficients of g, by Gauss-Newton from `g`; steps that make the curl larger are
    /// shortened.
    fn find(&self, rows: &LatitudeNodes, mut g: Vec<f64>) -> Result<Vec<f64>, LeastCurlError> {
        let mut last_step = f64::NAN;
        let (mut a, mut b) = self.linear(rows, &g);
        for steps in 1..=MOST_STEPS {
            let square = b.norm_squared();
            if !square.is_finite() {
                return Err(LeastCurlError::NotConverged { steps, last_step: f64::NAN });
            }
            let step = least_squares::solve(a, -b)?.x;
            // (|P_k| <= 1.)
            let size: f64 = step.iter().map(|d| d.abs()).sum();
            let mut share = f64::min(1.0, LONGEST / size);
            last_step = size;
            loop {
                let there: Vec<f64> = g.iter().zip(&step).map(|(g, d)| g + share * d).collect();
                (a, b) = self.linear(rows, &there);
                // (Rounding may make the smallest steps look wrong.)
                if b.norm_squared() <= square * (1.0 + 1e-12) || size <= TOLERANCE {
                    g = there;
                    break;
                }
                share *= 0.5;
                if share < 1e-6 {
                    return Err(LeastCurlError::NotConverged { steps, last_step });
                }
            }
            if size <= TOLERANCE {
                return Ok(g);
            }
        }
        Err(LeastCurlError::NotConverged { steps: MOST_STEPS, last_step })
    }

    /// The residuals, whose sum of squares is the mean of the curl's square over the panel, and
    /// their derivatives by the coefficients `g`.
    fn linear(&self, rows: &LatitudeNodes, g: &[f64]) -> (DMatrix<f64>, DVector<f64>) {
        let shape = rows.shape(g);
        let (nodes, weights) = gauss_legendre(PLACES);
        let mut a = DMatrix::zeros(PLACES * ROWS, g.len());
        let mut b = DVector::zeros(PLACES * ROWS);
        // What each coefficient of g adds to z and to the height.
        let adds = |weights: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let add = |k: usize| {
                let term =
                    |(j, row): (usize, &LatitudeNode)| weights(j) * shape.stretch[j] * row.basis[k];
                rows.rows.iter().enumerate().map(term).sum()
            };
            (0..g.len()).map(add).collect()
        };
        let height = adds(&|j| rows.rows[j].weight);
        for (i, row) in rows.rows.iter().enumerate() {
            let z = adds(&|j| row.sums[j]);
            let y = shape.z[i] - self.below * shape.height;
            let rise = 1.0 / shape.stretch[i];
            for (j, (u, w)) in nodes.iter().zip(&weights).enumerate() {
                let x = 0.5 * self.across * u;
                let curl = self.curl([x, y], row.m, rise);
                let share = 0.5 * w * row.weight * shape.stretch[i] / shape.height;
                let (k, root) = (i * PLACES + j, f64::sqrt(share));
                b[k] = root * curl.value;
                for n in 0..g.len() {
                    let grow = 0.5 * (row.basis[n] - height[n] / shape.height);
                    a[(k, n)] = root
                        * (curl.by_y * (z[n] - self.below * height[n])
                            - curl.by_rise * rise * row.basis[n]
                            + curl.value * grow);
                }
            }
        }
        (a, b)
    }

    /// The curl at image point `place` (paper's units) of a law that shows latitude `m` there and
    /// has dm/dz = `rise`.
    fn curl(&self, place: [f64; 2], m: f64, rise: f64) -> CurlDerivatives {
        type Jet = Jet2<f64>;
        let unit = self.scale_mm;
        let [x, y] = place.map(|p| p * unit);
        let field = |x: Jet, y: Jet, h: Jet, m: Jet| {
            let azimuth = x / unit + self.azimuth;
            let shrink = (-m).exp();
            self.field.slope_for([x, y], h, [shrink * azimuth.sin(), shrink * azimuth.cos()])
        };
        // The field's first derivatives by X, Y, m and height, and their derivatives by Y.
        let (flat, up) = (Jet::flat, Jet::variable_y(y));
        let s = field(Jet::variable_x(x), up, flat(0.0), flat(m));
        let by_m = field(flat(x), up, flat(0.0), Jet::variable_x(m));
        let by_h = match self.field.target {
            Target::Infinity => [flat(0.0); 2],
            _ => field(flat(x), up, Jet::variable_x(0.0), flat(m)),
        };
        // What becomes of them along the law, as functions of Y and of dm/dY.
        let dual = |value, by_y, by_rise| Dual { value, slope: [by_y, by_rise] };
        let rise = rise / unit;
        let first = |s: Jet| dual(s.gradient[0], s.hessian[1], 0.0);
        let along_y: [Dual<2>; 2] = std::array::from_fn(|k| {
            let (s, t) = (s[k], by_m[k]);
            let bend = s.hessian[2] + rise * t.hessian[1];
            dual(s.gradient[1] + rise * t.gradient[0], bend, t.gradient[0])
        });
        let along = [s.map(first), along_y, by_h.map(first)];
        let q = [dual(x, 0.0, 0.0), dual(y, 1.0, 0.0)];
        let s = s.map(|s| dual(s.value, s.gradient[1], 0.0));
        let curl = self.field.curl(q, dual(0.0, 0.0, 0.0), s, along) * unit;
        CurlDerivatives {
            value: curl.value,
            by_y: curl.slope[0] * unit,
            by_rise: curl.slope[1] / unit,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Chart, DVec2};
    use crate::num::{log, sin};
    use crate::optics::{ImagingTask, PictureMap, Projection, Strip, StripLaw};
    use std::sync::Arc;

    fn search<'a>(chart: &'a Chart, target: &'a Target, below: f64) -> LeastCurlProblem<'a> {
        let across = radians(200.0);
        LeastCurlProblem {
            field: SlopeField { chart, target, origin_mm: 0.0 },
            scale_mm: 60.0 / across,
            azimuth: 0.3,
            across,
            elevation_deg: [-25.0, 40.0],
            below,
        }
    }

    /// Coefficients of g(m).
    fn expanded(rows: &LatitudeNodes, g: impl Fn(f64) -> f64) -> Vec<f64> {
        let half = 0.5 * (rows.ends[1] - rows.ends[0]);
        let term = |k: usize, row: &LatitudeNode| row.weight / half * row.basis[k] * g(row.m);
        let sum = |k: usize| rows.rows.iter().map(|row| term(k, row)).sum::<f64>();
        (0..=DEGREE).map(|k| (k as f64 + 0.5) * sum(k)).collect()
    }

    /// The root mean square by the view's own curl, for a law over the range `z`.
    fn rms(search: &LeastCurlProblem, law: StripLaw, z: [f64; 2]) -> f64 {
        let unit = search.scale_mm;
        let below = z[0] + search.below * (z[1] - z[0]);
        let strip = Strip { law, scale_mm: unit, azimuth: search.azimuth, z: below };
        let view = ImagingTask {
            projection: Projection::Strip(strip),
            target: search.field.target.clone(),
            origin_mm: search.field.origin_mm,
            fold: None,
            picture: PictureMap::default(),
        };
        let (nodes, weights) = gauss_legendre(60);
        let mut sum = 0.0;
        for (u, v) in nodes.iter().zip(&weights) {
            for (t, w) in nodes.iter().zip(&weights) {
                let y = 0.5 * (z[0] + z[1] + t * (z[1] - z[0])) - below;
                let q = DVec2::new(0.5 * search.across * u, y) * unit;
                let curl = unit * view.curl(search.field.chart, q, 0.0);
                sum += 0.25 * v * w * curl * curl;
            }
        }
        sum.sqrt()
    }

    fn rms_of(search: &LeastCurlProblem, (table, height): (TabulatedLaw, f64)) -> f64 {
        rms(search, StripLaw::Tabulated(Arc::new(table)), [0.0, height])
    }

    fn charts() -> [Chart; 3] {
        [0.0, 1.0 / 180.0, 1.0 / 120.0].map(|vergence| Chart::on_axis(vergence, 0.0))
    }

    const CYLINDER: Target = Target::Cylinder { radius_mm: 100.0 };

    #[test]
    fn derivatives_agree_with_differences() {
        for (chart, target) in charts().iter().zip([CYLINDER, Target::Infinity, CYLINDER]) {
            for below in [0.0, 0.5, 1.0] {
                let search = search(chart, &target, below);
                let rows = search.rows();
                let g = [0.1, -0.2, 0.05, 0.1];
                let (a, _) = search.linear(&rows, &g);
                for k in 0..g.len() {
                    let at = |step: f64| {
                        let mut g = g;
                        g[k] += step;
                        search.linear(&rows, &g).1
                    };
                    let off = (at(1e-5) - at(-1e-5)) / 2e-5 - a.column(k);
                    assert!(off.amax() < 1e-9, "{k}: {}", off.amax());
                }
            }
        }
    }

    #[test]
    fn far_away_mercator_is_found_from_other_laws() {
        let chart = &charts()[0];
        let search = search(chart, &Target::Infinity, 0.5);
        let rows = search.rows();
        let lean = |m: f64| log(0.5 * (exp(m) + exp(-m)));
        // dz/dm is cosh m for the paper's law, its inverse for the equirectangular one.
        for sense in [1.0, -1.0] {
            let start = expanded(&rows, |m| sense * lean(m));
            let far = rows.shape(&start).stretch;
            assert!(far.iter().any(|e| (e - 1.0).abs() > 0.2));
            let g = search.find(&rows, start).unwrap();
            let stretch = rows.shape(&g).stretch;
            assert!(stretch.iter().all(|e| (e - 1.0).abs() < 1e-9));
            let found = rows.table(&g).unwrap();
            assert!((found.1 - (rows.ends[1] - rows.ends[0])).abs() < 1e-9);
            assert!(rms_of(&search, found) < 1e-9);
        }
        let (table, height) = search.law().unwrap();
        assert!((height - (rows.ends[1] - rows.ends[0])).abs() < 1e-14);
        assert!((table.stereographic_radius(0.3) - exp(-0.3 - rows.ends[0])).abs() < 1e-14);
    }

    #[test]
    fn the_law_found_beats_the_named_ones_and_every_law_near_it() {
        let [parallel, far, near] = &charts();
        for (chart, target, below) in [
            (near, Target::Infinity, 0.0),
            (near, Target::Infinity, 0.5),
            (far, Target::Infinity, 1.0),
            (parallel, CYLINDER, 0.5),
            (far, CYLINDER, 0.0),
            (parallel, Target::Cylinder { radius_mm: 45.0 }, 0.0),
        ] {
            let search = search(chart, &target, below);
            let (table, height) = search.law().unwrap();
            let least = rms_of(&search, (table.clone(), height));
            for law in [
                StripLaw::Cylindrical,
                StripLaw::Mercator,
                StripLaw::Equirectangular,
                StripLaw::EqualArea,
            ] {
                let z = search.elevation_deg.map(|e| law.image_of_degrees(e));
                let named = rms(&search, law.clone(), z);
                assert!(least < 0.95 * named, "{law:?}: {named:e} {least:e}");
            }
            // z(m) with a bump at t of 0..=1.
            let [low, high] = search.rows().ends;
            let bumped = |bump: &dyn Fn(f64) -> f64| {
                let t = |k: u32| f64::from(k) / 128.0;
                let m: Vec<f64> = (0..=128).map(|k| low + (high - low) * t(k)).collect();
                let z: Vec<f64> = (0..=128)
                    .map(|k| table.image_coordinate(exp(-m[k as usize])) + bump(t(k)))
                    .collect();
                // From z = 0 on.
                let z: Vec<f64> = z.iter().map(|x| x - z[0]).collect();
                rms_of(&search, (TabulatedLaw::from_latitudes(&z, &m).unwrap(), z[128]))
            };
            assert!((bumped(&|_| 0.0) / least - 1.0).abs() < 1e-6);
            let bumps: [fn(f64) -> f64; 5] = [
                |t| t,
                |t| sin(std::f64::consts::PI * t),
                |t| sin(2.0 * std::f64::consts::PI * t),
                |t| exp(-40.0 * (t - 0.3) * (t - 0.3)),
                |t| exp(-40.0 * (t - 0.8) * (t - 0.8)),
            ];
            for (k, bump) in bumps.iter().enumerate() {
                for size in [-1e-2, -2e-3, 2e-3, 1e-2] {
                    let near = bumped(&|t| size * bump(t));
                    assert!(near > least, "bump {k} of {size}: {near:e} {least:e}");
                }
            }
        }
    }

    #[test]
    fn a_target_out_of_sight_is_an_error() {
        let chart = &charts()[0];
        let found = search(chart, &Target::Plane { height_mm: -100.0 }, 0.5).law();
        assert!(matches!(found, Err(LeastCurlError::NotConverged { .. })));
    }
}
