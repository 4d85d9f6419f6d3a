//! What a profile asks of a tolerance study, with usual values where it says nothing.

use super::{ErrorSource, Process, TextureShape, ToleranceSpec, form_of_pv};
use crate::geom::BicubicSpline;
use crate::profile::{Profile, Tolerance};
use crate::tolerance_terms::{Distribution, ErrorSourceRow, FormMeasure, Perturbation, Reference};
use thiserror::Error;

/// About how many places stand for the picture: a Fibonacci number, as lattices have that many. RMS
/// and P95 of the shipped designs' errors are then within 0.1 % and 1 %.
const SAMPLES: usize = 987;

/// A cutter that does not reach from track to track.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error(
    "a ball of {ball_radius_mm} mm does not reach from track to track {stepover_mm} mm apart; raise \
     tolerance.ball_radius_mm, or lower tolerance.limits.stepover_mm"
)]
pub struct TracksError {
    /// From track to track, mm.
    pub stepover_mm: f64,
    /// Radius of the ball, mm.
    pub ball_radius_mm: f64,
}

impl ToleranceSpec {
    /// What `profile` asks of its mirror, `[round, telecentric]` or not, with a measured form error `map` if
    /// there is one. `facets_px` is the bound that its mesh keeps; 0 where the part is not made from a mesh.
    ///
    /// # Errors
    /// [`TracksError`] when its ball is too small for its stepover.
    pub fn asked(
        profile: &Profile,
        [round, telecentric]: [bool; 2],
        map: Option<BicubicSpline>,
        facets_px: f64,
    ) -> Result<Self, TracksError> {
        let asked = &profile.tolerance;
        let process = Process::of(asked.preset);
        let sources: Vec<ErrorSource> = ErrorSourceRow::TABLE
            .iter()
            .filter(|row| row.applies_to.holds(round, telecentric, map.is_some()))
            .map(|row| source(asked, &process, row.perturbation, facets_px))
            .filter(|source| source.limit != 0.0)
            .collect();
        let texture = texture(asked, &process.texture, profile.lens.wavelength_nm);
        let tracks = sources.iter().find(|source| source.kind == Perturbation::Stepover);
        if let Some(tracks) = tracks.filter(|t| t.limit >= 2.0 * texture.ball_radius_mm) {
            let (stepover_mm, ball_radius_mm) = (tracks.limit, texture.ball_radius_mm);
            return Err(TracksError { stepover_mm, ball_radius_mm });
        }
        Ok(Self::of_sources(profile, sources, map))
    }

    /// The question how much form error the mirror of `profile`, round or not, bears: terms of one micrometre from peak
    /// to valley, against the projection and without adjustment, as a finished part is judged.
    #[must_use]
    pub fn of_form(profile: &Profile, round: bool) -> Self {
        let source = |row: &ErrorSourceRow| ErrorSource {
            kind: row.perturbation,
            limit: 1.0,
            distribution: Distribution::Fixed,
            weight: 1.0,
        };
        let sources = ErrorSourceRow::of_form(round).map(source);
        Self {
            form: FormMeasure::Pv,
            compensators: Vec::new(),
            reference: Reference::Projection,
            ..Self::of_sources(profile, sources.collect(), None)
        }
    }

    /// What `profile` asks of these sources.
    fn of_sources(
        profile: &Profile,
        sources: Vec<ErrorSource>,
        map: Option<BicubicSpline>,
    ) -> Self {
        let asked = &profile.tolerance;
        let usual = Process::of(asked.preset).texture;
        Self {
            sources,
            form: asked.form,
            texture: texture(asked, &usual, profile.lens.wavelength_nm),
            map,
            compensators: asked.compensators.clone(),
            criterion: asked.criterion,
            reference: asked.reference,
            budget_px: asked.budget_px,
            budget_blur_px: asked.budget_blur_px.unwrap_or(asked.budget_px),
            target_yield: asked.target_yield,
            samples: SAMPLES,
        }
    }
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
        limit: asked.limit(kind).unwrap_or(usual),
        distribution: asked.distribution(kind).unwrap_or(distribution),
        weight: asked.weight(kind).unwrap_or(1.0),
    }
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
    use super::*;
    use crate::optics::CameraModel;
    use crate::profile::{Layout, shipped};
    use crate::tolerance_terms::{Compensator, Criterion, ProcessPreset};

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
            let round = matches!(source.layout, Layout::Disc | Layout::Annulus { .. });
            let telecentric = matches!(source.camera, CameraModel::Orthographic { .. });
            let asked = ToleranceSpec::asked(&source, [round, telecentric], None, 0.0).unwrap();
            // (This asks for no facets, as where the part is made from the STEP.)
            assert!(asked.sources.len() >= 23, "{}: {}", shipped.name, asked.sources.len());
        }
        let source: Profile = profile(
            "[tolerance]\npreset = \"spdt\"\nball_radius_mm = 0.7\ncriterion = \"p95\"\n\
             compensators = [\"tilt\"]\n[tolerance.limits]\ntilt_x_mrad = 3\ntilt_y_mrad = 0\n\
             [tolerance.distributions]\ntilt_x_mrad = \"normal\"\n",
        );
        let asked = ToleranceSpec::asked(&source, [false, true], None, 0.0).unwrap();
        let tilt = asked.sources.iter().find(|s| s.kind == Perturbation::TiltX).unwrap();
        assert_eq!((tilt.limit, tilt.distribution), (3.0, Distribution::Normal));
        assert!(asked.sources.iter().all(|s| s.kind != Perturbation::TiltY));
        assert_eq!((asked.texture.ball_radius_mm, asked.criterion), (0.7, Criterion::P95));
        assert_eq!(asked.compensators, [Compensator::Tilt]);
        let wide: Profile =
            profile("[tolerance]\nball_radius_mm = 0.01\n[tolerance.limits]\nstepover_mm = 0.02\n");
        assert!(ToleranceSpec::asked(&wide, [false, true], None, 0.0).is_err());
    }
}
