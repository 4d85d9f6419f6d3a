//! How the mirror is milled: `[program]`.

use super::super::program::{
    CutterLengths, FinishingSpec, MachineSpec, MillControl, ProgramSpec, RoughingSpec, SpeedsSpec,
    StockMaterial, WorkOffset,
};
use super::super::reader::Need::Optional;
use super::super::reader::{ProfileReader, Section};
use super::super::values::{Located, NumbersFormat, number, numbers, word};

/// `[program]`; the usual values where there is none.
pub(super) fn read(reader: &mut ProfileReader, root: &Section) -> ProgramSpec {
    let usual = ProgramSpec::default();
    let Some(section) = reader.section(root, "program", Optional) else { return usual };
    let materials = StockMaterial::ALL.map(|material| (material.name(), material));
    let hint = "it sets feeds, speeds and levels that are usual";
    let material = word(reader, &section, "material", &materials, hint);
    let controls = MillControl::ALL.map(|control| (control.name(), control));
    let hint = "what the mill's control reads";
    let control = word(reader, &section, "control", &controls, hint);
    let offsets = WorkOffset::ALL.map(|offset| (offset.name(), offset));
    let hint = "the offset whose zero is on the part's base";
    let work_offset = word(reader, &section, "work_offset", &offsets, hint);
    let mut table = Table { reader, section: &section };
    let hint = "what the stock stands over the part, as in stock_mm = 1";
    let stock = table.figure("stock_mm", [0.0, 100.0], hint);
    ProgramSpec {
        material: material.unwrap_or(usual.material),
        control: control.unwrap_or(usual.control),
        work_offset: work_offset.unwrap_or(usual.work_offset),
        stock_mm: stock.map_or(usual.stock_mm, |mm| mm.value),
        finishing: table.finishing(usual.finishing),
        roughing: table.roughing(usual.roughing),
        speeds: table.speeds(usual.speeds),
        machine: table.machine(usual.machine),
    }
}

/// Radius of the smallest ball, mm.
const LEAST_BALL_MM: f64 = 0.05;
/// Keys of the lengths of a cutter: teeth, shank, out of the holder.
const FINISHING_LENGTHS: [&str; 3] = ["flute_mm", "shank_diameter_mm", "stickout_mm"];
const ROUGHING_LENGTHS: [&str; 3] =
    ["rough_flute_mm", "rough_shank_diameter_mm", "rough_stickout_mm"];

/// The table, and who complains of it.
struct Table<'r, 'f, 's, 't> {
    reader: &'r mut ProfileReader<'f>,
    section: &'s Section<'t>,
}

impl Table<'_, '_, '_, '_> {
    /// A number between limits.
    fn figure(&mut self, key: &str, [least, most]: [f64; 2], hint: &str) -> Option<Located<f64>> {
        let must = format!("a number from {least} to {most}");
        let allowed = |f: f64| (least..=most).contains(&f);
        number(self.reader, self.section, key, Optional, &must, hint, allowed)
    }

    fn value(&mut self, key: &str, range: [f64; 2], hint: &str) -> Option<f64> {
        self.figure(key, range, hint).map(|figure| figure.value)
    }

    fn finishing(&mut self, usual: FinishingSpec) -> FinishingSpec {
        let hint = "the radius of the ball, as in ball_mm = 3";
        let ball_mm = self.value("ball_mm", [LEAST_BALL_MM, 1000.0], hint).unwrap_or(usual.ball_mm);
        let hint = "from line to line of finishing, as in stepover_mm = 0.3";
        let stepover = self.figure("stepover_mm", [1e-3, 100.0], hint);
        if let Some(Located { value, at }) = stepover.filter(|mm| mm.value >= 2.0 * ball_mm) {
            let message = format!(
                "program.stepover_mm must be less than the ball's diameter of {} mm, found {value}",
                2.0 * ball_mm
            );
            self.reader.complain(at, message, hint);
        }
        let hint = "the height of what stays between lines, as in scallop_um = 2";
        let scallop_um = self.value("scallop_um", [1e-3, 1000.0], hint);
        let hint = "the pixel error that 95 % of the face may have, as in budget_px = 2";
        let budget_px = self.value("budget_px", [1e-3, 1000.0], hint);
        let hint = "the direction of the lines from X towards Y, as in angle_deg = 90";
        let angle_deg = self.value("angle_deg", [-180.0, 180.0], hint);
        let hint = "what straight moves may be off the path, as in chord_um = 1";
        let chord_um = self.value("chord_um", [0.01, 100.0], hint).unwrap_or(usual.chord_um);
        let hint = "what is polished off the milled face, as in polish_um = 10";
        let polish_um = self.value("polish_um", [0.01, 1000.0], hint);
        let stepover_mm = stepover.map(|mm| mm.value);
        FinishingSpec {
            ball_mm,
            stepover_mm,
            scallop_um,
            budget_px,
            angle_deg,
            chord_um,
            polish_um,
            lengths: self.lengths(FINISHING_LENGTHS, Some(ball_mm)),
        }
    }

    fn roughing(&mut self, usual: RoughingSpec) -> RoughingSpec {
        let hint = "the radius of the ball that roughs, as in rough_ball_mm = 4";
        let ball_mm = self.value("rough_ball_mm", [LEAST_BALL_MM, 1000.0], hint);
        let hint = "what roughing leaves, as in allowance_mm = 0.3";
        let allowance = self.value("allowance_mm", [0.01, 10.0], hint);
        let hint = "from level to level of roughing, as in stepdown_mm = 1";
        let stepdown_mm = self.value("stepdown_mm", [0.01, 100.0], hint);
        RoughingSpec {
            ball_mm,
            allowance_mm: allowance.unwrap_or(usual.allowance_mm),
            stepdown_mm,
            lengths: self.lengths(ROUGHING_LENGTHS, ball_mm),
        }
    }

    /// Lengths of a cutter, by their keys; one without a ball of its own has none.
    fn lengths(
        &mut self,
        [flute, shank, stickout]: [&str; 3],
        ball_mm: Option<f64>,
    ) -> CutterLengths {
        let ball = ball_mm.unwrap_or(LEAST_BALL_MM);
        let hint = format!("the length of the teeth from the tip, as in {flute} = {}", 4.0 * ball);
        let flute = self.figure(flute, [ball, 1000.0], &hint);
        let hint = format!("the diameter above the teeth, as in {shank} = {}", 2.0 * ball);
        let shank = self.figure(shank, [LEAST_BALL_MM, 1000.0], &hint);
        let teeth = flute.map_or(ball, |flute| flute.value);
        let hint = format!(
            "from the tip to the holder, no less than the teeth, as in {stickout} = {}",
            teeth + 4.0 * ball
        );
        let stickout = self.figure(stickout, [teeth, 1000.0], &hint);
        let alone = [flute, shank, stickout].into_iter().flatten().next();
        if let (None, Some(found)) = (ball_mm, alone) {
            let message = "lengths of a cutter that roughs must go with program.rough_ball_mm, found them alone";
            let hint =
                "add rough_ball_mm, its radius; without it the cutter that finishes roughs too";
            self.reader.complain(found.at, message.to_owned(), hint);
        }
        let [flute_mm, shank_diameter_mm, stickout_mm] =
            [flute, shank, stickout].map(|found| found.map(|found| found.value));
        CutterLengths { flute_mm, shank_diameter_mm, stickout_mm }
    }

    fn speeds(&mut self, usual: SpeedsSpec) -> SpeedsSpec {
        let hint = "the cutter's teeth, as in teeth = 2";
        let is_count = |f: f64| (1.0..=8.0).contains(&f) && f.fract() == 0.0;
        let must = "a whole number from 1 to 8";
        let teeth = number(self.reader, self.section, "teeth", Optional, must, hint, is_count);
        let hint = "the feed of finishing, as in feed_mm_min = 800";
        let feed_mm_min = self.value("feed_mm_min", [1.0, 1e5], hint);
        let hint = "the feed of roughing, as in rough_feed_mm_min = 600";
        let rough_feed_mm_min = self.value("rough_feed_mm_min", [1.0, 1e5], hint);
        let hint = "the speed of the spindle, as in spindle_rpm = 12000";
        let spindle_rpm = self.value("spindle_rpm", [1.0, 1e6], hint);
        let teeth = teeth.map_or(usual.teeth, |teeth| teeth.value as u32);
        SpeedsSpec { teeth, feed_mm_min, rough_feed_mm_min, spindle_rpm }
    }

    fn machine(&mut self, usual: MachineSpec) -> MachineSpec {
        let hint = "the speed of rapid moves, as in rapid_mm_min = 5000";
        let rapid = self.value("rapid_mm_min", [10.0, 1e6], hint);
        let hint = "the machine's largest feed, as in max_feed_mm_min = 3000";
        let feed = self.value("max_feed_mm_min", [10.0, 1e6], hint);
        let hint = "the spindle's largest speed, as in max_spindle_rpm = 24000";
        let spindle = self.value("max_spindle_rpm", [10.0, 1e6], hint);
        let hint = "the acceleration of the axes, as in acceleration_mm_s2 = 500";
        let acceleration = self.value("acceleration_mm_s2", [1.0, 1e6], hint);
        let hint = "the height of rapid moves over the stock, as in safe_mm = 5";
        let safe = self.value("safe_mm", [0.1, 1000.0], hint);
        let hint = "the diameter of the holder or of its nut, as in holder_diameter_mm = 42";
        let holder = self.value("holder_diameter_mm", [0.1, 1000.0], hint);
        MachineSpec {
            rapid_mm_min: rapid.unwrap_or(usual.rapid_mm_min),
            max_feed_mm_min: feed.unwrap_or(usual.max_feed_mm_min),
            max_spindle_rpm: spindle.unwrap_or(usual.max_spindle_rpm),
            acceleration_mm_s2: acceleration.unwrap_or(usual.acceleration_mm_s2),
            travel_mm: self.travel(),
            safe_mm: safe.unwrap_or(usual.safe_mm),
            holder_diameter_mm: holder.unwrap_or(usual.holder_diameter_mm),
        }
    }

    fn travel(&mut self) -> Option<[f64; 3]> {
        if !self.section.has("travel_mm") {
            return None;
        }
        let format = NumbersFormat {
            key: "travel_mm",
            parts: "the machine's travels [X, Y, Z]",
            each: "a number from 1 to 100000",
            form: "as in travel_mm = [300, 200, 80]",
            limit: "how far the machine's axes travel",
        };
        let allowed = |mm: f64| (1.0..=1e5).contains(&mm);
        numbers(self.reader, self.section, &format, allowed).map(|found| found.value)
    }
}
