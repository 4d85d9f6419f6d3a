//! Programs: the text of an operation as a control reads it.

use super::motions::TipMove;
use super::operation::Operation;
use crate::profile::{MillControl, WorkOffset};
use std::fmt::Write;

/// Decimals of a millimetre: a tenth of a micrometre, which all three controls read.
const DECIMALS: usize = 4;
/// Longest comment, bytes: grbl reads lines of 80.
const LONGEST: usize = 70;
/// Number of a Fanuc program, and of the tool.
const NUMBER: u32 = 1;

/// What a program says before its moves.
pub struct Header<'a> {
    /// What the control reads.
    pub control: MillControl,
    /// Offset of the zero point.
    pub work_offset: WorkOffset,
    /// Lines of comment: part, stock, zero.
    pub comments: &'a [String],
    /// How far a control may round corners, mm.
    pub rounding_mm: f64,
}

/// The program of an operation.
#[must_use]
pub fn program_text(header: &Header, operation: &Operation) -> String {
    let mut text = String::new();
    begin(&mut text, header, operation);
    let mut writer = MoveWriter { place: [const { None }; 3], word: "", feed: None };
    for motion in &operation.motions {
        writer.write(&mut text, motion, operation);
    }
    text.push_str("M5\n");
    text.push_str(match header.control {
        MillControl::Linuxcnc | MillControl::Grbl => "M2\n",
        MillControl::Fanuc => "M30\n%\n",
    });
    text
}

fn begin(text: &mut String, header: &Header, operation: &Operation) {
    let offset = header.work_offset.name();
    let safe = operation.motions.first().map_or(0.0, |motion| motion.to.z);
    if header.control == MillControl::Fanuc {
        let _ = writeln!(text, "%\nO{NUMBER:04}");
    }
    for comment in header.comments {
        let _ = writeln!(text, "({})", program_comment(comment));
    }
    let _ = writeln!(text, "G21 G90 G17 G40 G80 G94 {offset}");
    match header.control {
        MillControl::Linuxcnc => {
            let _ = writeln!(text, "{}", blending(header.rounding_mm));
            let _ = writeln!(text, "T{NUMBER} M6\nG43 H{NUMBER}");
        }
        MillControl::Fanuc => {
            let _ = writeln!(text, "T{NUMBER} M6\nG43 H{NUMBER} G0 Z{}", program_number(safe));
        }
        MillControl::Grbl => {}
    }
    // Two seconds for the spindle; a Fanuc takes P for milliseconds.
    let dwell = if header.control == MillControl::Fanuc { "X2." } else { "P2" };
    let _ = writeln!(text, "S{} M3\nG4 {dwell}", operation.speeds.spindle_rpm.round());
    let _ = writeln!(text, "G0 Z{}", program_number(safe));
}

/// A comment as controls read it: letters, figures and plain marks, in capitals.
#[must_use]
pub fn program_comment(comment: &str) -> String {
    let is_plain = |c: &char| c.is_ascii_alphanumeric() || " .,:+-/=".contains(*c);
    let kept: String = comment.chars().filter(is_plain).take(LONGEST).collect();
    kept.to_ascii_uppercase()
}

/// A number with its point, which a Fanuc needs to read millimetres.
#[must_use]
pub fn program_number(value: f64) -> String {
    rounded_number(value, DECIMALS)
}

/// The same in so many decimals.
#[must_use]
pub fn rounded_number(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let text = text.trim_end_matches('0');
    if text == "-0." { "0.".to_owned() } else { text.to_owned() }
}

/// LinuxCNC's word for rounding corners by so much, mm: never 0, which lets it round them as it likes.
#[must_use]
pub fn blending(rounding_mm: f64) -> String {
    /// The least that four decimals tell.
    const COARSE_MM: f64 = 1e-4;
    match rounding_mm < COARSE_MM {
        true => format!("G64 P{:.6}", rounding_mm.max(1e-6)),
        false => format!("G64 P{rounding_mm:.4}"),
    }
}

/// Writes moves: words that are in force are left out.
struct MoveWriter {
    place: [Option<String>; 3],
    word: &'static str,
    feed: Option<f64>,
}

impl MoveWriter {
    fn write(&mut self, text: &mut String, motion: &TipMove, operation: &Operation) {
        let TipMove { to, pace } = *motion;
        let feed = operation.speeds.feed_of(pace);
        let word = if feed.is_some() { "G1" } else { "G0" };
        let mut words = Vec::new();
        if word != self.word {
            words.push(word.to_owned());
        }
        let before = words.len();
        for (axis, (value, place)) in to.to_array().into_iter().zip(&mut self.place).enumerate() {
            let value = program_number(value);
            if place.as_ref() != Some(&value) {
                words.push(format!("{}{value}", ["X", "Y", "Z"][axis]));
                *place = Some(value);
            }
        }
        if words.len() == before {
            return;
        }
        self.word = word;
        if feed.is_some() && feed != self.feed {
            self.feed = feed;
            words.extend(feed.map(|feed| format!("F{feed}")));
        }
        let _ = writeln!(text, "{}", words.join(" "));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Cutter, DVec3};
    use crate::milling::{OperationKind, Pace, Speeds};
    use crate::profile::CutterLengths;

    fn operation() -> Operation {
        let at = |x: f64, z: f64, pace| TipMove { to: DVec3::new(x, -0.00001, z), pace };
        Operation {
            kind: OperationKind::Finishing,
            cutter: Cutter::ball(3.0),
            lengths: CutterLengths::default(),
            stepover_mm: 0.3,
            levels: 1,
            allowance_mm: 0.0,
            speeds: Speeds { spindle_rpm: 11000.0, feed_mm_min: 900.0, entry_feed_mm_min: 300.0 },
            motions: vec![
                at(1.0, 20.0, Pace::Rapid),
                at(1.0, 5.0, Pace::Rapid),
                at(1.0, 2.5, Pace::Entry),
                at(2.0, 2.5, Pace::Cut),
                at(2.00001, 2.5, Pace::Cut),
                at(3.0, 2.25, Pace::Cut),
                at(3.0, 20.0, Pace::Rapid),
            ],
        }
    }

    fn text(control: MillControl) -> String {
        let header = Header {
            control,
            work_offset: WorkOffset::ALL[0],
            comments: &["part (naïve) 1".to_owned()],
            rounding_mm: 0.001,
        };
        program_text(&header, &operation())
    }

    #[test]
    fn words_in_force_are_left_out_and_numbers_have_their_point() {
        let moves =
            "G0 Z20.\nG0 X1. Y0. Z20.\nZ5.\nG1 Z2.5 F300\nX2. F900\nX3. Z2.25\nG0 Z20.\nM5\n";
        let grbl = text(MillControl::Grbl);
        assert_eq!(
            grbl,
            format!("(PART NAVE 1)\nG21 G90 G17 G40 G80 G94 G54\nS11000 M3\nG4 P2\n{moves}M2\n")
        );
        let linuxcnc = text(MillControl::Linuxcnc);
        assert!(linuxcnc.contains("\nG64 P0.0010\nT1 M6\nG43 H1\n") && linuxcnc.ends_with("M2\n"));
        let fanuc = text(MillControl::Fanuc);
        assert!(fanuc.starts_with("%\nO0001\n(PART") && fanuc.ends_with("M30\n%\n"));
        assert!(fanuc.contains("G43 H1 G0 Z20.\n") && fanuc.contains("G4 X2.\n"));
    }
}
