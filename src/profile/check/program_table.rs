//! The table `[program]`: what all machines have.

use super::super::program_words::{ProgramControl, StockMaterial, WorkOffset};
use super::super::reader::Need::Optional;
use super::super::reader::{ProfileReader, Section};
use super::super::values::{Located, NumbersFormat, number, numbers, word};

/// The table, and who complains of it.
pub(super) struct ProgramTable<'r, 'f, 's, 't> {
    pub reader: &'r mut ProfileReader<'f>,
    pub section: &'s Section<'t>,
}

/// A control that a machine has not: its name, which it must be, and why.
pub(super) type ForeignControl = (ProgramControl, &'static str, &'static str);

/// What a machine's control reads, one of some; foreign ones are complained of with what would do.
pub(super) fn control<C: Copy>(
    (reader, section): (&mut ProfileReader, &Section),
    controls: &[(&'static str, C)],
    foreign: &[ForeignControl],
    hint: &str,
) -> Option<C> {
    if let Some(value) = reader.value(section, "control", Optional, "", hint) {
        let found = value.get_ref().as_str();
        let foreign = foreign.iter().find(|(control, ..)| found == Some(control.name()));
        if let Some((control, must, why)) = foreign {
            let message = format!("program.control must be {must}, found \"{}\"", control.name());
            reader.complain(value.span().start, message, why);
            return None;
        }
    }
    word(reader, section, "control", controls, hint)
}

/// What programs of all machines have.
impl ProgramTable<'_, '_, '_, '_> {
    /// A number between limits.
    pub(super) fn figure(
        &mut self,
        key: &str,
        [least, most]: [f64; 2],
        hint: &str,
    ) -> Option<Located<f64>> {
        let must = format!("a number from {least} to {most}");
        let allowed = |f: f64| (least..=most).contains(&f);
        number(self.reader, self.section, key, Optional, &must, hint, allowed)
    }

    pub(super) fn value(&mut self, key: &str, range: [f64; 2], hint: &str) -> Option<f64> {
        self.figure(key, range, hint).map(|figure| figure.value)
    }

    pub(super) fn material(&mut self) -> Option<StockMaterial> {
        let materials = StockMaterial::ALL.map(|material| (material.name(), material));
        let hint = "it sets feeds, speeds and levels that are usual";
        word(self.reader, self.section, "material", &materials, hint)
    }

    pub(super) fn work_offset(&mut self) -> Option<WorkOffset> {
        let offsets = WorkOffset::ALL.map(|offset| (offset.name(), offset));
        let hint = "the offset whose zero is on the part's base";
        word(self.reader, self.section, "work_offset", &offsets, hint)
    }

    pub(super) fn stock(&mut self) -> Option<f64> {
        self.value(
            "stock_mm",
            [0.0, 100.0],
            "what the stock stands over the part, as in stock_mm = 1",
        )
    }

    pub(super) fn scallop(&mut self) -> Option<f64> {
        let hint = "the height of what stays between lines, as in scallop_um = 2";
        self.value("scallop_um", [1e-3, 1000.0], hint)
    }

    pub(super) fn budget(&mut self) -> Option<f64> {
        let hint = "the pixel error that 95 % of the face may have, as in budget_px = 2";
        self.value("budget_px", [1e-3, 1000.0], hint)
    }

    pub(super) fn chord(&mut self) -> Option<f64> {
        let hint = "what straight moves may be off the path, as in chord_um = 1";
        self.value("chord_um", [0.01, 100.0], hint)
    }

    pub(super) fn polish(&mut self) -> Option<f64> {
        let hint = "what is polished off the machined face, as in polish_um = 10";
        self.value("polish_um", [0.01, 1000.0], hint)
    }

    pub(super) fn allowance(&mut self) -> Option<f64> {
        let hint = "what roughing leaves, as in allowance_mm = 0.3";
        self.value("allowance_mm", [0.01, 10.0], hint)
    }

    pub(super) fn stepdown(&mut self) -> Option<f64> {
        let hint = "from level to level of roughing, as in stepdown_mm = 1";
        self.value("stepdown_mm", [0.01, 100.0], hint)
    }

    pub(super) fn spindle(&mut self, example: u32) -> Option<f64> {
        let hint = format!("the speed of the spindle, as in spindle_rpm = {example}");
        self.value("spindle_rpm", [1.0, 1e6], &hint)
    }

    /// Speed of rapid moves, largest speed of the spindle, acceleration and height of rapid moves.
    pub(super) fn axes(&mut self, example_rpm: u32) -> [Option<f64>; 4] {
        let hint = "the speed of rapid moves, as in rapid_mm_min = 5000";
        let rapid = self.value("rapid_mm_min", [10.0, 1e6], hint);
        let hint = format!("the spindle's largest speed, as in max_spindle_rpm = {example_rpm}");
        let spindle = self.value("max_spindle_rpm", [10.0, 1e6], &hint);
        let hint = "the acceleration of the axes, as in acceleration_mm_s2 = 500";
        let acceleration = self.value("acceleration_mm_s2", [1.0, 1e6], hint);
        let hint = "the height of rapid moves over the stock, as in safe_mm = 5";
        let safe = self.value("safe_mm", [0.1, 1000.0], hint);
        [rapid, spindle, acceleration, safe]
    }

    /// How fast the acceleration of the axes may change.
    pub(super) fn jerk(&mut self) -> Option<f64> {
        let hint = "how fast their acceleration may change, as in jerk_mm_s3 = 5000";
        self.value("jerk_mm_s3", [1.0, 1e9], hint)
    }

    /// How far the axes of a machine travel.
    pub(super) fn travel<const N: usize>(
        &mut self,
        [parts, form]: [&'static str; 2],
    ) -> Option<[f64; N]> {
        if !self.section.has("travel_mm") {
            return None;
        }
        let format = NumbersFormat {
            key: "travel_mm",
            parts,
            each: "a number from 1 to 100000",
            form,
            limit: "how far the machine's axes travel",
        };
        let allowed = |mm: f64| (1.0..=1e5).contains(&mm);
        numbers(self.reader, self.section, &format, allowed).map(|found| found.value)
    }
}
