//! The whole face before a raster: how steep and hollow it is, what scallops do to its pixels, which
//! direction is best, and which stepover keeps a budget.

use super::{BallRaster, MachiningError, Scallop, clears_ridge};
use crate::geom::{DVec2, Outline};
use crate::mirror::{LocalSurface, Mirror, SurfaceSamples};
use crate::num::stats::Summary;
use crate::num::{Arithmetic, Dual, degrees, radians};
use crate::optics::{Camera, ImagingTask};
use crate::parallel;
use serde::Serialize;

/// About how many pixels are looked at.
const PIXELS: f64 = 12_000.0;
/// Directions that are tried before the best is refined.
const DIRECTIONS: usize = 180;
/// Directions that differ by less than this share are as good as each other.
const SAME: f64 = 1e-3;

/// A number and where it is reached.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Extreme {
    /// The number, in the unit of its key.
    pub value: f64,
    /// X, Y, Z, mm.
    pub at_mm: [f64; 3],
}

/// What a raster leaves on the unpolished face.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ScallopFigures {
    /// Highest scallop, square to the mirror, um.
    #[cfg_attr(test, schemars(with = "Option<Extreme>"))]
    pub scallop_um: Extreme,
    /// Error of the slope in the plan, root of the mean square over the pixels; no number without any.
    #[cfg_attr(test, schemars(with = "Option<f64>"))]
    pub slope_rms: f64,
    /// Its largest value.
    #[cfg_attr(test, schemars(with = "Option<f64>"))]
    pub slope_max: f64,
    /// Pixels that were looked at and see a place that the ball touches.
    #[cfg_attr(test, schemars(with = "Option<usize>"))]
    pub pixels: usize,
    /// Those of them whose image moves by no finite number of pixels, which are left out of the pixel error.
    #[cfg_attr(test, schemars(with = "Option<usize>"))]
    pub pixels_unbounded: usize,
    /// How far scallops displace the image, pixels; none without a projection. P95 and RMS are over the
    /// pixels and over the scallops' slopes in each.
    pub pixel_error_px: Option<Summary>,
}

/// The best direction of a raster by one measure.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct RasterDirection {
    /// From X towards Y, degrees in 0..180.
    pub angle_deg: f64,
    /// The measure there over that of the worst direction.
    pub of_worst: f64,
    /// Whether all directions are as good, within a thousandth.
    pub any: bool,
}

impl RasterDirection {
    /// Of a mirror that has no best direction.
    const ANY: Self = Self { angle_deg: 0.0, of_worst: 1.0, any: true };
}

/// A pixel's place, and how far the image moves for each unit of the slope along X and along Y, pixels.
#[derive(Debug, Clone, Copy)]
struct Pixel {
    place: LocalSurface,
    moves: Option<[DVec2; 2]>,
}

/// Along which way turns about the axis are evenly far apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TurnSpacing {
    /// Along the mirror, as the feed of a lathe's path is.
    AlongMirror,
    /// Along the radius, so that they are farther apart where the mirror rises or falls along it, as of a slow tool servo.
    AlongRadius,
}

/// A mirror's face, sampled.
#[derive(Debug, Clone)]
pub struct SurfaceAnalysis<'a> {
    samples: SurfaceSamples<'a>,
    pixels: Vec<Pixel>,
    projected: bool,
    /// Whether lines go around the axis.
    around: bool,
}

impl<'a> SurfaceAnalysis<'a> {
    /// Samples the face, rim included, and every few of the camera's pixels that see it.
    #[must_use]
    pub fn new(mirror: &'a Mirror, camera: &Camera, view: Option<&ImagingTask>) -> Self {
        let [columns, rows] = camera.pixels;
        let stride = (f64::from(columns) * f64::from(rows) / PIXELS).sqrt().floor().max(1.0) as u32;
        let row = |row: usize| {
            let centre = move |k: u32| f64::from(k * stride + stride / 2) + 0.5;
            let points =
                (0..columns.div_ceil(stride)).map(centre).filter(|&x| x < f64::from(columns));
            let y = centre(row as u32);
            points
                .filter(|_| y < f64::from(rows))
                .filter_map(|x| pixel(mirror, camera, view, camera.image_point(x, y)))
                .collect::<Vec<_>>()
        };
        let pixels = parallel::map(rows.div_ceil(stride) as usize, 1, row);
        Self {
            samples: SurfaceSamples::new(mirror),
            pixels: pixels.concat(),
            projected: view.is_some(),
            around: false,
        }
    }

    /// The same of a cutter whose lines go around the axis, square to the radius, in the place of a raster's direction.
    #[must_use]
    pub fn around_axis(self) -> Self {
        Self { around: true, ..self }
    }

    /// Unit vector along the line through a place.
    fn along(&self, place: &LocalSurface, raster: &BallRaster) -> DVec2 {
        if !self.around {
            return raster.along();
        }
        place.at.truncate().try_normalize().unwrap_or(DVec2::X).perp()
    }

    /// The place of the face where `measure` is largest.
    #[must_use]
    pub fn largest(&self, measure: impl Fn(&LocalSurface) -> f64) -> (f64, LocalSurface) {
        self.samples.largest(measure)
    }

    /// Slope of the steepest place of the face, degrees from the horizontal plane.
    #[must_use]
    pub fn steepest_deg(&self) -> Extreme {
        let (slope, place) = self.largest(|place| place.slope.length());
        Extreme { value: degrees(crate::num::atan(slope)), at_mm: place.at.to_array() }
    }

    /// The least radius of curvature of a hollow normal section, mm: no larger ball fits. None where the
    /// face is hollow in no direction.
    #[must_use]
    pub fn least_hollow_mm(&self) -> Option<Extreme> {
        let (most, place) = self.largest(LocalSurface::largest_curvature);
        let size = self.samples.mirror().full_outline().bounds().size().max_element();
        (most * size > 1e-9).then(|| Extreme { value: 1.0 / most, at_mm: place.at.to_array() })
    }

    /// Lowest and highest Z of the face, mm.
    #[must_use]
    pub fn heights_mm(&self) -> [f64; 2] {
        [-self.largest(|place| -place.at.z).0, self.largest(|place| place.at.z).0]
    }

    /// The scallops that `raster` leaves where its ball fits; none where it fits nowhere.
    ///
    /// # Errors
    /// [`MachiningError::Apart`] when somewhere the lines are farther apart than the ball's radius (there
    /// scallops are no small errors).
    pub fn figures(&self, raster: &BallRaster) -> Result<Option<ScallopFigures>, MachiningError> {
        let BallRaster { ball_mm, stepover_mm, .. } = *raster;
        for (place, scallop) in
            self.samples.face.iter().filter_map(|(_, place)| self.cut(place, raster))
        {
            let apart_mm = scallop.apart * stepover_mm;
            if !(apart_mm <= scallop.radius_mm) {
                let at = place.at.truncate();
                return Err(MachiningError::Apart { stepover_mm, ball_mm, apart_mm, at });
            }
        }
        let (highest, place) = self.largest(|place| {
            let height = self.cut(place, raster).and_then(|(_, s)| s.height_mm(stepover_mm));
            height.unwrap_or(f64::NEG_INFINITY)
        });
        if !highest.is_finite() {
            return Ok(None);
        }
        let slopes = self.over_pixels(raster, |_, scallop| Some(scallop.slope(stepover_mm)));
        let displacements = self.displacements(raster);
        let pixels = slopes.len();
        let pixels_unbounded = if self.projected { pixels - displacements.len() } else { 0 };
        let (slope_rms, slope_max) =
            spread(slopes).map_or((f64::NAN, f64::NAN), |slopes| (slopes.rms, slopes.max));
        Ok(Some(ScallopFigures {
            scallop_um: Extreme { value: 1e3 * highest, at_mm: place.at.to_array() },
            slope_rms,
            slope_max,
            pixels,
            pixels_unbounded,
            pixel_error_px: spread(displacements),
        }))
    }

    /// The direction whose root mean square of the pixel error is least; none without a projection.
    #[must_use]
    pub fn best_for_pixels(&self, raster: &BallRaster) -> Option<RasterDirection> {
        let measure = |angle: f64| {
            let all = self.displacements(&BallRaster { angle, ..*raster });
            (all.iter().map(|a| a * a).sum::<f64>() / all.len() as f64).sqrt()
        };
        let known = self.projected && !self.pixels.is_empty();
        known.then(|| if self.has_no_direction() { RasterDirection::ANY } else { best(measure) })
    }

    /// The direction whose highest scallop is least.
    #[must_use]
    pub fn best_for_height(&self, raster: &BallRaster) -> RasterDirection {
        if self.has_no_direction() {
            return RasterDirection::ANY;
        }
        best(|angle| {
            let raster = BallRaster { angle, ..*raster };
            let all = self.samples.face.iter().filter_map(|(_, place)| self.cut(place, &raster));
            // Heights grow with W^2 / r.
            all.map(|(_, s)| s.apart * s.apart / s.radius_mm).fold(0.0, f64::max)
        })
    }

    /// The stepover at which 95 % of the pixels and slopes are displaced by no more than `budget_px`, mm.
    /// Displacements are proportional to the stepover. No more than the ball allows.
    #[must_use]
    pub fn stepover_for_pixels(&self, raster: &BallRaster, budget_px: f64) -> Option<f64> {
        let p95 = spread(self.displacements(raster))?.p95;
        Some((raster.stepover_mm * budget_px / p95).min(self.widest_mm(raster)))
    }

    /// The stepover at which the root mean square of the displacements and their largest are within two limits, px, mm: no more than
    /// the ball allows. None without a projection.
    #[must_use]
    pub fn stepover_for_limits(
        &self,
        raster: &BallRaster,
        [rms_px, max_px]: [f64; 2],
    ) -> Option<f64> {
        let found = spread(self.displacements(raster))?;
        let share = (rms_px / found.rms).min(max_px / found.max);
        Some((raster.stepover_mm * share).min(self.widest_mm(raster)))
    }

    /// The largest stepover whose scallops are no higher than `height_mm` anywhere, mm; no more than the
    /// ball allows.
    #[must_use]
    pub fn stepover_for_height(&self, raster: &BallRaster, height_mm: f64) -> Option<f64> {
        let (least, _) = self.largest(|place| {
            let scallop = self.cut(place, raster);
            scallop.map_or(f64::NEG_INFINITY, |(_, s)| -s.stepover_mm(height_mm))
        });
        least.is_finite().then_some((-least).min(self.widest_mm(raster)))
    }

    /// The largest stepover that [`Self::figures`] takes, mm.
    #[must_use]
    pub fn widest_mm(&self, raster: &BallRaster) -> f64 {
        let all = self.samples.face.iter().filter_map(|(_, place)| self.cut(place, raster));
        all.map(|(_, s)| s.radius_mm / s.apart).fold(raster.ball_mm, f64::min)
    }

    /// How far neighbouring points along the lines may be for a chord's slope to be off by no more than
    /// `share` of the scallops' own, mm.
    #[must_use]
    pub fn along_mm(&self, raster: &BallRaster, share: f64) -> f64 {
        let all = self.samples.face.iter().filter_map(|(_, place)| self.cut(place, raster));
        let steps = all.map(|(place, scallop)| {
            let along = self.along(place, raster);
            share * scallop.slope(raster.stepover_mm) / along.dot(place.hessian.times(along)).abs()
        });
        steps.fold(f64::INFINITY, f64::min)
    }

    /// How far tilts along the radius, evenly spread up to `tilt` radians from the mirror's own normal where turns about the axis are as far
    /// apart as `spacing` tells, displace the image, pixels. None without a projection.
    #[must_use]
    pub fn displacements_of_turns(&self, tilt: f64, spacing: TurnSpacing) -> Option<Summary> {
        let of = |pixel: &Pixel| {
            let [x, y] = pixel.moves?;
            let place = &pixel.place;
            let out = place.at.truncate().normalize_or_zero();
            let rise = place.slope.dot(out);
            let square = 1.0 + rise * rise;
            // On ground that rises by g along the radius a tilt changes that by 1 + g^2 times itself.
            let slope = match spacing {
                TurnSpacing::AlongMirror => tilt * square,
                TurnSpacing::AlongRadius => tilt * square * square.sqrt(),
            };
            Some((x * out.x + y * out.y).length() * slope).filter(|px| px.is_finite())
        };
        spread(self.pixels.iter().filter_map(of).collect())
    }

    /// Whether all directions are as good: the mirror looks the same from all sides, or lines go around.
    fn has_no_direction(&self) -> bool {
        let round = self.samples.mirror().surface.is_axisymmetric()
            && matches!(self.samples.mirror().outline, Outline::Ring { .. });
        self.around || round
    }

    fn cut<'b>(
        &self,
        place: &'b LocalSurface,
        raster: &BallRaster,
    ) -> Option<(&'b LocalSurface, Scallop)> {
        let fits = clears_ridge(self.samples.mirror(), place, raster.ball_mm);
        let scallop =
            fits.then(|| Scallop::new(place, raster.ball_mm, self.along(place, raster)))??;
        Some((place, scallop))
    }

    /// The largest displacement that the scallops cause in each pixel that has a finite one, pixels.
    fn displacements(&self, raster: &BallRaster) -> Vec<f64> {
        self.over_pixels(raster, |pixel, scallop| {
            let across = self.along(&pixel.place, raster).perp();
            let [x, y] = pixel.moves?;
            Some((x * across.x + y * across.y).length() * scallop.slope(raster.stepover_mm))
        })
    }

    fn over_pixels(
        &self,
        raster: &BallRaster,
        of: impl Fn(&Pixel, &Scallop) -> Option<f64>,
    ) -> Vec<f64> {
        let value = |pixel: &Pixel| {
            let (_, scallop) = self.cut(&pixel.place, raster)?;
            of(pixel, &scallop).filter(|x| x.is_finite())
        };
        self.pixels.iter().filter_map(value).collect()
    }
}

fn pixel(
    mirror: &Mirror,
    camera: &Camera,
    view: Option<&ImagingTask>,
    image: DVec2,
) -> Option<Pixel> {
    let q = mirror
        .intersect_camera_ray(&camera.chart, camera.picture.chart_point(image))
        .filter(|&q| mirror.full_outline().aims(q))?;
    let place = mirror.extended_surface(q);
    let reflected = mirror.reflects(q);
    let designed = if reflected { place.reflected() } else { place };
    let moves = view.map(|view| {
        let near = if reflected { DVec2::new(image.x, -image.y) } else { image };
        let at = designed.at.to_array().map(Dual::constant);
        let slope = [Dual::variable(designed.slope.x, 0), Dual::variable(designed.slope.y, 1)];
        let content: [Dual<2>; 2] = view.image_of_seen(&camera.chart, at, slope, near);
        let side = if reflected { -1.0 } else { 1.0 };
        let by = |k: usize| DVec2::new(content[0].slope[k], content[1].slope[k]) / camera.pixel_mm;
        [by(0), by(1) * side]
    });
    Some(Pixel { place, moves })
}

/// RMS, P95 and maximum of what is uniform from 0 to each of the `largest`; none without any.
fn spread(largest: Vec<f64>) -> Option<Summary> {
    if largest.is_empty() {
        return None;
    }
    let count = largest.len() as f64;
    let rms = (largest.iter().map(|a| a * a).sum::<f64>() / (3.0 * count)).sqrt();
    let max = largest.iter().copied().fold(0.0, f64::max);
    let below = |t: f64| largest.iter().map(|&a| if a <= t { 1.0 } else { t / a }).sum::<f64>();
    let [mut lo, mut hi] = [0.0, max];
    for _ in 0..60 {
        let middle = 0.5 * (lo + hi);
        if below(middle) < 0.95 * count { lo = middle } else { hi = middle }
    }
    Some(Summary { rms, p95: hi, max })
}

/// The direction where `measure` is least: the best of many, refined between its neighbours.
fn best(measure: impl Fn(f64) -> f64 + Sync) -> RasterDirection {
    let angle = |k: usize| radians(180.0 * k as f64 / DIRECTIONS as f64);
    let all = parallel::map(DIRECTIONS, 1, |k| measure(angle(k)));
    let least = (1..DIRECTIONS).fold(0, |least, k| if all[k] < all[least] { k } else { least });
    let worst = all.iter().copied().fold(0.0, f64::max);
    if !(all[least] < (1.0 - SAME) * worst) {
        return RasterDirection::ANY;
    }
    let step = angle(1);
    let (mut at, mut value) = (angle(least), all[least]);
    let mut reach = 0.5 * step;
    // To a thousandth of a degree, which no machine tells apart.
    while reach > 1e-3 * step {
        let sides = [at - reach, at + reach].map(|angle| (measure(angle), angle));
        match sides.into_iter().find(|side| side.0 < value) {
            Some(side) => (value, at) = side,
            None => reach *= 0.5,
        }
    }
    let turned = degrees(at).rem_euclid(180.0);
    RasterDirection { angle_deg: turned, of_worst: value / worst, any: false }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mixture_of_uniforms_has_its_own_percentile() {
        let one = spread(vec![2.0; 10]).unwrap();
        assert!((one.rms - 2.0 / 3f64.sqrt()).abs() < 1e-15 && (one.p95 - 1.9).abs() < 1e-12);
        // Half at 1, half at 10: 0.5 + 0.5 t / 10 = 0.95 at t = 9.
        let two = spread(vec![1.0, 10.0, 1.0, 10.0]).unwrap();
        assert!((two.p95 - 9.0).abs() < 1e-12 && two.max == 10.0);
        assert_eq!(spread(vec![]), None);
    }

    #[test]
    fn the_best_direction_is_found_between_the_samples() {
        let found = best(|t| 2.0 - crate::num::cos(2.0 * (t - radians(33.4567))));
        assert!((found.angle_deg - 33.4567).abs() < 3e-3 && !found.any, "{found:?}");
        assert!((found.of_worst - 1.0 / 3.0).abs() < 1e-4);
        let wrapped = best(|t| 2.0 - crate::num::cos(2.0 * (t + radians(0.3))));
        assert!((wrapped.angle_deg - 179.7).abs() < 3e-3);
        assert!(best(|_| 1.0).any);
    }
}
