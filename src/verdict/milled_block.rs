//! What programs leave of a block, one after the other, held against the mirror.

use crate::design::Design;
use crate::geom::DVec3;
use crate::machining::{BallRaster, FLOOR_MM, SurfaceAnalysis, surface_on_face};
use crate::milling::{OperationKind, StockBlock};
use crate::parallel;
use crate::profile::Profile;
use crate::program::{StockMap, ToolPath};
use crate::results::{CuttingFault, LeftFacts};

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
    let own = design.facts.pixel_error_px?;
    let limits = profile.acceptance_limits();
    let [rms, max] = [limits.pixel_error_rms_px.value, limits.pixel_error_max_px.value];
    let room = |left: f64, limit: f64| SHARE * left.max(LEAST_SHARE * limit);
    let rms_px = room((rms * rms - own.rms * own.rms).max(0.0).sqrt(), rms);
    let max_px = room(max - own.max, max);
    analysis.stepover_for_limits(raster, [rms_px, max_px])
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

    /// Takes away what a program cuts with a ball, which is to leave `allowance_mm`; its moves are within `chord_mm` of their paths.
    pub(crate) fn cut(
        &mut self,
        path: &ToolPath,
        kind: OperationKind,
        [ball_mm, allowance_mm, chord_mm]: [f64; 3],
    ) -> ProgramLeft {
        let moved = self.map.cut(&path.moves, ball_mm);
        let at_mm = |at: DVec3| [at.x, at.y];
        let rapid = moved.rapid.map(|rapid| CuttingFault::RapidIntoStock {
            line: rapid.line,
            at_mm: at_mm(rapid.at),
            depth_mm: rapid.depth_mm,
        });
        let plunge = moved.plunge.map(|plunge| CuttingFault::Plunge {
            line: plunge.line,
            at_mm: at_mm(plunge.at),
            depth_mm: plunge.depth_mm,
        });
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
        ProgramLeft { left, faults: [rapid, plunge, gouge].into_iter().flatten().collect() }
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
