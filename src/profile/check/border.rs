//! The flat rim around the mirror: its keys, and whether everything in it has room.

use super::super::border::{BorderFeature, BorderSpec};
use super::super::reader::Need::Optional;
use super::super::reader::{ProfileReader, Section};
use super::super::values::{Located, RowsFormat, number, rows, within};
use super::super::{FormingSpec, HoleSpec, PartSpec};
use super::{Entries, SIZE, is_size, reach};
use crate::geom::{DVec2, Drilled};

/// Most holes, and most marks.
const MOST: usize = 200;
/// The rim's height as a share of the base under the mirror.
const RIM: [f64; 2] = [0.01, 0.99];
/// A mark is less deep than this share of the rim's height.
const DEEPEST: f64 = 0.99;

/// Entries of `[part]` about the border, each figure with its place.
#[derive(Default)]
pub(super) struct BorderEntry {
    width: Option<Located<f64>>,
    rim: Option<Located<f64>>,
    corner: Option<Located<f64>>,
    chamfer: Option<Located<f64>>,
    holes: Vec<Located<Drilled>>,
    marks: Vec<Located<Drilled>>,
}

pub(super) fn read(reader: &mut ProfileReader, section: &Section) -> BorderEntry {
    let least = |f: f64| (BorderSpec::LEAST_MM..=1e6).contains(&f);
    let must = "a number from 0.1 to 1000000";
    let hint = "the width of a flat rim around the mirror, as in border_mm = 8";
    let width = number(reader, section, "border_mm", Optional, must, hint, least);
    let hint = "the height of the flat rim over the base plane; half of base_mm without it";
    let rim = number(reader, section, "rim_mm", Optional, SIZE, hint, is_size);
    let hint = "what the part's corners are rounded with; left out they are sharp";
    let corner = number(reader, section, "corner_radius_mm", Optional, must, hint, least);
    let hint = "the leg of the chamfers of 45 degrees at the outer edges; left out they are sharp";
    let chamfer = number(reader, section, "edge_chamfer_mm", Optional, must, hint, least);
    let holes = spots(reader, section, "holes_mm");
    let marks = spots(reader, section, "marks_mm");
    if !section.has("border_mm") {
        for key in ["rim_mm", "corner_radius_mm", "edge_chamfer_mm", "holes_mm", "marks_mm"] {
            if let Some(value) = reader.value(section, key, Optional, "", "") {
                let path = section.path_of(key);
                let message = format!("{path} must go with border_mm, found it alone");
                let hint = "border_mm = 8 puts a flat rim around the mirror";
                reader.complain(value.span().start, message, hint);
            }
        }
    }
    BorderEntry { width, rim, corner, chamfer, holes, marks }
}

/// Entries of X, Y and diameter under `key`, each with its place.
pub(super) fn spots(
    reader: &mut ProfileReader,
    section: &Section,
    key: &str,
) -> Vec<Located<Drilled>> {
    let hint = "[34, 0, 3.2] is 3.2 mm wide, about X = 34 mm and Y = 0 mm";
    let list =
        RowsFormat { key, need: Optional, entry: "[x, y, diameter]", count: [1, MOST], hint };
    let path = section.path_of(key);
    let mut spots = Vec::new();
    for entry in rows::<3>(reader, section, &list).map_or_else(Vec::new, |rows| rows.value) {
        let [x, y, diameter] = entry.value;
        let centres = format!("the centres in {path}");
        let must = "numbers from -1000000 to 1000000";
        let [x, y] = [x, y].map(|v| within(reader, &centres, v, must, hint, |f| f.abs() <= 1e6));
        let diameters = format!("the diameters in {path}");
        let must = "numbers from 0.1 to 1000000";
        let least = |f: f64| (BorderSpec::LEAST_MM..=1e6).contains(&f);
        let diameter = within(reader, &diameters, diameter, must, hint, least);
        let (Some(x), Some(y), Some(diameter_mm)) = (x, y, diameter) else { return spots };
        spots.push(Located { value: Drilled { at: DVec2::new(x, y), diameter_mm }, at: entry.at });
    }
    spots
}

/// Holds the rim and the holes to the rest of the profile.
pub(super) fn check(
    reader: &mut ProfileReader,
    parts: &Entries,
    holes: &[Located<HoleSpec>],
    tool: Option<&FormingSpec>,
) {
    let found = &parts.part.border;
    if let (Some(corner), Some(layout)) = (found.corner, &parts.layout)
        && layout.is_round()
    {
        let message = format!(
            "part.corner_radius_mm must be left out with [layout.{}], found {}",
            layout.name, corner.value
        );
        reader.complain(corner.at, message, "a round part has no corners");
    }
    let Some(base) = parts.part.base else { return };
    let range = RIM.map(|share| share * base.value);
    if let Some(rim) = found.rim
        && !(range[0]..=range[1]).contains(&rim.value)
    {
        let message = format!(
            "part.rim_mm must be from {} to {} of base_mm = {}, found {}",
            RIM[0], RIM[1], base.value, rim.value
        );
        let hint = "the mirror stands out of the flat rim all around; rim_mm is the rim's height \
                    over the base plane";
        reader.complain(rim.at, message, hint);
        return;
    }
    let border = found.border(base.value);
    for (mark, border) in found.marks.iter().flat_map(|mark| Some((mark, border.as_ref()?))) {
        let depth = mark.value.radius();
        if !(depth <= DEEPEST * border.rim_mm) {
            let message = format!(
                "part.marks_mm must be less deep than {DEEPEST} of rim_mm = {}, found a mark \
                 {depth} mm deep",
                border.rim_mm
            );
            let hint = "a mark is a cone of 90 degrees, half as deep as wide; make it smaller";
            reader.complain(mark.at, message, hint);
        }
    }
    let conflicts = match (reach::known_outline(parts), parts.part.width) {
        (Some(mirror), Some(width)) if tool.is_none() => {
            let holes = holes.iter().map(|hole| hole.value).collect();
            let (width_mm, base_mm) = (width.value, base.value);
            PartSpec { width_mm, base_mm, border, holes, forming: None, shell: None }
                .conflicts(&mirror)
        }
        // Of a tool's rim the design complains, of a mirror whose outline it alone can tell of the rest.
        _ if tool.is_some() => Vec::new(),
        _ => border.and_then(|border| border.edges()).into_iter().collect(),
    };
    for conflict in conflicts {
        let at = match conflict.feature {
            BorderFeature::Corners => found.corner.map_or(0, |corner| corner.at),
            BorderFeature::Edges => found.chamfer.map_or(0, |chamfer| chamfer.at),
            BorderFeature::Hole(k) => found.holes[k].at,
            BorderFeature::Mark(k) => found.marks[k].at,
            BorderFeature::Drilling(k) => holes[k].at,
        };
        reader.complain(at, conflict.message, &conflict.hint);
    }
}

impl BorderEntry {
    /// Whether there is a border.
    pub(super) fn has_width(&self) -> bool {
        self.width.is_some()
    }

    /// The border over a base of this thickness.
    pub(super) fn border(&self, base_mm: f64) -> Option<BorderSpec> {
        let spots = |list: &[Located<Drilled>]| list.iter().map(|spot| spot.value).collect();
        Some(BorderSpec {
            width_mm: self.width?.value,
            rim_mm: self.rim.map_or(0.5 * base_mm, |rim| rim.value),
            corner_radius_mm: self.corner.map_or(0.0, |corner| corner.value),
            edge_chamfer_mm: self.chamfer.map_or(0.0, |chamfer| chamfer.value),
            holes: spots(&self.holes),
            marks: spots(&self.marks),
        })
    }
}
