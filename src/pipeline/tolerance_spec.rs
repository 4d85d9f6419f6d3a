//! Preparation of a tolerance run: the design, a measured form error, the facets of the mesh that the part is
//! made from, and the engine.

use super::run::Run;
use super::{Error, Stage};
use crate::design::Design;
use crate::geom::{BicubicSpline, Outline};
use crate::mirror::Mirror;
use crate::num::units::Mm;
use crate::part::plan;
use crate::profile::{CadFormat, FileFormat, Profile};
use crate::results::FacetsFrom;
use crate::tolerance::{Engine, ToleranceSpec, extent, facets_bound};
use crate::tolerance_terms::{MadeFrom, Perturbation};

/// A question, ready to be answered.
pub(crate) struct PreparedStudy {
    /// The design.
    pub design: Design,
    /// Engine that traces it.
    pub engine: Engine,
    /// Origin of the facets' limit, if they are a source.
    pub facets_from: Option<FacetsFrom>,
}

/// The design of the profile, and what is asked of it.
///
/// # Errors
/// [`enum@Error`] when it has no answer, no projection, or a form error that is none of its mirror.
pub(crate) fn prepared(run: &Run) -> Result<PreparedStudy, Error> {
    let design = run.design()?;
    let (engine, facets_from) = engine(run, &design)?;
    Ok(PreparedStudy { design, engine, facets_from })
}

/// The engine that traces what the profile asks of its design, and the origin of the facets' limit, if they are a source.
///
/// # Errors
/// [`enum@Error`] when there is no projection, or a form error that is none of the mirror.
pub(super) fn engine(run: &Run, design: &Design) -> Result<(Engine, Option<FacetsFrom>), Error> {
    let profile = run.profile;
    let map = map(profile, &design.mirror)?;
    let name = || profile.name.clone();
    let view = design
        .view
        .as_ref()
        .ok_or_else(|| Error::NoProjection { work: "tolerance", profile: name() })?;
    let meshed = meshed(profile, design)?;
    let round = matches!(design.mirror.outline, Outline::Ring { .. });
    let telecentric = design.camera.chart.vergence == 0.0;
    let asked =
        ToleranceSpec::asked(profile, [round, telecentric], map, meshed.map_or(0.0, |(px, _)| px))
            .map_err(|error| Error::tracks(profile, error))?;
    let has_facets = asked.sources.iter().any(|source| source.kind == Perturbation::Facets);
    let facets_from = meshed.map(|(_, from)| from).filter(|_| has_facets);
    let engine = run.stage(Stage::Sensitivities, || {
        let engine = Engine::new(&design.mirror, &design.camera, view, asked)
            .ok_or_else(|| Error::Unseen { profile: name() })?;
        run.timer.toleranced(Stage::Sensitivities, engine.worked());
        let sources = engine.spec.sources.len();
        let [pixels, expanded] = [engine.samples(), engine.expanded()];
        let note = format!("{sources} sources, {pixels} pixels, {expanded} by polynomials");
        Ok((engine, note))
    })?;
    Ok((engine, facets_from))
}

/// The measured form error that the profile names, which must cover the mirror.
fn map(source: &Profile, mirror: &Mirror) -> Result<Option<BicubicSpline>, Error> {
    /// A grid may end so little before the mirror, as a share of its size: rounding.
    const SLACK: f64 = 1e-6;
    let Some(grid) = source.form_map()? else { return Ok(None) };
    let file = source.tolerance.map_file.clone().unwrap_or_default();
    let fault = |reason: String| Error::Map { file: file.clone(), reason };
    let map = BicubicSpline::new(grid.x, grid.y, &grid.z_mm)
        .ok_or_else(|| fault("no spline goes through its heights".into()))?;
    let (centre, half) = extent(mirror);
    for (k, (axis, knots)) in ["X", "Y"].into_iter().zip(map.knots()).enumerate() {
        let [lo, hi] = [centre[k] - half[k], centre[k] + half[k]];
        let slack = SLACK * half[k];
        if knots.first_mm > lo + slack || knots.last_mm() < hi - slack {
            return Err(fault(format!(
                "it covers {axis} from {} to {} mm, and the mirror goes from {lo:.4} to {hi:.4} mm; \
                 add rows or columns as far as that",
                knots.first_mm,
                knots.last_mm()
            )));
        }
    }
    Ok(Some(map))
}

/// The facets' bound, px, of the mesh that a part of this profile is made from, and what says it; none
/// where it is made from the STEP.
fn meshed(profile: &Profile, design: &Design) -> Result<Option<(f64, FacetsFrom)>, Error> {
    let csv = FileFormat::Cad(CadFormat::Csv);
    let first = profile.formats.iter().find(|format| **format != csv);
    let from_step = match profile.tolerance.made_from {
        Some(file) => file == MadeFrom::Step,
        None => first.is_none_or(|format| *format == FileFormat::Cad(CadFormat::Step)),
    };
    if let Some(px) = profile.tolerance.limit(Perturbation::Facets) {
        return Ok(Some((px, FacetsFrom::Limits)));
    }
    if from_step {
        return Ok(None);
    }
    if let Some(px) = profile.mesh.facet_px() {
        return Ok(Some((px, FacetsFrom::Mesh)));
    }
    let plan = plan(profile, design).map_err(|error| Error::face(profile, error))?.made;
    let px = match plan.limits.facet_mm {
        Some(mm) => design.camera.to_px(Mm(mm)).0,
        None => {
            let pixel = design.camera.pixel_mm;
            let pixels = design.mirror.full_outline().area() / (pixel * pixel);
            facets_bound(plan.forecast.facets / pixels)
        }
    };
    // (No more digits than it deserves.)
    Ok(Some(((1e3 * px).round() / 1e3, FacetsFrom::Foreseen)))
}
