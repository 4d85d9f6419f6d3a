//! The state of a control between lines: modes, place and feed.

use super::arc::ArcPlane;
use super::{ProgramFault, ToolMove};
use crate::geom::DVec3;

/// Kind of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Motion {
    Rapid,
    Feed,
    Arc { is_clockwise: bool },
}

/// The largest place or radius, mm, and feed, mm/min: a kilometre, or as much a minute.
pub(super) const LARGEST: f64 = 1e6;
/// Names of the axes.
const AXES: [&str; 3] = ["X", "Y", "Z"];

/// Modes and place. The place of an axis is unknown until the program has told it, and after a move to a place of the
/// machine.
#[derive(Debug, Clone)]
pub(super) struct ControlState {
    pub motion: Option<Motion>,
    pub plane: ArcPlane,
    pub is_relative: bool,
    pub has_absolute_centres: bool,
    /// Millimetres to the program's unit.
    pub unit_mm: f64,
    /// Feed, mm/min.
    pub feed: Option<f64>,
    pub place: [Option<f64>; 3],
    /// What a unit of the words of X, Y and Z is along the axis: a half where X is a diameter.
    pub scale: [f64; 3],
}

impl ControlState {
    /// That with which programs begin: millimetres, absolute places, arcs in XY.
    pub(super) fn new() -> Self {
        Self {
            motion: None,
            plane: ArcPlane::XY,
            is_relative: false,
            has_absolute_centres: false,
            unit_mm: 1.0,
            feed: None,
            place: [None; 3],
            scale: [1.0; 3],
        }
    }

    /// That of a lathe: arcs in ZX.
    pub(super) fn of_lathe() -> Self {
        Self { plane: ArcPlane::ZX, ..Self::new() }
    }

    /// Where the words of X, Y and Z lead to.
    pub(super) fn target(
        &self,
        line: u32,
        axes: [Option<f64>; 3],
    ) -> Result<[Option<f64>; 3], ProgramFault> {
        let mut target = self.place;
        for (k, axis) in axes.into_iter().enumerate() {
            let Some(value) = axis.map(|value| value * self.unit_mm * self.scale[k]) else {
                continue;
            };
            target[k] = match (self.is_relative, self.place[k]) {
                (false, _) => Some(value),
                (true, Some(before)) => Some(before + value),
                (true, None) => {
                    let name = AXES[k];
                    let reason =
                        format!("a relative move in {name}, whose place no line before has told");
                    return Err(ProgramFault::Line { line, reason });
                }
            };
            if target[k].is_some_and(|place| place.abs() > LARGEST) {
                let reason = format!("{} is beyond any machine", AXES[k]);
                return Err(ProgramFault::Line { line, reason });
            }
        }
        Ok(target)
    }

    /// The place, if all of it is known.
    pub(super) fn known(place: [Option<f64>; 3]) -> Option<DVec3> {
        let [x, y, z] = place;
        Some(DVec3::new(x?, y?, z?))
    }

    /// The feed of a cutting move.
    ///
    /// # Errors
    /// [`ProgramFault::Line`] where none or 0 is set.
    pub(super) fn cutting_feed(&self, line: u32) -> Result<f64, ProgramFault> {
        self.feed.filter(|feed| *feed > 0.0).ok_or_else(|| {
            let reason = "a cutting move without a feed; an F word greater than 0 sets it".into();
            ProgramFault::Line { line, reason }
        })
    }

    /// Moves straight to `target`; the move, unless it begins or ends at a place that is not known.
    ///
    /// # Errors
    /// [`ProgramFault::Line`] of a cutting move between places that are not known, or without a feed.
    pub(super) fn go(
        &mut self,
        line: u32,
        target: [Option<f64>; 3],
        is_rapid: bool,
    ) -> Result<Option<ToolMove>, ProgramFault> {
        let ends = Self::known(self.place).zip(Self::known(target));
        self.place = target;
        let feed = if is_rapid { None } else { Some(self.cutting_feed(line)?) };
        match ends {
            Some((from, to)) => Ok(Some(ToolMove { from, to, feed, line })),
            None if is_rapid => Ok(None),
            None => {
                let reason =
                    "a cutting move before lines have told X, Y and Z of where it begins".into();
                Err(ProgramFault::Line { line, reason })
            }
        }
    }
}
