//! Specification of a tolerance run, by the profile's words, a measured form error, and the facets of the
//! mesh that the part is made from.

use super::face::plan;
use super::run::Run;
use super::{Error, Stage};
use crate::design::Design;
use crate::geom::Outline;
use crate::mirror::{BicubicSpline, Mirror};
use crate::num::units::Mm;
use crate::profile::{CadFormat, FileFormat, Profile, Tolerance};
use crate::report::FacetsFrom;
use crate::tolerance::{
    Engine, ErrorSource, Process, TextureShape, ToleranceSpec, extent, facets_bound, form_of_pv,
};
use crate::tolerance_terms::{ErrorSourceRow, MadeFrom, Perturbation};

/// About how many places stand for the picture: a Fibonacci number, as lattices have that many. RMS
/// and P95 of the shipped designs' errors are then within 0.1 % and 1 %.
const SAMPLES: usize = 987;

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
    let profile = run.profile;
    let design = run.design()?;
    let map = map(run.profile, &design.mirror)?;
    let name = || profile.name.clone();
    let view = design
        .view
        .as_ref()
        .ok_or_else(|| Error::NoProjection { work: "tolerance", profile: name() })?;
    let (asked, facets_from) = spec(profile, &design, map, meshed(profile, &design)?)?;
    let engine = run.stage(Stage::Sensitivities, || {
        let engine = Engine::new(&design.mirror, &design.camera, view, asked)
            .ok_or_else(|| Error::Unseen { profile: name() })?;
        run.timer.toleranced(Stage::Sensitivities, engine.worked());
        let sources = engine.spec.sources.len();
        let [pixels, expanded] = [engine.samples(), engine.expanded()];
        let note = format!("{sources} sources, {pixels} pixels, {expanded} by polynomials");
        Ok((engine, note))
    })?;
    Ok(PreparedStudy { design, engine, facets_from })
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
    if let Some(px) = said_of(&profile.tolerance.limits, Perturbation::Facets) {
        return Ok(Some((px, FacetsFrom::Limits)));
    }
    if from_step {
        return Ok(None);
    }
    if let Some(px) = profile.mesh.facet_px() {
        return Ok(Some((px, FacetsFrom::Mesh)));
    }
    let plan = plan(profile, design)?.made;
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

/// The profile's specification, with usual values where it says nothing.
fn spec(
    profile: &Profile,
    design: &Design,
    map: Option<BicubicSpline>,
    meshed: Option<(f64, FacetsFrom)>,
) -> Result<(ToleranceSpec, Option<FacetsFrom>), Error> {
    let asked = &profile.tolerance;
    let process = Process::of(asked.preset);
    let round = matches!(design.mirror.outline, Outline::Ring { .. });
    let telecentric = design.camera.chart.vergence == 0.0;
    let facets_px = meshed.map_or(0.0, |(px, _)| px);
    let sources: Vec<ErrorSource> = ErrorSourceRow::TABLE
        .iter()
        .filter(|row| row.applies_to.holds(round, telecentric, map.is_some()))
        .map(|row| source(asked, &process, row.perturbation, facets_px))
        .filter(|source| source.limit != 0.0)
        .collect();
    let has_facets = sources.iter().any(|source| source.kind == Perturbation::Facets);
    let facets_from = meshed.map(|(_, from)| from).filter(|_| has_facets);
    let texture = texture(asked, &process.texture, profile.lens.wavelength_nm);
    let tracks = sources.iter().find(|source| source.kind == Perturbation::Stepover);
    if let Some(tracks) = tracks.filter(|t| t.limit >= 2.0 * texture.ball_radius_mm) {
        let (stepover_mm, ball_radius_mm) = (tracks.limit, texture.ball_radius_mm);
        return Err(Error::Tracks { profile: profile.name.clone(), stepover_mm, ball_radius_mm });
    }
    let spec = ToleranceSpec {
        sources,
        form: asked.form,
        texture,
        map,
        compensators: asked.compensators.clone(),
        criterion: asked.criterion,
        reference: asked.reference,
        budget_px: asked.budget_px,
        budget_blur_px: asked.budget_blur_px.unwrap_or(asked.budget_px),
        target_yield: asked.target_yield,
        samples: SAMPLES,
    };
    Ok((spec, facets_from))
}

/// An error source as the profile has it, or as is usual; `facets_px` is the bound that the mesh keeps.
fn source(asked: &Tolerance, process: &Process, kind: Perturbation, facets_px: f64) -> ErrorSource {
    let (usual, distribution) = process.usual(kind);
    let usual = if kind == Perturbation::Facets { facets_px } else { usual };
    let share = kind.form_term().map_or(1.0, |term| form_of_pv(term, asked.form));
    // (A usual figure has few digits.)
    let usual = if share == 1.0 { usual } else { (1e3 * usual * share).round() * 1e-3 };
    ErrorSource {
        kind,
        limit: said_of(&asked.limits, kind).unwrap_or(usual),
        distribution: said_of(&asked.distributions, kind).unwrap_or(distribution),
        weight: said_of(&asked.weights, kind).unwrap_or(1.0),
    }
}

/// The value of an error source in a table of the profile.
fn said_of<T: Copy>(table: &[(Perturbation, T)], kind: Perturbation) -> Option<T> {
    table.iter().find(|(of, _)| *of == kind).map(|(_, said)| *said)
}

/// Shapes of the textures as the profile has them, or as are usual.
fn texture(asked: &Tolerance, usual: &TextureShape, wavelength_nm: f64) -> TextureShape {
    TextureShape {
        cte_ppm_per_k: asked.expansion_ppm_per_k.unwrap_or(usual.cte_ppm_per_k),
        waviness_period_mm: asked.waviness_period_mm.unwrap_or(usual.waviness_period_mm),
        waviness_direction_deg: asked
            .waviness_direction_deg
            .unwrap_or(usual.waviness_direction_deg),
        slope_correlation_mm: asked.slope_correlation_mm.unwrap_or(usual.slope_correlation_mm),
        ball_radius_mm: asked.ball_radius_mm.unwrap_or(usual.ball_radius_mm),
        stepover_direction_deg: asked
            .stepover_direction_deg
            .unwrap_or(usual.stepover_direction_deg),
        wavelength_nm,
    }
}

#[cfg(test)]
mod tests {
    use super::super::run::designed;
    use super::*;
    use crate::profile::shipped;
    use crate::tolerance_terms::{Compensator, Criterion, Distribution, ProcessPreset};

    fn profile(edit: &str) -> Profile {
        let shipped = shipped().iter().find(|p| p.name == "conquistador").unwrap();
        let text = format!("{}\n{edit}", shipped.text);
        Profile::parse("case", "case.toml", text.as_bytes()).unwrap_or_else(|c| panic!("{c}"))
    }

    #[test]
    fn every_key_and_every_word_of_a_profile_is_read() {
        let zeros: Vec<String> =
            Perturbation::KEYS.iter().map(|key| format!("{key} = 0\n")).collect();
        let limits = format!("map_file = \"map.csv\"\n[tolerance.limits]\n{}", zeros.concat());
        let read = |lines: &str| profile(&format!("[tolerance]\n{lines}")).tolerance;
        assert!(read(&limits).limits.iter().map(|limit| limit.0).eq(Perturbation::all()));
        for (word, preset) in ProcessPreset::WORDS {
            assert_eq!(read(&format!("preset = \"{word}\"")).preset, *preset);
            assert_eq!((preset.word(), Process::of(*preset).preset), (*word, *preset));
        }
        for (word, distribution) in Distribution::WORDS {
            let asked = read(&format!("distributions.scale_ppm = \"{word}\""));
            assert_eq!(asked.distributions, [(Perturbation::Scale, *distribution)]);
        }
        for (word, compensator) in Compensator::WORDS {
            assert_eq!(read(&format!("compensators = [\"{word}\"]")).compensators, [*compensator]);
        }
    }

    #[test]
    fn every_shipped_profile_has_24_sources_and_its_own_words_count() {
        for shipped in shipped() {
            let source: Profile =
                Profile::parse(shipped.name, shipped.name, shipped.text.as_bytes()).unwrap();
            let design = designed(&source).unwrap();
            let (asked, _) = spec(&source, &design, None, None).unwrap();
            // (This asks for no facets, as where the part is made from the STEP.)
            assert!(asked.sources.len() >= 23, "{}: {}", shipped.name, asked.sources.len());
        }
        let source: Profile = profile(
            "[tolerance]\npreset = \"spdt\"\nball_radius_mm = 0.7\ncriterion = \"p95\"\n\
             compensators = [\"tilt\"]\n[tolerance.limits]\ntilt_x_mrad = 3\ntilt_y_mrad = 0\n\
             [tolerance.distributions]\ntilt_x_mrad = \"normal\"\n",
        );
        let design = designed(&source).unwrap();
        let (asked, _) = spec(&source, &design, None, None).unwrap();
        let tilt = asked.sources.iter().find(|s| s.kind == Perturbation::TiltX).unwrap();
        assert_eq!((tilt.limit, tilt.distribution), (3.0, Distribution::Normal));
        assert!(asked.sources.iter().all(|s| s.kind != Perturbation::TiltY));
        assert_eq!((asked.texture.ball_radius_mm, asked.criterion), (0.7, Criterion::P95));
        assert_eq!(asked.compensators, [Compensator::Tilt]);
        let wide: Profile =
            profile("[tolerance]\nball_radius_mm = 0.01\n[tolerance.limits]\nstepover_mm = 0.02\n");
        assert!(matches!(spec(&wide, &design, None, None), Err(Error::Tracks { .. })));
    }
}
