//! Operations of a lathe: what each of them leaves, at which feed.

use super::TurningError;
use super::bar::Bar;
use super::cutting_data::{OperationFeeds, stepdown_mm, usual_rpm};
use super::facing::{BESIDE_MM, FacingLevels};
use super::meridian::Meridian;
use super::nose_path::{MoveLimits, NosePath};
use super::tool_fit;
use crate::geom::{DVec2, DVec3};
use crate::milling::{MotionList, OperationKind, TipMove};
use crate::profile::TurnSpec;

/// What straight moves of both are off the path over what they leave.
pub(super) const CHORD: f64 = 0.02;
/// Largest difference of the slopes of finishing moves from the path's over those of the cusps, f / (2 r), to which they add: where
/// all moves have it, it adds 4 % of the cusps' mean square.
pub const FINE_SLOPE: f64 = 0.2;
/// How far turns go on beside the rim, over their feed.
pub(super) const BEYOND: f64 = 2.0;
/// Most moves of an operation: as many as readers keep.
pub(super) const MOST: f64 = 5e6;

/// A mirror to be turned.
pub struct TurningTask<'a> {
    /// Its section.
    pub meridian: Meridian<'a>,
    /// How it is asked for.
    pub spec: &'a TurnSpec,
    /// Feed of finishing in a turn, mm.
    pub feed_mm: f64,
    /// The bar.
    pub bar: Bar,
    /// Z of what is around the mirror, below which no nose goes, mm.
    pub floor_mm: f64,
    /// Whether that is a flat rim.
    pub has_rim: bool,
}

/// What the tool does in one program of a lathe.
#[derive(Debug, Clone, PartialEq)]
pub struct TurnedOperation {
    /// What it is.
    pub kind: OperationKind,
    /// Radius of the nose, mm.
    pub nose_mm: f64,
    /// Feed in a turn, mm.
    pub feed_mm_rev: f64,
    /// Speed of the spindle, 1/min.
    pub spindle_rpm: f64,
    /// Levels; one of what follows the mirror.
    pub levels: usize,
    /// What it leaves on the mirror, mm.
    pub allowance_mm: f64,
    /// Whether the tool stays in the axis for a turn, so that the last turn is whole.
    pub is_held: bool,
    /// The moves of the tool point: X is the distance from the axis, Y is 0.
    pub motions: Vec<TipMove>,
}

impl TurningTask<'_> {
    /// Height of rapid moves, mm.
    #[must_use]
    pub fn safe_mm(&self) -> f64 {
        self.bar.top_mm + self.spec.machine.safe_mm
    }

    /// All operations, in their order.
    ///
    /// # Errors
    /// [`TurningError`] when the tool does not fit, or would go below what is around the mirror.
    pub fn operations(&self) -> Result<Vec<TurnedOperation>, TurningError> {
        let (nose, rough) = (&self.spec.nose, &self.spec.roughing);
        let edges_deg = [nose.inner_edge_deg, nose.outer_edge_deg];
        tool_fit::clears(self.meridian.places(), edges_deg)?;
        tool_fit::holds(self.meridian.places(), nose.radius_mm, rough.allowance_mm)?;
        let finishing = self.path(0.0, self.feed_mm, self.fine());
        self.check_floor(&finishing)?;
        let rough_mm = rough.allowance_mm;
        let OperationFeeds { rough_feed_mm, even_mm, even_feed_mm } =
            OperationFeeds::new(self.spec, self.feed_mm);
        let coarse = |left_mm: f64| MoveLimits { chord_mm: CHORD * left_mm, slope: f64::INFINITY };
        let rough_path = self.path(rough_mm, rough_feed_mm, coarse(rough_mm));
        let even_path = self.path(even_mm, even_feed_mm, coarse(even_mm));
        let operations = [
            self.roughing(&rough_path, rough_feed_mm, rough_mm),
            self.along(OperationKind::SemiFinishing, even_feed_mm, even_mm, &even_path),
            self.along(OperationKind::Finishing, self.feed_mm, 0.0, &finishing),
        ];
        for operation in &operations {
            if operation.motions.len() as f64 > MOST {
                return Err(TurningError::Many { what: operation.kind.name(), most: MOST });
            }
        }
        Ok(operations.into())
    }

    /// How moves of finishing follow their path.
    fn fine(&self) -> MoveLimits {
        let cusps = 0.5 * self.feed_mm / self.spec.nose.radius_mm;
        MoveLimits { chord_mm: 1e-3 * self.spec.finishing.chord_um, slope: FINE_SLOPE * cusps }
    }

    /// The tool point's path from beside the bar to the axis at a feed, with what is left on the mirror.
    fn path(&self, left_mm: f64, feed_mm: f64, limits: MoveLimits) -> Vec<DVec3> {
        let nose_mm = self.spec.nose.radius_mm;
        let reach_mm = nose_mm + left_mm;
        let path = NosePath::new(&self.meridian, reach_mm, BEYOND * feed_mm, limits);
        let point = |at: DVec2| DVec3::new(at.x - nose_mm, 0.0, at.y - nose_mm);
        let mut places: Vec<DVec3> = path.places.into_iter().map(point).collect();
        if let Some(first) = places.first().copied() {
            let beside_mm = self.bar.radius_mm + BESIDE_MM;
            places.insert(0, DVec3::new(beside_mm, 0.0, first.z));
        }
        places
    }

    /// That the nose is nowhere below what is around the mirror.
    fn check_floor(&self, path: &[DVec3]) -> Result<(), TurningError> {
        let lowest = path.iter().map(|at| at.z).fold(f64::INFINITY, f64::min);
        let below_mm = self.floor_mm - lowest;
        if below_mm > 0.0 {
            let what = if self.has_rim { "flat rim" } else { "base" };
            let nose_mm = self.spec.nose.radius_mm;
            return Err(TurningError::Floor { nose_mm, below_mm, what, has_rim: self.has_rim });
        }
        Ok(())
    }

    fn operation(
        &self,
        kind: OperationKind,
        feed_mm_rev: f64,
        allowance_mm: f64,
        (motions, levels): (Vec<TipMove>, usize),
    ) -> TurnedOperation {
        TurnedOperation {
            kind,
            nose_mm: self.spec.nose.radius_mm,
            feed_mm_rev,
            spindle_rpm: usual_rpm(self.spec, 2.0 * self.bar.radius_mm),
            levels,
            allowance_mm,
            is_held: kind != OperationKind::Roughing,
            motions,
        }
    }

    fn roughing(&self, path: &[DVec3], feed_mm_rev: f64, allowance_mm: f64) -> TurnedOperation {
        let cusp_mm = feed_mm_rev * feed_mm_rev / (8.0 * self.spec.nose.radius_mm);
        let levels = FacingLevels {
            bar: self.bar,
            stepdown_mm: stepdown_mm(self.spec),
            left_mm: 2.0 * (CHORD * allowance_mm + cusp_mm),
            safe_mm: self.safe_mm(),
        };
        self.operation(OperationKind::Roughing, feed_mm_rev, allowance_mm, levels.moves(path))
    }

    /// An operation along a path, from beside the bar.
    fn along(
        &self,
        kind: OperationKind,
        feed_mm_rev: f64,
        allowance_mm: f64,
        path: &[DVec3],
    ) -> TurnedOperation {
        let mut list = MotionList::new(self.safe_mm());
        if let Some(&begin) = path.first() {
            list.over(begin, begin.z);
        }
        list.cut(path.iter().copied());
        self.operation(kind, feed_mm_rev, allowance_mm, (list.finish(), 1))
    }
}
