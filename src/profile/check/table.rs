//! `[projection.table]`: rows of a strip and their elevations, or places along the radius of a round mirror and
//! their polar angles.

use super::super::reader::Need::Required;
use super::super::reader::{ProfileReader, Section};
use super::super::values::{Located, RowsFormat, rows, within};

/// Hint at an elevation out of its limits.
pub(super) const POLE: &str =
    "at the pole all azimuths are one direction; use 89 or less, -89 or more";

/// Whether an elevation is strictly inside +-90 degrees.
pub(super) fn below_the_pole(degrees: f64) -> bool {
    -90.0 < degrees && degrees < 90.0
}

/// Entries of a table: a place and its angle in degrees.
pub(super) type Entries = Located<Vec<[f64; 2]>>;

/// A table by what it is of; none with entries that are not those of one.
pub(super) enum Table {
    /// Rows of a strip and their elevations.
    Strip(Option<Entries>),
    /// Shares of the way between the rims of a round mirror, and their polar angles.
    Radial(Option<Entries>),
}

/// Form of a table of angles: what they belong to comes first in each entry.
struct AnglesFormat {
    list: RowsFormat<'static>,
    /// What the angles belong to, with its limits in words and numbers.
    places: &'static str,
    each_place: &'static str,
    limits: [f64; 2],
    /// Limits of the angles, and the hint at them.
    each_angle: &'static str,
    is_angle: fn(f64) -> bool,
    angle_hint: &'static str,
    /// 1 where angles rise from entry to entry, -1 where they fall, and how that is said.
    sense: f64,
    order: &'static str,
}

const ELEVATIONS: AnglesFormat = AnglesFormat {
    list: RowsFormat {
        key: "elevation_deg",
        need: Required,
        entry: "[row, degrees]",
        count: [2, 1000],
        hint: "rows run down the picture, as in elevation_deg = [[0, 30], [240, 0], [480, -30]]",
    },
    places: "rows",
    each_place: "from -1000000 to 1000000",
    limits: [-1e6, 1e6],
    each_angle: "strictly between -90 and 90",
    is_angle: below_the_pole,
    angle_hint: POLE,
    sense: -1.0,
    order: "fall down the rows",
};

const POLAR_ANGLES: AnglesFormat = AnglesFormat {
    list: RowsFormat {
        key: "polar_deg",
        need: Required,
        entry: "[share, degrees]",
        count: [2, 1000],
        hint: "shares of the way from the inner rim (of a disc, the centre) to the outer one in the picture, as in \
               polar_deg = [[0, 0], [0.6, 75], [1, 95]]",
    },
    places: "shares",
    each_place: "from 0 to 1",
    limits: [0.0, 1.0],
    each_angle: "0 or more and less than 180",
    is_angle: |degrees| (0.0..180.0).contains(&degrees),
    angle_hint: "the angle between the axis towards the camera and what is seen; 90 is the horizon",
    sense: 1.0,
    order: "rise with the shares",
};

/// The table; none where the keys do not say what it is of.
pub(super) fn read(reader: &mut ProfileReader, section: &Section) -> Option<Table> {
    let strip = ["azimuth_deg", "elevation_deg"].into_iter().find(|key| section.has(key));
    match (strip, section.has("polar_deg")) {
        (Some(_), false) => Some(Table::Strip(entries(reader, section, &ELEVATIONS))),
        (None, true) => {
            let table = entries(reader, section, &POLAR_ANGLES);
            Some(Table::Radial(table.filter(|table| reaches_both_rims(reader, section, table))))
        }
        (strip, _) => {
            let found = strip.map_or("neither".to_owned(), |key| format!("{key} and polar_deg"));
            let message = format!(
                "{} must hold either azimuth_deg and elevation_deg or polar_deg, found {found}",
                section.path
            );
            let hint = "azimuth_deg and elevation_deg are for a strip or a conquistador, polar_deg is for a disc \
                        or an annulus";
            reader.missing(section, message, hint);
            None
        }
    }
}

/// The angles of the first and the last entry, each where the table is; a table has at least two.
pub(super) fn ends(table: &Entries) -> [Located<f64>; 2] {
    let (rows, at) = (&table.value, table.at);
    [rows[0], rows[rows.len() - 1]].map(|[_, angle]| Located { value: angle, at })
}

/// Whether the shares begin with 0 and end with 1.
fn reaches_both_rims(reader: &mut ProfileReader, section: &Section, table: &Entries) -> bool {
    let [first, last] = [table.value[0], table.value[table.value.len() - 1]].map(|row| row[0]);
    if [first, last] == POLAR_ANGLES.limits {
        return true;
    }
    let list = &POLAR_ANGLES.list;
    let path = section.path_of(list.key);
    let message = format!("{path} must have shares from 0 to 1, found {first} to {last}");
    reader.complain(table.at, message, list.hint);
    false
}

/// The entries of a table whose places rise, and whose angles rise or fall.
fn entries(
    reader: &mut ProfileReader,
    section: &Section,
    format: &AnglesFormat,
) -> Option<Entries> {
    let AnglesFormat { list, places, order, sense, limits: [least, most], .. } = format;
    let path = section.path_of(list.key);
    let entries = rows::<2>(reader, section, list)?;
    let mut table: Vec<[f64; 2]> = Vec::with_capacity(entries.value.len());
    for entry in entries.value {
        let [place, angle] = entry.value;
        let of_places = format!("the {places} in {path}");
        let is_place = |place| (*least..=*most).contains(&place);
        let place = within(reader, &of_places, place, format.each_place, list.hint, is_place);
        let (of_angles, hint) = (format!("the degrees in {path}"), format.angle_hint);
        let angle = within(reader, &of_angles, angle, format.each_angle, hint, format.is_angle);
        let (place, angle) = (place?, angle?);
        if let Some([before, other]) = table.last() {
            let wrong = if place <= *before {
                Some(format!(
                    "{places} that rise from entry to entry, found {place} after {before}"
                ))
            } else if sense * angle <= sense * other {
                Some(format!("degrees that {order}, found {angle} after {other}"))
            } else {
                None
            };
            if let Some(wrong) = wrong {
                reader.complain(entry.at, format!("{path} must have {wrong}"), list.hint);
                return None;
            }
        }
        table.push([place, angle]);
    }
    Some(Located { value: table, at: entries.at })
}
