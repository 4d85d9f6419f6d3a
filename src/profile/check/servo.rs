//! How the mirror is cut by a slow tool servo: `[program]` with `machine = "sts"`.

use super::super::Layout;
use super::super::program_words::ProgramControl;
use super::super::reader::Need::Optional;
use super::super::reader::{ProfileReader, Section};
use super::super::servo::{ServoControl, ServoSpec};
use super::program_table::{self, ForeignControl, ProgramTable};

/// Complains of a mirror that is neither disc nor rectangle, at the key that asks for a slow tool servo.
pub(super) fn suits(reader: &mut ProfileReader, section: &Section, layout: Option<&Layout>) {
    let (outline, instead) = match layout {
        None | Some(Layout::Disc | Layout::Rectangle { .. } | Layout::Strip { .. }) => return,
        Some(Layout::Annulus { .. }) => ("an annulus", "\"turn\""),
        Some(Layout::Conquistador { .. }) => ("a conquistador of two panels", "\"mill3\""),
    };
    let Some(value) = reader.value(section, "machine", Optional, "", "") else { return };
    let message = format!(
        "program.machine must be {instead} for a mirror that is neither a disc nor one rectangle, found \"sts\" for {outline}"
    );
    let hint = "a slow tool servo follows the mirror all around the axis, and out of it: [layout.disc], [layout.rectangle]";
    reader.complain(value.span().start, message, hint);
}

/// What no slow tool servo reads.
const FOREIGN: &[ForeignControl] = &[
    (
        ProgramControl::Grbl,
        "\"linuxcnc\" or \"xzc\" for a slow tool servo",
        "grbl has no C axis beside X and Z; LinuxCNC has, and \"xzc\" is a table of points for others",
    ),
    (
        ProgramControl::Fanuc,
        "\"linuxcnc\" or \"xzc\" for a slow tool servo",
        "makers set Fanuc's C axes up in ways of their own; \"xzc\" is a table of points, which theirs can be made of",
    ),
];

/// What a slow tool servo has beside a lathe.
pub(super) fn read(reader: &mut ProfileReader, section: &Section) -> ServoSpec {
    let usual = ServoSpec::default();
    let controls = ServoControl::ALL.map(|control| (control.control().name(), control));
    let hint = "what the machine's control reads";
    let control = program_table::control((reader, section), &controls, FOREIGN, hint);
    let hint =
        "of the flank below the edge, from the direction of cutting, as in clearance_deg = 10";
    let clearance = ProgramTable { reader, section }.value("clearance_deg", [0.0, 90.0], hint);
    ServoSpec {
        control: control.unwrap_or(usual.control),
        clearance_deg: clearance.unwrap_or(usual.clearance_deg),
    }
}
