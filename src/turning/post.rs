//! Programs of lathes: the text of an operation as a control reads it.

use super::operation::TurnedOperation;
use crate::milling::{Pace, TipMove, blending, program_comment, program_number, rounded_number};
use crate::profile::{LatheControl, WorkOffset};
use std::fmt::Write;

/// Number of a Fanuc program, and of the tool.
const NUMBER: u32 = 1;
/// Feed over the nose's radius below which places have nanometres: moves are then so short that a tenth of a micrometre would tilt them by
/// a tenth of what the cusps are tilted. Controls of lathes that cut so fine read them; a Fanuc takes them for an error, unless it is
/// made for them.
const FINE_FEED: f64 = 0.02;
/// Decimals of a millimetre in usual programs and in those.
const DECIMALS: [usize; 2] = [4, 6];
/// Turns for which a tool is held in the axis: one, and a little.
const HELD_TURNS: f64 = 1.1;

/// What a program says before its moves.
pub struct LatheHeader<'a> {
    /// What the control reads.
    pub control: LatheControl,
    /// Offset of the zero point.
    pub work_offset: WorkOffset,
    /// Lines of comment: part, bar, zero, tool point.
    pub comments: &'a [String],
    /// How far a control may round corners, mm.
    pub rounding_mm: f64,
    /// Largest speed of the spindle, 1/min.
    pub max_spindle_rpm: f64,
}

/// The program of an operation: X as a diameter, feeds in a turn.
#[must_use]
pub fn lathe_program_text(header: &LatheHeader, operation: &TurnedOperation) -> String {
    let mut text = String::new();
    begin(&mut text, header, operation);
    let held = operation.is_held.then(|| operation.motions.len().saturating_sub(1));
    let is_fine = operation.feed_mm_rev < FINE_FEED * operation.nose_mm;
    let decimals = DECIMALS[usize::from(is_fine && header.control == LatheControl::Linuxcnc)];
    let mut writer = TurnWriter { place: [const { None }; 2], word: "", feed: None, decimals };
    for (k, motion) in operation.motions.iter().enumerate() {
        if held == Some(k) {
            let seconds = (6e3 * HELD_TURNS / operation.spindle_rpm).ceil() / 100.0;
            dwell(&mut text, header.control, seconds);
        }
        writer.write(&mut text, motion, operation.feed_mm_rev);
    }
    text.push_str("M5\n");
    text.push_str(match header.control {
        LatheControl::Linuxcnc => "M2\n",
        LatheControl::Fanuc => "M30\n%\n",
    });
    text
}

fn begin(text: &mut String, header: &LatheHeader, operation: &TurnedOperation) {
    let offset = header.work_offset.name();
    let safe = operation.motions.first().map_or(0.0, |motion| motion.to.z);
    let rpm = operation.spindle_rpm.round();
    if header.control == LatheControl::Fanuc {
        let _ = writeln!(text, "%\nO{NUMBER:04}");
    }
    for comment in header.comments {
        let _ = writeln!(text, "({})", program_comment(comment));
    }
    match header.control {
        LatheControl::Linuxcnc => {
            let _ = writeln!(text, "G21 G90 G18 G40 G80 G7 G95 {offset}");
            let _ = writeln!(text, "{}", blending(header.rounding_mm));
            let _ = writeln!(text, "T{NUMBER} M6\nG43");
        }
        LatheControl::Fanuc => {
            let _ = writeln!(text, "G21 G18 G40 G80 G99 {offset}");
            let _ = writeln!(text, "G50 S{}", header.max_spindle_rpm.round());
            let _ = writeln!(text, "T{NUMBER:02}{NUMBER:02}");
        }
    }
    let _ = writeln!(text, "G97 S{rpm} M3");
    // For the spindle to reach its speed.
    dwell(text, header.control, 2.0);
    let _ = writeln!(text, "G0 Z{}", program_number(safe));
}

/// A Fanuc takes P for milliseconds.
fn dwell(text: &mut String, control: LatheControl, seconds: f64) {
    let seconds = program_number(seconds);
    let _ = match control {
        LatheControl::Linuxcnc => writeln!(text, "G4 P{seconds}"),
        LatheControl::Fanuc => writeln!(text, "G4 X{seconds}"),
    };
}

/// Writes moves: words that are in force are left out.
struct TurnWriter {
    place: [Option<String>; 2],
    word: &'static str,
    feed: Option<f64>,
    decimals: usize,
}

impl TurnWriter {
    fn write(&mut self, text: &mut String, motion: &TipMove, feed_mm_rev: f64) {
        let is_rapid = motion.pace == Pace::Rapid;
        let word = if is_rapid { "G0" } else { "G1" };
        let mut words = Vec::new();
        if word != self.word {
            words.push(word.to_owned());
        }
        let before = words.len();
        let values = [("X", 2.0 * motion.to.x), ("Z", motion.to.z)];
        for ((letter, value), place) in values.into_iter().zip(&mut self.place) {
            let value = rounded_number(value, self.decimals);
            if place.as_ref() != Some(&value) {
                words.push(format!("{letter}{value}"));
                *place = Some(value);
            }
        }
        if words.len() == before {
            return;
        }
        self.word = word;
        if !is_rapid && self.feed != Some(feed_mm_rev) {
            self.feed = Some(feed_mm_rev);
            words.push(format!("F{feed_mm_rev}"));
        }
        let _ = writeln!(text, "{}", words.join(" "));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::DVec3;
    use crate::milling::OperationKind;

    fn text(control: LatheControl) -> String {
        text_of(control, [0.05, 0.001])
    }

    /// With a feed in a turn, and what a control may round corners by, mm.
    fn text_of(control: LatheControl, [feed_mm_rev, rounding_mm]: [f64; 2]) -> String {
        let at = |x: f64, z: f64, pace| TipMove { to: DVec3::new(x, 0.0, z), pace };
        let operation = TurnedOperation {
            kind: OperationKind::Finishing,
            nose_mm: 0.8,
            feed_mm_rev,
            spindle_rpm: 1200.0,
            levels: 1,
            allowance_mm: 0.0,
            is_held: true,
            motions: vec![
                at(32.0, 20.0, Pace::Rapid),
                at(32.0, 5.0, Pace::Rapid),
                at(30.0, 5.0, Pace::Cut),
                at(-0.8, 9.250004, Pace::Cut),
                at(-0.8, 20.0, Pace::Rapid),
            ],
        };
        let header = LatheHeader {
            control,
            work_offset: WorkOffset::FIRST,
            comments: &["part (naïve) 1".to_owned()],
            rounding_mm,
            max_spindle_rpm: 3000.0,
        };
        lathe_program_text(&header, &operation)
    }

    /// Feeds below a fiftieth of the nose's radius have places in nanometres, but for a Fanuc, and corners are never rounded by 0.
    #[test]
    fn fine_feeds_have_nanometres() {
        let fine = text_of(LatheControl::Linuxcnc, [0.005, 2e-5]);
        assert!(fine.contains("Z9.250004\n") && fine.contains("G64 P0.000020\n"), "{fine}");
        assert!(text_of(LatheControl::Fanuc, [0.005, 2e-5]).contains("Z9.25\n"));
        assert!(text_of(LatheControl::Linuxcnc, [0.02, 0.0]).contains("G64 P0.000001\n"));
    }

    /// A turn takes 0.05 s; the tool is held for a little more.
    #[test]
    fn x_is_a_diameter_and_the_tool_is_held_in_the_axis() {
        assert_eq!(
            text(LatheControl::Linuxcnc),
            "(PART NAVE 1)\nG21 G90 G18 G40 G80 G7 G95 G54\nG64 P0.0010\nT1 M6\nG43\nG97 S1200 M3\nG4 P2.\nG0 Z20.\n\
             G0 X64. Z20.\nZ5.\nG1 X60. F0.05\nX-1.6 Z9.25\nG4 P0.06\nG0 Z20.\nM5\nM2\n"
        );
        assert_eq!(
            text(LatheControl::Fanuc),
            "%\nO0001\n(PART NAVE 1)\nG21 G18 G40 G80 G99 G54\nG50 S3000\nT0101\nG97 S1200 M3\nG4 X2.\nG0 Z20.\n\
             G0 X64. Z20.\nZ5.\nG1 X60. F0.05\nX-1.6 Z9.25\nG4 X0.06\nG0 Z20.\nM5\nM30\n%\n"
        );
    }
}
