//! Whether the directions that the picture shows meet the target.

use super::super::RadialLawSpec;
use super::super::reader::ProfileReader;
use super::super::values::Located;
use super::layout::LayoutName;
use super::map::{MapKeys, VectorKind};
use super::panels::PanelKeys;
use super::projection::{ProjectionEntry, ProjectionKeys};
use super::{Entries, layout};
use crate::geom::DVec3;
use crate::num::{degrees, radians};
use crate::optics::{RadialLawKind, RimConditions, Target};

/// Largest distance of a point from the target, as a share of its own from the origin: a table of five digits is
/// within.
const OFF: f64 = 1e-4;

pub(super) fn check(reader: &mut ProfileReader, parts: &Entries) {
    let Some(projection) = &parts.projection else { return };
    if let Some(radius) = projection.radius {
        cylinder(reader, parts, projection, radius);
    }
    match &projection.keys {
        ProjectionKeys::Map(Some(keys)) => {
            map_meets(reader, projection, (&projection.section.path, keys));
        }
        ProjectionKeys::Panels(panels) => {
            for map in panels.iter().filter_map(PanelKeys::map) {
                map_meets(reader, projection, map);
            }
        }
        _ => {}
    }
    let Some(plane) = projection.plane else { return };
    match &projection.keys {
        ProjectionKeys::Strip { elevation, .. } => {
            if let Some(elevation) = elevation {
                elevations_meet(reader, projection, plane, elevation);
            }
        }
        ProjectionKeys::Radial { law: Some(law), inner, outer: Some(outer) } => {
            polar_angles_meet(reader, parts, projection, plane, law, (inner.as_ref(), outer));
        }
        ProjectionKeys::Radial { .. } => {}
        ProjectionKeys::Azimuthal(keys) => {
            if let Some(centre) = &keys.centre {
                centre_meets(reader, projection, plane, centre);
            }
        }
        ProjectionKeys::Map(_) | ProjectionKeys::Panels(_) => {}
    }
}

fn cylinder(
    reader: &mut ProfileReader,
    parts: &Entries,
    projection: &ProjectionEntry,
    radius: Located<f64>,
) {
    let path = projection.section.path_of("target_radius_mm");
    if let Some(width) = parts.part.width
        && radius.value <= 0.5 * width.value
    {
        let message = format!(
            "{path} must be more than half of part.width_mm = {}, found {}",
            width.value, radius.value
        );
        reader.complain(radius.at, message, "the mirror stands inside the cylinder");
    }
    let ProjectionKeys::Radial { law, inner, .. } = &projection.keys else { return };
    let on = |name| parts.layout.as_ref().is_some_and(|layout| layout.name == name);
    let hint = "what lies along the axis never meets a cylinder about it";
    if on(LayoutName::Disc) && !needs_annulus(law.as_ref()) {
        let message = format!("{path} must be left out with [layout.disc], found {}", radius.value);
        reader.complain(radius.at, message, &format!("{hint}; [layout.annulus] leaves it out"));
    }
    if let Some(inner) = inner
        && on(LayoutName::Annulus)
        && inner.value == 0.0
    {
        let path = projection.polar_path("inner_polar_deg");
        let message =
            format!("{path} must be more than 0 with target_radius_mm = {}, found 0", radius.value);
        reader.complain(inner.at, message, hint);
    }
}

const CAMERA_SIDE: &str = "this plane is on the camera's side";
const FAR_SIDE: &str = "this plane is behind the mirror, seen from the camera";

fn elevations_meet(
    reader: &mut ProfileReader,
    projection: &ProjectionEntry,
    plane: Located<f64>,
    elevation: &Located<[f64; 2]>,
) {
    let [low, high] = elevation.value;
    let (meets, side, why) = match plane.value > 0.0 {
        true => (low > 0.0, "above", CAMERA_SIDE),
        false => (high < 0.0, "below", FAR_SIDE),
    };
    if !meets {
        let path = projection.section.path_of("elevation_deg");
        let message = format!(
            "{path} must stay {side} 0 with target_plane_mm = {}, found {low} to {high}",
            plane.value
        );
        let hint = format!("{why}; target_radius_mm is a cylinder, which every elevation meets");
        reader.complain(elevation.at, message, &hint);
    }
}

/// The centre of a view looks to the plane's side; how far its edges reach is the design's to find out.
fn centre_meets(
    reader: &mut ProfileReader,
    projection: &ProjectionEntry,
    plane: Located<f64>,
    centre: &Located<[f64; 2]>,
) {
    let elevation = centre.value[1];
    if elevation * plane.value > 0.0 {
        return;
    }
    let (side, why) = if plane.value > 0.0 { ("above", CAMERA_SIDE) } else { ("below", FAR_SIDE) };
    let path = projection.section.path_of("centre_deg");
    let message = format!(
        "{path} must have an elevation {side} 0 with target_plane_mm = {}, found {elevation}",
        plane.value
    );
    reader.complain(centre.at, message, why);
}

fn polar_angles_meet(
    reader: &mut ProfileReader,
    parts: &Entries,
    projection: &ProjectionEntry,
    plane: Located<f64>,
    law: &RadialLawSpec,
    (inner, outer): (Option<&Located<f64>>, &Located<f64>),
) {
    let path = |key| projection.section.path_of(key);
    let height = plane.value;
    if height > 0.0 {
        if outer.value >= 90.0 {
            let key = projection.polar_path("outer_polar_deg");
            let found = outer.value;
            let message = format!(
                "{key} must be less than 90 with target_plane_mm = {height}, found {found}"
            );
            reader.complain(outer.at, message, CAMERA_SIDE);
        }
        return;
    }
    if *law == RadialLawSpec::Named(RadialLawKind::Plane) {
        let key = path("target_plane_mm");
        let message = format!("{key} must be more than 0, found {height}");
        let hint = "this law shows a plane on the camera's side";
        return reader.complain(plane.at, message, hint);
    }
    // A disc that this law cannot have is complained of already.
    if parts.layout.as_ref().is_some_and(|layout| layout.name == LayoutName::Disc)
        && !needs_annulus(Some(law))
    {
        let key = path("target_plane_mm");
        let message = format!("{key} must be more than 0 with [layout.disc], found {height}");
        let hint = "a disc looks back along the axis at its centre; use [layout.annulus] for a \
                    plane behind the mirror";
        return reader.complain(plane.at, message, hint);
    }
    let (key, end) = match inner {
        Some(inner) => ("inner_polar_deg", inner),
        None => ("outer_polar_deg", outer),
    };
    let key = projection.polar_path(key);
    let must = format!("{key} must be more than 90 with target_plane_mm = {height}");
    if end.value <= 90.0 {
        reader.complain(end.at, format!("{must}, found {}", end.value), FAR_SIDE);
    } else if *law == RadialLawSpec::Named(RadialLawKind::Parabolic)
        && let Some(least) = parabolic_inner(parts, outer.value)
        && least <= 90.0
    {
        let must = format!("{must} at the inner rim too");
        let message = format!("{must}, found {}, which makes it {least:.3} there", outer.value);
        reader.complain(outer.at, message, FAR_SIDE);
    }
}

/// Whether a disc of this law is complained of already.
fn needs_annulus(law: Option<&RadialLawSpec>) -> bool {
    matches!(law, Some(RadialLawSpec::Named(kind)) if kind.needs_annulus())
}

/// The polar angle at the inner rim of a paraboloid, in degrees.
fn parabolic_inner(parts: &Entries, outer_deg: f64) -> Option<f64> {
    let inner = parts.layout.as_ref().and_then(|layout: &layout::LayoutEntry| layout.inner)?;
    let radius = [inner.value, parts.part.width?.value].map(|diameter| 0.5 * diameter);
    let rims = RimConditions { radius, psi: [0.0, radians(outer_deg)], vergence: 0.0 };
    Some(degrees(rims.law(RadialLawKind::Parabolic).polar(radius[0])))
}

/// Whether the directions of a map, which has the path of its table, meet the target, and the points are on it.
fn map_meets(
    reader: &mut ProfileReader,
    projection: &ProjectionEntry,
    (path, keys): (&str, &MapKeys),
) {
    let target = projection.target();
    let viewpoint_mm =
        projection.posed.as_ref().map_or(DVec3::ZERO, |target| target.viewpoint_mm());
    if keys.kind == VectorKind::Point && target == Target::Infinity {
        let message = format!("{path}.kind = \"point\" must come with a target");
        let hint = "points lie on target_plane_mm, target_radius_mm or a surface of [target]; what is far away is given \
                    by directions";
        reader.complain(keys.file.at, message, hint);
        return;
    }
    let off = |v: &DVec3| -> f64 {
        let from = match keys.kind {
            VectorKind::Direction => *v,
            VectorKind::Point => *v - viewpoint_mm,
        };
        let share = match &target {
            Target::Infinity => 0.0,
            target => target.reach_mm(from.normalize()) / from.length(),
        };
        match keys.kind {
            // It must be met ahead.
            VectorKind::Direction if share >= 0.0 && share.is_finite() => 0.0,
            VectorKind::Direction => f64::INFINITY,
            VectorKind::Point => (share - 1.0).abs(),
        }
    };
    let found = keys.map.vectors.iter().position(|v| !v.is_nan() && !(off(v) <= OFF));
    if let Some(k) = found {
        complain_of_target(reader, projection, (path, keys), k);
    }
}

fn complain_of_target(
    reader: &mut ProfileReader,
    projection: &ProjectionEntry,
    (path, keys): (&str, &MapKeys),
    k: usize,
) {
    let (row, column) = (k / keys.map.columns + 1, k % keys.map.columns + 1);
    let target = match projection.target() {
        Target::Plane { height_mm } => format!("target_plane_mm = {height_mm}"),
        Target::Cylinder { radius_mm } => format!("target_radius_mm = {radius_mm}"),
        Target::Posed(_) => "[target]".to_owned(),
        Target::Infinity => return,
    };
    let (what, hint) = match keys.kind {
        VectorKind::Direction => (
            "direction must meet the target",
            "directions lead from the middle of the mirror or from viewpoint_mm; NaN leaves out what is not wanted",
        ),
        VectorKind::Point => (
            "point must be on the target",
            "points are mm in the part's frame, from the middle of the mirror: X to the right of the picture, Y up \
             in it, Z towards the camera",
        ),
    };
    let v = keys.map.vectors[k];
    let message = format!(
        "{path}.file: {}: row {row}, column {column}: each {what}, {target}; found ({}, {}, {})",
        keys.file.value, v.x, v.y, v.z
    );
    reader.complain(keys.file.at, message, hint);
}
