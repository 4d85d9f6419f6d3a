//! The part, its mesh, the files and the limits of a pass.

use toml::de::DeValue;

use super::super::reader::Need::{Optional, Required};
use super::super::reader::{ProfileReader, Section};
use super::super::values::{Located, number, word};
use super::super::words::list;
use super::super::{AcceptanceSpec, FileFormat, MeshGoal, StepProtocol, schema};
use super::{Entries, SIZE, border, forming, is_size, shell};

/// The part's figures, each with its place.
#[derive(Default)]
pub(super) struct PartEntry {
    pub(super) width: Option<Located<f64>>,
    pub(super) base: Option<Located<f64>>,
    pub(super) height: Option<Located<f64>>,
    /// Offset of a part without a height.
    pub(super) lacks_height: Option<usize>,
    pub(super) border: border::BorderEntry,
    /// The cavity of a hollow part.
    pub(super) shell: Option<shell::ShellEntry>,
    pub(super) form: Option<forming::FormEntry>,
}

pub(super) fn part(reader: &mut ProfileReader, root: &Section) -> PartEntry {
    let Some(section) = reader.section(root, "part", Required) else {
        return PartEntry::default();
    };
    let hint = "the mirror's width in millimetres, as in width_mm = 60";
    let width = number(reader, &section, "width_mm", Required, SIZE, hint, is_size);
    let hint = "millimetres of material under the mirror's lowest point, as in base_mm = 5";
    let base = number(reader, &section, "base_mm", Required, SIZE, hint, is_size);
    let hint = "the height of a rectangular given mirror in millimetres, as in height_mm = 40";
    let height = number(reader, &section, "height_mm", Optional, SIZE, hint, is_size);
    let lacks_height = (!section.has("height_mm")).then_some(section.at);
    let border = border::read(reader, &section);
    let shell = shell::read(reader, &section);
    let form = Some(forming::form(reader, &section));
    PartEntry { width, base, height, lacks_height, border, shell, form }
}

/// The mesh's limits; without a projection there is nothing to measure pixels by.
pub(super) fn mesh(
    reader: &mut ProfileReader,
    root: &Section,
    parts: &Entries,
) -> Option<MeshGoal> {
    let bare = parts.bare;
    let section = reader.section(root, "mesh", Required)?;
    let has = |key: &str| section.has(key);
    let lacks = !has("max_triangles") && !has("chord_um");
    if lacks && !bare && !has("facet_px") {
        reader.missing(
            &section,
            "mesh must hold chord_um, facet_px or both, or max_triangles, found none of them"
                .to_owned(),
            "chord_um = 2 keeps facets within 2 micrometres of the mirror; facet_px = 1 keeps \
             the picture within a pixel; max_triangles = 200000 makes the best of so many",
        );
    }
    let need = if lacks && bare { Required } else { Optional };
    let must = "a number from 0.0001 to 1000000";
    let hint = "the height of a facet off the mirror in micrometres, as in chord_um = 2";
    let chord =
        number(reader, &section, "chord_um", need, must, hint, |f| (1e-4..=1e6).contains(&f));
    let must = "a number from 0.001 to 1000";
    let hint = "the pixel error that a flat facet may cause, as in facet_px = 1";
    let facet =
        number(reader, &section, "facet_px", Optional, must, hint, |f| (1e-3..=1e3).contains(&f));
    if bare {
        needs_projection(reader, "mesh.facet_px", facet, "chord_um alone sets the facets");
    }
    let must = "a whole number from 100 to 40000000";
    let hint = "the most triangles that the whole part may have, as in max_triangles = 200000";
    let most = number(reader, &section, "max_triangles", Optional, must, hint, |f| {
        (100.0..=4e7).contains(&f) && f.fract() == 0.0
    });
    let limits: Vec<&str> = ["chord_um", "facet_px"].into_iter().filter(|key| has(key)).collect();
    if let (Some(most), [_, ..]) = (most, limits.as_slice()) {
        let (beside, several) = (list(&limits, "and"), limits.len() > 1);
        let message = format!("mesh.max_triangles must stand alone, found {beside} beside it");
        let hint = format!(
            "remove max_triangles to keep the limit{}, or {beside} to have the finest mesh of that \
             size",
            if several { "s" } else { "" }
        );
        reader.complain(most.at, message, &hint);
    }
    heights_alone(reader, parts, [("facet_px", facet), ("max_triangles", most)]);
    let limits = || MeshGoal::limits(chord.map(|f| f.value), facet.map(|f| f.value));
    Some(most.map_or_else(limits, |most| MeshGoal::Budget(most.value as usize)))
}

/// Facets of the mirror before a target of facets have heights alone as limits.
fn heights_alone(
    reader: &mut ProfileReader,
    parts: &Entries,
    others: [(&str, Option<Located<f64>>); 2],
) {
    let Some(posed) = parts.posed.as_ref().filter(|posed| posed.is_faceted()) else { return };
    for (key, found) in others {
        let Some(found) = found else { continue };
        let message =
            format!("mesh must hold chord_um alone with [{}], found mesh.{key}", posed.path);
        let hint = "across edges of the target's facets no displacement of the picture can be proven; with chord_um = 1 \
                    the mirror's own facets rarely move it by a pixel";
        reader.complain(found.at, message, hint);
    }
}

/// The schema of the STEP file; the default where `[export]` does not say.
pub(super) fn step(reader: &mut ProfileReader, export: &Section) -> StepProtocol {
    let Some(section) = reader.section(export, "step", Optional) else {
        return StepProtocol::default();
    };
    let words = [("ap214", StepProtocol::Ap214), ("ap242", StepProtocol::Ap242)];
    let hint = "ap242 has datum features and the mirror's profile tolerance, ap214 the shape alone";
    word(reader, &section, "schema", &words, hint).unwrap_or_default()
}

pub(super) fn formats(reader: &mut ProfileReader, section: &Section) -> Option<Vec<FileFormat>> {
    let path = section.path_of("formats");
    let names: Vec<&str> = FileFormat::all().map(FileFormat::name).collect();
    let quoted: Vec<String> = names.iter().map(|name| format!("\"{name}\"")).collect();
    let quoted = list(&quoted.iter().map(String::as_str).collect::<Vec<_>>(), "or");
    let must = format!("a list of one or more of {quoted}");
    let hint = "as in formats = [\"stl\", \"obj\"]";
    let value = reader.value(section, "formats", Required, &must, hint)?;
    let items = match value.get_ref() {
        DeValue::Array(items) if !items.is_empty() => items,
        DeValue::Array(_) => {
            let message = format!("{path} must be {must}, found an empty list");
            reader.complain(value.span().start, message, hint);
            return None;
        }
        _ => {
            let message = format!("{path} must be {must}, found {}", reader.quote_type(value));
            reader.complain(value.span().start, message, hint);
            return None;
        }
    };
    let mut formats = Vec::new();
    for item in items {
        let at = item.span().start;
        let name = item.get_ref().as_str();
        match FileFormat::all().find(|format| Some(format.name()) == name) {
            Some(format) if formats.contains(&format) => {
                let message =
                    format!("{path} must name each format once, found \"{}\" again", format.name());
                reader.complain(at, message, "remove the second one");
            }
            Some(format) => formats.push(format),
            None => {
                let message = match name {
                    Some(_) => format!("{path} must name {quoted}, found {}", reader.quote(item)),
                    None => format!("{path} must name {quoted}, found {}", reader.quote_type(item)),
                };
                let meant = name.and_then(|name| schema::nearest(name, &names));
                let meant = meant.map(|meant| format!("did you mean \"{meant}\"?"));
                reader.complain(at, message, meant.as_deref().unwrap_or(hint));
            }
        }
    }
    Some(formats)
}

/// The limits of a pass; without a projection there are none.
pub(super) fn accept(
    reader: &mut ProfileReader,
    root: &Section,
    bare: bool,
) -> Option<AcceptanceSpec> {
    let Some(section) = reader.section(root, "accept", Optional) else {
        return Some(AcceptanceSpec::default());
    };
    let must = "a number, 0 or more";
    let hint = "an error limit in pixels, as in 2.5";
    let mut pixels = |key| number(reader, &section, key, Optional, must, hint, |f| f >= 0.0);
    let rms = pixels("pixel_error_rms_px");
    let max = pixels("pixel_error_max_px");
    let blur = pixels("blur_p95_px");
    let must = "a number from 0 to 1";
    let hint = "a share of the frame, not a percentage: 0.999 is 99.9 %";
    let filled = number(reader, &section, "frame_filled", Optional, must, hint, |f| {
        (0.0..=1.0).contains(&f)
    });
    if bare {
        let keys = ["pixel_error_rms_px", "pixel_error_max_px", "frame_filled"];
        for (key, limit) in keys.into_iter().zip([rms, max, filled]) {
            let path = section.path_of(key);
            needs_projection(reader, &path, limit, "without one a pixel has nothing to see");
        }
    }
    Some(AcceptanceSpec {
        pixel_error_rms_px: rms.map(|f| f.value),
        pixel_error_max_px: max.map(|f| f.value),
        frame_filled: filled.map(|f| f.value),
        blur_p95_px: blur.map(|f| f.value),
    })
}

fn needs_projection(
    reader: &mut ProfileReader,
    path: &str,
    limit: Option<Located<f64>>,
    why: &str,
) {
    if let Some(limit) = limit {
        let message =
            format!("{path} must be left out without a projection, found {}", limit.value);
        let hint = format!("errors in pixels are measured against a projection; {why}");
        reader.complain(limit.at, message, &hint);
    }
}
