//! RS-274 text of a lathe to moves in a half-plane, with the turns that the spindle makes meanwhile.

use super::commanded::{CommandedAxis, SpindleTurn};
use super::lathe_words::LatheState;
use super::lines::each_line;
use super::modal::ControlState;
use super::reader::{LineWords, Vocabulary};
use super::{ProgramFault, ToolMove, ToolPath};

/// Most turns of the spindle on all moves: hours of the finest finishing.
const MOST_TURNS: f64 = 1e6;

/// The moves of a program of a lathe: X is the distance from the axis, Y is 0.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TurningPath {
    /// The moves of the tool point, with their feeds in mm/min; a dwell is one that ends where it begins.
    pub tool: ToolPath,
    /// Turns of the spindle in each move; 0 of rapid ones.
    pub turns: Vec<f64>,
    /// Where C is in each move; none of a spindle that turns freely, whose phase is that of its turns.
    pub commanded: Vec<SpindleTurn>,
}

impl TurningPath {
    /// The moves of a program of a lathe, or of a slow tool servo, whose spindle is an axis.
    ///
    /// Known are the words of [`ToolPath::read`] but for Y and J, and G7 and G8 (X as a diameter or a radius), G94 and G95 (feed a minute
    /// or in a turn), G96 and G97 (speed of the surface, limited by D, or of the spindle), and of Fanuc's system A, where X is a
    /// diameter, G98 and G99 (these feeds) and G50 S (the limit). Without any of these X is a radius, as LinuxCNC has it. I is the
    /// distance of a centre, never twice that. Of a program with C, an axis in degrees, G93 and G94 tell the times of moves; M3 and M4 are
    /// refused beside it.
    ///
    /// # Errors
    /// [`ProgramFault`] with the line of what is not known, or contradicts itself.
    pub fn read(bytes: &[u8]) -> Result<Self, ProgramFault> {
        let (mut turns, mut lathe) = (Vec::new(), LatheState::default());
        let (mut all, mut axis) = (0.0, CommandedAxis::default());
        let tool =
            each_line(bytes, ControlState::of_lathe(), Vocabulary::Lathe, |block, state, path| {
                let fault = |reason| ProgramFault::Line { line: block.line(), reason };
                // A lathe has no Y.
                state.place[1] = Some(0.0);
                let Some(words) = block.lathe() else { return Ok(()) };
                if words.is_limit && block.has_axes() {
                    return Err(fault(
                        "G50 with a place moves the origin, which no program here does".into(),
                    ));
                }
                lathe.update(words).map_err(fault)?;
                state.scale[0] = lathe.x_scale();
                let first = path.moves.len();
                block.run(state, &mut path.moves)?;
                if axis.take(block, words, (state, &lathe), (&mut *path, first)).map_err(fault)? {
                    turns.extend(axis.turns_from(turns.len()));
                } else {
                    let seconds = block.dwell().map(|x| lathe.dwell_s(words, x));
                    if let Some(seconds) = seconds {
                        hold(block, state, (&lathe, seconds), (path, &mut turns));
                    }
                    for step in &mut path.moves[turns.len().max(first)..] {
                        turns.push(turned(step, &lathe, state.unit_mm).map_err(fault)?);
                    }
                }
                all += turns[first..].iter().map(|turns| turns.abs()).sum::<f64>();
                if !(all <= MOST_TURNS) {
                    let reason =
                        format!("more than {MOST_TURNS:.0e} turns of the spindle up to here");
                    return Err(fault(reason));
                }
                Ok(())
            })?;
        Ok(Self { tool, turns, commanded: axis.finish() })
    }

    /// Whether the spindle is an axis that the program turns.
    #[must_use]
    pub fn is_commanded(&self) -> bool {
        !self.commanded.is_empty()
    }

    /// Time of the cutting moves, minutes; starts and stops take longer.
    #[must_use]
    pub fn cutting_min(&self) -> f64 {
        match self.is_commanded() {
            true => self.commanded.iter().map(|turn| turn.minutes).sum(),
            false => self.tool.cutting_min(),
        }
    }
}

/// Turns in a move, whose feed becomes one in mm/min.
fn turned(step: &mut ToolMove, lathe: &LatheState, unit_mm: f64) -> Result<f64, String> {
    let Some(feed) = step.feed else { return Ok(0.0) };
    if lathe.is_inverse_time {
        return Err("times of moves, G93, without C, the axis that they are for".into());
    }
    // At an even speed of the surface the time of a turn grows with the distance from the axis: in the mean it is that in the middle.
    let rpm = lathe.rpm(0.5 * (step.from.x + step.to.x), unit_mm)?;
    let length = step.from.distance(step.to);
    if lathe.is_per_turn {
        step.feed = Some(feed * rpm);
        Ok(length / feed)
    } else {
        Ok(length / feed * rpm)
    }
}

/// A dwell of so many seconds at a place that is known, after a feed move.
fn hold(
    block: &LineWords,
    state: &ControlState,
    (lathe, seconds): (&LatheState, f64),
    (path, turns): (&mut ToolPath, &mut Vec<f64>),
) {
    let Some(last) = path.moves.last().copied() else { return };
    let at = ControlState::known(state.place);
    if let (Some(feed), Some(at)) = (last.feed, at)
        && let Ok(rpm) = lathe.rpm(at.x, state.unit_mm)
    {
        path.moves.push(ToolMove { from: at, to: at, feed: Some(feed), line: block.line() });
        turns.push(seconds * rpm / 60.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::DVec3;

    fn read(text: &str) -> TurningPath {
        TurningPath::read(text.as_bytes()).unwrap_or_else(|error| panic!("{error}"))
    }

    fn refused(text: &str) -> String {
        TurningPath::read(text.as_bytes()).unwrap_err().to_string()
    }

    fn ends(path: &TurningPath) -> Vec<[f64; 2]> {
        path.tool.moves.iter().map(|step| [step.to.x, step.to.z]).collect()
    }

    /// The same moves, X as a diameter and as a radius, of three ways to write them.
    #[test]
    fn x_is_a_diameter_or_a_radius_as_the_words_tell() {
        let moves = "G0 X40 Z5\nG1 X30 F0.1\nX-1.6 Z6\n";
        let exact = [[15.0, 5.0], [-0.8, 6.0]];
        let diameter = read(&format!("G21 G18 G90 G7 G95 G97 S1000 M3\n{moves}M2\n"));
        assert_eq!(ends(&diameter), exact);
        let system_a = read(&format!("G99 G21\nG50 S3000\nG97 S1000 M3\n{moves}M30\n"));
        assert_eq!(ends(&system_a), exact);
        assert_eq!(system_a.turns, diameter.turns);
        let radius = "G0 X20 Z5\nG1 X15 F0.1\nX-0.8 Z6\n";
        for head in ["G8 G95 G97 S1000 M3", "G95 S1000 M3"] {
            let found = read(&format!("{head}\n{radius}"));
            assert_eq!((ends(&found), &found.turns), (exact.to_vec(), &diameter.turns));
        }
        let relative = read("G7 G95 G97 S1000 M3\nG0 X40 Z5\nG91 G1 X-10 F0.1\nX-31.6 Z1\n");
        for (found, exact) in ends(&relative).into_iter().zip(exact) {
            assert!((found[0] - exact[0]).abs() + (found[1] - exact[1]).abs() < 1e-12);
        }
    }

    /// 5 mm at 0.1 mm in a turn are 50 turns; at 1000/min they take 3 s, which is 100 mm/min. At 100 mm/min they are as many.
    #[test]
    fn feeds_in_a_turn_are_turns_and_millimetres_a_minute() {
        let found =
            read("G8 G95 G97 S1000 M3\nG0 X20 Z5\nG1 X15 F0.1\nG94 X10 F100\nG4 P1.5\nG0 Z9\n");
        let steps = [(Some(100.0), 50.0), (Some(100.0), 50.0), (Some(100.0), 25.0), (None, 0.0)];
        for ((step, turns), exact) in found.tool.moves.iter().zip(&found.turns).zip(steps) {
            assert_eq!(step.feed, exact.0);
            assert!((turns - exact.1).abs() < 1e-12, "{turns} {exact:?}");
        }
        assert_eq!(found.tool.moves.len(), 4);
        assert!((found.tool.cutting_min() - 6.0 / 60.0).abs() < 1e-12);
        // A dwell of system A: X is in seconds, P in milliseconds.
        let held = read("G99 G97 S600 M3\nG0 X20 Z5\nG1 X10 F0.1\nG4 X2.\nG4 P500\n");
        assert_eq!(&held.turns[1..], [20.0, 5.0]);
        assert_eq!(ends(&held), [[5.0, 5.0]; 3]);
    }

    /// At 100 m/min over 10 to 20 mm from the axis: the time is that of the integral, 2 pi x ds / (f v).
    #[test]
    fn an_even_speed_of_the_surface_slows_the_spindle_outside() {
        let found = read("G8 G95 G96 D3000 S100 M3\nG0 X20 Z5\nG1 X10 F0.1\nX0\n");
        let parts = 10_000;
        let seconds: f64 = (0..parts)
            .map(|k| {
                let x = 10.0 + 10.0 * (f64::from(k) + 0.5) / f64::from(parts);
                60.0 * (10.0 / f64::from(parts)) / 0.1 * std::f64::consts::TAU * x / 1e5
            })
            .sum();
        let step = &found.tool.moves[0];
        let told = 60.0 * 10.0 / step.feed.unwrap();
        assert!((told / seconds - 1.0).abs() < 1e-9, "{told} {seconds}");
        assert!((found.turns[0] - 100.0).abs() < 1e-9);
        // 100 m/min at 5 mm would be 3183/min.
        assert_eq!(found.tool.moves[1].feed, Some(300.0));
        assert!(
            refused("G8 G95 G96 S100 M3\nG0 X20 Z5\nG1 X10 F0.1\n").contains("without a limit")
        );
        assert!(refused("G8 G94 G96 D9 S100 M3\n").contains("G96, beside a feed a minute"));
    }

    /// Seen from +Y, with X up and Z to the right, G3 turns against the clock: from Z to X. The centre is at X 10, Z 0.
    #[test]
    fn arcs_turn_from_z_to_x_against_the_clock() {
        let head = "G7 G18 G95 G97 S100 M3\nG0 X20 Z5\nF0.1\n";
        for arc in ["G3 X30 Z0 K-5", "G3 X30 Z0 R5", "G3 X30 Z0 I0 K-5", "G90.1 G3 X30 Z0 I10 K0"] {
            let found = read(&format!("{head}{arc}"));
            for step in &found.tool.moves {
                let [x, z] = [step.to.x - 10.0, step.to.z];
                assert!(
                    (x * x + z * z - 25.0).abs() < 1e-9 && x > -1e-9 && z > -1e-9,
                    "{arc} {x} {z}"
                );
            }
            assert_eq!(found.tool.moves.last().unwrap().to, DVec3::new(15.0, 0.0, 0.0), "{arc}");
        }
        // G18 is in force from the beginning, and no other plane is.
        let whole = read(&format!("{head}G3 X30 Z0 K-5"));
        assert_eq!(read(&format!("{}G3 X30 Z0 K-5", head.replace("G18 ", ""))), whole);
        // Clockwise it takes the long way round.
        let clockwise = read(&format!("{head}G2 X30 Z0 K-5"));
        assert!(clockwise.tool.moves.iter().any(|step| step.to.x < 5.1));
        let turns: f64 = clockwise.turns.iter().sum();
        assert!((turns - 1.5 * std::f64::consts::PI * 5.0 / 0.1).abs() < 0.1, "{turns}");
    }

    #[test]
    fn what_no_lathe_reads_is_refused_by_line_and_name() {
        let start = "G8 G95 G97 S100 M3\nG0 X9 Z5\nF0.1\n";
        for (text, said) in [
            ("G1 Y1", "line 4: Y is no word that is known here"),
            (
                "G99",
                "line 4: words of Fanuc's system A after those of LinuxCNC and Fanuc's system B, which mean other things by them",
            ),
            (
                "M5\nG1 X5",
                "line 5: a cutting move while the spindle stands; M3 and an S word greater than 0 turn it",
            ),
            (
                "S0\nG1 X5",
                "line 5: a cutting move while the spindle stands; M3 and an S word greater than 0 turn it",
            ),
            ("G1 X5 F0", "line 4: a cutting move without a feed; an F word greater than 0 sets it"),
            ("G17 G3 X1 R90", "line 4: arcs of a lathe lie in the plane of X and Z, G18"),
            ("G19 G2 Z1 R90", "line 4: arcs of a lathe lie in the plane of X and Z, G18"),
            ("G33 Z1 K1", "line 4: G33 is no word that is known here"),
            ("G76 P1 Z1", "line 4: G76 is no word that is known here"),
            ("G1 X5 S1 S2", "line 4: S twice"),
            ("G1 X5 F.000001", "line 4: more than 1e6 turns of the spindle up to here"),
            ("G1 X5\nG4 P999999", "line 5: more than 1e6 turns of the spindle up to here"),
            (
                "G1 X5\nG50 X9 S100",
                "line 5: G50 with a place moves the origin, which no program here does",
            ),
        ] {
            assert_eq!(refused(&format!("{start}{text}")), said);
        }
        // A mill knows none of these.
        let mill = |text: &str| ToolPath::read(text.as_bytes()).unwrap_err().to_string();
        for word in ["G7", "G95", "G96", "G99", "G50"] {
            assert_eq!(mill(word), format!("line 1: {word} is no word that is known here"));
        }
    }
}
