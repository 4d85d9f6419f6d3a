//! A line of RS-274 text: its words by what they mean, and the moves that follow from them.

use super::arc::{Arc, ArcPlane};
use super::lathe_words::LatheWords;
use super::modal::{ControlState, LARGEST, Motion};
use super::words::Word;
use super::{ProgramFault, ToolMove};
use crate::geom::DVec3;

/// Millimetres to an inch.
const INCH: f64 = 25.4;

/// Whose words a program has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Vocabulary {
    Mill,
    Lathe,
}

/// A command of a line that is not a mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Special {
    /// To a place of the machine by way of the place that the axes tell.
    Reference,
    /// Places of this line are the machine's.
    MachinePlace,
    /// A dwell, of which P is the time.
    Dwell,
}

/// The words of a line, by what they mean.
#[derive(Debug, Default)]
pub(super) struct LineWords {
    line: u32,
    motion: Option<Motion>,
    special: Option<Special>,
    plane: Option<ArcPlane>,
    unit_mm: Option<f64>,
    is_relative: Option<bool>,
    has_absolute_centres: Option<bool>,
    cancels_motion: bool,
    feed: Option<f64>,
    axes: [Option<f64>; 3],
    centre: [Option<f64>; 3],
    radius: Option<f64>,
    ends: bool,
    /// What lathes alone have; none of a mill's.
    lathe: Option<LatheWords>,
}

impl LineWords {
    pub(super) fn new(
        line: u32,
        words: &[Word],
        vocabulary: Vocabulary,
    ) -> Result<Self, ProgramFault> {
        let lathe = (vocabulary == Vocabulary::Lathe).then(LatheWords::default);
        let mut block = Self { line, lathe, ..Self::default() };
        for &word in words {
            block.add(word)?;
        }
        Ok(block)
    }

    /// Its line, from 1.
    pub(super) fn line(&self) -> u32 {
        self.line
    }

    /// What lathes alone have.
    pub(super) fn lathe(&self) -> Option<&LatheWords> {
        self.lathe.as_ref()
    }

    /// X of a dwell, if it is one.
    pub(super) fn dwell(&self) -> Option<Option<f64>> {
        (self.special == Some(Special::Dwell)).then_some(self.axes[0])
    }

    fn fault<T>(&self, reason: String) -> Result<T, ProgramFault> {
        Err(ProgramFault::Line { line: self.line, reason })
    }

    fn add(&mut self, word: Word) -> Result<(), ProgramFault> {
        let Word { letter, number } = word;
        let slot = match letter {
            'G' => return self.add_preparatory(word),
            'M' => return self.add_miscellaneous(word),
            'Y' | 'J' if self.lathe.is_some() => return Err(self.unknown(word)),
            'X' => &mut self.axes[0],
            'Y' => &mut self.axes[1],
            'Z' => &mut self.axes[2],
            'I' => &mut self.centre[0],
            'J' => &mut self.centre[1],
            'K' => &mut self.centre[2],
            'R' => &mut self.radius,
            'F' => &mut self.feed,
            'S' | 'D' | 'P' | 'C' if self.lathe.is_some() => {
                let added = self.lathe.as_mut().map(|lathe| lathe.add_number(letter, number));
                return added.unwrap_or(Ok(())).or_else(|reason| self.fault(reason));
            }
            // Numbers of lines, programs, tools and offsets, speeds, times.
            'N' | 'O' | 'H' | 'T' | 'S' | 'P' => return Ok(()),
            _ => return Err(self.unknown(word)),
        };
        if slot.replace(number).is_some() {
            return self.fault(format!("{letter} twice"));
        }
        if number.abs() > LARGEST {
            return self.fault(format!("{letter} is beyond any machine"));
        }
        Ok(())
    }

    fn unknown(&self, Word { letter, number }: Word) -> ProgramFault {
        let word =
            if matches!(letter, 'G' | 'M') { format!("{letter}{number}") } else { letter.into() };
        ProgramFault::Word { line: self.line, word }
    }

    fn add_preparatory(&mut self, word: Word) -> Result<(), ProgramFault> {
        let lathe = self.lathe.as_mut().zip(tenths(word.number));
        let added = lathe.map_or(Ok(false), |(lathe, tenths)| lathe.add_mode(tenths));
        if added.or_else(|reason| self.fault(reason))? {
            return Ok(());
        }
        let motion = |motion| (Some(motion), None);
        let (motion, special) = match tenths(word.number) {
            Some(0) => motion(Motion::Rapid),
            Some(10) => motion(Motion::Feed),
            Some(20) => motion(Motion::Arc { is_clockwise: true }),
            Some(30) => motion(Motion::Arc { is_clockwise: false }),
            Some(40) => (None, Some(Special::Dwell)),
            Some(280 | 300) => (None, Some(Special::Reference)),
            Some(530) => (None, Some(Special::MachinePlace)),
            _ => return self.add_mode(word),
        };
        if motion.is_some() && self.motion.is_some() || special.is_some() && self.special.is_some()
        {
            return self.fault(format!("G{} beside another motion", word.number));
        }
        self.motion = self.motion.or(motion);
        self.special = self.special.or(special);
        Ok(())
    }

    fn add_mode(&mut self, word: Word) -> Result<(), ProgramFault> {
        match tenths(word.number) {
            Some(170) => self.plane = Some(ArcPlane::XY),
            Some(180) => self.plane = Some(ArcPlane::ZX),
            Some(190) => self.plane = Some(ArcPlane::YZ),
            Some(200) => self.unit_mm = Some(INCH),
            Some(210) => self.unit_mm = Some(1.0),
            Some(800) => self.cancels_motion = true,
            Some(900) => self.is_relative = Some(false),
            Some(910) => self.is_relative = Some(true),
            Some(901) => self.has_absolute_centres = Some(true),
            Some(911) => self.has_absolute_centres = Some(false),
            // Compensation of radii off; tool lengths; work offsets; exact paths or blended ones; feed a minute, speed a minute.
            Some(
                400 | 430 | 490 | 540 | 550 | 560 | 570 | 580 | 590 | 610 | 611 | 640 | 940 | 970,
            ) => {}
            _ => return Err(self.unknown(word)),
        }
        Ok(())
    }

    fn add_miscellaneous(&mut self, word: Word) -> Result<(), ProgramFault> {
        if let (Some(lathe), Some(code @ (30 | 40 | 50))) = (&mut self.lathe, tenths(word.number)) {
            lathe.turns = Some(code != 50);
        }
        match tenths(word.number) {
            Some(20 | 300) => self.ends = true,
            // Stops, spindle, tool change, coolant, overrides.
            Some(0 | 10 | 30 | 40 | 50 | 60 | 70 | 80 | 90 | 480 | 490) => {}
            _ => return Err(self.unknown(word)),
        }
        Ok(())
    }

    /// Whether it ends the program.
    pub(super) fn ends(&self) -> bool {
        self.ends
    }

    /// Whether it tells a place.
    pub(super) fn has_axes(&self) -> bool {
        self.axes.iter().any(Option::is_some)
    }

    /// F of the line itself, in the program's unit.
    pub(super) fn feed(&self) -> Option<f64> {
        self.feed
    }

    /// Whether it is a command that is no mode: a dwell, or a way to places of the machine.
    pub(super) fn is_command(&self) -> bool {
        self.special.is_some()
    }

    /// Sets modes, and moves.
    pub(super) fn run(
        &self,
        state: &mut ControlState,
        moves: &mut Vec<ToolMove>,
    ) -> Result<(), ProgramFault> {
        state.unit_mm = self.unit_mm.unwrap_or(state.unit_mm);
        state.plane = self.plane.unwrap_or(state.plane);
        state.is_relative = self.is_relative.unwrap_or(state.is_relative);
        state.has_absolute_centres =
            self.has_absolute_centres.unwrap_or(state.has_absolute_centres);
        state.feed = self.feed.map(|feed| feed * state.unit_mm).or(state.feed);
        // (Inches are more than what was read as a number. Of a lathe F may be the inverse of a time.)
        if self.lathe.is_none() && state.feed.is_some_and(|feed| feed > LARGEST) {
            return self.fault("F is beyond any machine".into());
        }
        if self.cancels_motion {
            state.motion = None;
        }
        state.motion = self.motion.or(state.motion);
        match self.special {
            Some(Special::Dwell) => Ok(()),
            Some(Special::Reference) => self.to_reference(state, moves),
            Some(Special::MachinePlace) => self.to_machine_place(state),
            None if self.has_axes() || self.centre.iter().any(Option::is_some) => {
                self.travel(state, moves)
            }
            None => Ok(()),
        }
    }

    /// A rapid move to the place that is told, from which the axes that are named go to a place of the machine.
    fn to_reference(
        &self,
        state: &mut ControlState,
        moves: &mut Vec<ToolMove>,
    ) -> Result<(), ProgramFault> {
        let target = state.target(self.line, self.axes)?;
        moves.extend(state.go(self.line, target, true)?);
        for (axis, place) in self.axes.iter().zip(&mut state.place) {
            // Without an axis all of them go.
            if axis.is_some() || !self.has_axes() {
                *place = None;
            }
        }
        Ok(())
    }

    /// A rapid move to a place of the machine.
    fn to_machine_place(&self, state: &mut ControlState) -> Result<(), ProgramFault> {
        if state.motion != Some(Motion::Rapid) {
            return self.fault(
                "G53 goes with G0: where the machine's places are, no program tells".into(),
            );
        }
        for (axis, place) in self.axes.iter().zip(&mut state.place) {
            if axis.is_some() {
                *place = None;
            }
        }
        Ok(())
    }

    fn travel(
        &self,
        state: &mut ControlState,
        moves: &mut Vec<ToolMove>,
    ) -> Result<(), ProgramFault> {
        let target = state.target(self.line, self.axes)?;
        match state.motion {
            None => self.fault("axes without a motion: no G0, G1, G2 or G3 is in force".into()),
            Some(Motion::Arc { is_clockwise }) => self.arc(state, target, is_clockwise, moves),
            Some(motion) => {
                moves.extend(state.go(self.line, target, motion == Motion::Rapid)?);
                Ok(())
            }
        }
    }

    fn arc(
        &self,
        state: &mut ControlState,
        target: [Option<f64>; 3],
        is_clockwise: bool,
        moves: &mut Vec<ToolMove>,
    ) -> Result<(), ProgramFault> {
        let (line, plane) = (self.line, state.plane);
        let ends = ControlState::known(state.place).zip(ControlState::known(target));
        let Some((from, to)) = ends else {
            return self.fault("an arc before lines have told X, Y and Z of its start".into());
        };
        if self.lathe.is_some() && plane != ArcPlane::ZX {
            return self.fault("arcs of a lathe lie in the plane of X and Z, G18".into());
        }
        let told = |k: usize| self.centre[plane.0[k]].map(|value| value * state.unit_mm);
        if self.centre[plane.0[2]].is_some() {
            return self.fault("a centre beside the plane of arcs, G17, G18 or G19".into());
        }
        let fault = |reason| ProgramFault::Line { line, reason };
        let centre = match (self.radius, [told(0), told(1)]) {
            (Some(radius), [None, None]) => {
                let radius = radius * state.unit_mm;
                Arc::centre_by_radius(plane, is_clockwise, [from, to], radius).map_err(fault)?
            }
            (None, [x, y]) if x.is_some() || y.is_some() => {
                let start = plane.flat(from);
                let origin = if state.has_absolute_centres { [0.0; 2] } else { start.to_array() };
                let usual = if state.has_absolute_centres { start.to_array() } else { [0.0; 2] };
                [(x, 0), (y, 1)]
                    .map(|(told, k)| told.map_or(origin[k] + usual[k], |value| origin[k] + value))
                    .into()
            }
            _ => return self.fault("an arc takes a centre, I, J, K, or a radius, R".into()),
        };
        let feed = Some(state.cutting_feed(line)?);
        let mut from_place: DVec3 = from;
        for to in (Arc { plane, is_clockwise, from, to, centre }).chords().map_err(fault)? {
            if to.abs().max_element() > LARGEST {
                return self.fault("an arc goes beyond any machine".into());
            }
            moves.push(ToolMove { from: from_place, to, feed, line });
            from_place = to;
        }
        state.place = target;
        Ok(())
    }
}

/// A number of a word with one decimal at the most, in tenths.
fn tenths(number: f64) -> Option<u32> {
    let tenths = (10.0 * number).round();
    ((0.0..=9999.0).contains(&tenths) && (10.0 * number - tenths).abs() < 1e-6)
        .then_some(tenths as u32)
}

#[cfg(test)]
mod tests {
    use super::super::ToolPath;
    use super::*;

    fn read(text: &str) -> ToolPath {
        ToolPath::read(text.as_bytes()).unwrap_or_else(|error| panic!("{error}"))
    }

    fn ends(path: &ToolPath) -> Vec<[f64; 3]> {
        path.moves.iter().map(|step| step.to.to_array()).collect()
    }

    fn refused(text: &str) -> String {
        ToolPath::read(text.as_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn words_last_until_others_take_their_place() {
        let path = read(
            "%\nO1000 (a program)\nN10 G21 G90 G17 G54\nT1 M6\nS12000 M3\nG0 Z10\nG0 X1 Y2\nZ1\n\
             G1 Z-.5 F300\nX4\nG91 Y1 F600\nG90 G0 Z10\nM30\nX99\n%\n",
        );
        assert_eq!(
            ends(&path),
            [
                [1.0, 2.0, 1.0],
                [1.0, 2.0, -0.5],
                [4.0, 2.0, -0.5],
                [4.0, 3.0, -0.5],
                [4.0, 3.0, 10.0]
            ]
        );
        let feeds: Vec<_> = path.moves.iter().map(|step| step.feed).collect();
        assert_eq!(feeds, [None, Some(300.0), Some(300.0), Some(600.0), None]);
        assert_eq!((path.moves[1].line, path.lines), (9, 13));
        assert_eq!(path.moves[1].from, DVec3::new(1.0, 2.0, 1.0));
    }

    #[test]
    fn inches_are_told_in_millimetres() {
        let path = read("G20\nG0 X1 Y0 Z1\nG1 X2 F10\nG2 X3 I.5 J0\n");
        let near = |found: DVec3, x: f64| (found - DVec3::new(x, 0.0, 25.4)).length() < 1e-12;
        assert!(near(path.moves[0].to, 50.8) && near(path.moves.last().unwrap().to, 76.2));
        assert_eq!(path.moves[0].feed, Some(254.0));
    }

    /// The same half circle by its centre, absolute and relative, and by its radius.
    #[test]
    fn arcs_are_one_however_they_are_told() {
        let start = "G0 X10 Y0 Z2\nF100\n";
        let one = read(&format!("{start}G3 X-10 Y0 I-10"));
        for other in
            ["G90.1 G3 X-10 Y0 I0 J0", "G3 X-10 R10", "G91 G3 X-20 I-10 J0", "G3 X-10 I-10 J0"]
        {
            let other = read(&format!("{start}{other}"));
            assert_eq!(one.moves.len(), other.moves.len());
            for (a, b) in one.moves.iter().zip(&other.moves) {
                assert!((a.to - b.to).length() < 1e-12);
                assert!((a.to.truncate().length() - 10.0).abs() < 1e-12 && a.to.y > -1e-12);
            }
        }
        let helix = read(&format!("{start}G18 G2 X-10 I-10 Y5"));
        assert!(helix.moves.windows(2).all(|pair| pair[1].to.y > pair[0].to.y));
        assert!(
            helix.moves.iter().all(|step| step.to.z <= 2.0 + 1e-12 || step.to.z >= 2.0 - 1e-12)
        );
    }

    #[test]
    fn places_of_the_machine_are_not_known() {
        let path =
            read("G0 X0 Y0 Z5\nG1 Z1 F50\nG91 G28 Z0\nG90 G0 X5 Y5\nG0 Z5\nG1 Z0\nG53 G0 Z0\n");
        assert_eq!(ends(&path), [[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [5.0, 5.0, 0.0]]);
        let blind = refused("G0 X0 Y0\nG1 X5 F100\n");
        assert_eq!(
            blind,
            "line 2: a cutting move before lines have told X, Y and Z of where it begins"
        );
    }

    #[test]
    fn what_is_not_known_is_refused_by_line_and_name() {
        let start = "G0 X0 Y0 Z5\n";
        for (text, said) in [
            ("G1 X1", "line 2: a cutting move without a feed; an F word greater than 0 sets it"),
            ("G1 X1 F0", "line 2: a cutting move without a feed; an F word greater than 0 sets it"),
            ("G41 D1", "line 2: G41 is no word that is known here"),
            ("G38.2 Z0", "line 2: G38.2 is no word that is known here"),
            ("M98 P100", "line 2: M98 is no word that is known here"),
            ("G1 A90 F1", "line 2: A is no word that is known here"),
            ("G1 X1 X2 F9", "line 2: X twice"),
            ("G1 G0 X1 F9", "line 2: G0 beside another motion"),
            ("G80\nX5", "line 3: axes without a motion: no G0, G1, G2 or G3 is in force"),
            ("F9 G2 X5", "line 2: an arc takes a centre, I, J, K, or a radius, R"),
            ("F9 G2 X5 I1", "line 2: an arc of radius 1 at its start and 4 at its end"),
            ("F9 G2 X5 R1", "line 2: R1 is less than half the distance of the arc's ends, 2.5"),
            ("F9 G2 X5 K1", "line 2: a centre beside the plane of arcs, G17, G18 or G19"),
            (
                "G1 G53 X0 F9",
                "line 2: G53 goes with G0: where the machine's places are, no program tells",
            ),
            ("G1 X1e3 F1", "line 2: E is no word that is known here"),
            ("G1 X9999999 F1", "line 2: X is beyond any machine"),
            ("G20 G1 X5 F90000", "line 2: F is beyond any machine"),
            ("G20 G1 X90000 F1", "line 2: X is beyond any machine"),
            ("F9 G2 X0 Y0 I600000", "line 2: an arc goes beyond any machine"),
            ("M30", "it has no feed move"),
        ] {
            assert_eq!(refused(&format!("{start}{text}")), said);
        }
        assert_eq!(
            refused("G91 X1"),
            "line 1: a relative move in X, whose place no line before has told"
        );
        let broken = ToolPath::read(b"G0 X1 \xff").unwrap_err().to_string();
        assert_eq!(broken, "it is no text: byte 6 is none of UTF-8");
    }
}
