//! The errors that a profile expects.

use toml::de::DeValue;

use super::super::reader::Need::Optional;
use super::super::reader::{ProfileReader, Section};
use super::super::tolerance::Tolerance;
use super::super::values::{number, word};
use super::super::words::list;
use super::super::{Layout, schema};
use crate::optics::CameraModel;
use crate::tolerance_terms::{
    AppliesTo, Compensator, Criterion, Distribution, FormMeasure, MadeFrom, Perturbation,
    ProcessPreset, Reference, UsualLimit,
};

/// Camera and layout, which decide which error sources there are; none where missing or wrong.
#[derive(Clone, Copy)]
pub(super) struct Setting {
    pub(super) camera: Option<CameraModel>,
    pub(super) layout: Option<Layout>,
}

pub(super) fn read(reader: &mut ProfileReader, root: &Section, setting: Setting) -> Tolerance {
    let mut found = Tolerance::default();
    let Some(section) = reader.section(root, "tolerance", Optional) else { return found };
    let hint = "how the part is made, as in preset = \"precision-cnc\"";
    let preset = word(reader, &section, "preset", ProcessPreset::WORDS, hint);
    found.preset = preset.unwrap_or(found.preset);
    let hint = "the root mean square over the picture, or what 95 % of it stay below";
    let criterion = word(reader, &section, "criterion", Criterion::WORDS, hint);
    found.criterion = criterion.unwrap_or(found.criterion);
    let hint = "errors against the picture as designed, or against the projection";
    let reference = word(reader, &section, "reference", Reference::WORDS, hint);
    found.reference = reference.unwrap_or(found.reference);
    let hint = "limits of form errors from peak to valley, or their root mean squares";
    let form = word(reader, &section, "form", FormMeasure::WORDS, hint);
    found.form = form.unwrap_or(found.form);
    let hint = "what the shop makes the part from, the triangles or the curved faces";
    found.made_from = word(reader, &section, "made_from", MadeFrom::WORDS, hint);
    let must = "a number from 0.000001 to 1000000";
    let size = |f: f64| (1e-6..=1e6).contains(&f);
    let mut budget = |key, hint: &str| {
        number(reader, &section, key, Optional, must, hint, size).map(|px| px.value)
    };
    let hint = "the most that the criterion may be in pixels, as in budget_px = 1";
    found.budget_px = budget("budget_px", hint).unwrap_or(found.budget_px);
    let hint = "the most that textures may blur within a pixel, as in budget_blur_px = 1";
    found.budget_blur_px = budget("budget_blur_px", hint);
    let share = "a number from 0.001 to 0.999";
    let hint = "a share of the parts, not a percentage: 0.95 is 95 %";
    let inside = |f: f64| (1e-3..=0.999).contains(&f);
    if let Some(f) = number(reader, &section, "target_yield", Optional, share, hint, inside) {
        found.target_yield = f.value;
    }
    let mut length = |key, hint: &str| {
        number(reader, &section, key, Optional, must, hint, size).map(|f| f.value)
    };
    found.waviness_period_mm = length("waviness_period_mm", "from wave to wave in millimetres");
    found.slope_correlation_mm = length(
        "slope_correlation_mm",
        "where the slope's correlation falls to 1/e, in millimetres",
    );
    found.ball_radius_mm = length("ball_radius_mm", "the cutter's radius in millimetres");
    found.expansion_ppm_per_k =
        length("expansion_ppm_per_k", "23 for aluminium, 90 for acrylic resins");
    let must = "a number from -360 to 360";
    let mut angle = |key| {
        let hint = "from X towards Y in degrees: 90 where the lines run along X";
        let turn = |f: f64| f.abs() <= 360.0;
        number(reader, &section, key, Optional, must, hint, turn).map(|f| f.value)
    };
    found.waviness_direction_deg = angle("waviness_direction_deg");
    found.stepover_direction_deg = angle("stepover_direction_deg");
    if let Some(asked) = compensators(reader, &section) {
        found.compensators = asked;
    }
    found.map_file = map_file(reader, &section);
    sources(reader, &section, setting, &mut found);
    found
}

/// Limits, distributions and weights by source.
fn sources(reader: &mut ProfileReader, section: &Section, setting: Setting, found: &mut Tolerance) {
    let has_map = section.has("map_file");
    let why = |source: Perturbation| foreign(source, setting, has_map);
    if let Some(section) = reader.section(section, "distributions", Optional) {
        for source in Perturbation::all() {
            let key = source.key();
            let hint = "uniform between the limits; normal with the limit at two standard \
                        deviations, truncated there or not; or fixed at the limit";
            if let Some(chosen) = word(reader, &section, key, Distribution::WORDS, hint) {
                refuse_foreign(reader, &section, key, why(source));
                found.distributions.push((source, chosen));
            }
        }
    }
    if let Some(limits) = reader.section(section, "limits", Optional) {
        for source in Perturbation::all() {
            let key = source.key();
            let signed = has_sign(source, &found.distributions);
            let (must, hint) = if signed {
                (
                    "a number from -1000000 to 1000000",
                    "the error with its sign; 0 for no such error",
                )
            } else {
                ("a number from 0 to 1000000", unsigned_hint(source))
            };
            let least = if signed { -1e6 } else { 0.0 };
            let allowed = |f: f64| (least..=1e6).contains(&f);
            let limit = number(reader, &limits, key, Optional, must, hint, allowed);
            let Some(limit) = limit else { continue };
            if limit.value != 0.0 {
                refuse_foreign(reader, &limits, key, why(source));
            }
            found.limits.push((source, limit.value));
        }
    }
    if let Some(section) = reader.section(section, "weights", Optional) {
        for source in Perturbation::all() {
            let key = source.key();
            let must = "a number from 0.000001 to 1000000";
            let hint = "how dear this is to hold against the others, which have 1";
            let allowed = |f: f64| (1e-6..=1e6).contains(&f);
            if let Some(f) = number(reader, &section, key, Optional, must, hint, allowed) {
                refuse_foreign(reader, &section, key, why(source));
                found.weights.push((source, f.value));
            }
        }
    }
}

/// Whether an error is at its limit, with its sign, where these distributions are asked for.
fn has_sign(source: Perturbation, distributions: &[(Perturbation, Distribution)]) -> bool {
    let asked = distributions.iter().find(|of| of.0 == source).map(|of| of.1);
    let fixed = match asked {
        Some(distribution) => distribution == Distribution::Fixed,
        None => matches!(source.row().usual, UsualLimit::Fixed(_)),
    };
    fixed && !source.is_unsigned()
}

fn unsigned_hint(source: Perturbation) -> &'static str {
    if source.is_unsigned() {
        "the limit in the unit that the key ends in; 0 for no such error"
    } else {
        "the limit in the unit that the key ends in, on both sides; 0 for no such error. An error with a \
         sign is \"fixed\" in [tolerance.distributions]"
    }
}

/// Complains of what is said about an error that the mirror cannot have.
fn refuse_foreign(
    reader: &mut ProfileReader,
    table: &Section,
    key: &str,
    why: Option<(&'static str, &'static str)>,
) {
    let Some((why, hint)) = why else { return };
    let Some(value) = reader.value(table, key, Optional, "", hint) else { return };
    let (path, shown) = (table.path_of(key), reader.quote(value));
    let message = format!("{path} must be left out {why}, found {shown}");
    reader.complain(value.span().start, message, hint);
}

/// Why a mirror cannot have this error, and what to take instead.
fn foreign(
    source: Perturbation,
    setting: Setting,
    has_map: bool,
) -> Option<(&'static str, &'static str)> {
    let round = setting.layout.map(|l| matches!(l, Layout::Disc | Layout::Annulus { .. }));
    let pinhole = matches!(
        setting.camera,
        Some(CameraModel::Pinhole { .. } | CameraModel::Calibrated { .. })
    );
    match source.row().applies_to {
        AppliesTo::RoundMirror if round == Some(false) => {
            Some(("for a rectangular mirror", "its form errors are legendre_20_um and the like"))
        }
        AppliesTo::RectangularMirror if round == Some(true) => {
            Some(("for a round mirror", "its form errors are zernike_4_um to zernike_11_um"))
        }
        AppliesTo::TelecentricCamera if pinhole => {
            Some(("for a pinhole", "its rays meet in one point"))
        }
        AppliesTo::MappedMirror if !has_map => Some(("without a map", "map_file names it")),
        _ => None,
    }
}

fn map_file(reader: &mut ProfileReader, section: &Section) -> Option<String> {
    let hint = "a file beside the profile: lines of X, Y and departure along Z in millimetres";
    let value = reader.value(section, "map_file", Optional, "a file's name", hint)?;
    match value.get_ref() {
        DeValue::String(name) if !name.is_empty() => Some(name.to_string()),
        _ => {
            let path = section.path_of("map_file");
            let found = reader.quote_type(value);
            let message = format!("{path} must be a file's name, found {found}");
            reader.complain(value.span().start, message, hint);
            None
        }
    }
}

fn compensators(reader: &mut ProfileReader, section: &Section) -> Option<Vec<Compensator>> {
    let names: Vec<&str> = Compensator::WORDS.iter().map(|(name, _)| *name).collect();
    let quoted: Vec<String> = names.iter().map(|name| format!("\"{name}\"")).collect();
    let quoted: Vec<&str> = quoted.iter().map(String::as_str).collect();
    let quoted = list(&quoted, "or");
    let must = format!("a list of none or some of {quoted}");
    let hint = "as in compensators = [\"shift\", \"rotation\"]; focusing is \"magnification\"";
    let path = section.path_of("compensators");
    let value = reader.value(section, "compensators", Optional, &must, hint)?;
    let DeValue::Array(items) = value.get_ref() else {
        let message = format!("{path} must be {must}, found {}", reader.quote_type(value));
        reader.complain(value.span().start, message, hint);
        return None;
    };
    let mut asked = Vec::new();
    for item in items {
        let name = item.get_ref().as_str();
        match Compensator::WORDS.iter().find(|(known, _)| Some(*known) == name) {
            Some((known, compensator)) if asked.contains(compensator) => {
                let message = format!("{path} must name each once, found \"{known}\" again");
                reader.complain(item.span().start, message, "remove the second one");
            }
            Some((_, compensator)) => asked.push(*compensator),
            None => {
                let message =
                    format!("{path} must name {quoted}, found {}", reader.quote_type(item));
                let meant = name.and_then(|name| schema::nearest(name, &names));
                let meant = meant.map(|meant| format!("did you mean \"{meant}\"?"));
                reader.complain(item.span().start, message, meant.as_deref().unwrap_or(hint));
            }
        }
    }
    Some(asked)
}
