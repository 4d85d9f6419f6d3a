//! Programs of slow tool servos: an operation as a control reads it, or as a table of points.

use super::servo_task::ServoOperation;
use crate::milling::{blending, program_comment};
use crate::profile::{ServoControl, WorkOffset};
use std::fmt::Write;

/// What a program says before its points.
pub struct ServoHeader<'a> {
    /// What the control reads.
    pub control: ServoControl,
    /// Offset of the zero point.
    pub work_offset: WorkOffset,
    /// Lines of comment: part, bar, zero, tool point.
    pub comments: &'a [String],
    /// How far a control may round corners, mm.
    pub rounding_mm: f64,
    /// Height of fast moves, mm.
    pub safe_mm: f64,
}

/// The program of an operation: X as a radius, C in degrees that only grow, an even time for each move.
#[must_use]
pub fn servo_program_text(header: &ServoHeader, operation: &ServoOperation) -> String {
    match header.control {
        ServoControl::Linuxcnc => linuxcnc(header, operation),
        ServoControl::Xzc => table(header, operation),
    }
}

fn linuxcnc(header: &ServoHeader, operation: &ServoOperation) -> String {
    let mut text = String::new();
    for comment in header.comments {
        let _ = writeln!(text, "({})", program_comment(comment));
    }
    let _ = writeln!(text, "G21 G90 G18 G40 G80 G8 G94 {}", header.work_offset.name());
    let _ = writeln!(text, "{}", blending(header.rounding_mm));
    text.push_str("T1 M6\nG43\n");
    let _ = writeln!(text, "G0 Z{}", length(header.safe_mm));
    let per_turn = operation.table.per_turn;
    // A turn takes 1 / rpm minutes, and F of G93 is how many moves go into one.
    let moves_a_minute = trimmed(format!("{:.4}", operation.rpm * per_turn as f64));
    let mut before = None;
    for (k, at) in operation.table.points.iter().enumerate() {
        let (place, c) = ([length(at.x), length(at.y)], degrees(k, per_turn));
        let [x, z] = &place;
        let is_new =
            |axis: usize| before.as_ref().is_none_or(|b: &[String; 2]| b[axis] != place[axis]);
        match k {
            0 => {
                let _ = writeln!(text, "G0 X{x} C{c}\nG0 Z{z}\nG93");
            }
            _ => {
                let x = if is_new(0) { format!(" X{x}") } else { String::new() };
                let z = if is_new(1) { format!(" Z{z}") } else { String::new() };
                let _ = writeln!(text, "G1{x}{z} C{c} F{moves_a_minute}");
            }
        }
        before = Some(place);
    }
    text.push_str("G94\nM2\n");
    text
}

fn table(header: &ServoHeader, operation: &ServoOperation) -> String {
    let mut text = String::from("# XZC point table\n");
    for comment in header.comments {
        let _ = writeln!(text, "# {comment}");
    }
    let per_turn = operation.table.per_turn;
    let _ = writeln!(text, "# nose_mm {}", operation.nose_mm);
    let _ = writeln!(text, "# feed_mm_rev {}", operation.feed_mm_rev);
    let _ = writeln!(text, "# points_rev {per_turn}");
    let _ = writeln!(text, "# spindle_rpm {}", operation.rpm);
    text.push_str("# X as a radius and Z in mm, C in degrees\nX Z C\n");
    for (k, at) in operation.table.points.iter().enumerate() {
        let [x, z] = at.to_array().map(|mm| if mm == 0.0 { 0.0 } else { mm });
        let _ = writeln!(text, "{x:.6} {z:.6} {}", degrees(k, per_turn));
    }
    text
}

/// Degrees of C at a point.
fn degrees(k: usize, per_turn: usize) -> String {
    trimmed(format!("{:.4}", 360.0 * k as f64 / per_turn as f64))
}

/// A length with its point, to a nanometre: coarser steps would shake the axes.
fn length(mm: f64) -> String {
    trimmed(format!("{mm:.6}"))
}

fn trimmed(text: String) -> String {
    let text = text.trim_end_matches('0');
    if text == "-0." { "0.".to_owned() } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::DVec2;
    use crate::milling::OperationKind;
    use crate::turning::{PointTable, ServoLimit};

    fn text(control: ServoControl) -> String {
        let points = [(12.0, 9.0), (12.0, 5.25), (11.5, 5.25), (-0.8, 5.0000007)];
        let operation = ServoOperation {
            kind: OperationKind::Finishing,
            nose_mm: 0.8,
            feed_mm_rev: 0.05,
            levels: 1,
            allowance_mm: 0.0,
            table: PointTable {
                points: points.map(|(x, z)| DVec2::new(x, z)).into(),
                per_turn: 576,
            },
            rpm: 120.0,
            limit: ServoLimit::Spindle,
        };
        let header = ServoHeader {
            control,
            work_offset: WorkOffset::FIRST,
            comments: &["part (naïve) 1".to_owned()],
            rounding_mm: 0.001,
            safe_mm: 20.0,
        };
        servo_program_text(&header, &operation)
    }

    /// 576 points of a turn at 120 turns a minute are 69120 moves a minute.
    #[test]
    fn moves_have_their_time_and_c_only_grows() {
        assert_eq!(
            text(ServoControl::Linuxcnc),
            "(PART NAVE 1)\nG21 G90 G18 G40 G80 G8 G94 G54\nG64 P0.0010\nT1 M6\nG43\nG0 Z20.\nG0 X12. C0.\nG0 Z9.\nG93\n\
             G1 Z5.25 C0.625 F69120.\nG1 X11.5 C1.25 F69120.\nG1 X-0.8 Z5.000001 C1.875 F69120.\nG94\nM2\n"
        );
        assert_eq!(
            text(ServoControl::Xzc),
            "# XZC point table\n# part (naïve) 1\n# nose_mm 0.8\n# feed_mm_rev 0.05\n# points_rev 576\n# spindle_rpm 120\n\
             # X as a radius and Z in mm, C in degrees\nX Z C\n12.000000 9.000000 0.\n12.000000 5.250000 0.625\n\
             11.500000 5.250000 1.25\n-0.800000 5.000001 1.875\n"
        );
    }
}
