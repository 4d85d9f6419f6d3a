//! Rules that camera, projection, layout and part keep among each other.

use super::super::reader::ProfileReader;
use super::super::words::list;
use super::super::{RadialLawSpec, StripLawSpec, schema};
use super::camera::CameraName;
use super::layout::LayoutName;
use super::projection::{INNER_POLAR, ProjectionKeys};
use super::{Entries, layout, projection};
use crate::optics::{CameraModel, RadialLawKind};

const FULL_TURN: [f64; 2] = [-180.0, 180.0];
/// An annulus' land is narrower than this share of the part.
const MOST_LAND: f64 = 0.99;

pub(super) fn check(reader: &mut ProfileReader, parts: &Entries) {
    if let Some(projection) = &parts.projection {
        camera_suits(reader, parts, projection);
        not_best(reader, parts, projection);
    }
    if let (Some(projection), Some(layout)) = (&parts.projection, &parts.layout) {
        if layout_suits(reader, parts, projection, layout) {
            polar_angles(reader, projection, layout);
        }
        fill_frame(reader, parts, projection, layout);
    }
    if let Some(layout) = &parts.layout {
        bare_layout(reader, parts, layout);
        land(reader, parts, layout);
        wide_enough(reader, parts, layout);
    }
    distortion_suits(reader, parts);
    height(reader, parts);
}

/// Under a camera with distortion there are designed strips alone.
fn distortion_suits(reader: &mut ProfileReader, parts: &Entries) {
    let Some(camera) = parts.camera.as_ref().filter(|c| c.name == CameraName::Calibrated) else {
        return;
    };
    let given = parts.shape.as_ref().filter(|shape| shape.is_given);
    let straight = [LayoutName::Strip, LayoutName::Rectangle];
    let layout = parts.layout.as_ref().filter(|layout| !straight.contains(&layout.name));
    let (with, hint) = match (given, layout) {
        (Some(given), _) => (
            given.path.clone(),
            "a given mirror is judged by a picture without distortion; use [camera.pinhole]",
        ),
        (None, Some(layout)) => (
            format!("layout.{}", layout.name),
            "its fold or its circles lie about the optical axis, which a distorted picture does not keep; \
             use [layout.strip] or [layout.rectangle]",
        ),
        (None, None) => return,
    };
    let message = format!(
        "camera must be [camera.orthographic] or [camera.pinhole] with [{with}], found [camera.calibrated]"
    );
    reader.complain(camera.at, message, hint);
}

/// Some laws are made for one kind of camera.
fn camera_suits(
    reader: &mut ProfileReader,
    parts: &Entries,
    projection: &projection::ProjectionEntry,
) {
    let Some(camera) = &parts.camera else { return };
    let ProjectionKeys::Radial { law: Some(RadialLawSpec::Named(law)), .. } = &projection.keys
    else {
        return;
    };
    let (needed, hint) = match law {
        RadialLawKind::Parabolic => (
            CameraName::Orthographic,
            "a paraboloid gathers parallel rays; for a pinhole use [projection.hyperbolic]",
        ),
        RadialLawKind::Hyperbolic => (
            CameraName::Pinhole,
            "a hyperboloid has a pinhole at its focus; for parallel rays use \
             [projection.parabolic]",
        ),
        RadialLawKind::Conical => {
            (CameraName::Pinhole, "under parallel rays a cone sees one polar angle only")
        }
        _ => return,
    };
    // Of a calibrated camera the layout's rule tells.
    if camera.name != needed && camera.name != CameraName::Calibrated {
        let message = format!(
            "camera must be [{}] with [{}], found [{}]",
            needed.table(),
            projection.section.path,
            camera.name.table()
        );
        reader.complain(camera.at, message, hint);
    }
}

/// The law `best` comes of a design.
fn not_best(reader: &mut ProfileReader, parts: &Entries, projection: &projection::ProjectionEntry) {
    let Some(shape) = &parts.shape else { return };
    if projection.is_best() && shape.is_given {
        let message = format!(
            "projection must be a law of known height with [{}], found [projection.best]",
            shape.path
        );
        let hint = "the best law is an outcome of a design; [projection.table] can hold it";
        reader.complain(projection.section.at, message, hint);
    }
}

/// Whether the layout can show the projection.
fn layout_suits(
    reader: &mut ProfileReader,
    parts: &Entries,
    projection: &projection::ProjectionEntry,
    layout: &layout::LayoutEntry,
) -> bool {
    let path = &projection.section.path;
    let given = parts.shape.as_ref().filter(|shape| shape.is_given);
    let (needed, hint) = match &projection.keys {
        ProjectionKeys::Radial { law: Some(RadialLawSpec::Named(law)), .. }
            if law.needs_annulus() =>
        (
            &[LayoutName::Annulus][..],
            "the mirror of this law is not smooth at the centre".to_owned(),
        ),
        ProjectionKeys::Radial { .. } => (
            &[LayoutName::Disc, LayoutName::Annulus][..],
            other_laws(projection, "a strip", &["elevation_deg"]),
        ),
        ProjectionKeys::Azimuthal(_) => (
            &[LayoutName::Rectangle][..],
            "a view's mirror is a rectangle, part.width_mm by part.height_mm or as high as the frame"
                .to_owned(),
        ),
        ProjectionKeys::Map(_) => (
            &[LayoutName::Rectangle][..],
            "a map's mirror is a rectangle, part.width_mm by part.height_mm or as high as the frame"
                .to_owned(),
        ),
        ProjectionKeys::Panels(_) => (
            &[LayoutName::Rectangle][..],
            "panels make up a rectangle, part.width_mm by part.height_mm or as high as the frame".to_owned(),
        ),
        ProjectionKeys::Strip { .. } if given.is_some() => (
            &[LayoutName::Strip][..],
            "a conquistador is folded out of a designed panel; laws for a disc are radial"
                .to_owned(),
        ),
        ProjectionKeys::Strip { .. } => (
            &[LayoutName::Strip, LayoutName::Conquistador][..],
            other_laws(projection, "a disc or an annulus", &["outer_polar_deg", "polar_deg"]),
        ),
    };
    if !needed.contains(&layout.name) {
        let tables: Vec<String> = needed.iter().map(|name| format!("[layout.{name}]")).collect();
        let tables: Vec<&str> = tables.iter().map(String::as_str).collect();
        let with = match given {
            _ if matches!(projection.keys, ProjectionKeys::Panels(_)) => "[[panel]]".to_owned(),
            Some(given) if !projection.is_radial() => format!("[{path}] and [{}]", given.path),
            _ => format!("[{path}]"),
        };
        let must = list(&tables, "or");
        let message = format!("layout must be {must} with {with}, found [layout.{}]", layout.name);
        reader.complain(layout.at, message, &hint);
        return false;
    }
    if let (ProjectionKeys::Strip { azimuth: Some(azimuth), .. }, LayoutName::Conquistador) =
        (&projection.keys, layout.name)
        && azimuth.value != FULL_TURN
    {
        let path = projection.section.path_of("azimuth_deg");
        let [first, last] = azimuth.value;
        let message = format!(
            "{path} must be [-180, 180] with [layout.conquistador], found [{first}, {last}]"
        );
        let hint = "a conquistador folds a full turn into two panels; for part of a turn use \
                    [layout.strip]";
        reader.complain(azimuth.at, message, hint);
    }
    true
}

/// The laws for a layout: those that have one of `keys`, or the table's own of them.
fn other_laws(projection: &projection::ProjectionEntry, layout: &str, keys: &[&str]) -> String {
    if projection.is_table() {
        return format!("a table for {layout} has {}", keys[keys.len() - 1]);
    }
    let has = |law: &&str| {
        let of_law = schema::PROFILE.keys(&format!("projection.{law}"));
        keys.iter().any(|key| of_law.contains(key))
    };
    let laws: Vec<&str> = schema::PROFILE.keys("projection").iter().copied().filter(has).collect();
    format!("laws for {layout} are {}", list(&laws, "and"))
}

/// An annulus lets laws of two parameters choose the polar angle at its inner rim.
fn polar_angles(
    reader: &mut ProfileReader,
    projection: &projection::ProjectionEntry,
    layout: &layout::LayoutEntry,
) {
    let ProjectionKeys::Radial { law, inner, outer } = &projection.keys else { return };
    let path = projection.polar_path("inner_polar_deg");
    if layout.name == LayoutName::Disc {
        if let Some(inner) = inner
            && inner.value != 0.0
        {
            let must = if projection.is_table() { "0" } else { "0 or left out" };
            let message =
                format!("{path} must be {must} with [layout.disc], found {}", inner.value);
            let hint = "a disc looks back along the axis at its centre; [layout.annulus] has an \
                        inner rim";
            reader.complain(inner.at, message, hint);
        }
    } else if let Some(RadialLawSpec::Named(law)) = law
        && law.has_two_parameters()
        && !projection.section.has("inner_polar_deg")
    {
        let must = match law {
            RadialLawKind::Cylinder => "strictly between 0 and 180",
            _ => "0 or more and less than 180",
        };
        let message = format!("{path} must be {must} with [layout.annulus], found nothing");
        reader.missing(&projection.section, message, INNER_POLAR);
    }
    if let (Some(inner), Some(outer)) = (inner, outer)
        && inner.value >= outer.value
    {
        let message = format!(
            "{path} must be less than outer_polar_deg = {}, found {}",
            outer.value, inner.value
        );
        let hint = "polar angles grow from the inner rim to the outer one";
        reader.complain(inner.at, message, hint);
    }
}

/// A table has the rows that fill the frame, or more.
fn fill_frame(
    reader: &mut ProfileReader,
    parts: &Entries,
    projection: &projection::ProjectionEntry,
    layout: &layout::LayoutEntry,
) {
    let ProjectionKeys::Strip { law: Some(StripLawSpec::Table(rows)), .. } = &projection.keys
    else {
        return;
    };
    let camera = parts.camera.as_ref().and_then(|camera| camera.camera);
    let (Some(at), Some(camera)) = (layout.fills, camera) else { return };
    let needed = f64::from(camera.pixels()[1]) / layout.panels();
    let high = match rows[..] {
        [[first, _], .., [last, _]] => last - first,
        _ => return,
    };
    if high >= needed * (1.0 - 1e-9) {
        return;
    }
    let path = projection.section.path_of("elevation_deg");
    let message = format!(
        "{path} must reach over {needed} rows or more with fill_frame = true, found {high}"
    );
    reader.complain(at, message, "add rows to the table, or leave out fill_frame");
}

/// Without a projection there is nothing to tile.
fn bare_layout(reader: &mut ProfileReader, parts: &Entries, layout: &layout::LayoutEntry) {
    if parts.bare && !layout.is_round() {
        let message = format!(
            "layout must be [layout.disc], [layout.annulus] or left out without a projection, \
             found [layout.{}]",
            layout.name
        );
        let hint = "without a layout the given mirror is a rectangle, part.width_mm by \
                    part.height_mm";
        reader.complain(layout.at, message, hint);
    }
}

fn land(reader: &mut ProfileReader, parts: &Entries, layout: &layout::LayoutEntry) {
    let (Some(inner), Some(width)) = (layout.inner, parts.part.width) else { return };
    if inner.value >= MOST_LAND * width.value {
        let message = format!(
            "layout.annulus.inner_width_mm must be less than {MOST_LAND} of part.width_mm = {}, \
             found {}",
            width.value, inner.value
        );
        let hint = "both are diameters; the mirror is the ring between them";
        reader.complain(inner.at, message, hint);
    }
}

/// A pinhole's frame has its own width at the mirror.
fn wide_enough(reader: &mut ProfileReader, parts: &Entries, layout: &layout::LayoutEntry) {
    let camera = parts.camera.as_ref().and_then(|camera| camera.camera);
    let Some(CameraModel::Pinhole { pixels, focal_px, distance_mm }) = camera else { return };
    let (Some(width), Some(_)) = (parts.part.width, layout.fills) else { return };
    let frame = f64::from(pixels[0]) * distance_mm / focal_px;
    if width.value >= frame * (1.0 - 1e-9) {
        return;
    }
    // Rounded up, so that the number written down is enough.
    let enough = (frame * 1e3).ceil() / 1e3;
    let message = format!(
        "part.width_mm must be at least {enough} with fill_frame = true, found {}",
        width.value
    );
    let hint = if super::is_size(enough) {
        format!("the frame is that wide at distance_mm = {distance_mm}; write width_mm = {enough}")
    } else {
        "no part is that wide; bring the camera closer".to_owned()
    };
    reader.complain(width.at, message, &hint);
}

/// Only a rectangle has a height of its own.
fn height(reader: &mut ProfileReader, parts: &Entries) {
    if parts.rectangle {
        if let Some(at) = parts.part.lacks_height {
            let message = format!("part.height_mm must be {}, found nothing", super::SIZE);
            let hint = "a given mirror without a layout is a rectangle, as in height_mm = 40; \
                        [layout.disc] makes it round";
            reader.complain(at, message, hint);
        }
        return;
    }
    let (Some(height), Some(layout)) = (parts.part.height, &parts.layout) else { return };
    if layout.name == LayoutName::Rectangle || parts.bare && !layout.is_round() {
        return;
    }
    let message = format!(
        "part.height_mm must be left out with [layout.{}], found {}",
        layout.name, height.value
    );
    let hint = if layout.is_round() {
        "width_mm is the diameter"
    } else {
        "the height comes of the projection"
    };
    reader.complain(height.at, message, hint);
}
