//! Operations: what each of them leaves, with which ball, at which lines.

use super::MillingError;
use super::bridge::TipLines;
use super::cutting_data::{Speeds, stepdown_mm};
use super::levels::LevelCut;
use super::motions::TipMove;
use super::rest_heights::RestHeights;
use super::rest_lines::rest_lines;
use super::spiral::TipSpiral;
use super::stock_block::StockBlock;
use super::stock_left::StockLeft;
use super::surface_lines::SurfaceCut;
use crate::geom::Cutter;
use crate::machining::{
    BallRaster, MOST_POINTS, MachiningError, Passes, SurfaceAnalysis, bounding_corners,
    plan_outlines,
};
use crate::mirror::Mirror;
use crate::profile::{CutterLengths, FinishingPath, MillSpec};
use serde::Serialize;

/// Stepover of roughing over the cutter's radius: 40 % of its diameter.
const ROUGH_STEPOVER: f64 = 0.8;
/// What stands between two lines of roughing over the cutter's radius, at most: of balls, whose cusps are half the stepover's square.
const ROUGH_CUSP: f64 = 0.5 * ROUGH_STEPOVER * ROUGH_STEPOVER;
/// Scallops of semi-finishing, and what its straight moves are off the path, over the allowance: it is to be left within 10 %.
const SEMI_SCALLOP: f64 = 0.06;
const SEMI_CHORD: f64 = 0.02;
/// What straight moves of roughing are off the path over the allowance.
const ROUGH_CHORD: f64 = 0.05;
/// Largest slopes of chords along finishing lines over those of the scallops across them, which are independent: they add up to 6 % to
/// the root mean square of both where the mirror is as curved everywhere, 1.5 % on the shipped ones.
const FINE_SLOPE: f64 = 0.35;
/// Most moves of an operation: what the reader of programs keeps.
const MOST: f64 = 5e6;

/// A mirror to be milled.
pub struct MillingTask<'a> {
    /// The mirror.
    pub mirror: &'a Mirror,
    /// Its curvature.
    pub analysis: &'a SurfaceAnalysis<'a>,
    /// How it is asked for.
    pub spec: &'a MillSpec,
    /// Lines of finishing.
    pub raster: BallRaster,
    /// The block.
    pub stock: StockBlock,
    /// Z of what is around the mirror, below which no tip goes, mm.
    pub floor_mm: f64,
    /// Whether that is a flat rim.
    pub has_rim: bool,
}

/// What one cutter does in one program.
#[derive(Debug, Clone, PartialEq)]
pub struct Operation {
    /// What it is.
    pub kind: OperationKind,
    /// The cutter's end.
    pub cutter: Cutter,
    /// Lengths of the cutter.
    pub lengths: CutterLengths,
    /// Distance of its lines in the plan, mm.
    pub stepover_mm: f64,
    /// Levels; one of what follows the surface.
    pub levels: usize,
    /// What it leaves on the mirror, mm.
    pub allowance_mm: f64,
    /// Speed and feeds.
    pub speeds: Speeds,
    /// The moves of its tip, from a place at the height of rapid moves on.
    pub motions: Vec<TipMove>,
}

/// Kind of an operation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum OperationKind {
    /// Levels, from the stock's top down.
    Roughing,
    /// Lines that leave an even allowance.
    SemiFinishing,
    /// Lines that leave the mirror.
    Finishing,
}

impl OperationKind {
    /// All, in their order.
    pub const ALL: [Self; 3] = [Self::Roughing, Self::SemiFinishing, Self::Finishing];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Roughing => "roughing",
            Self::SemiFinishing => "semi-finishing",
            Self::Finishing => "finishing",
        }
    }
}

impl MillingTask<'_> {
    /// Height of rapid moves, mm.
    #[must_use]
    pub fn safe_mm(&self) -> f64 {
        self.stock.top_mm + self.spec.machine.safe_mm
    }

    /// The cutter that roughs.
    #[must_use]
    pub fn rough_cutter(&self) -> Cutter {
        self.spec.roughing.cutter.unwrap_or_else(|| Cutter::ball(self.raster.ball_mm))
    }

    /// All operations, in their order.
    ///
    /// # Errors
    /// [`MillingError`] when lines cannot be worked out, or the ball would go below what is around the mirror.
    pub fn operations(&self) -> Result<Vec<Operation>, MillingError> {
        self.check_floor()?;
        self.check_hollow()?;
        let roughing = within_most(self.roughing()?)?;
        let mut left = StockLeft::new(self.stock, roughing.stepover_mm);
        left.cut(&roughing.motions, roughing.cutter, roughing.stepover_mm);
        let semi_finishing = within_most(self.semi_finishing(&left)?)?;
        left.cut(&semi_finishing.motions, semi_finishing.cutter, semi_finishing.stepover_mm);
        let finishing = within_most(self.finishing(&left)?)?;
        Ok(vec![roughing, semi_finishing, finishing])
    }

    /// That no ball that touches the rim is below what is around it.
    fn check_floor(&self) -> Result<(), MillingError> {
        let outlines = plan_outlines(self.mirror);
        let ball_mm = self.raster.ball_mm;
        let lowest = outlines.iter().flatten().flatten().filter_map(|&at| {
            let place = self.mirror.extended_surface_over(at)?;
            let tip = place.at.z - ball_mm * (1.0 - place.normal().z);
            Some((self.floor_mm - tip, at))
        });
        let lowest = lowest.reduce(|a, b| if b.0 > a.0 { b } else { a });
        match lowest {
            Some((below_mm, at)) if below_mm > 0.0 => {
                let what = if self.has_rim { "flat rim" } else { "base" };
                Err(MillingError::Floor { at, ball_mm, below_mm, what, has_rim: self.has_rim })
            }
            _ => Ok(()),
        }
    }

    /// That balls which leave an allowance fit where the mirror is most hollow, as a ball that is larger by as much must.
    fn check_hollow(&self) -> Result<(), MillingError> {
        let Some(hollow) = self.analysis.least_hollow_mm() else { return Ok(()) };
        let allowance_mm = self.spec.roughing.allowance_mm;
        // Other cutters than balls rest on what is too hollow for them.
        let rough = self.rough_cutter().ball_mm();
        let balls = [
            rough.map(|ball_mm| (ball_mm, "roughing", "program.rough_ball_mm")),
            Some((self.raster.ball_mm, "semi-finishing", "program.ball_mm")),
        ];
        let tight =
            balls.into_iter().flatten().find(|(ball_mm, ..)| ball_mm + allowance_mm > hollow.value);
        tight.map_or(Ok(()), |(ball_mm, what, key)| {
            let [x, y, _] = hollow.at_mm;
            let why = format!(
                "at X {x:.3} mm, Y {y:.3} mm the mirror is hollow with a radius of {:.4} mm, less than the ball's {ball_mm} mm and \
                 program.allowance_mm of {allowance_mm} mm",
                hollow.value
            );
            Err(MillingError::Unreached { why, what, key })
        })
    }

    /// The lines of a ball of radius `ball_mm` that leaves `allowance_mm`.
    fn lines(
        &self,
        [ball_mm, allowance_mm]: [f64; 2],
        stepover_mm: f64,
        [chord_mm, longest_mm]: [f64; 2],
    ) -> Result<TipLines, MillingError> {
        let raster = BallRaster { ball_mm: ball_mm + allowance_mm, stepover_mm, ..self.raster };
        let corners = bounding_corners(&plan_outlines(self.mirror));
        let passes = Passes::new(self.mirror, corners, raster).map_err(too_many)?;
        let paths = passes.paths(chord_mm, longest_mm);
        let mut lines = TipLines::new(&paths, ball_mm, self.mirror.folded);
        let all = lines.across.iter_mut().chain(&mut lines.ridge);
        all.for_each(|line| line.raise(self.floor_mm));
        Ok(lines)
    }

    /// The path over the surface of the ball that finishes, which leaves `allowance_mm`: its lines, or its spiral.
    fn surface_lines(
        &self,
        allowance_mm: f64,
        stepover_mm: f64,
        [chord_mm, longest_mm]: [f64; 2],
    ) -> Result<TipLines, MillingError> {
        let ball_mm = [self.raster.ball_mm, allowance_mm];
        if self.spec.finishing.path == FinishingPath::Lines {
            return self.lines(ball_mm, stepover_mm, [chord_mm, longest_mm]);
        }
        let spiral = TipSpiral { mirror: self.mirror, ball_mm, stepover_mm, chord_mm, longest_mm };
        let mut line = spiral.line().map_err(too_many)?;
        line.raise(self.floor_mm);
        Ok(TipLines { across: vec![line], ridge: Vec::new() })
    }

    /// Distance of the lines that rough, mm. On a slope what stands between those of a flat end is as high as the slope times their distance.
    fn rough_stepover_mm(&self, cutter: Cutter) -> f64 {
        let widest = ROUGH_STEPOVER * cutter.radius_mm;
        if cutter.ball_mm().is_some() {
            return widest;
        }
        let (steepest, _) = self.analysis.largest(|place| place.slope.length());
        let by_slope = ROUGH_CUSP * cutter.radius_mm / steepest.max(f64::MIN_POSITIVE);
        widest.min(by_slope)
    }

    /// The lines along which a cutter that is no ball rests on the mirror with the allowance.
    fn rest_lines(&self, cutter: Cutter, stepover_mm: f64) -> TipLines {
        let heights = RestHeights::new(self.mirror, cutter, self.spec.roughing.allowance_mm);
        let raster = BallRaster { ball_mm: cutter.radius_mm, stepover_mm, ..self.raster };
        let corners = bounding_corners(&plan_outlines(self.mirror));
        let mut lines = rest_lines(&heights, &raster, corners);
        lines.across.iter_mut().for_each(|line| line.raise(self.floor_mm));
        lines
    }

    fn roughing(&self) -> Result<Operation, MillingError> {
        let (cutter, allowance_mm) = (self.rough_cutter(), self.spec.roughing.allowance_mm);
        let ball_mm = cutter.radius_mm;
        let chord_mm = ROUGH_CHORD * allowance_mm;
        let stepover_mm = self.rough_stepover_mm(cutter);
        let lines = match cutter.ball_mm() {
            Some(ball_mm) => {
                self.lines([ball_mm, allowance_mm], stepover_mm, [chord_mm, f64::INFINITY])?
            }
            None => self.rest_lines(cutter, stepover_mm),
        };
        let cut = LevelCut {
            stock: self.stock,
            raster: BallRaster { ball_mm, stepover_mm, ..self.raster },
            stepdown_mm: stepdown_mm(self.spec, ball_mm),
            chord_mm,
            safe_mm: self.safe_mm(),
        };
        let (motions, levels) = cut.moves(&lines);
        Ok(Operation {
            kind: OperationKind::Roughing,
            cutter,
            lengths: self.spec.rough_lengths(),
            stepover_mm,
            levels,
            allowance_mm,
            speeds: Speeds::new(self.spec, ball_mm, self.spec.speeds.rough_feed_mm_min),
            motions,
        })
    }

    fn semi_finishing(&self, left: &StockLeft) -> Result<Operation, MillingError> {
        let allowance_mm = self.spec.roughing.allowance_mm;
        let ball_mm = self.raster.ball_mm;
        // (Scallops over the mirror are those over the allowance but for its thickness over the mirror's radius.)
        let asked = self.analysis.stepover_for_height(&self.raster, SEMI_SCALLOP * allowance_mm);
        let stepover_mm = asked.unwrap_or(0.2 * ball_mm);
        let limits = [SEMI_CHORD * allowance_mm, f64::INFINITY];
        let lines = self.surface_lines(allowance_mm, stepover_mm, limits)?;
        let feed = self.spec.speeds.feed_mm_min;
        Ok(self.along_surface(
            (OperationKind::SemiFinishing, feed),
            [stepover_mm, allowance_mm],
            (&lines, left),
        ))
    }

    fn finishing(&self, left: &StockLeft) -> Result<Operation, MillingError> {
        let stepover_mm = self.raster.stepover_mm;
        let chord_mm = 1e-3 * self.spec.finishing.chord_um;
        let longest_mm = self.analysis.along_mm(&self.raster, FINE_SLOPE);
        let lines = self.surface_lines(0.0, stepover_mm, [chord_mm, longest_mm])?;
        let feed = self.spec.speeds.feed_mm_min;
        Ok(self.along_surface((OperationKind::Finishing, feed), [stepover_mm, 0.0], (&lines, left)))
    }

    /// An operation along lines, of what was left.
    fn along_surface(
        &self,
        (kind, feed_mm_min): (OperationKind, Option<f64>),
        [stepover_mm, allowance_mm]: [f64; 2],
        (lines, stock): (&TipLines, &StockLeft),
    ) -> Operation {
        let ball_mm = self.raster.ball_mm;
        let cut = SurfaceCut { ball_mm, stepover_mm, stock, safe_mm: self.safe_mm() };
        Operation {
            kind,
            cutter: Cutter::ball(ball_mm),
            lengths: self.spec.finishing.lengths,
            stepover_mm,
            levels: 1,
            allowance_mm,
            speeds: Speeds::new(self.spec, ball_mm, feed_mm_min),
            motions: cut.moves(lines),
        }
    }
}

/// The operation, if its moves can be kept.
fn within_most(operation: Operation) -> Result<Operation, MillingError> {
    let count = operation.motions.len() as f64;
    if count > MOST {
        let (what, key) = (operation.kind.name(), "stepover_mm");
        return Err(MillingError::Many { what, count, most: MOST, key });
    }
    Ok(operation)
}

/// Lines of which there are more than can be kept.
fn too_many(error: MachiningError) -> MillingError {
    match error {
        MachiningError::TooFine { count, .. } => {
            let (what, key) = ("the lines", "stepover_mm");
            MillingError::Many { what, count, most: MOST_POINTS, key }
        }
        other => other.into(),
    }
}
