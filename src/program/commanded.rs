//! A spindle that is an axis, C: where it is in each move, and how long the move takes.

use super::lathe_words::{LatheState, LatheWords};
use super::modal::{ControlState, Motion};
use super::reader::LineWords;
use super::{ToolMove, ToolPath};

/// Where a commanded spindle is in a move, and the move's time.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SpindleTurn {
    /// Turns of C at its beginning.
    pub begin: f64,
    /// Turns of C at its end.
    pub end: f64,
    /// Minutes that it takes; 0 of a rapid one, whose time is the machine's.
    pub minutes: f64,
}

impl SpindleTurn {
    /// Turns of C in it, negative of one that turns back.
    #[must_use]
    pub fn turns(&self) -> f64 {
        self.end - self.begin
    }
}

/// C in the course of a program.
#[derive(Debug, Default)]
pub(super) struct CommandedAxis {
    /// Where C is, degrees; none before a line has told it.
    degrees: Option<f64>,
    /// Turns of the first cutting move that turns: all others go the same way.
    way: Option<f64>,
    turns: Vec<SpindleTurn>,
}

impl CommandedAxis {
    /// Takes in a line whose moves are those of the path from `first` on; whether the spindle is commanded.
    ///
    /// # Errors
    /// The reason why the line tells no moves of an axis.
    pub(super) fn take(
        &mut self,
        block: &LineWords,
        words: &LatheWords,
        (state, lathe): (&ControlState, &LatheState),
        (path, first): (&mut ToolPath, usize),
    ) -> Result<bool, String> {
        if words.angle.is_none() && self.degrees.is_none() {
            return Ok(false);
        }
        if lathe.is_turning() {
            return Err("C, an axis, while the spindle turns freely by M3 or M4".into());
        }
        if self.degrees.is_none() && path.moves[..first].iter().any(|step| step.feed.is_some()) {
            return Err("C after cutting moves without it".into());
        }
        let from = self.degrees;
        let to = match (words.angle, from) {
            (Some(by), Some(from)) if state.is_relative => from + by,
            (Some(_), None) if state.is_relative => {
                return Err("a relative move in C, whose place no line before has told".into());
            }
            (Some(at), _) => at,
            (None, Some(from)) => from,
            (None, None) => return Ok(false),
        };
        self.degrees = Some(to);
        // Rapid moves before C is told are where it begins.
        let begin = SpindleTurn { begin: to / 360.0, end: to / 360.0, minutes: 0.0 };
        self.turns.resize(first.max(self.turns.len()), begin);
        let is_feed = state.motion == Some(Motion::Feed) && !block.is_command();
        if path.moves.len() == first && is_feed && words.angle.is_some() && from != Some(to) {
            let at = ControlState::known(state.place)
                .ok_or("a turn of C before lines have told X and Z of its place")?;
            state.cutting_feed(block.line()).map_err(|_| "a turn of C without a feed")?;
            path.moves.push(ToolMove { from: at, to: at, feed: Some(0.0), line: block.line() });
        }
        let Some(from) = from.or_else(|| path.moves[first..].is_empty().then_some(to)) else {
            if path.moves[first..].iter().any(|step| step.feed.is_some()) {
                return Err("a cutting move before a line has told where C begins".into());
            }
            self.turns.resize(path.moves.len(), begin);
            return Ok(true);
        };
        self.share(block, (state, lathe), &mut path.moves[first..], [from, to])?;
        Ok(true)
    }

    /// Shares a line's way of C, degrees, and its time among its moves, by their lengths.
    fn share(
        &mut self,
        block: &LineWords,
        (state, lathe): (&ControlState, &LatheState),
        moves: &mut [ToolMove],
        [from, to]: [f64; 2],
    ) -> Result<(), String> {
        let whole: f64 = moves.iter().map(|step| step.from.distance(step.to)).sum();
        let is_cut = moves.iter().any(|step| step.feed.is_some());
        let minutes = match is_cut {
            true => minutes(block, (state, lathe), whole, (to - from).abs())?,
            false => 0.0,
        };
        if is_cut && to != from {
            let way = *self.way.get_or_insert(to - from);
            if way * (to - from) < 0.0 {
                return Err(format!(
                    "C turns back from {from} to {to} degrees, but a tool cuts in one direction"
                ));
            }
        }
        let mut before = 0.0;
        for step in moves {
            let length = step.from.distance(step.to);
            let part = if whole > 0.0 { length / whole } else { 1.0 };
            let at = |share: f64| (from + (to - from) * share) / 360.0;
            let after = if whole > 0.0 { (before + part).min(1.0) } else { 1.0 };
            let turn = SpindleTurn { begin: at(before), end: at(after), minutes: minutes * part };
            if step.feed.is_some() {
                step.feed = Some(if length > 0.0 { length / turn.minutes } else { 0.0 });
            }
            self.turns.push(turn);
            before = after;
        }
        Ok(())
    }

    /// Turns in each cutting move from number `first` on; 0 of rapid ones.
    pub(super) fn turns_from(&self, first: usize) -> impl Iterator<Item = f64> + '_ {
        let is_cut = |turn: &SpindleTurn| turn.minutes > 0.0;
        let all = self.turns.iter().skip(first);
        all.map(move |turn| if is_cut(turn) { turn.turns() } else { 0.0 })
    }

    /// C of all moves.
    pub(super) fn finish(self) -> Vec<SpindleTurn> {
        self.turns
    }
}

/// Minutes of a line's cutting moves, which are so long, mm, and turn C by so much, degrees.
fn minutes(
    block: &LineWords,
    (state, lathe): (&ControlState, &LatheState),
    length_mm: f64,
    degrees: f64,
) -> Result<f64, String> {
    if lathe.is_inverse_time {
        let feed = block.feed().filter(|feed| *feed > 0.0);
        return feed.map(f64::recip).ok_or_else(|| {
            "a cutting move in G93 without its F, the inverse of its minutes".to_owned()
        });
    }
    if lathe.is_per_turn {
        return Err("a feed in a turn beside C, which does not turn by itself; G93 or G94".into());
    }
    let feed = state.cutting_feed(block.line()).map_err(|fault| fault.to_string())?;
    // C alone goes so many degrees a minute, whatever the unit of lengths.
    Ok(if length_mm > 0.0 { length_mm / feed } else { degrees * state.unit_mm / feed })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::TurningPath;

    fn read(text: &str) -> TurningPath {
        TurningPath::read(text.as_bytes()).unwrap_or_else(|error| panic!("{error}"))
    }

    fn refused(text: &str) -> String {
        TurningPath::read(text.as_bytes()).unwrap_err().to_string()
    }

    /// At F120 a move takes half a second; 6 mm at 120 mm/min take three, and 90 degrees alone at 180 degrees a minute take thirty.
    #[test]
    fn moves_of_c_have_their_places_and_times() {
        let found = read(
            "G21 G90 G8\nG0 Z9\nG0 X12 C0\nG0 Z5\nG93\nG1 X11.5 C90 F120\nG1 C180 F120\nG94 G1 X5.5 C200 F120\nG1 C290 F180\n             G91 X-1 C10\nG90 G0 Z9\nM2\n",
        );
        let exact = [
            (None, 0.0, 0.0, 0.0),
            (Some(60.0), 0.0, 0.25, 0.5),
            (Some(0.0), 0.25, 0.5, 0.5),
            (Some(120.0), 0.5, 200.0 / 360.0, 3.0),
            (Some(0.0), 200.0 / 360.0, 290.0 / 360.0, 30.0),
            (Some(180.0), 290.0 / 360.0, 300.0 / 360.0, 1.0 / 3.0),
            (None, 300.0 / 360.0, 300.0 / 360.0, 0.0),
        ];
        assert_eq!(found.tool.moves.len(), exact.len());
        let moves = found.tool.moves.iter().zip(&found.commanded).zip(&found.turns);
        for (((step, turn), turns), (feed, begin, end, seconds)) in moves.zip(exact) {
            assert_eq!(step.feed.is_some(), feed.is_some());
            assert!((step.feed.unwrap_or(0.0) - feed.unwrap_or(0.0)).abs() < 1e-9, "{step:?}");
            let off = [turn.begin - begin, turn.end - end, 60.0 * turn.minutes - seconds];
            assert!(off.iter().all(|off| off.abs() < 1e-12), "{turn:?}");
            assert!((turns - if feed.is_some() { end - begin } else { 0.0 }).abs() < 1e-12);
        }
        assert!((60.0 * found.cutting_min() - 34.0 - 1.0 / 3.0).abs() < 1e-9);
        // An arc shares its way of C by length.
        let arc = read("G90 G18 G8 G93\nG0 X10 Z0 C0\nG2 X0 Z10 I-10 K0 C180 F1\n");
        let last = arc.commanded[arc.commanded.len() - 1];
        assert!((last.end - 0.5).abs() < 1e-12 && (arc.cutting_min() - 1.0).abs() < 1e-12);
        let middle = arc.commanded[arc.commanded.len() / 2];
        assert!((middle.begin - 0.25).abs() < 0.01, "{middle:?}");
    }

    #[test]
    fn what_no_axis_does_is_refused_by_line() {
        let start = "G8 G93\nG0 X9 Z5 C0\n";
        for (text, said) in [
            ("G1 X8 C5", "line 3: a cutting move without a feed; an F word greater than 0 sets it"),
            (
                "G1 X8 C5 F9\nX7 C9",
                "line 4: a cutting move in G93 without its F, the inverse of its minutes",
            ),
            (
                "G1 X8 C5 F9\nX7 C4 F9",
                "line 4: C turns back from 5 to 4 degrees, but a tool cuts in one direction",
            ),
            (
                "G95 G1 X8 C5 F9",
                "line 3: a feed in a turn beside C, which does not turn by itself; G93 or G94",
            ),
            (
                "S9 M3\nG1 X8 C5 F9",
                "line 3: C, an axis, while the spindle turns freely by M3 or M4",
            ),
            ("G1 C5 C6 F9", "line 3: C twice"),
            ("G1 C999999999 F9", "line 3: C is beyond any machine"),
        ] {
            assert_eq!(refused(&format!("{start}{text}\n")), said);
        }
        assert_eq!(
            refused("G8 G94 G97 S9 M3\nG0 X9 Z5\nG1 X8 F9\nM5\nG1 X7 C5\n"),
            "line 5: C after cutting moves without it"
        );
        assert_eq!(
            refused("G0 X9 Z5\nG93 G1 X8 C5 F9\n"),
            "line 2: a cutting move before a line has told where C begins"
        );
        assert_eq!(
            refused("G0 X9 Z5\nG91 G0 C5\n"),
            "line 2: a relative move in C, whose place no line before has told"
        );
        assert_eq!(
            refused("G97 S9 M3 G93\nG0 X9 Z5\nG1 X8 F9\n"),
            "line 3: times of moves, G93, without C, the axis that they are for"
        );
        let mill = ToolPath::read(b"G0 X9 Y0 Z5\nG1 X8 C5 F9\n").unwrap_err().to_string();
        assert_eq!(mill, "line 2: C is no word that is known here");
    }
}
