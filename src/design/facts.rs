//! Figures of merit of a design, before any mesh.

use super::cause::{FailureCause, LocalFailure};
use super::layout::DesignProblem;
use super::least_error::LeastError;
use super::solve::LeastSquaresFit;
use super::straightness::Straightness;
use crate::geom::{DVec2, angle};
use crate::mirror::{HeightAndSlope, Mirror};
use crate::num::stats::{Summary, or_null, unless_null};
use crate::num::units::Mm;
use crate::optics::{Camera, CurlBounds, FramedView, ImagingTask, Projection, SampledMap, reflect};
use crate::parallel;
use serde::{Deserialize, Serialize, Serializer};

/// Samples per side of the panel, or along each of as many radii; the rim is sampled too, where the
/// worst error usually is.
pub(super) const SAMPLES: usize = 200;

/// W . curl W / |W|^2 over the panel, paper's units (1/rad): zero where an exact mirror exists.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct CurlFacts {
    /// Area-weighted root mean square.
    #[cfg_attr(test, schemars(with = "Option<f64>"))]
    pub rms: f64,
    /// Largest magnitude.
    #[cfg_attr(test, schemars(with = "Option<f64>"))]
    pub max: f64,
    /// Largest condition: factor from relative errors of the field's derivatives to errors of the curl, the
    /// sum of the derivatives' magnitudes.
    #[cfg_attr(test, schemars(with = "Option<f64>"))]
    pub condition: f64,
    /// Proven bound of the curl's rounding error, by intervals.
    #[cfg_attr(test, schemars(with = "Option<f64>"))]
    pub rounding: f64,
}

/// Samples of a picture that is given as data; of several panels' those between which interpolation is the farthest off.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct MapFacts {
    /// Columns and rows.
    pub samples: [usize; 2],
    /// Share of them that may show anything.
    pub gaps: f64,
    /// Largest error of the interpolation between them, about, pixels.
    pub interpolation_px: f64,
}

impl MapFacts {
    fn of(camera: &Camera, view: &ImagingTask) -> Option<Self> {
        let views = match &view.projection {
            Projection::Framed(view) => std::slice::from_ref(view),
            Projection::Panels(panels) => &panels.views,
            Projection::Strip(_) | Projection::Radial { .. } => &[],
        };
        let facts = |map: &SampledMap| {
            let px = camera.to_px(Mm(map.interpolation_error() / map.radians_per_mm()));
            Self { samples: map.size(), gaps: map.gap_share(), interpolation_px: px.0 }
        };
        let worse = |a: Self, b: Self| if b.interpolation_px > a.interpolation_px { b } else { a };
        views.iter().filter_map(FramedView::map).map(facts).reduce(worse)
    }
}

/// Lines between panels, which a lens with distortion bends in the picture, and a camera that leans sees run together.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct DividingLineFacts {
    /// Largest distance in the frame of a line between panels from the edge between pixels that the profile names, pixels:
    /// what lies between both belongs to the neighbour.
    pub departure_px: f64,
}

/// The errors themselves leave the range of double precision.
const NO_ERROR: FailureCause = FailureCause::NotFinite { what: "image error" };

/// Figures of merit of a design.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct DesignFacts {
    /// Name of the method, as in the profile, or "given".
    pub method: String,
    /// Whether the largest error was made small instead of the mean square.
    pub minimax: bool,
    /// Polynomial degree in each of y and z, or along the radius.
    pub degree: usize,
    /// Number of coefficients solved for.
    pub unknowns: usize,
    /// Steps the solver took.
    pub steps: usize,
    /// Condition number (2-norm) of the least squares' matrix, its columns of unit length.
    pub condition: Option<f64>,
    /// Integral of |grad F - s|^2 over the domain of the fit, in the paper's units (paper,
    /// equation for A in section 4).
    pub gradient_residual: Option<f64>,
    /// Whether an exact mirror exists.
    #[serde(serialize_with = "curl_or_null", deserialize_with = "unless_null")]
    #[cfg_attr(test, schemars(with = "CurlFacts"))]
    pub curl: Option<CurlFacts>,
    /// Angle between the direction seen and the direction wanted, mrad.
    #[serde(serialize_with = "or_null", deserialize_with = "unless_null")]
    #[cfg_attr(test, schemars(with = "Summary"))]
    pub ray_error_mrad: Option<Summary>,
    /// Ray error carried back to the image, pixels.
    #[serde(serialize_with = "or_null", deserialize_with = "unless_null")]
    #[cfg_attr(test, schemars(with = "Summary"))]
    pub pixel_error_px: Option<Summary>,
    /// The least error that any single mirror has; absent without a projection.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub least_error: Option<LeastError>,
    /// The samples of a picture that is given as data; absent of others.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub map: Option<MapFacts>,
    /// How straight lines of the world are in the picture; absent of projections that bend them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub straightness: Option<Straightness>,
    /// How far lines between panels are from the profile's; absent where they are there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dividing_lines: Option<DividingLineFacts>,
}

/// A curl with its keys, all null when there is none: readers find the keys either way.
fn curl_or_null<S: Serializer>(curl: &Option<CurlFacts>, serializer: S) -> Result<S::Ok, S::Error> {
    let none = f64::NAN;
    let none = CurlFacts { rms: none, max: none, condition: none, rounding: none };
    curl.unwrap_or(none).serialize(serializer)
}

impl DesignFacts {
    /// A mirror that was given, of which nothing is wanted yet.
    #[must_use]
    pub fn given(degree: usize) -> Self {
        Self {
            method: "given".into(),
            minimax: false,
            degree,
            unknowns: 0,
            steps: 0,
            condition: None,
            gradient_residual: None,
            curl: None,
            ray_error_mrad: None,
            pixel_error_px: None,
            least_error: None,
            map: None,
            straightness: None,
            dividing_lines: None,
        }
    }

    /// A solved mirror.
    #[must_use]
    pub fn solved(
        method: &'static str,
        minimax: bool,
        degree: usize,
        fit: &LeastSquaresFit,
    ) -> Self {
        Self {
            method: method.into(),
            minimax,
            unknowns: fit.coefficients.len(),
            steps: fit.steps,
            condition: Some(fit.condition),
            ..Self::given(degree)
        }
    }

    /// These figures with the errors of `mirror` against `view`.
    ///
    /// # Errors
    /// [`FailureCause`] when one is not finite.
    pub fn against(
        self,
        mirror: &Mirror,
        camera: &Camera,
        view: &ImagingTask,
    ) -> Result<Self, FailureCause> {
        let (ray, pixel) = errors(mirror, camera, view)?;
        if !(ray.rms.is_finite() && pixel.rms.is_finite()) {
            return Err(NO_ERROR);
        }
        Ok(Self {
            curl: Some(curl(mirror, camera, view)),
            ray_error_mrad: Some(ray.scaled(1e3)),
            pixel_error_px: Some(pixel.scaled(1.0 / camera.pixel_mm)),
            map: MapFacts::of(camera, view),
            straightness: Straightness::of(mirror, camera, view),
            ..self
        })
    }
}

/// Ray error (rad) and image displacement (mm) of the designed panel against the projection.
fn errors(
    mirror: &Mirror,
    camera: &Camera,
    view: &ImagingTask,
) -> Result<(Summary, Summary), FailureCause> {
    let lines = mirror.outline.samples(SAMPLES);
    let lines = parallel::map_slice(&lines, 1, |line| line_errors(mirror, camera, view, line));
    let lines: Vec<LineErrors> = lines.into_iter().collect::<Result<_, _>>()?;
    let (rays, shifts): (Vec<_>, Vec<_>) = lines.into_iter().unzip();
    let summary = |errors: Vec<Vec<_>>| Summary::weighted(errors.concat()).ok_or(NO_ERROR);
    Ok((summary(rays)?, summary(shifts)?))
}

/// Ray errors (rad) and image displacements (mm) with their weights.
type LineErrors = (Vec<(f64, f64)>, Vec<(f64, f64)>);

fn line_errors(
    mirror: &Mirror,
    camera: &Camera,
    view: &ImagingTask,
    line: &[(DVec2, f64)],
) -> Result<LineErrors, FailureCause> {
    let (mut rays, mut shifts) = (Vec::new(), Vec::new());
    let places: Vec<DVec2> = line.iter().map(|(q, _)| *q).collect();
    for (&(q, weight), point) in line.iter().zip(mirror.eval_many(&places)) {
        let at = mirror.position(q, &point);
        let (on_chart, _) = camera.chart.coordinates(at);
        let image = camera.picture.image_point(on_chart);
        if view.is_framed() && !(camera.frames(image) && view.projection.wants(image)) {
            continue;
        }
        let weight = weight * camera.picture.density(on_chart);
        let ray = camera.chart.ray(on_chart, at.z + 1.0);
        let seen = reflect(ray.direction, mirror.normal(q, &point));
        let slope = mirror.slope(q, &point).to_array();
        let content = view.image_of_seen(&camera.chart, at.to_array(), slope, image);
        let ray = angle(seen, view.direction_of(image, at));
        let shift = (DVec2::from_array(content) - image).length();
        if !(ray.is_finite() && shift.is_finite()) {
            let failure = LocalFailure::at(&camera.chart, view, on_chart, at, slope);
            let cause = |failure| FailureCause::At { at: at.truncate(), failure, stage: None };
            return Err(failure.map_or(NO_ERROR, cause));
        }
        rays.push((ray, weight));
        shifts.push((shift, weight));
    }
    Ok((rays, shifts))
}

/// Every so many places along and across, the curl's rounding is bounded.
const BOUNDED: usize = 5;

fn curl(mirror: &Mirror, camera: &Camera, view: &ImagingTask) -> CurlFacts {
    let (mut square, mut area, mut worst) = (0.0, 0.0, (0.0f64, None));
    let (unit, chart) = (view.projection.scale_mm(), &camera.chart);
    let lines = mirror.outline.samples(SAMPLES / 2);
    let curls = parallel::map_slice(&lines, 1, |line| {
        let places: Vec<DVec2> = line.iter().map(|(q, _)| *q).collect();
        let curl = |(q, point): (&DVec2, HeightAndSlope)| {
            let (image, f) = chart.coordinates(mirror.position(*q, &point));
            (image, f, view.curl(chart, image, f))
        };
        places.iter().zip(mirror.eval_many(&places)).map(curl).collect::<Vec<_>>()
    });
    let mut bounded = Vec::new();
    for (row, (line, curls)) in lines.iter().zip(&curls).enumerate() {
        for (k, ((_, weight), &(image, f, curl))) in line.iter().zip(curls).enumerate() {
            square += weight * curl * curl;
            area += weight;
            // A law may have no derivative on the axis itself.
            if curl.abs() > worst.0 {
                worst = (curl.abs(), Some((image, f)));
            }
            if row % BOUNDED == 0 && k % BOUNDED == 0 && curl.is_finite() {
                bounded.push((image, f));
            }
        }
    }
    bounded.extend(worst.1);
    let (mut condition, mut rounding) = (0.0f64, 0.0f64);
    let bounds = parallel::map_slice(&bounded, 16, |&(image, f)| {
        (view.curl_bounds(chart, image, f), view.curl(chart, image, f))
    });
    for (CurlBounds { range, condition: here }, curl) in bounds {
        rounding = rounding.max(curl - range.lo).max(range.hi - curl);
        condition = condition.max(here);
    }
    let rms = f64::sqrt(square / area);
    CurlFacts {
        rms: unit * rms,
        max: unit * worst.0,
        condition: unit * condition,
        rounding: unit * rounding,
    }
}

/// The integral of |grad F - s|^2 that a fit leaves, in the paper's units.
#[must_use]
pub(super) fn in_paper_units(integral: f64, problem: &DesignProblem) -> f64 {
    let unit = problem.view.projection.scale_mm();
    integral / (unit * unit)
}
