//! The cheapest settings that reach a pixel error.

use super::design::METHODS;
use super::profile_edit::{document, set};
use super::{BenchError, BenchRun, BenchSweep, Subject, SuggestedSettings, Suggestion};
use crate::num::rounding::two_digits_below;
use crate::num::sort_by_number;
use crate::num::stats::Summary;
use crate::pipeline::{Run, Silent, build_in_memory, designed, meshed};
use crate::profile::{MeshGoal, Method, Profile, ShapeSpec};
use std::time::Instant;
use toml_edit::{Item, Table, value};

/// How often the facets' limit is corrected by what the witness finds.
const TRIES: usize = 4;
/// What is aimed at, as a share of the error allowed.
const AIM: f64 = 0.98;

/// The cheapest settings for `target_px`, by the runs of `sweeps`, proven by the witness; and the
/// profile's text with them.
pub(super) fn suggest(
    subject: &Subject,
    sweeps: &[BenchSweep],
    target_px: f64,
) -> Result<(Suggestion, Option<String>), BenchError> {
    let of = |name: &str| -> Vec<&BenchRun> {
        let sweep = sweeps.iter().find(|sweep| sweep.name == name);
        let runs = sweep.map_or(&[][..], |sweep| &sweep.runs);
        runs.iter().filter(|run| run.profile == subject.name()).collect()
    };
    let (designs, meshes) = (of("design"), of("mesh-facet"));
    let design_px = |run: &BenchRun| run.figures["pixel_rms_px"];
    let least_px = designs.iter().map(|run| design_px(run)).fold(f64::INFINITY, f64::min);
    let mut suggestion = Suggestion {
        profile: subject.name().to_owned(),
        target_px,
        settings: None,
        least_px,
        program: None,
    };
    // By the time that the design takes and a mesh which leaves the rest of the error to facets.
    let mut candidates: Vec<(f64, &BenchRun, f64)> = designs
        .iter()
        .filter(|run| design_px(run) < AIM * target_px)
        .filter_map(|run| {
            let left = target_px * target_px - design_px(run) * design_px(run);
            let facet_px = left.sqrt();
            let nearest =
                |mesh: &&&BenchRun| (mesh.setting / facet_px).max(facet_px / mesh.setting);
            let mesh = meshes.iter().min_by(|a, b| nearest(a).total_cmp(&nearest(b)))?;
            let ratio = mesh.setting / facet_px;
            Some((run.time_ms + mesh.time_ms * ratio * ratio, *run, facet_px))
        })
        .collect();
    sort_by_number(&mut candidates, |candidate| candidate.0);
    for (_, run, facet_px) in candidates {
        if let Some((settings, method)) = reached(subject, run, facet_px, target_px)? {
            let text = edited(&subject.text()?, &method, settings.facet_px);
            suggestion.settings = Some(settings);
            return Ok((suggestion, text));
        }
    }
    Ok((suggestion, None))
}

/// The settings of the design `run` with facets so fine that the witness finds no more than `target_px`.
fn reached(
    subject: &Subject,
    run: &BenchRun,
    mut facet_px: f64,
    target_px: f64,
) -> Result<Option<(SuggestedSettings, Method)>, BenchError> {
    let minimax = run.series.ends_with(", minimax");
    let word = run.series.trim_end_matches(", minimax");
    let Some(kind) = METHODS.into_iter().find(|kind| kind.name() == word) else {
        return Ok(None);
    };
    let method = Method { kind, degree: run.setting as usize, minimax };
    let design_px = run.figures["pixel_rms_px"];
    let mut best: Option<SuggestedSettings> = None;
    for _ in 0..TRIES {
        facet_px = two_digits_below(facet_px);
        if best.as_ref().is_some_and(|best| facet_px <= best.facet_px) {
            break;
        }
        let mut profile = Profile { shape: ShapeSpec::Designed(method), ..subject.profile.clone() };
        profile.mesh = MeshGoal::limits(profile.mesh.chord_um(), Some(facet_px));
        let source = profile;
        let run = Run::in_memory(&source, &Silent);
        let began = Instant::now();
        let design = designed(&source)?;
        let triangles = meshed(&run, &design)?.0.made.mesh.triangles.len();
        let time_ms = 1e3 * began.elapsed().as_secs_f64();
        let found = build_in_memory(&run, &design, &mut |_| {})?.pixel_error_px;
        let Some(Summary { rms: pixel_rms_px, .. }) = found else { return Ok(None) };
        if pixel_rms_px <= target_px {
            best = Some(SuggestedSettings {
                method: word.to_owned(),
                minimax,
                degree: method.degree,
                facet_px,
                triangles,
                pixel_rms_px,
                time_ms,
                file: format!("{}.toml", subject.name()),
            });
        }
        // What the facets add to the design's error is in proportion to their limit.
        let added = |px: f64| (px * px - design_px * design_px).max(0.0).sqrt();
        facet_px *= (added(AIM * target_px) / added(pixel_rms_px)).clamp(0.1, 10.0);
    }
    Ok(best.map(|settings| (settings, method)))
}

/// `text` with other settings; none where it is no table of a designed mirror.
fn edited(text: &[u8], method: &Method, facet_px: f64) -> Option<String> {
    let mut profile = document(text)?;
    let methods = profile.get_mut("method")?;
    let name = method.kind.name();
    if methods.get(name).is_none() {
        *methods = Item::Table(Table::new());
        methods[name] = Item::Table(Table::new());
    }
    let own = &mut methods[name];
    set(own, "degree", value(method.degree as i64));
    if method.minimax || own.get("minimax").is_some() {
        set(own, "minimax", value(method.minimax));
    }
    let mesh = profile.get_mut("mesh")?;
    set(mesh, "facet_px", value(facet_px));
    if let Some(mesh) = mesh.as_table_like_mut() {
        mesh.remove("max_triangles");
    }
    Some(profile.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::{MethodKind, shipped};

    #[test]
    fn a_profile_is_edited_in_place_and_stays_valid() {
        for shipped in shipped() {
            let bytes = shipped.text.as_bytes();
            let method = |kind, minimax| Method { kind, degree: 9, minimax };
            for method in [
                method(MethodKind::VectorField, false),
                method(MethodKind::VectorField, true),
                method(MethodKind::Distribution, true),
            ] {
                let text = edited(bytes, &method, 0.37).unwrap();
                let before = Profile::parse(shipped.name, shipped.name, bytes).unwrap();
                let after = Profile::parse(shipped.name, shipped.name, text.as_bytes());
                let after = after.unwrap_or_else(|error| panic!("{error}\n{text}"));
                assert_eq!(after.shape, ShapeSpec::Designed(method));
                assert_eq!(after.mesh.facet_px(), Some(0.37));
                assert_eq!((after.camera, after.formats), (before.camera, before.formats));
                let comments = |text: &str| text.matches('#').count();
                let lost = comments(shipped.text) - comments(&text);
                // What was said of a number of triangles goes with it.
                let spent = usize::from(before.mesh.max_triangles().is_some());
                let own = if method.kind == MethodKind::VectorField { 0 } else { 4 };
                assert!(lost <= own + spent, "{}: {lost}", shipped.name);
            }
        }
        let given = "mirror.polynomial.terms = []\n[mesh]\nchord_um = 1\n";
        assert!(
            edited(
                given.as_bytes(),
                &Method { kind: MethodKind::VectorField, degree: 9, minimax: false },
                1.0
            )
            .is_none()
        );
    }
}
