//! How the mirror is milled or turned: `[program]`.

use super::super::Layout;
use super::super::program::{
    CutterLengths, FinishingSpec, MachineSpec, MillSpec, ProgramSpec, RoughingSpec, SpeedsSpec,
};
use super::super::program_words::{MillControl, ProgramControl};
use super::super::reader::Need::Optional;
use super::super::reader::{ProfileReader, Section};
use super::super::servo::ServoSpec;
use super::super::turning::TurnSpec;
use super::super::values::{Located, number, word};
use super::program_table::{self, ForeignControl, ProgramTable};
use super::rough_cutter::LEAST_BALL_MM;
use super::{servo, turning};

/// `[program]` of a mirror with this layout, if that is known; a mill's usual values where there is none.
pub(super) fn read(
    reader: &mut ProfileReader,
    root: &Section,
    layout: Option<&Layout>,
) -> ProgramSpec {
    let usual = ProgramSpec::default();
    let Some(section) = reader.section(root, "program", Optional) else { return usual };
    let machines =
        [("mill3", MachineKind::Mill), ("turn", MachineKind::Turn), ("sts", MachineKind::Servo)];
    let hint = "a mill of three axes, a lathe for mirrors that are round, or a slow tool servo for discs of any shape";
    let kind = word(reader, &section, "machine", &machines, hint).unwrap_or(MachineKind::Mill);
    kind.refuse_others(reader, &section);
    match kind {
        MachineKind::Mill => ProgramSpec::Mill(mill(reader, &section, layout)),
        MachineKind::Turn => {
            turning::suits(reader, &section, layout);
            let control = turning::control(reader, &section);
            ProgramSpec::Turn(turning::read(reader, &section, TurnSpec::default()), control)
        }
        MachineKind::Servo => {
            servo::suits(reader, &section, layout);
            let axis = servo::read(reader, &section);
            ProgramSpec::Servo(turning::read(reader, &section, ServoSpec::lathe()), axis)
        }
    }
}

/// A machine that has keys of its own.
#[derive(Clone, Copy, PartialEq, Eq)]
enum MachineKind {
    Mill,
    Turn,
    Servo,
}

/// Keys that only a mill has.
const MILL_KEYS: &[&str] = &[
    "ball_mm",
    "path",
    "stepover_mm",
    "angle_deg",
    "flute_mm",
    "shank_diameter_mm",
    "stickout_mm",
    "rough_ball_mm",
    "rough_radius_mm",
    "rough_corner_mm",
    "rough_flute_mm",
    "rough_shank_diameter_mm",
    "rough_stickout_mm",
    "teeth",
    "feed_mm_min",
    "rough_feed_mm_min",
    "max_feed_mm_min",
    "holder_diameter_mm",
];
/// Keys that only a lathe has.
const LATHE_KEYS: &[&str] =
    &["nose_mm", "inner_edge_deg", "outer_edge_deg", "feed_mm_rev", "rough_feed_mm_rev"];

/// Keys that only a slow tool servo has.
const SERVO_KEYS: &[&str] = &["clearance_deg"];

impl MachineKind {
    /// Complains of keys of other machines.
    fn refuse_others(self, reader: &mut ProfileReader, section: &Section) {
        let lathe = "a lathe has nose_mm and feed_mm_rev";
        let (own, instead) = match self {
            Self::Mill => ("a mill", "a mill has ball_mm and stepover_mm"),
            Self::Turn => ("a lathe", lathe),
            Self::Servo => ("a slow tool servo", "it has nose_mm and feed_mm_rev"),
        };
        let foreign: &[(&[&str], &str)] = match self {
            Self::Mill => &[(LATHE_KEYS, "turn"), (SERVO_KEYS, "sts")],
            Self::Turn => &[(MILL_KEYS, "mill3"), (SERVO_KEYS, "sts")],
            Self::Servo => &[(MILL_KEYS, "mill3")],
        };
        let must = format!("left out of programs for {own}");
        for (key, other) in
            foreign.iter().flat_map(|(keys, other)| keys.iter().map(move |key| (key, other)))
        {
            let Some(value) = reader.value(section, key, Optional, &must, "") else { continue };
            let found = reader.quote_type(value);
            let message = format!("program.{key} must be {must}, found {found}");
            let hint = format!("{key} goes with machine = \"{other}\"; {instead}");
            reader.complain(value.span().start, message, &hint);
        }
    }
}

/// What no mill reads.
const FOREIGN: &[ForeignControl] = &[(
    ProgramControl::Xzc,
    "\"linuxcnc\", \"grbl\" or \"fanuc\" for a mill",
    "a table of points in X, Z and C is that of a slow tool servo; it goes with machine = \"sts\"",
)];

fn mill(reader: &mut ProfileReader, section: &Section, layout: Option<&Layout>) -> MillSpec {
    let usual = MillSpec::default();
    let controls = MillControl::ALL.map(|control| (control.name(), control));
    let hint = "what the mill's control reads";
    let control = program_table::control((reader, section), &controls, FOREIGN, hint);
    let mut table = ProgramTable { reader, section };
    MillSpec {
        material: table.material().unwrap_or(usual.material),
        control: control.unwrap_or(usual.control),
        work_offset: table.work_offset().unwrap_or(usual.work_offset),
        stock_mm: table.stock().unwrap_or(usual.stock_mm),
        finishing: table.finishing(usual.finishing, layout),
        roughing: table.roughing(usual.roughing),
        speeds: table.speeds(usual.speeds),
        machine: table.machine(usual.machine),
    }
}

/// Keys of the lengths of a cutter: teeth, shank, out of the holder.
const FINISHING_LENGTHS: [&str; 3] = ["flute_mm", "shank_diameter_mm", "stickout_mm"];
const ROUGHING_LENGTHS: [&str; 3] =
    ["rough_flute_mm", "rough_shank_diameter_mm", "rough_stickout_mm"];

/// What a mill alone has.
impl ProgramTable<'_, '_, '_, '_> {
    fn finishing(&mut self, usual: FinishingSpec, layout: Option<&Layout>) -> FinishingSpec {
        let hint = "the radius of the ball, as in ball_mm = 3";
        let ball_mm = self.value("ball_mm", [LEAST_BALL_MM, 1000.0], hint).unwrap_or(usual.ball_mm);
        let path = self.finishing_path(layout).unwrap_or(usual.path);
        let hint = "from line to line of finishing, as in stepover_mm = 0.3";
        let stepover = self.figure("stepover_mm", [1e-3, 100.0], hint);
        if let Some(Located { value, at }) = stepover.filter(|mm| mm.value >= 2.0 * ball_mm) {
            let message = format!(
                "program.stepover_mm must be less than the ball's diameter of {} mm, found {value}",
                2.0 * ball_mm
            );
            self.reader.complain(at, message, hint);
        }
        let (scallop_um, budget_px) = (self.scallop(), self.budget());
        let hint = "the direction of the lines from X towards Y, as in angle_deg = 90";
        let angle_deg = self.value("angle_deg", [-180.0, 180.0], hint);
        let chord_um = self.chord().unwrap_or(usual.chord_um);
        let polish_um = self.polish();
        let stepover_mm = stepover.map(|mm| mm.value);
        FinishingSpec {
            ball_mm,
            path,
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
        let cutter = self.rough_cutter();
        let (allowance, stepdown_mm) = (self.allowance(), self.stepdown());
        RoughingSpec {
            cutter,
            allowance_mm: allowance.unwrap_or(usual.allowance_mm),
            stepdown_mm,
            // Teeth are no shorter than the rounded edge.
            lengths: self.lengths(
                ROUGHING_LENGTHS,
                cutter.map(|cutter| cutter.corner_mm.max(LEAST_BALL_MM)),
            ),
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
        let spindle_rpm = self.spindle(12_000);
        let teeth = teeth.map_or(usual.teeth, |teeth| teeth.value as u32);
        SpeedsSpec { teeth, feed_mm_min, rough_feed_mm_min, spindle_rpm }
    }

    fn machine(&mut self, usual: MachineSpec) -> MachineSpec {
        let [rapid, spindle, acceleration, safe] = self.axes(24_000);
        let hint = "the machine's largest feed, as in max_feed_mm_min = 3000";
        let feed = self.value("max_feed_mm_min", [10.0, 1e6], hint);
        let hint = "the diameter of the holder or of its nut, as in holder_diameter_mm = 42";
        let holder = self.value("holder_diameter_mm", [0.1, 1000.0], hint);
        MachineSpec {
            rapid_mm_min: rapid.unwrap_or(usual.rapid_mm_min),
            max_feed_mm_min: feed.unwrap_or(usual.max_feed_mm_min),
            max_spindle_rpm: spindle.unwrap_or(usual.max_spindle_rpm),
            acceleration_mm_s2: acceleration.unwrap_or(usual.acceleration_mm_s2),
            jerk_mm_s3: self.jerk(),
            travel_mm: self
                .travel(["the machine's travels [X, Y, Z]", "as in travel_mm = [300, 200, 80]"]),
            safe_mm: safe.unwrap_or(usual.safe_mm),
            holder_diameter_mm: holder.unwrap_or(usual.holder_diameter_mm),
        }
    }
}
