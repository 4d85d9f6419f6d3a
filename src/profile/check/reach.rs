//! The mirror's outline as far as a profile tells it, and whether a given conic reaches it.

use super::super::reader::ProfileReader;
use super::super::{Layout, StripLawSpec};
use super::camera::CameraName;
use super::projection::ProjectionKeys;
use super::{Entries, layout};
use crate::geom::{DVec2, Outline, Rect};

/// A conic ends where its slope is upright, `|R| / sqrt(1 + k)` from the axis.
pub(super) fn check(reader: &mut ProfileReader, parts: &Entries) {
    let Some(shape) = &parts.shape else { return };
    let (Some(conic), Some(reach)) = (shape.conic, farthest(parts)) else { return };
    let (radius, k) = (conic.value.radius_mm, conic.value.conic);
    if (1.0 + k) * (reach / radius) * (reach / radius) < 1.0 {
        return;
    }
    let end = radius.abs() / f64::sqrt(1.0 + k);
    let message = format!(
        "{}.radius_mm must make a conic that reaches the outline, {reach:.3} mm from the axis, \
         found {radius}, with which it ends at {end:.3} mm",
        shape.path
    );
    let hint = "take a larger radius, a conic closer to -1 or a smaller part";
    reader.complain(conic.at, message, hint);
}

/// Distance of the outline's farthest point from the axis, mm.
fn farthest(parts: &Entries) -> Option<f64> {
    Some(match outline(parts)? {
        Outline::Rect(rect) => rect.max.length(),
        Outline::Ring { outer, .. } => outer,
    })
}

/// The mirror's outline over X and Y, where that is known before it is designed.
pub(super) fn known_outline(parts: &Entries) -> Option<Outline> {
    let given = parts.shape.as_ref()?.is_given;
    let parallel = parts.camera.as_ref()?.name == CameraName::Orthographic;
    let round = parts.layout.as_ref().is_some_and(layout::LayoutEntry::is_round);
    if given || parallel || round { outline(parts) } else { None }
}

/// The outline of a mirror with straight or round sides; designed strips under a pinhole have curved ones.
fn outline(parts: &Entries) -> Option<Outline> {
    let width = parts.part.width?.value;
    let height = if let Some(Layout::Rectangle { height_mm }) = parts.layout() {
        height_mm?
    } else if parts.layout.as_ref()?.is_round() {
        let land = parts.layout.as_ref()?.inner.map_or(0.0, |inner| inner.value);
        return Some(Outline::Ring { inner: 0.5 * land, outer: 0.5 * width });
    } else {
        strip_height(parts, width)?
    };
    let half = 0.5 * DVec2::new(width, height);
    Some(Outline::Rect(Rect { min: -half, max: half }))
}

/// The height in millimetres of the strip or the two panels that the frame or the law makes.
fn strip_height(parts: &Entries, width: f64) -> Option<f64> {
    let camera = parts.camera.as_ref()?.camera?;
    let pixels = camera.pixels().map(f64::from);
    let pixel_mm = camera.pixel_mm(width);
    let layout = parts.layout.as_ref()?;
    if layout.fills.is_some() {
        return Some(pixels[1] * pixel_mm);
    }
    let ProjectionKeys::Strip { law, azimuth, elevation } = &parts.projection.as_ref()?.keys else {
        return None;
    };
    // A conquistador has two panels, each half a turn wide.
    let panels = layout.panels();
    let azimuth = azimuth.as_ref()?.value;
    let z = match law.as_ref()? {
        StripLawSpec::Named(law) => {
            elevation.as_ref()?.value.map(|degrees| law.image_of_degrees(degrees))
        }
        StripLawSpec::LeastCurl => return None,
        StripLawSpec::Table(rows) => {
            return Some(panels * (rows.last()?[0] - rows.first()?[0]) * pixel_mm);
        }
    };
    Some(panels * panels * (z[1] - z[0]) * width / (azimuth[1] - azimuth[0]).to_radians())
}

#[cfg(test)]
mod tests {
    use super::super::super::Profile;

    /// The complaint about a dome of this radius, if there is one.
    fn found(radius: f64, rest: &str) -> Option<String> {
        let text = format!(
            "camera.orthographic.pixels = [640, 480]\nmirror.polynomial.radius_mm = {radius}\n\
             mesh.chord_um = 2\nexport.formats = [\"stl\"]\n{rest}"
        );
        let complaints = Profile::parse("p", "p.toml", text.as_bytes()).err()?;
        Some(complaints.0.iter().map(|c| c.message.clone()).collect())
    }

    /// Each outline is just inside a dome a little larger and just outside one a little smaller.
    #[test]
    fn a_dome_covers_the_outline_or_is_refused() {
        let strip = |law: &str, fill: bool| {
            format!(
                "part = {{ width_mm = 60, base_mm = 5 }}\nlayout.strip.fill_frame = {fill}\n\
                 projection.{law} = {{ azimuth_deg = [-90, 90], elevation_deg = [-30, 30] }}"
            )
        };
        let diagonal = |height: f64| 0.5 * f64::sqrt(3600.0 + height * height);
        let scale = 60.0 / std::f64::consts::PI;
        let rows = "[[0, 30], [160, 0], [320, -9]]";
        let table = strip("table", false).replace("[-30, 30]", rows);
        for (reach, rest) in [
            (50.0, "part = { width_mm = 80, height_mm = 60, base_mm = 5 }".to_owned()),
            (40.0, "part = { width_mm = 80, base_mm = 5 }\nlayout.disc = {}".to_owned()),
            (diagonal(45.0), strip("cylindrical", true)),
            (diagonal(scale * 2.0 / f64::sqrt(3.0)), strip("cylindrical", false)),
            (diagonal(scale * crate::num::log(3.0)), strip("mercator", false)),
            (diagonal(20.0), strip("equirectangular", false)),
            (diagonal(scale), strip("equal-area", false)),
            (diagonal(30.0), table),
        ] {
            assert_eq!(found(-1.0001 * reach, &rest), None, "{rest}");
            let refused = found(-0.9999 * reach, &rest).expect("too small a dome");
            assert!(refused.contains(&format!("{reach:.3} mm from the axis")), "{refused}");
        }
    }
}
