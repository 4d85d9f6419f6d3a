//! What programs leave of a block, one after the other, held against the mirror.

use crate::design::Design;
use crate::machining::{BallRaster, FLOOR_MM, SurfaceAnalysis, surface_on_face};
use crate::milling::{Operation, OperationKind, StockBlock};
use crate::parallel;
use crate::profile::Profile;
use crate::program::{HeldCutter, MovedInto, StockBeside, StockMap, ToolPath};
use crate::results::{CutterPart, CuttingFault, LeftFacts, LengthFacts, StockMeeting};

/// Least that roughing and semi-finishing leave over what they are asked to.
const LEAST_ALLOWANCE: f64 = 0.9;
/// What finishing may cut into the mirror beyond the chords of its moves, mm: half a micrometre, for the decimals of programs and
/// the rounding of figures.
const GOUGE_MM: f64 = 5e-4;
/// Shares of what the picture's limits leave beside the design that scallops may take.
const SHARE: f64 = 0.9;
/// Least share of a limit that scallops may take, where the design leaves them less.
const LEAST_SHARE: f64 = 0.3;

/// The stepover, mm, whose scallops leave the picture within the profile's limits beside what the design does; none without a
/// projection. Scallops and design are taken for independent in the mean, and for adding up where they are largest. Limits that the
/// design all but uses up leave nothing for scallops, and are then kept by no stepover that a shop would take.
pub(crate) fn stepover_for_picture(
    profile: &Profile,
    design: &Design,
    analysis: &SurfaceAnalysis,
    raster: &BallRaster,
) -> Option<f64> {
    analysis.stepover_for_limits(raster, room_for_picture(profile, design)?)
}

/// What the profile's limits leave for scallops beside the design, RMS and largest, px; none without a projection.
pub(crate) fn room_for_picture(profile: &Profile, design: &Design) -> Option<[f64; 2]> {
    let own = design.facts.pixel_error_px?;
    let limits = profile.acceptance_limits();
    let [rms, max] = [limits.pixel_error_rms_px.value, limits.pixel_error_max_px.value];
    let room = |left: f64, limit: f64| SHARE * left.max(LEAST_SHARE * limit);
    let rms_px = room((rms * rms - own.rms * own.rms).max(0.0).sqrt(), rms);
    Some([rms_px, room(max - own.max, max)])
}

/// A block in the course of its programs.
pub(crate) struct MilledBlock {
    map: StockMap,
    /// Z of the mirror over each place, mm, and how much of Z its normal takes; none off the mirror.
    mirror: Vec<Option<[f64; 2]>>,
}

/// What a program leaves.
pub(crate) struct ProgramLeft {
    /// How much on the mirror; none where no place of the grid is over it.
    pub left: Option<LeftFacts>,
    /// Least length of the cutter's teeth, and of the cutter out of its holder; none of moves that meet no stock.
    pub lengths: [Option<LengthFacts>; 2],
    /// What is wrong.
    pub faults: Vec<CuttingFault>,
}

impl MilledBlock {
    /// The block before its programs.
    pub(crate) fn new(design: &Design, stock: StockBlock) -> Self {
        let map = StockMap::new([stock.min, stock.max], stock.top_mm);
        let mirror = parallel::map(map.heights.len(), 64, |k| {
            let place = surface_on_face(&design.mirror, map.place(k))?;
            Some([place.at.z, place.normal().z])
        });
        Self { map, mirror }
    }

    /// Takes away what a program of an operation cuts, whose moves are within `chord_mm` of their paths, with a cutter in a holder of this
    /// diameter.
    pub(crate) fn cut(
        &mut self,
        path: &ToolPath,
        operation: &Operation,
        [chord_mm, holder_mm]: [f64; 2],
    ) -> ProgramLeft {
        let Operation { kind, cutter, allowance_mm, lengths, .. } = *operation;
        let shank_mm = lengths.shank_diameter_mm.map_or(cutter.radius_mm, |wide| 0.5 * wide);
        let cutter = HeldCutter { cutter, shank_mm, holder_mm: 0.5 * holder_mm };
        let moved = self.map.cut(&path.moves, &cutter);
        let met = |kind: StockMeeting, found: MovedInto| CuttingFault::IntoStock {
            meeting: kind,
            line: found.line,
            at_mm: found.at.truncate().to_array(),
            depth_mm: found.depth_mm,
        };
        let rapid = moved.rapid.map(|found| met(StockMeeting::Rapid, found));
        let plunge = moved.plunge.map(|found| met(StockMeeting::Plunge, found));
        let [teeth, out] = [
            (moved.by_shank, lengths.flute_mm, CutterPart::Shank),
            (moved.by_holder, lengths.stickout_mm, CutterPart::Holder),
        ]
        .map(|(beside, given_mm, part)| (beside.map(|beside| length(beside, given_mm)), part));
        let short = [teeth, out].map(|(length, part)| too_short(length?, part));
        let left = self.left();
        let least_mm = match kind {
            OperationKind::Finishing => -chord_mm - GOUGE_MM,
            _ => LEAST_ALLOWANCE * allowance_mm,
        };
        let gouge =
            left.filter(|left| 1e-3 * left.least_um < least_mm).map(|left| CuttingFault::TooDeep {
                left_um: left.least_um,
                asked_um: 1e3 * allowance_mm,
                at_mm: left.least_at_mm,
            });
        let faults = [rapid, plunge].into_iter().chain(short).chain([gouge]).flatten().collect();
        ProgramLeft { left, lengths: [teeth.0, out.0], faults }
    }

    /// The least and the most that is left on the mirror.
    fn left(&self) -> Option<LeftFacts> {
        let off = |k: usize| {
            let [z, normal] = self.mirror[k]?;
            Some((1e3 * (self.map.heights[k] - z) * normal, self.map.place(k).to_array()))
        };
        let all = (0..self.mirror.len()).filter_map(off);
        all.fold(None, |found: Option<LeftFacts>, (um, at_mm)| {
            let one =
                LeftFacts { least_um: um, least_at_mm: at_mm, most_um: um, most_at_mm: at_mm };
            let Some(mut found) = found else { return Some(one) };
            if um < found.least_um {
                (found.least_um, found.least_at_mm) = (um, at_mm);
            }
            if um > found.most_um {
                (found.most_um, found.most_at_mm) = (um, at_mm);
            }
            Some(found)
        })
    }

    /// What is left on the mirror over each place of the grid, mm, row by row with Y rising: 0 for less than a tenth of a micrometre,
    /// none off the mirror; columns and rows; the distance of the places, mm.
    pub(crate) fn map(&self) -> (Vec<Option<f64>>, [usize; 2], f64) {
        let left = self.mirror.iter().zip(&self.map.heights).map(|(mirror, z)| {
            let [at, normal] = (*mirror)?;
            let left = (z - at) * normal;
            Some(if left > FLOOR_MM { left } else { 0.0 })
        });
        (left.collect(), self.map.size, self.map.pitch_mm)
    }
}

/// The least length of a part of a cutter, which stays clear of what stands beside it.
fn length(beside: StockBeside, given_mm: Option<f64>) -> LengthFacts {
    let StockBeside { line, at, over_tip_mm } = beside;
    LengthFacts { least_mm: over_tip_mm, given_mm, line, at_mm: at.truncate().to_array() }
}

fn too_short(length: LengthFacts, part: CutterPart) -> Option<CuttingFault> {
    let LengthFacts { least_mm, given_mm, line, at_mm } = length;
    let given_mm = given_mm.filter(|given| *given < least_mm)?;
    Some(CuttingFault::Short { part, line, at_mm, least_mm, given_mm })
}
