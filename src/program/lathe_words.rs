//! Words that lathes alone have, and the modes that they set.

use std::f64::consts::TAU;

/// Modal words of which two systems make different things.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum CodeSystem {
    /// Fanuc's system A: G98 and G99 are feeds, G50 a limit of the spindle, X is a diameter; G90 to G94 are cycles.
    A,
    /// LinuxCNC's, which is Fanuc's system B but for G7 and G8: G90 and G91 tell places, G94 and G95 feeds.
    B,
}

impl CodeSystem {
    fn name(self) -> &'static str {
        match self {
            Self::A => "Fanuc's system A",
            Self::B => "LinuxCNC and Fanuc's system B",
        }
    }
}

/// The largest angle of C: a million turns.
const MOST_DEGREES: f64 = 3.6e8;

/// Lathe words of a line.
#[derive(Debug, Default)]
pub(super) struct LatheWords {
    system: Option<CodeSystem>,
    is_diameter: Option<bool>,
    is_per_turn: Option<bool>,
    is_surface_speed: Option<bool>,
    /// G50: S is the limit of the spindle's speed.
    pub is_limit: bool,
    spindle: Option<f64>,
    limit: Option<f64>,
    time: Option<f64>,
    /// C, degrees.
    pub angle: Option<f64>,
    is_inverse_time: Option<bool>,
    /// M3 and M4, or M5.
    pub turns: Option<bool>,
}

impl LatheWords {
    /// Takes in a G word, in tenths; whether it is of lathes alone.
    pub(super) fn add_mode(&mut self, tenths: u32) -> Result<bool, String> {
        let system = match tenths {
            70 | 80 | 900 | 901 | 910 | 911 | 940 | 950 => CodeSystem::B,
            500 | 980 | 990 => CodeSystem::A,
            // Feeds are what of a minute moves take, in both systems.
            930 => {
                self.is_inverse_time = Some(true);
                return Ok(true);
            }
            960 => {
                self.is_surface_speed = Some(true);
                return Ok(true);
            }
            970 => {
                self.is_surface_speed = Some(false);
                return Ok(false);
            }
            _ => return Ok(false),
        };
        let others = self.system.replace(system).filter(|before| *before != system);
        if let Some(before) = others {
            return Err(mixed(system, before));
        }
        if matches!(tenths, 940 | 950 | 980 | 990) {
            self.is_inverse_time = Some(false);
        }
        match tenths {
            70 => self.is_diameter = Some(true),
            80 => self.is_diameter = Some(false),
            940 | 980 => self.is_per_turn = Some(false),
            950 | 990 => self.is_per_turn = Some(true),
            500 => self.is_limit = true,
            _ => {}
        }
        Ok(matches!(tenths, 70 | 80 | 500 | 950 | 980 | 990))
    }

    /// Takes in the number of S, D, P or C.
    pub(super) fn add_number(&mut self, letter: char, number: f64) -> Result<(), String> {
        let slot = match letter {
            'S' => &mut self.spindle,
            'D' => &mut self.limit,
            'C' => &mut self.angle,
            _ => &mut self.time,
        };
        if slot.replace(number).is_some() {
            return Err(format!("{letter} twice"));
        }
        let range = if letter == 'C' { -MOST_DEGREES..=MOST_DEGREES } else { 0.0..=1e6 };
        if !range.contains(&number) {
            return Err(format!("{letter} is beyond any machine"));
        }
        Ok(())
    }
}

fn mixed(one: CodeSystem, other: CodeSystem) -> String {
    format!(
        "words of {} after those of {}, which mean other things by them",
        one.name(),
        other.name()
    )
}

/// Modes of a lathe.
#[derive(Debug, Clone, Default)]
pub(super) struct LatheState {
    system: Option<CodeSystem>,
    is_diameter: Option<bool>,
    /// Whether feeds are those of a turn.
    pub is_per_turn: bool,
    is_surface_speed: bool,
    /// Whether feeds are inverses of moves' times.
    pub is_inverse_time: bool,
    /// Speed of the spindle, 1/min, or that of the surface, m/min or ft/min.
    spindle: Option<f64>,
    limit_rpm: Option<f64>,
    turns: bool,
}

impl LatheState {
    /// Takes in the words of a line.
    pub(super) fn update(&mut self, words: &LatheWords) -> Result<(), String> {
        if let (Some(system), Some(before)) = (words.system, self.system)
            && system != before
        {
            return Err(mixed(system, before));
        }
        self.system = words.system.or(self.system);
        self.is_diameter = words.is_diameter.or(self.is_diameter);
        self.is_per_turn = words.is_per_turn.unwrap_or(self.is_per_turn);
        self.is_surface_speed = words.is_surface_speed.unwrap_or(self.is_surface_speed);
        self.is_inverse_time = words.is_inverse_time.unwrap_or(self.is_inverse_time);
        self.turns = words.turns.unwrap_or(self.turns);
        self.limit_rpm = words.limit.or(self.limit_rpm);
        if words.is_limit {
            self.limit_rpm = words.spindle.or(self.limit_rpm);
        } else {
            self.spindle = words.spindle.or(self.spindle);
        }
        if self.is_surface_speed && !self.is_per_turn {
            return Err(
                "an even surface speed, G96, beside a feed a minute; G95 or G99 sets one in a turn"
                    .into(),
            );
        }
        Ok(())
    }

    /// Distance from the axis for each millimetre of an X word: a half where X is a diameter, as system A has it.
    pub(super) fn x_scale(&self) -> f64 {
        let is_diameter = self.is_diameter.unwrap_or(self.system == Some(CodeSystem::A));
        if is_diameter { 0.5 } else { 1.0 }
    }

    /// Whether M3 or M4 is in force.
    pub(super) fn is_turning(&self) -> bool {
        self.turns
    }

    /// Speed of the spindle with the tool at a distance from the axis, mm, 1/min.
    ///
    /// # Errors
    /// The reason why it does not turn.
    pub(super) fn rpm(&self, radius_mm: f64, unit_mm: f64) -> Result<f64, String> {
        let spindle = self.spindle.filter(|speed| *speed > 0.0 && self.turns);
        let Some(speed) = spindle else {
            return Err(
                "a cutting move while the spindle stands; M3 and an S word greater than 0 turn it"
                    .into(),
            );
        };
        if !self.is_surface_speed {
            return Ok(speed);
        }
        // Metres a minute, or feet where places are inches.
        let mm_min = if unit_mm == 1.0 { 1e3 * speed } else { 12.0 * unit_mm * speed };
        let Some(limit_rpm) = self.limit_rpm.filter(|limit| *limit > 0.0) else {
            return Err(
                "an even surface speed, G96, without a limit of the spindle's speed, D or G50 S"
                    .into(),
            );
        };
        Ok((mm_min / (TAU * radius_mm.abs())).min(limit_rpm))
    }

    /// Seconds of a dwell: `x` is in seconds, P too but for system A, where it is in milliseconds.
    pub(super) fn dwell_s(&self, words: &LatheWords, x: Option<f64>) -> f64 {
        let is_a = self.system == Some(CodeSystem::A);
        match (is_a, x, words.time) {
            (true, Some(seconds), _) => seconds,
            (true, None, Some(milliseconds)) => 1e-3 * milliseconds,
            (false, _, Some(seconds)) => seconds,
            _ => 0.0,
        }
    }
}
