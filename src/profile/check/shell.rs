//! The cavity of a hollow part: `part.shell_mm` and `part.drains_mm`, and what goes with them.

use super::super::FormingSpec;
use super::super::reader::Need::Optional;
use super::super::reader::{ProfileReader, Section};
use super::super::shell::ShellSpec;
use super::super::values::{Located, number};
use super::{Entries, border};

/// `part.shell_mm` with its place, and the drains.
pub(super) type ShellEntry = Located<ShellSpec>;

/// The keys of `[part]`.
pub(super) fn read(reader: &mut ProfileReader, part: &Section) -> Option<ShellEntry> {
    let must = "a number from 0.2 to 1000000";
    let hint = "the least thickness of a hollow part's walls, as in shell_mm = 2";
    let is_wall = |f: f64| (ShellSpec::LEAST_WALL_MM..=1e6).contains(&f);
    let wall = number(reader, part, "shell_mm", Optional, must, hint, is_wall);
    let drains = border::spots(reader, part, "drains_mm");
    if let (false, Some(drain)) = (part.has("shell_mm"), drains.first()) {
        let message = "part.drains_mm must go with shell_mm, found it alone".to_owned();
        reader.complain(drain.at, message, "shell_mm = 2 makes the part hollow");
    }
    let drains: Vec<_> = drains.into_iter().map(|drain| drain.value).collect();
    let wall = wall?;
    let drains = part.has("drains_mm").then_some(drains);
    Some(Located { value: ShellSpec { wall_mm: wall.value, drains }, at: wall.at })
}

/// Holds the rest of the profile to its hollow part.
pub(super) fn check(reader: &mut ProfileReader, parts: &Entries, tool: Option<&FormingSpec>) {
    let Some(shell) = &parts.part.shell else { return };
    let mut must = |what: &str, found: &str, hint: &str| {
        let message = format!("part.shell_mm must {what}, found {found}");
        reader.complain(shell.at, message, hint);
    };
    if let Some(tool) = tool {
        let hint = "a mould or mandrel is solid; leave shell_mm out";
        must("go with part.form = \"part\"", &format!("\"{}\"", tool.form.name()), hint);
    }
    if parts.projection.as_ref().is_some_and(|projection| projection.panels().is_some()) {
        let hint = "walls between panels stand in the way of a cavity; leave shell_mm out";
        must("have a mirror of one surface", "panels", hint);
    }
}
