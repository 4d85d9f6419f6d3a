//! Operations of a slow tool servo: what each of them leaves, as tables of points.

use super::TurningError;
use super::bar::Bar;
use super::cutting_data::{OperationFeeds, stepdown_mm, usual_rpm};
use super::disc_sections::DiscSections;
use super::facing::BESIDE_MM;
use super::nose_heights::{NoseHeights, NoseSpiral};
use super::operation::{BEYOND, CHORD, FINE_SLOPE, MOST};
use super::point_table::{AxisLimits, PointTable, ServoLimit, SpiralCut, TableBuilder, bend};
use super::tool_fit;
use crate::geom::DVec2;
use crate::milling::OperationKind;
use crate::num::{atan, degrees};
use crate::profile::{ServoSpec, TurnSpec};
use std::f64::consts::TAU;

/// Points of a turn that are chosen among: steps of C that are whole in four decimals of a degree.
const PER_TURN: [usize; 18] =
    [36, 48, 60, 72, 90, 96, 120, 144, 180, 240, 288, 360, 480, 576, 720, 900, 1440, FINEST];
/// The most of them: an eighth of a degree between two points.
const FINEST: usize = 2880;
/// What a move between two points is off its path, over the path's second difference.
const CHORD_SHARE: f64 = 0.125;
/// Largest chord that a profile may ask for, um.
const MOST_CHORD_UM: f64 = 100.0;
/// Share by which the points of a turn are more than first order asks for.
const ROOM: f64 = 1.05;

/// A disc to be cut by a slow tool servo.
pub struct ServoTask<'a> {
    /// Its sections.
    pub sections: &'a DiscSections<'a>,
    /// How it is asked for, as of a lathe.
    pub spec: &'a TurnSpec,
    /// The rest.
    pub servo: &'a ServoSpec,
    /// Feed of finishing in a turn, mm.
    pub feed_mm: f64,
    /// The bar.
    pub bar: Bar,
    /// Z of what is around the mirror, below which no nose goes, mm.
    pub floor_mm: f64,
    /// Whether that is a flat rim.
    pub has_rim: bool,
}

/// What the tool does in one program of a slow tool servo.
#[derive(Debug, Clone, PartialEq)]
pub struct ServoOperation {
    /// What it is.
    pub kind: OperationKind,
    /// Radius of the nose, mm.
    pub nose_mm: f64,
    /// Feed in a turn, mm.
    pub feed_mm_rev: f64,
    /// Cuts, one over the other.
    pub levels: usize,
    /// What it leaves on the mirror, mm.
    pub allowance_mm: f64,
    /// The points.
    pub table: PointTable,
    /// Speed of C, 1/min.
    pub rpm: f64,
    /// What holds it down.
    pub limit: ServoLimit,
}

/// What an operation is asked for.
#[derive(Clone, Copy)]
struct AskedOperation {
    kind: OperationKind,
    feed_mm: f64,
    left_mm: f64,
    chord_mm: f64,
    /// Largest slope along C of what lies between points over that of the path.
    slope: f64,
}

impl ServoTask<'_> {
    /// Height of lifts, mm.
    #[must_use]
    pub fn safe_mm(&self) -> f64 {
        self.bar.top_mm + self.spec.machine.safe_mm
    }

    /// All operations, in their order.
    ///
    /// # Errors
    /// [`TurningError`] when the tool does not fit, would go below what is around the mirror, or takes too many points.
    pub fn operations(&self) -> Result<Vec<ServoOperation>, TurningError> {
        let (nose, rough) = (&self.spec.nose, &self.spec.roughing);
        let edges_deg = [nose.inner_edge_deg, nose.outer_edge_deg];
        tool_fit::clears(self.sections.sections(), edges_deg)?;
        tool_fit::holds(self.sections.sections(), nose.radius_mm, rough.allowance_mm)?;
        self.clears_flank()?;
        let feeds = OperationFeeds::new(self.spec, self.feed_mm);
        let coarse = |kind, feed_mm, left_mm| AskedOperation {
            kind,
            feed_mm,
            left_mm,
            chord_mm: CHORD * left_mm,
            slope: f64::INFINITY,
        };
        // The finest is what is refused, if any is: not after all others have been made.
        let finishing = self.operation(self.finishing(self.feed_mm))?;
        let rough = coarse(OperationKind::Roughing, feeds.rough_feed_mm, rough.allowance_mm);
        let even = coarse(OperationKind::SemiFinishing, feeds.even_feed_mm, feeds.even_mm);
        Ok(vec![self.operation(rough)?, self.operation(even)?, finishing])
    }

    /// The least feed of finishing, mm, and a little, whose turns have enough points and all of them no more than a program may have; none
    /// where no feed up to the nose's radius does.
    #[must_use]
    pub fn least_feed_mm(&self) -> Option<f64> {
        /// Halvings of its logarithm, to far less than four digits from a thousandth of what is too little.
        const HALVINGS: usize = 40;
        /// What points before the first turn take, and rounding of the feed.
        const MARGIN: f64 = 1.02;
        let has_room = |feed_mm: f64| self.per_turn(self.finishing(feed_mm)).is_ok();
        let [mut low, mut high] = [1e-6, 1.0].map(|share| share * self.spec.nose.radius_mm);
        if !has_room(high) {
            return None;
        }
        for _ in 0..HALVINGS {
            let middle = f64::sqrt(low * high);
            if has_room(middle) { high = middle } else { low = middle }
        }
        Some(MARGIN * high)
    }

    /// Finishing with a feed.
    fn finishing(&self, feed_mm: f64) -> AskedOperation {
        AskedOperation {
            kind: OperationKind::Finishing,
            feed_mm,
            left_mm: 0.0,
            chord_mm: 1e-3 * self.spec.finishing.chord_um,
            slope: FINE_SLOPE * 0.5 * feed_mm / self.spec.nose.radius_mm,
        }
    }

    /// That no place falls along the direction of cutting more steeply than the tool's flank.
    fn clears_flank(&self) -> Result<(), TurningError> {
        let places = self.sections.places().iter();
        let Some(place) = places.min_by(|a, b| a.along.total_cmp(&b.along)) else { return Ok(()) };
        let slope_deg = degrees(atan(-place.along));
        let clearance_deg = self.servo.clearance_deg;
        if slope_deg > clearance_deg {
            return Err(TurningError::Flank {
                radius_mm: place.section.at.x,
                azimuth_deg: degrees(place.azimuth),
                slope_deg,
                clearance_deg,
            });
        }
        Ok(())
    }

    /// An operation with as many points of a turn as it needs.
    fn operation(&self, asked: AskedOperation) -> Result<ServoOperation, TurningError> {
        let mut per_turn = self.per_turn(asked)?;
        loop {
            let (heights, places) = self.spiral(asked, per_turn)?;
            let off = f64::sqrt(CHORD_SHARE * bend(&places) / asked.chord_mm);
            if off <= 1.0 {
                return self.along(asked, &heights, &places);
            }
            if per_turn == FINEST {
                return Err(chord_too_small(asked, off * off * asked.chord_mm));
            }
            let more = chosen(ROOM * off * per_turn as f64).unwrap_or(FINEST);
            per_turn = more.max(chosen(per_turn as f64 + 1.0).unwrap_or(FINEST));
        }
    }

    /// Points of a turn by the mirror's derivatives around the axis.
    fn per_turn(&self, asked: AskedOperation) -> Result<usize, TurningError> {
        let points = |share: f64| ROOM * TAU * share / FINEST as f64;
        let chord =
            self.sections.most(|place| f64::sqrt(place.around_mm().abs() / (8.0 * asked.chord_mm)));
        let slope = self
            .sections
            .most(|place| place.around_mm().abs() / (2.0 * asked.slope * place.section.at.x));
        let [chord, slope] = [points(chord), points(slope)];
        if chord > 1.0 {
            return Err(chord_too_small(asked, chord * chord * asked.chord_mm));
        }
        let Some(per_turn) = chosen(chord.max(slope) * FINEST as f64) else {
            // The slope that may be is in proportion to the feed.
            return Err(per_turn(
                asked,
                Some(("feed_mm_rev", rounded_up(slope * asked.feed_mm), "mm")),
            ));
        };
        let turns = (self.bar.radius_mm + BESIDE_MM + self.spec.nose.radius_mm) / asked.feed_mm;
        let count = turns * per_turn as f64;
        if count > MOST { Err(many(asked, count)) } else { Ok(per_turn) }
    }

    /// The nose's heights, and the places of its centre from beside the bar to the axis.
    fn spiral(
        &self,
        asked: AskedOperation,
        per_turn: usize,
    ) -> Result<(NoseHeights<'_>, Vec<DVec2>), TurningError> {
        let reach_mm = self.spec.nose.radius_mm + asked.left_mm;
        let tangent_mm = BEYOND * asked.feed_mm;
        let heights = NoseHeights::new(self.sections, reach_mm, per_turn, tangent_mm)?;
        let beside_mm = self.bar.radius_mm + BESIDE_MM + self.spec.nose.radius_mm;
        let outside_mm = beside_mm.max(heights.outside_mm() + tangent_mm);
        let places = NoseSpiral::new(outside_mm, asked.feed_mm).places(&heights)?;
        Ok((heights, places))
    }

    fn along(
        &self,
        asked: AskedOperation,
        heights: &NoseHeights,
        places: &[DVec2],
    ) -> Result<ServoOperation, TurningError> {
        let nose_mm = self.spec.nose.radius_mm;
        let lowest = places.iter().map(|at| at.y).fold(f64::INFINITY, f64::min) - nose_mm;
        if asked.kind == OperationKind::Finishing && lowest < self.floor_mm {
            let (below_mm, has_rim) = (self.floor_mm - lowest, self.has_rim);
            let what = if has_rim { "flat rim" } else { "base" };
            return Err(TurningError::Floor { nose_mm, below_mm, what, has_rim });
        }
        let limits = AxisLimits {
            acceleration_mm_s2: self.spec.machine.acceleration_mm_s2,
            speed_mm_min: self.spec.machine.rapid_mm_min,
            spindle_rpm: usual_rpm(self.spec, 2.0 * self.bar.radius_mm),
        };
        let mut table = TableBuilder::new(heights, self.safe_mm() + nose_mm, places, &limits);
        let stepdown_mm = stepdown_mm(self.spec);
        let levels = match asked.kind {
            OperationKind::Roughing => ((self.bar.top_mm - lowest) / stepdown_mm).ceil().max(1.0),
            _ => 1.0,
        } as usize;
        // By how much a place may be lower than that of the next turn.
        let rise_mm = asked.feed_mm * self.sections.most(|place| place.section.slope.abs());
        for level in (0..levels).rev() {
            let lift_mm = stepdown_mm * level as f64;
            // What goes above the bar is left out, but for a turn on both sides, in which it is lifted.
            let is_in = |at: &DVec2| at.y - nose_mm + lift_mm < self.bar.top_mm + rise_mm;
            let is_whole = asked.kind != OperationKind::Roughing;
            let first = if is_whole { Some(0) } else { places.iter().position(is_in) };
            let last = places.iter().rposition(is_in).filter(|_| !is_whole);
            let (Some(first), last) = (first, last.unwrap_or(places.len() - 1)) else { continue };
            let first = first.saturating_sub(heights.per_turn());
            let last = (last + heights.per_turn()).min(places.len() - 1);
            table.cut(&SpiralCut { places: &places[first..=last], first, lift_mm })?;
        }
        let table = table.finish(nose_mm);
        if table.points.len() as f64 > MOST {
            return Err(many(asked, table.points.len() as f64));
        }
        let (rpm, limit) = table.speed(&limits);
        Ok(ServoOperation {
            kind: asked.kind,
            nose_mm,
            feed_mm_rev: asked.feed_mm,
            levels,
            allowance_mm: asked.left_mm,
            table,
            rpm,
            limit,
        })
    }
}

/// The least number of points of a turn that is no less than what is needed.
fn chosen(needed: f64) -> Option<usize> {
    PER_TURN.into_iter().find(|&count| count as f64 >= needed)
}

/// A length in four decimals, no less than what is given.
fn rounded_up(mm: f64) -> f64 {
    (1e4 * mm).ceil() / 1e4
}

fn per_turn(
    asked: AskedOperation,
    remedy: Option<(&'static str, f64, &'static str)>,
) -> TurningError {
    TurningError::PerTurn { what: asked.kind.name(), most: FINEST, remedy }
}

/// No points of a turn follow the path within the chord; with `least_mm` the finest do.
fn chord_too_small(asked: AskedOperation, least_mm: f64) -> TurningError {
    let least_um = (1e6 * least_mm).ceil() / 1e3;
    let is_key = asked.kind == OperationKind::Finishing && least_um <= MOST_CHORD_UM;
    per_turn(asked, is_key.then_some(("chord_um", least_um, "um")))
}

/// More points than a table may have, with the feed that makes fewer turns.
fn many(asked: AskedOperation, count: f64) -> TurningError {
    let key = match asked.kind {
        OperationKind::Roughing => "rough_feed_mm_rev",
        _ => "feed_mm_rev",
    };
    TurningError::Points {
        what: asked.kind.name(),
        most: MOST,
        feed: (key, rounded_up(asked.feed_mm * count / MOST)),
    }
}
