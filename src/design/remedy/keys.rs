//! Ways to change one key of a profile.

use super::{KeyChange, KeyValue};
use crate::num::rounding::significant;
use crate::optics::{CameraModel, RadialLawKind, StripLaw, Target};
use crate::profile::{
    Layout, MethodKind, Profile, ProjectionSpec, RadialLawSpec, RadialSpec, ShapeSpec, StripLawSpec,
};

/// A profile after a change.
pub(super) struct EditedProfile {
    pub change: KeyChange,
    pub profile: Profile,
}

/// Ways to change one key, the smallest change first.
pub(super) type Edit = fn(&Profile) -> Vec<EditedProfile>;

/// A number as someone would write it, to four digits: what is tried is what is told.
fn short(x: f64) -> f64 {
    significant(x, 4)
}

/// A number to nine digits: rows that lie close together stay apart.
fn round(x: f64) -> f64 {
    significant(x, 9)
}

fn changed(profile: &Profile, change: KeyChange, edit: impl FnOnce(&mut Profile)) -> EditedProfile {
    let mut profile = profile.clone();
    edit(&mut profile);
    EditedProfile { change, profile }
}

/// The frame is not filled.
pub(super) fn unfilled(profile: &Profile) -> Vec<EditedProfile> {
    let mut layout = profile.layout;
    match &mut layout {
        Layout::Strip { fill_frame } | Layout::Conquistador { fill_frame, .. } if *fill_frame => {
            *fill_frame = false;
        }
        _ => return Vec::new(),
    }
    vec![changed(profile, KeyChange::Without("fill_frame"), |p| p.layout = layout)]
}

/// The smallest squares of errors instead of the smallest worst one.
pub(super) fn least_squares(profile: &Profile) -> Vec<EditedProfile> {
    let ShapeSpec::Designed(mut method) = profile.shape else { return Vec::new() };
    if !method.minimax {
        return Vec::new();
    }
    method.minimax = false;
    vec![changed(profile, KeyChange::Without("minimax"), |p| p.shape = ShapeSpec::Designed(method))]
}

/// The method that the others begin with.
pub(super) fn vector_field(profile: &Profile) -> Vec<EditedProfile> {
    let ShapeSpec::Designed(mut method) = profile.shape else { return Vec::new() };
    if method.kind == MethodKind::VectorField {
        return Vec::new();
    }
    method.kind = MethodKind::VectorField;
    let change = KeyChange::Take("method", method.kind.name());
    vec![changed(profile, change, |p| p.shape = ShapeSpec::Designed(method))]
}

fn of_degrees(profile: &Profile, degrees: impl IntoIterator<Item = usize>) -> Vec<EditedProfile> {
    let ShapeSpec::Designed(method) = profile.shape else { return Vec::new() };
    let of = |degree: usize| {
        let change = KeyChange::Set("degree", KeyValue::Number(degree as f64));
        let shape = ShapeSpec::Designed(crate::profile::Method { degree, ..method });
        changed(profile, change, |p| p.shape = shape)
    };
    degrees.into_iter().map(of).collect()
}

/// A degree that follows the picture more closely, where that is a matter of degree.
pub(super) fn degree(profile: &Profile) -> Vec<EditedProfile> {
    let ShapeSpec::Designed(method) = profile.shape else { return Vec::new() };
    of_degrees(profile, [4, 8, 12].into_iter().filter(|&degree| degree > method.degree))
}

/// A degree that the samples determine.
pub(super) fn degree_down(profile: &Profile) -> Vec<EditedProfile> {
    let ShapeSpec::Designed(method) = profile.shape else { return Vec::new() };
    let halves = std::iter::successors(Some(method.degree / 2), |degree| Some(degree / 2));
    of_degrees(profile, halves.take_while(|&degree| degree > 0))
}

fn set_target(profile: &mut Profile, to: Target) {
    if let Some(projection) = &mut profile.projection {
        projection.set_target(to);
    }
}

/// The target further away.
pub(super) fn targets(profile: &Profile) -> Vec<EditedProfile> {
    let Some(target) = profile.projection.as_ref().map(ProjectionSpec::target) else {
        return Vec::new();
    };
    let moved = |factor: f64| {
        let (key, far, to) = match target {
            // Of a surface in any pose it is for its owner to say where it may be.
            Target::Infinity | Target::Posed(_) => return None,
            Target::Cylinder { radius_mm } => {
                let far = short(factor * radius_mm);
                ("target_radius_mm", far, Target::Cylinder { radius_mm: far })
            }
            Target::Plane { height_mm } => {
                let far = short(factor * height_mm);
                ("target_plane_mm", far, Target::Plane { height_mm: far })
            }
        };
        let change = KeyChange::Set(key, KeyValue::Number(far));
        Some(changed(profile, change, |p| set_target(p, to)))
    };
    [2.0, 8.0, 64.0].into_iter().filter_map(moved).collect()
}

/// The target at infinity.
pub(super) fn untargeted(profile: &Profile) -> Vec<EditedProfile> {
    let key = match profile.projection.as_ref().map(ProjectionSpec::target) {
        None | Some(Target::Infinity) => return Vec::new(),
        Some(Target::Cylinder { .. }) => "target_radius_mm",
        Some(Target::Plane { .. }) => "target_plane_mm",
        Some(Target::Posed(_)) => "target",
    };
    vec![changed(profile, KeyChange::Without(key), |p| set_target(p, Target::Infinity))]
}

/// Part of the elevations, polar angles or angle of view: the part that is furthest from the horizon where a plane
/// is to be seen, or else the middle.
pub(super) fn elevation(profile: &Profile) -> Vec<EditedProfile> {
    let of = |share: f64| -> Option<EditedProfile> {
        let mut profile = profile.clone();
        let change = match profile.projection.as_mut()? {
            ProjectionSpec::Strip(strip) => {
                let [low, high] = strip.elevation_deg;
                let fixed = match strip.target {
                    Target::Plane { height_mm } if height_mm > 0.0 => high,
                    Target::Plane { .. } => low,
                    _ => 0.5 * (low + high),
                };
                let narrowed = |e: f64| short(fixed + share * (e - fixed));
                strip.elevation_deg = [low, high].map(narrowed);
                let value = match &mut strip.law {
                    // Rows of as many degrees each.
                    StripLawSpec::Table(rows) => {
                        let first = rows[0][0];
                        for [row, e] in rows.iter_mut() {
                            *row = round(first + share * (*row - first));
                            *e = round(fixed + share * (*e - fixed));
                        }
                        strip.elevation_deg = [rows[rows.len() - 1][1], rows[0][1]];
                        KeyValue::Rows(rows.clone())
                    }
                    _ => KeyValue::Range(strip.elevation_deg),
                };
                KeyChange::Set("elevation_deg", value)
            }
            ProjectionSpec::Radial(radial) => {
                let inner = radial.inner_polar_deg.unwrap_or(0.0);
                let floor = match radial.target {
                    Target::Plane { height_mm } if height_mm < 0.0 => inner.max(90.0),
                    _ => inner,
                };
                let narrowed = |degrees: f64| floor + share * (degrees - floor);
                match &mut radial.law {
                    RadialLawSpec::Named(_) => {
                        radial.outer_polar_deg = short(narrowed(radial.outer_polar_deg));
                        let outer = KeyValue::Number(radial.outer_polar_deg);
                        KeyChange::Set("outer_polar_deg", outer)
                    }
                    RadialLawSpec::Table(rows) => {
                        for [_, degrees] in rows.iter_mut() {
                            *degrees = round(narrowed(*degrees));
                        }
                        radial.outer_polar_deg = rows[rows.len() - 1][1];
                        KeyChange::Set("polar_deg", KeyValue::Rows(rows.clone()))
                    }
                }
            }
            ProjectionSpec::Azimuthal(view) => {
                view.hfov_deg = short(share * view.hfov_deg);
                KeyChange::Set("hfov_deg", KeyValue::Number(view.hfov_deg))
            }
            ProjectionSpec::Map(_) | ProjectionSpec::Panels(_) => return None,
        };
        Some(EditedProfile { change, profile })
    };
    [0.5, 0.25, 0.0625].into_iter().filter_map(of).collect()
}

/// A view with left and right the other way round.
pub(super) fn mirrored(profile: &Profile) -> Vec<EditedProfile> {
    let mut projection = profile.projection.clone();
    let Some(ProjectionSpec::Azimuthal(view)) = &mut projection else { return Vec::new() };
    view.mirrored = !view.mirrored;
    let change = KeyChange::Set("mirrored", KeyValue::Flag(view.mirrored));
    vec![changed(profile, change, |p| p.projection = projection)]
}

/// The law between the same elevations with the least curl.
pub(super) fn best(profile: &Profile) -> Vec<EditedProfile> {
    let mut projection = profile.projection.clone();
    let Some(ProjectionSpec::Strip(strip)) = &mut projection else { return Vec::new() };
    if strip.law == StripLawSpec::LeastCurl || !matches!(profile.shape, ShapeSpec::Designed(_)) {
        return Vec::new();
    }
    strip.law = StripLawSpec::LeastCurl;
    let change = KeyChange::Take("projection", "best");
    vec![changed(profile, change, |p| p.projection = projection)]
}

/// A law that has a place for every direction.
pub(super) fn law(profile: &Profile) -> Vec<EditedProfile> {
    let mut projection = profile.projection.clone();
    let name = match &mut projection {
        Some(ProjectionSpec::Strip(strip)) => match strip.law {
            StripLawSpec::LeastCurl => {
                strip.law = StripLawSpec::Named(StripLaw::Mercator);
                "mercator"
            }
            StripLawSpec::Named(StripLaw::Cylindrical | StripLaw::Mercator) => {
                strip.law = StripLawSpec::Named(StripLaw::Equirectangular);
                "equirectangular"
            }
            _ => return Vec::new(),
        },
        Some(ProjectionSpec::Radial(RadialSpec { law: RadialLawSpec::Named(kind), .. }))
            if kind.has_two_parameters() && *kind != RadialLawKind::Equiangular =>
        {
            *kind = RadialLawKind::Equiangular;
            "equiangular"
        }
        _ => return Vec::new(),
    };
    vec![changed(profile, KeyChange::Take("projection", name), |p| p.projection = projection)]
}

/// The camera further away.
pub(super) fn distance(profile: &Profile) -> Vec<EditedProfile> {
    let CameraModel::Pinhole { pixels, focal_px, distance_mm } = profile.camera else {
        return Vec::new();
    };
    // A part that fills the frame would have to grow with it.
    if !unfilled(profile).is_empty() {
        return Vec::new();
    }
    let moved = |factor: f64| {
        let distance_mm = short(factor * distance_mm);
        let change = KeyChange::Set("distance_mm", KeyValue::Number(distance_mm));
        let camera = CameraModel::Pinhole { pixels, focal_px, distance_mm };
        changed(profile, change, |p| p.camera = camera)
    };
    [2.0, 8.0, 64.0].into_iter().map(moved).collect()
}
