//! The target surface in any pose: `[target]`.

use super::super::reader::Need::Required;
use super::super::reader::{ProfileReader, Section};
use super::super::values::{Located, NumbersFormat, file, number, numbers};
use super::layout::LayoutName;
use super::{Entries, LARGE, is_large, only};
use crate::geom::DVec3;
use crate::optics::{PoseFault, PosedSurface, PosedTarget};
use std::sync::Arc;

/// A target surface and its place in the profile.
pub(super) struct PosedEntry {
    /// Path of its table.
    pub(super) path: String,
    pub(super) at: usize,
    /// None where it has a complaint.
    pub(super) target: Option<PosedTarget>,
}

impl PosedEntry {
    /// Whether it is made of flat facets.
    pub(super) fn is_faceted(&self) -> bool {
        self.target.as_ref().is_some_and(PosedTarget::is_faceted)
    }
}

pub(super) fn read(reader: &mut ProfileReader, root: &Section) -> Option<PosedEntry> {
    if !root.has("target") {
        return None;
    }
    let hint =
        "the surface that the picture shows, in the part's frame, from the middle of the mirror";
    let read = reader
        .alternatives(root, "target", hint)
        .into_iter()
        .map(|(name, section)| one(reader, name, &section))
        .collect();
    only(read)
}

fn one(reader: &mut ProfileReader, name: &str, section: &Section) -> PosedEntry {
    let surface = match name {
        "plane" => plane(reader, section),
        "sphere" => sphere(reader, section),
        "mesh" => mesh(reader, section),
        _ => cylinder(reader, section),
    };
    let viewpoint = match section.has("viewpoint_mm") {
        true => seen_place(reader, section, "viewpoint_mm"),
        false => Some(DVec3::ZERO),
    };
    let target = surface.zip(viewpoint).and_then(|(surface, viewpoint)| {
        PosedTarget::new(surface, viewpoint).map_err(|fault| complain(reader, section, fault)).ok()
    });
    PosedEntry { path: section.path.clone(), at: section.at, target }
}

fn plane(reader: &mut ProfileReader, section: &Section) -> Option<PosedSurface> {
    let point_mm = seen_place(reader, section, "point_mm");
    let normal = direction(reader, section, "normal");
    Some(PosedSurface::Plane { point_mm: point_mm?, normal: normal? })
}

fn sphere(reader: &mut ProfileReader, section: &Section) -> Option<PosedSurface> {
    let centre_mm = seen_place(reader, section, "centre_mm");
    let radius_mm = radius(reader, section);
    Some(PosedSurface::Sphere { centre_mm: centre_mm?, radius_mm: radius_mm? })
}

fn cylinder(reader: &mut ProfileReader, section: &Section) -> Option<PosedSurface> {
    let point_mm = seen_place(reader, section, "point_mm");
    let axis = direction(reader, section, "axis");
    let radius_mm = radius(reader, section);
    Some(PosedSurface::Cylinder { point_mm: point_mm?, axis: axis?, radius_mm: radius_mm? })
}

fn mesh(reader: &mut ProfileReader, section: &Section) -> Option<PosedSurface> {
    let hint = "an OBJ or STL beside the profile, from the middle of the mirror, as in file = \"room.obj\"";
    let file = file(reader, section, hint);
    let must = format!("a number {LARGE}");
    let hint = "the length of the file's unit in millimetres, as in unit_mm = 1000 for metres";
    let unit = match section.has("unit_mm") {
        true => number(reader, section, "unit_mm", Required, &must, hint, is_large)?.value,
        false => 1.0,
    };
    let Located { value: file, at } = file?;
    match reader.mesh(&file) {
        Ok(mut mesh) => {
            mesh.vertices.iter_mut().for_each(|v| *v *= unit);
            Some(PosedSurface::Mesh(Arc::new(mesh)))
        }
        Err(reason) => {
            let path = section.path_of("file");
            reader.complain(at, format!("{path}: {reason}"), "");
            None
        }
    }
}

fn radius(reader: &mut ProfileReader, section: &Section) -> Option<f64> {
    let must = format!("a number {LARGE}");
    let hint = "the radius of the surface that the picture shows, in millimetres";
    Some(number(reader, section, "radius_mm", Required, &must, hint, is_large)?.value)
}

/// A place of what is seen, mm from the middle of the mirror.
fn seen_place(reader: &mut ProfileReader, section: &Section, key: &str) -> Option<DVec3> {
    place(reader, section, key, [0, 0, 500]).map(|place| place.value)
}

/// A place in the part's frame, mm from the middle of the mirror, with an example of it.
pub(super) fn place(
    reader: &mut ProfileReader,
    section: &Section,
    key: &str,
    example: [i32; 3],
) -> Option<Located<DVec3>> {
    let form = format!(
        "millimetres from the middle of the mirror: X to the right of the picture, Y up in it, Z towards \
         the camera, as in {key} = {example:?}"
    );
    let keys = NumbersFormat {
        key,
        parts: "[X, Y, Z]",
        each: "from -1e12 to 1e12",
        form: &form,
        limit: &form,
    };
    let Located { value, at } = numbers(reader, section, &keys, |f| f.abs() <= 1e12)?;
    Some(Located { value: DVec3::from_array(value), at })
}

/// A direction in the part's frame, of any length.
fn direction(reader: &mut ProfileReader, section: &Section, key: &str) -> Option<DVec3> {
    let form = format!("a direction of any length in the part's frame, as in {key} = [0, 0, 1]");
    let keys = NumbersFormat {
        key,
        parts: "[X, Y, Z]",
        each: "from -1e6 to 1e6",
        form: &form,
        limit: &form,
    };
    let found = numbers(reader, section, &keys, |f| f.abs() <= 1e6)?;
    let direction = DVec3::from_array(found.value);
    if direction.length() >= 1e-6 {
        return Some(direction);
    }
    let message =
        format!("{} must have a length of 1e-6 or more, found {direction}", section.path_of(key));
    reader.complain(found.at, message, &form);
    None
}

fn complain(reader: &mut ProfileReader, section: &Section, fault: PoseFault) {
    let (found, hint) = match fault {
        PoseFault::MirrorOnSurface => (
            "the middle of the mirror in the surface",
            "places are millimetres from the middle of the mirror; move the surface away from it",
        ),
        PoseFault::ViewpointOnSurface => (
            "the viewpoint in the surface",
            "viewpoint_mm is where the directions of the picture start; without it, in the middle of the mirror",
        ),
        PoseFault::Parted => (
            "the surface between them",
            "what is seen from one side of a surface is not what is seen from the other; move viewpoint_mm or \
             the surface",
        ),
    };
    let message = format!(
        "{} must be in sight of the mirror and of the viewpoint, found {found}",
        section.path
    );
    reader.complain(section.at, message, hint);
}

/// There is one target, of a picture, and no circle or fold asks for one about the axis.
pub(super) fn suits(reader: &mut ProfileReader, parts: &Entries) {
    let Some(posed) = &parts.posed else { return };
    let Some(projection) = &parts.projection else {
        if parts.bare {
            let message = format!("{} must come with a projection, found none", posed.path);
            reader.complain(posed.at, message, "a target is what a picture shows; leave it out");
        }
        return;
    };
    for (key, other) in
        [("target_radius_mm", projection.radius), ("target_plane_mm", projection.plane)]
    {
        if other.is_some() {
            let path = projection.section.path_of(key);
            let message =
                format!("there must be at most one target, found [{}] and {path}", posed.path);
            reader.complain(posed.at, message, "remove one of them");
        }
    }
    if posed.is_faceted() && projection.is_best() {
        let message = format!(
            "projection must be a law of known height with [{}], found [projection.best]",
            posed.path
        );
        let hint = "the curl of flat facets has no law; with [projection.mercator] little is lost";
        reader.complain(projection.section.at, message, hint);
    }
    let straight = [LayoutName::Strip, LayoutName::Rectangle];
    if let Some(layout) = parts.layout.as_ref().filter(|layout| !straight.contains(&layout.name)) {
        let message = format!(
            "layout must be [layout.strip] or [layout.rectangle] with [{}], found [layout.{}]",
            posed.path, layout.name
        );
        let hint = "discs, annuli and folds show surfaces about the axis: target_plane_mm and target_radius_mm";
        reader.complain(layout.at, message, hint);
    }
}
