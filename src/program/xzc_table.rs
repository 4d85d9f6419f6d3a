//! Tables of points X, Z and C, which a spindle that is an axis goes through at an even speed.

use super::commanded::SpindleTurn;
use super::lathe::TurningPath;
use super::{ProgramFault, ToolMove, ToolPath};
use crate::geom::DVec3;

/// Longest line that is read, bytes.
const LONGEST: usize = 255;
/// Most points that are kept.
const MOST: usize = 5_000_000;
/// The largest place, mm, and angle, degrees.
const LARGEST: f64 = 1e6;
const LARGEST_DEGREES: f64 = 3.6e8;
/// Key of the speed of C, 1/min, in a line of comment.
const SPEED: &str = "spindle_rpm";

impl TurningPath {
    /// The moves of a table of points: X as a radius and Z of the tool point in mm, C in degrees, one line a point, numbers divided by
    /// blanks, commas or semicolons.
    ///
    /// Lines that begin with `#`, `;` or `(` are comments, of which `# spindle_rpm N` tells the speed of C, and is needed. A line of the
    /// letters X, Z and C before the first point tells another order of the columns. C goes one way.
    ///
    /// # Errors
    /// [`ProgramFault`] with the line of what is not known, or contradicts itself.
    pub fn read_table(bytes: &[u8]) -> Result<Self, ProgramFault> {
        let text = std::str::from_utf8(bytes)
            .map_err(|error| ProgramFault::Text { byte: error.valid_up_to() })?;
        let (mut table, mut found) = (TableState::new(), Self::default());
        for (k, text) in text.lines().enumerate() {
            let line = u32::try_from(k + 1).unwrap_or(u32::MAX);
            found.tool.lines = line;
            table
                .take(line, text, &mut found)
                .map_err(|reason| ProgramFault::Line { line, reason })?;
            if found.tool.moves.len() > MOST {
                return Err(ProgramFault::Many { line, most: MOST });
            }
        }
        if found.turns.iter().all(|turns| *turns == 0.0) {
            return Err(ProgramFault::Empty);
        }
        Ok(found)
    }
}

/// A table in the course of its lines.
struct TableState {
    /// Columns of X, Z and C.
    columns: [usize; 3],
    rpm: Option<f64>,
    /// X, Z and C of the last point.
    last: Option<[f64; 3]>,
    /// Whether C grows.
    grows: Option<bool>,
}

impl TableState {
    fn new() -> Self {
        Self { columns: [0, 1, 2], rpm: None, last: None, grows: None }
    }

    fn take(&mut self, line: u32, text: &str, found: &mut TurningPath) -> Result<(), String> {
        if text.len() > LONGEST {
            return Err(format!("it is longer than {LONGEST} bytes"));
        }
        let text = text.trim();
        if let Some(comment) = text.strip_prefix(['#', ';', '(']) {
            return self.comment(comment.trim_end_matches(')').trim());
        }
        let is_between = |c: char| c.is_whitespace() || c == ',' || c == ';';
        let words: Vec<&str> = text.split(is_between).filter(|word| !word.is_empty()).collect();
        if words.is_empty() {
            return Ok(());
        }
        if words.iter().all(|word| word.chars().all(|c| c.is_ascii_alphabetic())) {
            return self.order(&words);
        }
        let point = self.point(&words)?;
        self.go(line, point, &mut found.tool, (&mut found.turns, &mut found.commanded))
    }

    fn comment(&mut self, comment: &str) -> Result<(), String> {
        let Some(value) = comment.strip_prefix(SPEED) else { return Ok(()) };
        let value = value.trim_start_matches([' ', '\t', ':', '=']).trim();
        let rpm: Option<f64> = value.parse().ok().filter(|rpm| (1e-6..=1e6).contains(rpm));
        let Some(rpm) = rpm else {
            return Err(format!("{SPEED} {value:?} is no speed from 1e-6 to 1e6 turns a minute"));
        };
        if self.last.is_some() || self.rpm.is_some_and(|before| before != rpm) {
            return Err(format!("{SPEED} after points, or told twice: C turns evenly"));
        }
        self.rpm = Some(rpm);
        Ok(())
    }

    fn order(&mut self, words: &[&str]) -> Result<(), String> {
        let column = |letter: &str| words.iter().position(|word| word.eq_ignore_ascii_case(letter));
        let [x, z, c] = ["X", "Z", "C"].map(column);
        match (x, z, c) {
            (Some(x), Some(z), Some(c)) if words.len() == 3 && self.last.is_none() => {
                self.columns = [x, z, c];
                Ok(())
            }
            _ => Err(format!(
                "{:?}: columns are X, Z and C, each once, and are told before the first point",
                words.join(" ")
            )),
        }
    }

    fn point(&self, words: &[&str]) -> Result<[f64; 3], String> {
        if words.len() != 3 {
            return Err(format!("a point has X, Z and C, and {} words are here", words.len()));
        }
        let mut point = [0.0; 3];
        for (value, column) in point.iter_mut().zip(self.columns) {
            let number = words[column].parse().ok().filter(|number: &f64| number.is_finite());
            *value = number.ok_or_else(|| format!("{:?} is no number", words[column]))?;
        }
        let [x, z, c] = point;
        match x.abs().max(z.abs()) <= LARGEST && c.abs() <= LARGEST_DEGREES {
            true => Ok(point),
            false => Err("the point is beyond any machine".into()),
        }
    }

    /// The move from the last point.
    fn go(
        &mut self,
        line: u32,
        point: [f64; 3],
        path: &mut ToolPath,
        (turns, commanded): (&mut Vec<f64>, &mut Vec<SpindleTurn>),
    ) -> Result<(), String> {
        let Some(rpm) = self.rpm else {
            return Err(format!("a point before the speed of C: a line \"# {SPEED} 60\" tells it"));
        };
        let Some([x, z, c]) = self.last.replace(point) else { return Ok(()) };
        let [to_x, to_z, to_c] = point;
        if to_c == c {
            return Err(format!("C stays at {c} degrees, but it turns evenly"));
        }
        if *self.grows.get_or_insert(to_c > c) != (to_c > c) {
            return Err(format!(
                "C turns back from {c} to {to_c} degrees, but a tool cuts in one direction; C goes on beyond 360 degrees"
            ));
        }
        let turn = SpindleTurn {
            begin: c / 360.0,
            end: to_c / 360.0,
            minutes: (to_c - c).abs() / 360.0 / rpm,
        };
        let [from, to] = [DVec3::new(x, 0.0, z), DVec3::new(to_x, 0.0, to_z)];
        let feed = Some(from.distance(to) / turn.minutes);
        path.moves.push(ToolMove { from, to, feed, line });
        turns.push(turn.turns());
        commanded.push(turn);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> TurningPath {
        TurningPath::read_table(text.as_bytes()).unwrap_or_else(|error| panic!("{error}"))
    }

    fn refused(text: &str) -> String {
        TurningPath::read_table(text.as_bytes()).unwrap_err().to_string()
    }

    /// At 60 turns a minute a quarter of a turn takes a quarter of a second; the same points in three ways to write them.
    #[test]
    fn points_are_moves_at_the_speed_of_c() {
        let found = read("# a table\n# spindle_rpm 60\n12 5 0\n11.5 5.25 90\n\n-0.8 4.5 270\n");
        assert_eq!(found.tool.moves.len(), 2);
        let last = found.tool.moves[1];
        assert_eq!((last.from, last.to), (DVec3::new(11.5, 0.0, 5.25), DVec3::new(-0.8, 0.0, 4.5)));
        assert_eq!((last.line, found.tool.lines), (6, 6));
        assert_eq!(found.turns, [0.25, 0.5]);
        let exact = [SpindleTurn { begin: 0.0, end: 0.25, minutes: 0.25 / 60.0 }];
        assert_eq!(found.commanded[..1], exact);
        assert!((60.0 * found.cutting_min() - 0.75).abs() < 1e-12);
        let other = read("; spindle_rpm = 60\nc, x; z\n0, 12; 5\n90,+11.5,5.25\n270\t-0.8 4.5\n");
        assert_eq!((other.turns, other.commanded), (found.turns, found.commanded));
        let back = read("(spindle_rpm 60)\n12 5 0\n11.5 5.25 -90\n");
        assert_eq!((back.turns[0], back.commanded[0].minutes), (-0.25, 0.25 / 60.0));
    }

    #[test]
    fn what_is_no_point_is_refused_by_line() {
        let start = "# spindle_rpm 60\n12 5 0\n11 5 10\n";
        for (text, said) in [
            ("11 5", "line 4: a point has X, Z and C, and 2 words are here"),
            ("11 5 x", "line 4: \"x\" is no number"),
            ("11 5 inf", "line 4: \"inf\" is no number"),
            (
                "11 5 5",
                "line 4: C turns back from 10 to 5 degrees, but a tool cuts in one direction; C goes on beyond 360 degrees",
            ),
            ("11 5 10", "line 4: C stays at 10 degrees, but it turns evenly"),
            ("9999999 5 20", "line 4: the point is beyond any machine"),
            (
                "X Z C",
                "line 4: \"X Z C\": columns are X, Z and C, each once, and are told before the first point",
            ),
            ("# spindle_rpm 70", "line 4: spindle_rpm after points, or told twice: C turns evenly"),
        ] {
            assert_eq!(refused(&format!("{start}{text}\n")), said);
        }
        assert_eq!(
            refused("12 5 0\n11 5 10\n"),
            "line 1: a point before the speed of C: a line \"# spindle_rpm 60\" tells it"
        );
        assert!(refused("# spindle_rpm fast\n").contains("is no speed"));
        assert!(refused("X Y C\n").contains("columns are X, Z and C"));
        assert_eq!(refused("# spindle_rpm 60\n12 5 0\n"), "it has no feed move");
        assert_eq!(
            TurningPath::read_table(b"\xff").unwrap_err().to_string(),
            "it is no text: byte 0 is none of UTF-8"
        );
    }
}
