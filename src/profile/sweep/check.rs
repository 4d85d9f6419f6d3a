//! The rules of a study.

use super::super::reader::Need::Required;
use super::super::reader::{ProfileReader, Section};
use super::super::values::{Located, word};
use super::super::words::shown;
use super::axis::{self, AxisEntry};
use super::fields::{goal, label, text};
use super::{AxisSpec, ColumnSpec, MOST_POINTS, StudyContext, SweepCommand, SweepSpec};
use toml::de::DeTable;
use toml_edit::DocumentMut;

/// Most axes and most columns: each is a line across a plot.
const MOST: usize = 100;

/// The study of a tree; none where there is a complaint that leaves none.
pub(super) fn study(
    reader: &mut ProfileReader,
    tree: &DeTable,
    name: &str,
    context: StudyContext,
) -> Option<SweepSpec> {
    let root = reader.root(tree);
    let base = profile(reader, &root, context);
    let command = word(reader, &root, "command", &SweepCommand::ALL, "without it, design");
    let command = command.unwrap_or(SweepCommand::Design);
    let axes = axes(reader, &root);
    if let Some((_, base)) = &base {
        axes.iter().for_each(|axis| fits(reader, axis, base));
    }
    let columns = columns(reader, &root, command, (context, &axes));
    let (profile, base) = base?;
    let name = name.to_owned();
    let axes: Vec<AxisSpec> = axes.into_iter().map(|axis| axis.spec).collect();
    Some(SweepSpec { name, profile, command, axes, columns, base })
}

/// The profile's name and text.
fn profile(
    reader: &mut ProfileReader,
    root: &Section,
    context: StudyContext,
) -> Option<(String, DocumentMut)> {
    let must = "a profile file, by its path from the study, or the name of a shipped profile";
    let hint = "write profile = \"conquistador\"";
    let named = text(reader, root, "profile", (Required, must, hint))?;
    let found = (context.profile)(&named.value).and_then(|text| {
        let command = format!("`morion check {}` tells what is wrong with it", named.value);
        text.parse::<DocumentMut>().map_err(|_| format!("it is no TOML; {command}"))
    });
    match found {
        Ok(base) => Some((named.value, base)),
        Err(hint) => {
            let message = format!("profile must be {must}, found {}", shown(&named.value));
            reader.complain(named.at, message, &hint);
            None
        }
    }
}

/// All axes, no two of one key, with at most so many points.
fn axes(reader: &mut ProfileReader, root: &Section) -> Vec<AxisEntry> {
    let form = "[[axis]] with key = \"part.width_mm\" and values = [40, 60]";
    if !root.has("axis") {
        reader.missing(
            root,
            "axis must be a list of tables, found nothing".into(),
            &format!("write {form}"),
        );
    }
    let hints = [form, "sweep fewer keys at once"];
    let mut axes: Vec<AxisEntry> = Vec::new();
    for section in reader.sections(root, "axis", MOST, hints) {
        let Some(axis) = axis::axis(reader, &section, &axes) else { continue };
        if axes.iter().any(|other| other.spec.key == axis.spec.key) {
            let message =
                format!("each axis must have a key of its own, found {} again", axis.spec.key);
            reader.complain(axis.at, message, "keep one of them, with all its values");
        }
        axes.push(axis);
    }
    let mut points = 1_usize;
    for axis in axes.iter().filter(|axis| axis.spec.paired_with.is_none()) {
        let more = points.checked_mul(axis.spec.values.len());
        match more.filter(|more| *more <= MOST_POINTS) {
            Some(more) => points = more,
            None => {
                let count = axis.spec.values.len();
                let message = format!(
                    "a study must have at most {MOST_POINTS} points, found {points} times the {count} of {}",
                    axis.spec.key
                );
                reader.complain(axis.at, message, "take fewer values, or pair axes by paired_with");
                break;
            }
        }
    }
    axes
}

/// Complains of an axis whose first value has no place in the profile.
fn fits(reader: &mut ProfileReader, axis: &AxisEntry, base: &DocumentMut) {
    let Some(value) = axis.spec.values.first() else { return };
    let mut base = base.clone();
    if let Err(why) = super::set_value(&mut base, &axis.spec.path, value) {
        let message = format!("axis.key must be a place in the profile, found {}", axis.spec.key);
        reader.complain(axis.at, message, &format!("in the profile {why}"));
    }
}

/// All columns, no two of one key, none of an axis's.
fn columns(
    reader: &mut ProfileReader,
    root: &Section,
    command: SweepCommand,
    (context, axes): (StudyContext, &[AxisEntry]),
) -> Vec<ColumnSpec> {
    let form = "[[column]] with key = \"design.pixel_error_px.rms\"";
    if !root.has("column") {
        reader.missing(
            root,
            "column must be a list of tables, found nothing".into(),
            &format!("write {form}"),
        );
    }
    let mut columns: Vec<ColumnSpec> = Vec::new();
    for section in reader.sections(root, "column", MOST, [form, "keep fewer figures"]) {
        let goal = goal(reader, &section);
        let label = label(reader, &section);
        let must = format!("a key of the report of command = \"{}\"", command.name());
        let hint = "write key = \"design.pixel_error_px.rms\"";
        let Some(key) = text(reader, &section, "key", (Required, &must, hint)) else { continue };
        if let Err(hint) = (context.column)(command, &key.value) {
            let message = format!("column.key must be {must}, found {}", shown(&key.value));
            reader.complain(key.at, message, &hint);
        }
        let key = Located { value: key.value, at: key.at };
        if columns.iter().any(|other| other.key == key.value) {
            let message =
                format!("each column must have a key of its own, found {} again", key.value);
            reader.complain(key.at, message, "keep one of them");
        }
        if axes.iter().any(|axis| axis.spec.key == key.value) {
            let message = format!("a column must not have the key of an axis, found {}", key.value);
            reader.complain(
                key.at,
                message,
                "leave the column out; axes are columns of the rows too",
            );
        }
        columns.push(ColumnSpec { key: key.value, label, goal });
    }
    columns
}
