//! What stands in the way of rays: `[[obstacle]]`.

use super::super::ObstacleSpec;
use super::super::reader::Need::{Optional, Required};
use super::super::reader::{ProfileReader, Section};
use super::super::values::{Located, NumbersFormat, file, flag, number, numbers};
use super::posed_target::place;
use super::{SIZE, is_size, only};
use crate::geom::{Cuboid, Cylinder, DVec3, Obstacle, ObstacleShape, Tube};
use std::sync::Arc;
use toml::de::DeValue;

/// Obstacles that a profile may have: each of its rays is held against each of them.
const MOST: usize = 100;
/// What an obstacle's shape may be, in a hint that can be pasted.
const FORM: &str = "below [[obstacle]] write its shape, as in cylinder = { from_mm = [40, 0, 0], to_mm = [40, 0, 150], radius_mm = 2 }";

pub(super) fn read(reader: &mut ProfileReader, root: &Section) -> Vec<ObstacleSpec> {
    let sections =
        reader.sections(root, "obstacle", MOST, [FORM, "an STL may hold several bodies"]);
    let read = |(k, section): (usize, &Section)| one(reader, k + 1, section);
    sections.iter().enumerate().filter_map(read).collect()
}

fn one(reader: &mut ProfileReader, number: usize, section: &Section) -> Option<ObstacleSpec> {
    let name = name(reader, section);
    let shapes: Vec<_> = reader
        .one_of(section, FORM)
        .into_iter()
        .map(|(shape, section)| match shape {
            "box" => (cuboid(reader, &section), None),
            "cylinder" => (cylinder(reader, &section), None),
            "tube" => (tube(reader, &section), None),
            _ => mesh(reader, &section),
        })
        .collect();
    let (shape, file) = only(shapes)?;
    let name = name.unwrap_or_else(|| format!("obstacle {number}"));
    let place = reader.place(section.at);
    Some(ObstacleSpec { obstacle: Obstacle { name, shape: shape? }, file, place })
}

fn name(reader: &mut ProfileReader, section: &Section) -> Option<String> {
    let (must, hint) = ("text that is not empty", "what reports call it, as in name = \"leg\"");
    let value = reader.value(section, "name", Optional, must, hint)?;
    match value.get_ref() {
        DeValue::String(name) if !name.trim().is_empty() => Some(name.to_string()),
        _ => {
            let path = section.path_of("name");
            let message = format!("{path} must be {must}, found {}", reader.quote_type(value));
            reader.complain(value.span().start, message, hint);
            None
        }
    }
}

fn cuboid(reader: &mut ProfileReader, section: &Section) -> Option<ObstacleShape> {
    let centre = place(reader, section, "centre_mm", [40, 0, 50]);
    let size = size(reader, section, "size_mm", "[X, Y, Z]", "as in size_mm = [20, 40, 5]");
    Some(ObstacleShape::Cuboid(Cuboid::aligned(centre?.value, DVec3::from_array(size?.value))))
}

/// Lengths of a box's edges, mm.
pub(super) fn size(
    reader: &mut ProfileReader,
    section: &Section,
    key: &str,
    parts: &str,
    example: &str,
) -> Option<Located<[f64; 3]>> {
    let form = format!("the lengths of the box's edges in millimetres, {example}");
    let keys = NumbersFormat { key, parts, each: SIZE, form: &form, limit: &form };
    numbers(reader, section, &keys, is_size)
}

fn cylinder(reader: &mut ProfileReader, section: &Section) -> Option<ObstacleShape> {
    let ends = ends(reader, section);
    let radius_mm = radius(reader, section, "radius_mm", 2).map(|radius| radius.value);
    let is_solid = flag(reader, section, "solid").is_none_or(|flag| flag.value);
    let [from_mm, to_mm] = ends?;
    let cylinder = Cylinder { from_mm, to_mm, radius_mm: radius_mm?, is_solid };
    Some(ObstacleShape::Cylinder(cylinder))
}

fn tube(reader: &mut ProfileReader, section: &Section) -> Option<ObstacleShape> {
    let ends = ends(reader, section);
    let inner = radius(reader, section, "inner_radius_mm", 50);
    let outer = radius(reader, section, "outer_radius_mm", 52);
    let ([from_mm, to_mm], inner, outer) = (ends?, inner?, outer?);
    if !(inner.value < outer.value) {
        let path = section.path_of("inner_radius_mm");
        let message = format!(
            "{path} must be less than outer_radius_mm = {}, found {}",
            outer.value, inner.value
        );
        let hint = "a wall without thickness is [obstacle.cylinder] with solid = false";
        reader.complain(inner.at, message, hint);
        return None;
    }
    let [inner_radius_mm, outer_radius_mm] = [inner.value, outer.value];
    Some(ObstacleShape::Tube(Tube { from_mm, to_mm, inner_radius_mm, outer_radius_mm }))
}

/// Centres of both ends.
fn ends(reader: &mut ProfileReader, section: &Section) -> Option<[DVec3; 2]> {
    let from = place(reader, section, "from_mm", [40, 0, 0]);
    let to = place(reader, section, "to_mm", [40, 0, 150]);
    let (from, to) = (from?, to?);
    let length = (to.value - from.value).length();
    if is_size(length) {
        return Some([from.value, to.value]);
    }
    let path = section.path_of("to_mm");
    let message = format!("{path} must be 0.001 to 1000000 mm from from_mm, found {length} mm");
    let hint = "the centres of both ends, as in from_mm = [40, 0, 0] and to_mm = [40, 0, 150]";
    reader.complain(to.at, message, hint);
    None
}

fn radius(
    reader: &mut ProfileReader,
    section: &Section,
    key: &str,
    example: u32,
) -> Option<Located<f64>> {
    let hint = format!("a radius in millimetres, as in {key} = {example}");
    number(reader, section, key, Required, SIZE, &hint, is_size)
}

fn mesh(reader: &mut ProfileReader, section: &Section) -> (Option<ObstacleShape>, Option<String>) {
    let hint = "an STL beside the profile, in millimetres from the middle of the mirror, as in file = \"holder.stl\"";
    let Some(Located { value: file, at }) = file(reader, section, hint) else {
        return (None, None);
    };
    let shape = match reader.mesh(&file) {
        Ok(mesh) => Some(ObstacleShape::Mesh(Arc::new(mesh))),
        Err(reason) => {
            let path = section.path_of("file");
            reader.complain(at, format!("{path}: {reason}"), "");
            None
        }
    };
    (shape, Some(file))
}
