//! The rules of a profile: which values each key may take, and what goes with what.

use sha2::{Digest, Sha256};
use toml::de::{DeTable, DeValue};

use super::reader::Need::{Optional, Required};
use super::reader::{Reader, Section};
use super::values::{Pair, flag, number, pair, word};
use super::words::list;
use super::{
    Accept, Camera, Format, Law, Layout, MeshLimits, Method, PanelSource, Part, Profile,
    Projection, Ridge, schema,
};

const MAX_PIXELS: f64 = 16384.0;
/// Pixels of a frame: the ray trace keeps some 120 bytes for each.
const MOST_PIXELS: f64 = 4e7;
const MAX_DEGREE: f64 = 40.0;
const FULL_TURN: [f64; 2] = [-180.0, 180.0];

/// Reads the whole tree; `None` if there is anything to complain of.
pub(super) fn profile(
    reader: &mut Reader,
    tree: &DeTable,
    name: &str,
    bytes: &[u8],
) -> Option<Profile> {
    if tree.is_empty() && reader.is_clean() {
        let message = "the file must hold a profile, found nothing in it".to_owned();
        let hint = "`morion profiles --show conquistador` prints one to start from";
        reader.complain(0, message, hint);
        return None;
    }
    let root = reader.root(tree);
    let summary = summary(reader, &root);
    let camera = camera(reader, &root);
    let (projection, azimuth) = projection(reader, &root);
    let layout = layout(reader, &root);
    let method = method(reader, &root);
    let part = part(reader, &root);
    let mesh = mesh(reader, &root);
    let formats = formats(reader, &root);
    let accept = accept(reader, &root);
    if let (Some(azimuth), Some(layout)) = (&azimuth, &layout) {
        fits(reader, azimuth, layout);
    }
    if !reader.is_clean() {
        return None;
    }
    Some(Profile {
        name: name.to_owned(),
        sha256: hex(&Sha256::digest(bytes)),
        summary: summary.unwrap_or_default(),
        camera: camera?,
        projection: projection?,
        layout: layout?,
        method: method?,
        part: part?,
        mesh: mesh?,
        formats: formats?,
        accept: accept?,
    })
}

fn summary(reader: &mut Reader, root: &Section) -> Option<String> {
    let hint = "what the mirror is for, in quotes";
    let value = reader.value(root, "summary", Optional, "text", hint)?;
    match value.get_ref() {
        DeValue::String(text) => Some(text.to_string()),
        _ => {
            let found = reader.quote_type(value);
            let message = format!("summary must be text, found {found}");
            reader.complain(value.span().start, message, hint);
            None
        }
    }
}

fn camera(reader: &mut Reader, root: &Section) -> Option<Camera> {
    let hint = "an orthographic camera has a telecentric lens";
    let (_, section) = only(reader.alternatives(root, "camera", hint))?;
    let pixels = Pair {
        key: "pixels",
        parts: "[width, height]",
        each: "a whole number from 1 to 16384",
        form: "the size of the camera's frame in pixels, as in pixels = [640, 480]",
        limit: "the size of the camera's frame in pixels, as in pixels = [640, 480]",
    };
    let (figures, at) =
        pair(reader, &section, &pixels, |f| f.fract() == 0.0 && (1.0..=MAX_PIXELS).contains(&f))?;
    let [width, height] = figures;
    if width * height > MOST_PIXELS {
        let found = format!("{width} x {height}");
        let message = format!(
            "camera.orthographic.pixels must make a frame of at most 40 million pixels, found {found}"
        );
        reader.complain(at, message, "every pixel is traced; try half as many on each side");
        return None;
    }
    Some(Camera::Orthographic { pixels: figures.map(|f| f as u32) })
}

/// A range of azimuths, its key and where it stands.
struct Azimuth {
    path: String,
    range: [f64; 2],
    at: usize,
}

/// The projection, and its azimuths also if the rest of it is wrong.
fn projection(reader: &mut Reader, root: &Section) -> (Option<Projection>, Option<Azimuth>) {
    let hint = "cylindrical is the paper's law; with mercator an exact mirror exists";
    let read = reader
        .alternatives(root, "projection", hint)
        .into_iter()
        .map(|(law, section)| (law, azimuth(reader, &section), elevation(reader, &section)))
        .collect();
    let Some((law, azimuth, elevation)) = only(read) else {
        return (None, None);
    };
    let law = match law {
        "mercator" => Law::Mercator,
        _ => Law::Cylindrical,
    };
    let projection = azimuth.as_ref().zip(elevation).map(|(azimuth, elevation_deg)| Projection {
        law,
        azimuth_deg: azimuth.range,
        elevation_deg,
    });
    (projection, azimuth)
}

fn azimuth(reader: &mut Reader, section: &Section) -> Option<Azimuth> {
    let form = "a full turn is azimuth_deg = [-180, 180]";
    let azimuth = Pair {
        key: "azimuth_deg",
        parts: "[first, last]",
        each: "from -360 to 360",
        form,
        limit: form,
    };
    let (range, at) = pair(reader, section, &azimuth, |f| (-360.0..=360.0).contains(&f))?;
    let path = section.path_of("azimuth_deg");
    rising(reader, &path, range, at)?;
    let span = range[1] - range[0];
    if span > 360.0 {
        let message = format!("{path} must span at most 360 degrees, found {span}");
        let hint = "a panorama shows each direction once; a full turn is [-180, 180]";
        reader.complain(at, message, hint);
        return None;
    }
    Some(Azimuth { path, range, at })
}

fn elevation(reader: &mut Reader, section: &Section) -> Option<[f64; 2]> {
    let law = section.path.rsplit('.').next().unwrap_or_default();
    let limit =
        format!("the {law} law reaches the pole only at infinity; use 89 or less, -89 or more");
    let elevation = Pair {
        key: "elevation_deg",
        parts: "[lowest, highest]",
        each: "strictly between -90 and 90",
        form: "degrees above the horizon, as in elevation_deg = [-30, 30]",
        limit: &limit,
    };
    let (range, at) = pair(reader, section, &elevation, |f| -90.0 < f && f < 90.0)?;
    rising(reader, &section.path_of("elevation_deg"), range, at)?;
    Some(range)
}

fn rising(reader: &mut Reader, path: &str, [low, high]: [f64; 2], at: usize) -> Option<()> {
    if low < high {
        return Some(());
    }
    let message = format!("{path} must rise from first to last, found [{low}, {high}]");
    let hint = if low > high {
        format!("swap them: [{high}, {low}]")
    } else {
        "the two ends are the same, so the picture would be empty".to_owned()
    };
    reader.complain(at, message, &hint);
    None
}

fn layout(reader: &mut Reader, root: &Section) -> Option<Layout> {
    let hint = "a strip is one panel; a conquistador folds a full turn into two";
    let read: Vec<_> = reader
        .alternatives(root, "layout", hint)
        .into_iter()
        .map(|(name, section)| {
            let fill_frame = flag(reader, &section, "fill_frame").unwrap_or(false);
            if name == "strip" {
                return Layout::Strip { fill_frame };
            }
            let panels = [("refit", PanelSource::Refit), ("section", PanelSource::Section)];
            let hint = "refit solves for the half turn, section cuts the full turn's mirror";
            let panel = word(reader, &section, "panel", &panels, hint);
            let ridges = [("crest", Ridge::Crest), ("valley", Ridge::Valley)];
            let hint = "a crest stands out of the part and can be cut; a valley is sunk into it";
            let ridge = word(reader, &section, "ridge", &ridges, hint);
            Layout::Conquistador {
                panel: panel.unwrap_or(PanelSource::Refit),
                ridge: ridge.unwrap_or(Ridge::Crest),
                fill_frame,
            }
        })
        .collect();
    only(read)
}

fn method(reader: &mut Reader, root: &Section) -> Option<Method> {
    let hint = "vector-field fits the mirror's gradient by least squares";
    let (_, section) = only(reader.alternatives(root, "method", hint))?;
    let must = "a whole number from 1 to 40";
    let hint = "the degree of the mirror's polynomial; 12 suits a panorama";
    let degree = number(reader, &section, "degree", Required, must, hint, |f| {
        f.fract() == 0.0 && (1.0..=MAX_DEGREE).contains(&f)
    })?;
    Some(Method::VectorField { degree: degree as usize })
}

fn part(reader: &mut Reader, root: &Section) -> Option<Part> {
    let section = reader.section(root, "part", Required)?;
    let must = "a number from 0.001 to 1000000";
    let size = |f| (1e-3..=1e6).contains(&f);
    let hint = "the mirror's width in millimetres, as in width_mm = 60";
    let width = number(reader, &section, "width_mm", Required, must, hint, size);
    let hint = "millimetres of material under the mirror's lowest point, as in base_mm = 5";
    let base = number(reader, &section, "base_mm", Required, must, hint, size);
    Some(Part { width_mm: width?, base_mm: base? })
}

fn mesh(reader: &mut Reader, root: &Section) -> Option<MeshLimits> {
    let section = reader.section(root, "mesh", Required)?;
    if !section.has("chord_um") && !section.has("facet_px") {
        reader.missing(
            &section,
            "mesh must hold chord_um, facet_px or both, found neither".to_owned(),
            "chord_um = 2 keeps facets within 2 micrometres of the mirror; facet_px = 1 keeps \
             the picture within a pixel",
        );
    }
    let must = "a number from 0.0001 to 1000000";
    let hint = "the height of a facet off the mirror in micrometres, as in chord_um = 2";
    let chord_um =
        number(reader, &section, "chord_um", Optional, must, hint, |f| (1e-4..=1e6).contains(&f));
    let must = "a number from 0.001 to 1000";
    let hint = "the pixel error that a flat facet may cause, as in facet_px = 1";
    let facet_px =
        number(reader, &section, "facet_px", Optional, must, hint, |f| (1e-3..=1e3).contains(&f));
    Some(MeshLimits { chord_um, facet_px })
}

fn formats(reader: &mut Reader, root: &Section) -> Option<Vec<Format>> {
    let section = reader.section(root, "export", Required)?;
    let path = section.path_of("formats");
    let known = [Format::Stl, Format::Obj];
    let names = known.map(Format::name);
    let quoted = names.map(|name| format!("\"{name}\""));
    let quoted = list(&quoted.each_ref().map(String::as_str), "or");
    let must = format!("a list of one or more of {quoted}");
    let hint = "as in formats = [\"stl\", \"obj\"]";
    let value = reader.value(&section, "formats", Required, &must, hint)?;
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
        match known.iter().find(|format| Some(format.name()) == name) {
            Some(format) if formats.contains(format) => {
                let message =
                    format!("{path} must name each format once, found \"{format}\" again");
                reader.complain(at, message, "remove the second one");
            }
            Some(format) => formats.push(*format),
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

fn accept(reader: &mut Reader, root: &Section) -> Option<Accept> {
    let Some(section) = reader.section(root, "accept", Optional) else {
        return Some(Accept::default());
    };
    let must = "a number, 0 or more";
    let hint = "an error limit in pixels, as in 2.5";
    let mut pixels = |key| number(reader, &section, key, Optional, must, hint, |f| f >= 0.0);
    let pixel_error_rms_px = pixels("pixel_error_rms_px");
    let pixel_error_max_px = pixels("pixel_error_max_px");
    let must = "a number from 0 to 1";
    let hint = "a share of the frame, not a percentage: 0.999 is 99.9 %";
    let frame_filled = number(reader, &section, "frame_filled", Optional, must, hint, |f| {
        (0.0..=1.0).contains(&f)
    });
    Some(Accept { pixel_error_rms_px, pixel_error_max_px, frame_filled })
}

/// Whether the layout can show the projection.
fn fits(reader: &mut Reader, azimuth: &Azimuth, layout: &Layout) {
    if matches!(layout, Layout::Conquistador { .. }) && azimuth.range != FULL_TURN {
        let Azimuth { path, range, at } = azimuth;
        let [first, last] = range;
        let message = format!(
            "{path} must be [-180, 180] with [layout.conquistador], found [{first}, {last}]"
        );
        let hint = "a conquistador folds a full turn into two panels; for part of a turn use \
                    [layout.strip]";
        reader.complain(*at, message, hint);
    }
}

fn only<T>(mut several: Vec<T>) -> Option<T> {
    let last = several.pop();
    last.filter(|_| several.is_empty())
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
