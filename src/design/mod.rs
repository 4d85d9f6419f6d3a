//! The design stage: `Profile` -> `Mirror`, with what the design can and cannot do.

mod layout;
mod vector_field;

use crate::geom::{DVec2, Rect, angle};
use crate::mirror::{Mirror, Sheet};
use crate::num::least_squares::RankDeficient;
use crate::num::stats::Summary;
use crate::optics::{Image, Orthographic, reflect_vertical};
use crate::profile::{Method, Profile};
use layout::Plan;
use serde::Serialize;
use thiserror::Error;

/// Samples per side of the panel for the reported errors; the rim is sampled too, where the worst
/// error usually is.
const SAMPLES: usize = 200;

/// A designed mirror with the picture it is meant to give and the camera that takes it.
#[derive(Debug, Clone)]
pub struct Design {
    /// The surface.
    pub mirror: Mirror,
    /// The projection it approximates.
    pub image: Image,
    /// The camera.
    pub camera: Orthographic,
    /// Figures of merit.
    pub facts: Facts,
}

/// Root mean square and maximum over the panel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// Area-weighted root mean square.
    pub rms: f64,
    /// Largest magnitude.
    pub max: f64,
}

/// What the design reached, before any mesh.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Facts {
    /// Name of the method, as in the profile.
    pub method: &'static str,
    /// Polynomial degree in each of y and z.
    pub degree: usize,
    /// Number of coefficients solved for.
    pub unknowns: usize,
    /// Integral of |grad F - s|^2 over the domain of the fit, in the paper's units (paper,
    /// equation for A in section 4).
    pub gradient_residual: f64,
    /// Curl of the slope field over the panel, paper's units (1/rad).
    pub curl: Spread,
    /// Angle between the direction seen and the direction wanted, mrad.
    pub ray_error_mrad: Summary,
    /// The same carried back to the image, pixels.
    pub pixel_error_px: Summary,
}

/// Why no mirror could be designed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum DesignError {
    /// The fit has no unique answer.
    #[error("the fit of degree {degree} is not determined: {source}; lower the degree")]
    Fit {
        /// Degree asked for.
        degree: usize,
        /// The solver's account.
        source: RankDeficient,
    },
    /// The numbers leave the range of double precision.
    #[error(
        "the mirror's {what} is not finite; bring the elevation range further from +-90 degrees"
    )]
    NotFinite {
        /// Which quantity.
        what: &'static str,
    },
}

/// Designs the mirror that `profile` asks for.
///
/// # Errors
/// [`DesignError`] when the fit is not determined or its numbers overflow.
pub fn design(profile: &Profile) -> Result<Design, DesignError> {
    let plan = Plan::new(profile);
    let Method::VectorField { degree } = profile.method;
    let fit =
        vector_field::fit(&plan, degree).map_err(|source| DesignError::Fit { degree, source })?;
    let mut sheet = Sheet {
        series: fit.series,
        centre: plan.domain.centre(),
        half: 0.5 * plan.domain.size(),
        scale_mm: plan.strip.scale_mm,
        lift_mm: 0.0,
    };
    sheet.lift_mm = profile.part.base_mm - lowest(&sheet, &plan);
    let (ray, pixel) = errors(&sheet, &plan)
        .filter(|(ray, pixel)| ray.rms.is_finite() && pixel.rms.is_finite())
        .ok_or(DesignError::NotFinite { what: "image error" })?;
    if !sheet.lift_mm.is_finite() {
        return Err(DesignError::NotFinite { what: "sag" });
    }
    let facts = Facts {
        method: "vector-field",
        degree,
        unknowns: fit.unknowns,
        gradient_residual: fit.residual,
        curl: curl(&plan),
        ray_error_mrad: ray.scaled(1e3),
        pixel_error_px: pixel.scaled(1.0 / plan.camera.pixel_mm),
    };
    let mirror =
        Mirror { sheet, panel: plan.panel, folded: plan.fold.is_some(), even_x: plan.even_x };
    let image = Image { strip: plan.strip, fold: plan.fold };
    Ok(Design { mirror, image, camera: plan.camera, facts })
}

/// The least sag over the panel, to rounding (of a surface that sampling does not miss a dip of).
fn lowest(sheet: &Sheet, plan: &Plan) -> f64 {
    let least = |area: Rect, samples: usize| -> (DVec2, f64) {
        area.grid_rows(samples, samples)
            .flat_map(|(y, row)| {
                let line = sheet.row(y);
                row.into_iter().map(move |(q, _)| (q, line.at(q.x).sag)).collect::<Vec<_>>()
            })
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .expect("a grid has points")
    };
    let panel = plan.panel;
    let (mut at, mut sag) = least(panel, SAMPLES);
    let mut reach = panel.size() / SAMPLES as f64;
    // Each step looks closer around the least place so far, by a factor of four.
    for _ in 0..12 {
        let near = Rect { min: (at - reach).max(panel.min), max: (at + reach).min(panel.max) };
        (at, sag) = least(near, 8);
        reach /= 4.0;
    }
    sag
}

/// Ray error (rad) and image displacement (mm) of the sheet against the projection.
fn errors(sheet: &Sheet, plan: &Plan) -> Option<(Summary, Summary)> {
    let (mut rays, mut shifts) = (Vec::new(), Vec::new());
    for (y, row) in plan.panel.grid_rows(SAMPLES, SAMPLES) {
        let line = sheet.row(y);
        for (q, weight) in row {
            let seen = reflect_vertical(line.at(q.x).slope);
            rays.push((angle(seen, plan.strip.wanted(q)), weight));
            shifts.push(((plan.strip.locate(seen, q) - q).length(), weight));
        }
    }
    Some((Summary::weighted(rays)?, Summary::weighted(shifts)?))
}

fn curl(plan: &Plan) -> Spread {
    let (mut square, mut area, mut max) = (0.0, 0.0, 0.0f64);
    for (q, weight) in plan.panel.grid(SAMPLES, SAMPLES) {
        let curl = plan.strip.curl(q);
        square += weight * curl * curl;
        area += weight;
        max = max.max(curl.abs());
    }
    Spread { rms: f64::sqrt(square / area), max }
}
