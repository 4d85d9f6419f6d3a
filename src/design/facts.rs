//! What a design reached, before any mesh.

use super::layout::Plan;
use super::solve::Fit;
use crate::geom::{DVec2, angle};
use crate::mirror::Mirror;
use crate::num::stats::{Summary, or_null, unless_null};
use crate::optics::{Camera, View, reflect};
use serde::{Deserialize, Serialize, Serializer};

/// Samples per side of the panel, or along each of as many radii; the rim is sampled too, where the
/// worst error usually is.
pub const SAMPLES: usize = 200;

/// Root mean square and maximum over the panel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Area-weighted root mean square.
    pub rms: f64,
    /// Largest magnitude.
    pub max: f64,
}

/// Figures of merit of a design.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Facts {
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
    /// W . curl W / |W|^2 over the panel, paper's units (1/rad): zero where an exact mirror exists.
    #[serde(serialize_with = "spread_or_null", deserialize_with = "unless_null")]
    pub curl: Option<Spread>,
    /// Angle between the direction seen and the direction wanted, mrad.
    #[serde(serialize_with = "or_null", deserialize_with = "unless_null")]
    pub ray_error_mrad: Option<Summary>,
    /// The same carried back to the image, pixels.
    #[serde(serialize_with = "or_null", deserialize_with = "unless_null")]
    pub pixel_error_px: Option<Summary>,
}

/// A spread with its keys, all null when there is none: readers find the keys either way.
fn spread_or_null<S: Serializer>(
    spread: &Option<Spread>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    spread.unwrap_or(Spread { rms: f64::NAN, max: f64::NAN }).serialize(serializer)
}

impl Facts {
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
        }
    }

    /// A solved mirror.
    #[must_use]
    pub fn solved(method: &'static str, minimax: bool, degree: usize, fit: &Fit) -> Self {
        Self {
            method: method.into(),
            minimax,
            unknowns: fit.coefficients.len(),
            steps: fit.steps,
            condition: Some(fit.condition),
            ..Self::given(degree)
        }
    }

    /// The same with the errors of `mirror` against `view`; none when one is not finite.
    #[must_use]
    pub fn against(self, mirror: &Mirror, camera: &Camera, view: &View) -> Option<Self> {
        let (ray, pixel) = errors(mirror, camera, view)
            .filter(|(ray, pixel)| ray.rms.is_finite() && pixel.rms.is_finite())?;
        Some(Self {
            curl: Some(curl(mirror, camera, view)),
            ray_error_mrad: Some(ray.scaled(1e3)),
            pixel_error_px: Some(pixel.scaled(1.0 / camera.pixel_mm)),
            ..self
        })
    }
}

/// Ray error (rad) and image displacement (mm) of the designed panel against the projection.
fn errors(mirror: &Mirror, camera: &Camera, view: &View) -> Option<(Summary, Summary)> {
    let (mut rays, mut shifts) = (Vec::new(), Vec::new());
    for line in mirror.outline.samples(SAMPLES) {
        let places: Vec<DVec2> = line.iter().map(|(q, _)| *q).collect();
        for ((q, weight), point) in line.into_iter().zip(mirror.along(&places)) {
            let at = mirror.place(q, &point);
            let (image, _) = camera.chart.coordinates(at);
            let ray = camera.chart.ray(image, at.z + 1.0);
            let seen = reflect(ray.direction, mirror.normal(q, &point));
            rays.push((angle(seen, view.wanted(image, at)), weight));
            let content = view.content(
                &camera.chart,
                at.to_array(),
                mirror.slope(q, &point).to_array(),
                image,
            );
            shifts.push(((DVec2::from_array(content) - image).length(), weight));
        }
    }
    Some((Summary::weighted(rays)?, Summary::weighted(shifts)?))
}

fn curl(mirror: &Mirror, camera: &Camera, view: &View) -> Spread {
    let (mut square, mut area, mut max) = (0.0, 0.0, 0.0f64);
    let unit = view.projection.scale_mm();
    for line in mirror.outline.samples(SAMPLES / 2) {
        let places: Vec<DVec2> = line.iter().map(|(q, _)| *q).collect();
        for ((q, weight), point) in line.into_iter().zip(mirror.along(&places)) {
            let (image, f) = camera.chart.coordinates(mirror.place(q, &point));
            let curl = unit * view.curl(&camera.chart, image, f);
            square += weight * curl * curl;
            area += weight;
            // A law may have no derivative on the axis itself.
            max = if curl.abs() <= max { max } else { curl.abs() };
        }
    }
    Spread { rms: f64::sqrt(square / area), max }
}

/// The integral of |grad F - s|^2 that a fit leaves, in the paper's units.
#[must_use]
pub fn in_paper_units(integral: f64, plan: &Plan) -> f64 {
    let unit = plan.view.projection.scale_mm();
    integral / (unit * unit)
}
