//! How the mirror is turned: `[program]` with `machine = "turn"`, and of a slow tool servo what it has in common with that.

use super::super::Layout;
use super::super::program_words::ProgramControl;
use super::super::reader::Need::Optional;
use super::super::reader::{ProfileReader, Section};
use super::super::turning::{
    LatheControl, LatheSpec, NoseSpec, TurnSpec, TurnedFinishSpec, TurnedRoughSpec,
};
use super::program_table::{self, ForeignControl, ProgramTable};

/// Radius of the smallest nose, mm.
const LEAST_NOSE_MM: f64 = 0.05;

/// Complains of a mirror that is not round, at the key that asks for a lathe.
pub(super) fn suits(reader: &mut ProfileReader, section: &Section, layout: Option<&Layout>) {
    let outline = match layout {
        None | Some(Layout::Disc | Layout::Annulus { .. }) => return,
        Some(Layout::Strip { .. }) => "a strip",
        Some(Layout::Conquistador { .. }) => "a conquistador of two panels",
        Some(Layout::Rectangle { .. }) => "a rectangle",
    };
    let Some(value) = reader.value(section, "machine", Optional, "", "") else { return };
    let message = format!(
        "program.machine must be \"mill3\" for a mirror that is not round, found \"turn\" for {outline}"
    );
    let hint = "a lathe makes what is round about the axis: [layout.disc] or [layout.annulus]";
    reader.complain(value.span().start, message, hint);
}

/// `[program]` of a lathe, but for its control.
pub(super) fn read(reader: &mut ProfileReader, section: &Section, usual: TurnSpec) -> TurnSpec {
    let mut table = ProgramTable { reader, section };
    let nose = table.nose(usual.nose);
    TurnSpec {
        material: table.material().unwrap_or(usual.material),
        work_offset: table.work_offset().unwrap_or(usual.work_offset),
        stock_mm: table.stock().unwrap_or(usual.stock_mm),
        nose,
        finishing: table.turned_finish(usual.finishing, nose.radius_mm),
        roughing: table.turned_rough(usual.roughing, nose.radius_mm),
        spindle_rpm: table.spindle(1500),
        machine: table.lathe(usual.machine),
    }
}

/// Controls that no lathe has.
const FOREIGN: &[ForeignControl] = &[
    (
        ProgramControl::Grbl,
        "\"linuxcnc\" or \"fanuc\" for a lathe",
        "grbl knows no feed in a turn of the spindle; LinuxCNC and Fanuc do",
    ),
    (
        ProgramControl::Xzc,
        "\"linuxcnc\" or \"fanuc\" for a lathe",
        "a table of points has places of the spindle, which turns freely here; it goes with machine = \"sts\"",
    ),
];

/// What the control of a lathe reads.
pub(super) fn control(reader: &mut ProfileReader, section: &Section) -> LatheControl {
    let controls = LatheControl::ALL.map(|control| (control.control().name(), control));
    let hint = "what the lathe's control reads";
    let found = program_table::control((reader, section), &controls, FOREIGN, hint);
    found.unwrap_or(LatheControl::Linuxcnc)
}

impl ProgramTable<'_, '_, '_, '_> {
    fn nose(&mut self, usual: NoseSpec) -> NoseSpec {
        let hint = "the radius of the tool's nose, as in nose_mm = 0.8";
        let radius = self.value("nose_mm", [LEAST_NOSE_MM, 100.0], hint);
        let hint = "of the edge on the axis' side, from the plane across the spindle, as in inner_edge_deg = 58";
        let inner = self.value("inner_edge_deg", [0.0, 90.0], hint);
        let hint = "of the edge on the rim's side, from the plane across the spindle, as in outer_edge_deg = 5";
        let outer = self.value("outer_edge_deg", [0.0, 90.0], hint);
        NoseSpec {
            radius_mm: radius.unwrap_or(usual.radius_mm),
            inner_edge_deg: inner.unwrap_or(usual.inner_edge_deg),
            outer_edge_deg: outer.unwrap_or(usual.outer_edge_deg),
        }
    }

    /// A feed in a turn of the spindle, up to the nose's radius: cusps of wider turns are no small ones.
    fn feed_in_a_turn(&mut self, key: &str, nose_mm: f64, hint: &str) -> Option<f64> {
        let feed = self.figure(key, [1e-3, 10.0], hint)?;
        if feed.value > nose_mm {
            let message = format!(
                "program.{key} must be no more than the nose's radius of {nose_mm} mm, found {}",
                feed.value
            );
            self.reader.complain(feed.at, message, hint);
        }
        Some(feed.value)
    }

    fn turned_finish(&mut self, usual: TurnedFinishSpec, nose_mm: f64) -> TurnedFinishSpec {
        let hint = "the feed of finishing in a turn of the spindle, as in feed_mm_rev = 0.05";
        TurnedFinishSpec {
            feed_mm_rev: self.feed_in_a_turn("feed_mm_rev", nose_mm, hint),
            scallop_um: self.scallop(),
            budget_px: self.budget(),
            chord_um: self.chord().unwrap_or(usual.chord_um),
            polish_um: self.polish(),
        }
    }

    fn turned_rough(&mut self, usual: TurnedRoughSpec, nose_mm: f64) -> TurnedRoughSpec {
        let hint = "the feed of roughing in a turn of the spindle, as in rough_feed_mm_rev = 0.15";
        TurnedRoughSpec {
            allowance_mm: self.allowance().unwrap_or(usual.allowance_mm),
            stepdown_mm: self.stepdown(),
            feed_mm_rev: self.feed_in_a_turn("rough_feed_mm_rev", nose_mm, hint),
        }
    }

    fn lathe(&mut self, usual: LatheSpec) -> LatheSpec {
        let [rapid, spindle, acceleration, safe] = self.axes(3000);
        let travel = ["the slides' travels [X, Z]", "as in travel_mm = [120, 150], X as a radius"];
        LatheSpec {
            rapid_mm_min: rapid.unwrap_or(usual.rapid_mm_min),
            max_spindle_rpm: spindle.unwrap_or(usual.max_spindle_rpm),
            acceleration_mm_s2: acceleration.unwrap_or(usual.acceleration_mm_s2),
            jerk_mm_s3: self.jerk(),
            travel_mm: self.travel(travel),
            safe_mm: safe.unwrap_or(usual.safe_mm),
        }
    }
}
