//! Holes with a table of their own: `[[hole]]`.

use super::super::HoleSpec;
use super::super::border::BorderSpec;
use super::super::reader::Need::{Optional, Required};
use super::super::reader::{ProfileReader, Section};
use super::super::values::{Located, RowsFormat, number, rows, within, word};
use crate::geom::{Counterbore, DVec2, Hole, HoleBottom, HoleKind, MetricThread};

/// Tables of holes, and places of one table.
const MOST: usize = 100;
/// The form of a table, in a hint that can be pasted.
const FORM: &str =
    "below [[hole]] write its place and what it is, as in at_mm = [[20, 10]] and thread = \"M3\"";
/// Diameters of dowel pins whose limits are known, mm.
const DOWELS: [f64; 2] = [1.0, 10.0];
const LENGTH: &str = "a number from 0.1 to 1000000";

fn is_length(f: f64) -> bool {
    (BorderSpec::LEAST_MM..=1e6).contains(&f)
}

/// The holes, each place of a table for itself.
pub(super) fn read(reader: &mut ProfileReader, root: &Section) -> Vec<Located<HoleSpec>> {
    let too_many = "a table may have many places: at_mm = [[20, 10], [-20, 10]]";
    let sections = reader.sections(root, "hole", MOST, [FORM, too_many]);
    let mut holes = Vec::new();
    for section in &sections {
        let places = places(reader, section);
        let Some((hole, blind)) = shape(reader, section) else { continue };
        for Located { value: at, at: offset } in places {
            let place = reader.place(offset);
            let hole = Hole { at, ..hole };
            holes.push(Located { value: HoleSpec { hole, blind, place }, at: offset });
        }
    }
    holes
}

fn places(reader: &mut ProfileReader, section: &Section) -> Vec<Located<DVec2>> {
    let hint = "the same hole at one place or more, as in at_mm = [[20, 10], [-20, 10]]";
    let list = RowsFormat { key: "at_mm", need: Required, entry: "[x, y]", count: [1, MOST], hint };
    let entries = rows::<2>(reader, section, &list).map_or_else(Vec::new, |rows| rows.value);
    let path = section.path_of("at_mm");
    let must = "numbers from -1000000 to 1000000";
    let mut places = Vec::new();
    for entry in entries {
        let [x, y] = entry.value.map(|v| within(reader, &path, v, must, hint, |f| f.abs() <= 1e6));
        if let (Some(x), Some(y)) = (x, y) {
            places.push(Located { value: DVec2::new(x, y), at: entry.at });
        }
    }
    places
}

/// The purposes that a table names.
struct Purposes {
    diameter: Option<Located<f64>>,
    thread: Option<MetricThread>,
    screw: Option<MetricThread>,
    dowel: Option<Located<f64>>,
}

/// The hole about the origin, and where it ends.
fn shape(
    reader: &mut ProfileReader,
    section: &Section,
) -> Option<(Hole, Option<(f64, HoleBottom)>)> {
    let found = purposes(reader, section);
    let hint =
        "millimetres from the base to where the cylinder ends; without it the hole goes through";
    let depth = number(reader, section, "depth_mm", Optional, LENGTH, hint, is_length);
    let hint = "millimetres of usable thread from the base, as in thread_depth_mm = 6";
    let usable = number(reader, section, "thread_depth_mm", Optional, LENGTH, hint, is_length);
    let hint = "\"drill\" is the cone of 118 degrees that a drill leaves beyond depth_mm";
    let bottoms = [("drill", HoleBottom::DrillPoint), ("flat", HoleBottom::Flat)];
    let bottom = word(reader, section, "bottom", &bottoms, hint);
    let hint = "the leg of the chamfers of 45 degrees at the hole's mouths, as in chamfer_mm = 0.3";
    let chamfer = number(reader, section, "chamfer_mm", Optional, LENGTH, hint, is_length);
    let (kind, diameter_mm) = only_purpose(reader, section, &found)?;
    let (kind, depth) = match kind {
        HoleKind::Thread { size, .. } => threaded(reader, section, size, (usable, depth))?,
        kind => {
            if let Some(usable) = usable {
                needs(reader, section, "thread_depth_mm", usable.at, "thread");
            }
            (kind, depth)
        }
    };
    if let (HoleKind::Screw(_), Some(depth)) = (kind, depth) {
        let message = format!("hole.depth_mm must be left out with screw, found {}", depth.value);
        reader.complain(depth.at, message, "a screw goes through; give diameter_mm instead");
        return None;
    }
    if bottom.is_some() && depth.is_none() {
        needs(reader, section, "bottom", section.at, "depth_mm");
    }
    let counterbore = counterbore(reader, section, (kind, diameter_mm));
    let chamfer_mm = chamfer.map_or(0.0, |chamfer| chamfer.value);
    let hole = Hole { at: DVec2::ZERO, diameter_mm, kind, counterbore, chamfer_mm };
    if let Some(chamfer) = chamfer
        && let Some(counterbore) = counterbore
        && !(chamfer.value < counterbore.depth_mm)
    {
        let message = format!(
            "hole.chamfer_mm must be less than counterbore_depth_mm = {}, found {}",
            counterbore.depth_mm, chamfer.value
        );
        reader.complain(chamfer.at, message, "take a smaller chamfer");
    }
    let least = hole.mouth_depth_mm() + BorderSpec::CLEAR_MM;
    if let Some(depth) = depth.filter(|depth| !(depth.value >= least)) {
        let message = format!(
            "hole.depth_mm must be at least {least:.3}, {} mm more than its mouth, found {}",
            BorderSpec::CLEAR_MM,
            depth.value
        );
        reader.complain(depth.at, message, "drill deeper, or make counterbore and chamfer smaller");
    }
    Some((hole, depth.map(|depth| (depth.value, bottom.unwrap_or_default()))))
}

fn purposes(reader: &mut ProfileReader, section: &Section) -> Purposes {
    let hint = "the hole's diameter in millimetres, as in diameter_mm = 3.2";
    let diameter = number(reader, section, "diameter_mm", Optional, LENGTH, hint, is_length);
    let hint = "a metric thread of coarse pitch, as in thread = \"M3\"";
    let thread = word(reader, section, "thread", &MetricThread::ALL, hint);
    let hint =
        "the thread of a cylinder-head screw (ISO 4762) that goes through, as in screw = \"M3\"";
    let screw = word(reader, section, "screw", &MetricThread::ALL, hint);
    let must = "a number from 1 to 10";
    let hint = "the diameter of a dowel pin in millimetres, as in dowel_mm = 3";
    let is_dowel = |f: f64| (DOWELS[0]..=DOWELS[1]).contains(&f);
    let dowel = number(reader, section, "dowel_mm", Optional, must, hint, is_dowel);
    Purposes { diameter, thread, screw, dowel }
}

/// The only purpose that a table has, and the diameter of the cylinder for it, mm.
fn only_purpose(
    reader: &mut ProfileReader,
    section: &Section,
    found: &Purposes,
) -> Option<(HoleKind, f64)> {
    let given = ["diameter_mm", "thread", "screw", "dowel_mm"].map(|key| section.has(key));
    let count = given.into_iter().filter(|given| *given).count();
    if count != 1 {
        let message = format!(
            "hole must have exactly one of diameter_mm, thread, screw and dowel_mm, found {}",
            if count == 0 { "none".to_owned() } else { count.to_string() }
        );
        let hint = "thread = \"M3\" is a threaded hole, screw = \"M3\" one for such a screw, dowel_mm = 3 \
                    one for a pin, diameter_mm = 3.2 any other";
        reader.complain(section.at, message, hint);
        return None;
    }
    let thread =
        found.thread.map(|size| (HoleKind::Thread { size, depth_mm: None }, size.pilot_mm()));
    let screw = found.screw.map(|size| (HoleKind::Screw(size), size.clearance_mm()));
    let dowel = found.dowel.map(|dowel| (HoleKind::Dowel, dowel.value));
    let plain = found.diameter.map(|diameter| (HoleKind::Plain, diameter.value));
    thread.or(screw).or(dowel).or(plain)
}

/// The depth of a thread and of its pilot, either of which follows from the other; through without both.
fn threaded(
    reader: &mut ProfileReader,
    section: &Section,
    size: MetricThread,
    (usable, depth): (Option<Located<f64>>, Option<Located<f64>>),
) -> Option<(HoleKind, Option<Located<f64>>)> {
    let with = |depth_mm: Option<f64>| HoleKind::Thread { size, depth_mm };
    let overrun = size.overrun_mm();
    match (usable, depth) {
        (None, None) => Some((with(None), None)),
        (Some(usable), None) => {
            let depth = Located { value: usable.value + overrun, at: usable.at };
            Some((with(Some(usable.value)), Some(depth)))
        }
        (None, Some(depth)) if depth.value >= overrun + size.pitch_mm() => {
            Some((with(Some(depth.value - overrun)), Some(depth)))
        }
        (Some(usable), Some(depth)) if usable.value <= depth.value => {
            Some((with(Some(usable.value)), Some(depth)))
        }
        (None, Some(depth)) => {
            let least = overrun + size.pitch_mm();
            let message = format!(
                "{} must be at least {least}, for one turn of {size} and the tap's chamfer, found {}",
                section.path_of("depth_mm"),
                depth.value
            );
            reader.complain(depth.at, message, "give thread_depth_mm instead; depth_mm follows");
            None
        }
        (Some(usable), Some(depth)) => {
            let message = format!(
                "{} must be at most depth_mm = {}, found {}",
                section.path_of("thread_depth_mm"),
                depth.value,
                usable.value
            );
            let hint = format!("leave depth_mm out: the pilot is then {overrun} mm deeper");
            reader.complain(usable.at, message, &hint);
            None
        }
    }
}

/// The counterbore: of a screw that of its head, as far as the table does not say otherwise.
fn counterbore(
    reader: &mut ProfileReader,
    section: &Section,
    (kind, hole_mm): (HoleKind, f64),
) -> Option<Counterbore> {
    let keys = ["counterbore_diameter_mm", "counterbore_depth_mm"];
    let hint = "a wider cylinder at the base, as in counterbore_diameter_mm = 6.5 and \
                counterbore_depth_mm = 3.4";
    let [wide, deep] =
        keys.map(|key| number(reader, section, key, Optional, LENGTH, hint, is_length));
    let usual = match kind {
        HoleKind::Screw(size) => Some([size.counterbore_mm(), size.counterbore_depth_mm()]),
        _ => None,
    };
    if let (None, Some(lone)) = (usual, wide.or(deep))
        && section.has(keys[0]) != section.has(keys[1])
    {
        let [has, lacks] = if section.has(keys[0]) { keys } else { [keys[1], keys[0]] };
        needs(reader, section, has, lone.at, lacks);
        return None;
    }
    let figure = |found: Option<Located<f64>>, k: usize| {
        found.map(|found| found.value).or(usual.map(|usual| usual[k]))
    };
    let (diameter_mm, depth_mm) = (figure(wide, 0)?, figure(deep, 1)?);
    if let Some(wide) = wide.filter(|wide| !(wide.value > hole_mm)) {
        let message = format!(
            "hole.counterbore_diameter_mm must be more than the hole's diameter, {hole_mm}, found {}",
            wide.value
        );
        reader.complain(wide.at, message, hint);
    }
    Some(Counterbore { diameter_mm, depth_mm })
}

/// That a key goes with another one alone.
fn needs(reader: &mut ProfileReader, section: &Section, key: &str, at: usize, other: &str) {
    let message = format!("{} must go with {other}, found it alone", section.path_of(key));
    reader.complain(at, message, &format!("give {other} too, or leave {key} out"));
}
