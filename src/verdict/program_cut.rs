//! The face that a program of any making cuts: what its moves leave of the mirror.

use super::cusp_search::CuspSearch;
use super::cut_slopes::{CutSlopes, SlopeSource};
use super::turns_face::RoundFace;
use crate::design::Design;
use crate::forming::ParallelSurface;
use crate::geom::{Cutter, DVec2, DVec3, TriMesh};
use crate::machining::{
    BallRaster, FaceLattice, MachiningError, ROWS, bounding_corners, face_of_cut, facet_estimate,
    plan_outlines,
};
use crate::mirror::Mirror;
use crate::num::degrees;
use crate::parallel;
use crate::profile::FinishingPath;
use crate::program::{PathCoverage, SweptCutter, ToolMove, ToolPath, TurnCoverage};
use crate::results::{CutDeparture, CuttingFault, ProgramFacts, SlopeOrigin};

/// The most facets of a face whose cusps they follow.
const MOST_FACETS: f64 = 6e6;
/// The most of one whose slopes the program tells: with 2 million chords of the shipped mirrors are less than a micrometre off them.
const MOST_PLAIN_FACETS: f64 = 2e6;
/// Step along parallel lines, in their distance: where a mirror is as curved along them as a tenth of the ball, chords change
/// slopes by a tenth of what the scallops do, which adds half a percent.
const ALONG: f64 = 1.0;
/// Lines that agree so much in their direction are parallel.
const PARALLEL: f64 = 0.98;
/// Most moves of which the lines of contact are searched for.
const MOST_LINES: usize = 20_000;

/// A face as a program cuts it.
pub(crate) struct ProgramCut {
    /// The facets.
    pub mesh: TriMesh,
    /// The figures.
    pub facts: ProgramFacts,
    /// Why it is no part that passes, whatever the camera sees.
    pub faults: Vec<CuttingFault>,
    /// Slopes of the face, where facets do not follow its cusps.
    pub slopes: Option<CutSlopes>,
}

impl ProgramCut {
    /// The least distance of lines or turns, mm, whose cut of `mirror` by a ball facets can follow, and a little.
    #[must_use]
    pub(crate) fn narrowest_mm(mirror: &Mirror, path: FinishingPath, ball_mm: f64) -> f64 {
        let round = RoundFace::new(mirror).filter(|_| path == FinishingPath::Spiral);
        if let Some(round) = round {
            return 1.05 * round.narrowest_mm(ball_mm, MOST_FACETS);
        }
        let raster = BallRaster { ball_mm: 1.0, stepover_mm: 1.0, angle: 0.0 };
        let facets = facet_estimate(&plan_outlines(mirror), &raster, ALONG);
        1.05 * f64::sqrt(facets / MOST_FACETS)
    }

    /// What `path` cuts of the mirror of `design` with a cutter.
    ///
    /// # Errors
    /// [`CuttingFault`] where no move comes over a place of the mirror.
    pub(crate) fn new(
        design: &Design,
        path: &ToolPath,
        cutter: Cutter,
    ) -> Result<Self, CuttingFault> {
        let corners = bounding_corners(&plan_outlines(&design.mirror));
        let lines = contact_lines(&design.mirror, &path.moves, cutter);
        let coverage =
            PathCoverage::new(&lines.moves, lines.every, corners).ok_or(CuttingFault::Elsewhere)?;
        let swept = SweptCutter::new(&path.moves, cutter, corners);
        let mirror = &design.mirror;
        if let Some((face, apart_mm)) = cut_by_turns(mirror, &swept, &lines)? {
            let lines = LineFacts { apart_mm, angle_deg: None, parallel: None };
            return Ok(Self::of_face(design, path, (lines, swept), face));
        }
        let PathCoverage { apart_mm, angle, parallel, .. } = coverage;
        let face = cut_by_lines(mirror, &swept, coverage)?;
        let [angle_deg, parallel] = [degrees(angle), parallel].map(Some);
        let lines = LineFacts { apart_mm, angle_deg, parallel };
        Ok(Self::of_face(design, path, (lines, swept), face))
    }

    /// Of a face of which is told whether facets follow its cusps.
    fn of_face(
        design: &Design,
        path: &ToolPath,
        (lines, swept): (LineFacts, SweptCutter),
        (mesh, follows_cusps): (TriMesh, bool),
    ) -> Self {
        let mirror = &design.mirror;
        let departures = parallel::map_slice(&mesh.vertices, 1 << 12, |v| {
            let place = mirror.local_surface_over(v.truncate(), v.z)?;
            let cut = swept.lowest(v.truncate())?;
            let off_mm = (v.z - place.at.z) * place.normal().z;
            Some((off_mm, v.to_array(), cut.step))
        });
        let departures: Vec<_> = departures.into_iter().flatten().collect();
        let departure = |&(off_mm, at_mm, step): &(f64, [f64; 3], usize)| CutDeparture {
            off_um: 1e3 * off_mm,
            at_mm,
            line: path.moves[step].line,
        };
        let extreme = |sign: f64| {
            let higher = |a: &(f64, [f64; 3], usize), b: &(f64, [f64; 3], usize)| {
                (sign * a.0).total_cmp(&(sign * b.0))
            };
            let none = CutDeparture { off_um: f64::NAN, at_mm: [f64::NAN; 3], line: 0 };
            departures.iter().max_by(|a, b| higher(a, b)).map_or(none, departure)
        };
        let by_rapid = departures.iter().find(|(_, _, step)| path.moves[*step].feed.is_none());
        let faults =
            by_rapid.map(departure).map(|CutDeparture { at_mm: [x, y, _], line, .. }| {
                CuttingFault::Rapid { line, at_mm: [x, y] }
            });
        let below = path.lowest().filter(|step| step.to.z < 0.0);
        let below = below.map(|step| CuttingFault::BelowBase { line: step.line, z_mm: step.to.z });
        let faults = faults.into_iter().chain(below).collect();
        let [cutting_mm, rapid_mm] = path.lengths_mm();
        let cutter = swept.cutter();
        let other = cutter.ball_mm().is_none().then_some(cutter);
        let facts = ProgramFacts {
            ball_mm: cutter.ball_mm(),
            radius_mm: other.map(|cutter| cutter.radius_mm),
            corner_mm: other.map(|cutter| cutter.corner_mm),
            nose_mm: None,
            lines: path.lines,
            moves: path.moves.len(),
            cutting_mm,
            rapid_mm,
            cutting_min: path.cutting_min(),
            apart_mm: lines.apart_mm,
            angle_deg: lines.angle_deg,
            parallel: lines.parallel,
            optical_triangles: mesh.triangles.len(),
            slopes: SlopeOrigin::of(!follows_cusps),
            highest: extreme(1.0),
            lowest: extreme(-1.0),
        };
        let facets = mesh.triangles.len();
        let slopes = (!follows_cusps).then(|| CutSlopes::new(SlopeSource::Milled(swept), facets));
        Self { mesh, facts, faults, slopes }
    }
}

/// How lines lie over the face.
struct LineFacts {
    /// Distance from one to the next, mm.
    apart_mm: f64,
    /// Direction of most of them, degrees; none of turns about the axis.
    angle_deg: Option<f64>,
    /// How much they agree in it; none of turns.
    parallel: Option<f64>,
}

/// A face, and whether facets follow its cusps.
type CutFace = (TriMesh, bool);

/// The cut of turns about the axis of a round mirror, and how far apart they are, mm; none of other lines.
fn cut_by_turns(
    mirror: &Mirror,
    swept: &SweptCutter,
    lines: &ContactLines,
) -> Result<Option<(CutFace, f64)>, CuttingFault> {
    let Some(round) = RoundFace::new(mirror) else { return Ok(None) };
    let turns = TurnCoverage::new(&lines.moves, lines.every, round.radii_mm());
    let Some(turns) = turns else { return Ok(None) };
    let face = round.cut(swept, &turns, most_facets(swept.cutter())).transpose()?;
    Ok(face.map(|face| (face, turns.apart_mm)))
}

/// The cut of lines that cover `mirror` so. Facets follow cusps of lines that are parallel, and not too near each other for that.
fn cut_by_lines(
    mirror: &Mirror,
    swept: &SweptCutter,
    coverage: PathCoverage,
) -> Result<CutFace, CuttingFault> {
    let outlines = plan_outlines(mirror);
    let PathCoverage { apart_mm, angle, parallel, .. } = coverage;
    let ball_mm = swept.cutter().radius_mm;
    let mut raster = BallRaster { ball_mm, stepover_mm: apart_mm, angle };
    let mut along_mm = ALONG * raster.stepover_mm;
    let facets = facet_estimate(&outlines, &raster, along_mm);
    let follows_cusps = parallel >= PARALLEL && facets <= most_facets(swept.cutter());
    if !follows_cusps {
        // Squares, a row to each.
        along_mm = raster.stepover_mm / ROWS as f64;
        let facets = facet_estimate(&outlines, &raster, along_mm);
        let wider = f64::sqrt(facets / MOST_PLAIN_FACETS).max(1.0);
        along_mm *= wider;
        raster.stepover_mm *= wider;
    }
    let pitch_mm = raster.stepover_mm / ROWS as f64;
    // Cusps are half-way between lines. With rows beside them errors are off by up to 2.3 % of themselves, else by 1.
    let row_mm = coverage.line_mm + 0.5 * coverage.apart_mm;
    let lattice = FaceLattice { raster, along_mm, row_mm };
    let height = |at: DVec2| Some(swept.lowest(at)?.z_mm);
    let ways = [raster.along(), raster.along().perp()];
    let cusps = CuspSearch { swept, ways, apart_mm, pitch_mm };
    let snapping = |_| {
        let cusps = &cusps;
        move |x, y| if follows_cusps { cusps.near(x, y).unwrap_or(y) } else { y }
    };
    let face = face_of_cut(&outlines, lattice, &height, snapping).map_err(|error| match error {
        MachiningError::Uncut { at } => CuttingFault::Uncut { at_mm: at.to_array() },
        // (Nothing else is asked of a lattice.)
        other => CuttingFault::Face { why: other.to_string() },
    })?;
    Ok((face, follows_cusps))
}

/// The most facets that follow the cusps of a cutter: none those of one with a flat end, whose bends are anywhere.
fn most_facets(cutter: Cutter) -> f64 {
    if cutter.ball_mm().is_some() { MOST_FACETS } else { 0.0 }
}

/// Lines along which a cutter touches a mirror.
struct ContactLines {
    /// As moves of the place of contact.
    moves: Vec<ToolMove>,
    /// One of so many moves is among them.
    every: usize,
}

/// The lines along which a ball that cuts the mirror touches it on its cutting moves: its centre is on the surface that is
/// parallel to the mirror. Of another cutter the lines are those of its tip.
fn contact_lines(mirror: &Mirror, moves: &[ToolMove], cutter: Cutter) -> ContactLines {
    let cutting: Vec<&ToolMove> = moves.iter().filter(|step| step.feed.is_some()).collect();
    let every = cutting.len().div_ceil(MOST_LINES).max(1);
    let contact = |tip: DVec3| match cutter.ball_mm() {
        Some(offset_mm) => {
            Some(ParallelSurface { mirror, offset_mm }.place_over(tip.truncate())?.at)
        }
        None => Some(mirror.local_surface_over(tip.truncate(), tip.z)?.at),
    };
    let chosen: Vec<&ToolMove> = cutting.into_iter().step_by(every).collect();
    // Moves off the mirror and what goes on beyond its rim touch nothing.
    let moves = parallel::map_slice(&chosen, 1 << 8, |step| {
        Some(ToolMove { from: contact(step.from)?, to: contact(step.to)?, ..**step })
    });
    ContactLines { moves: moves.into_iter().flatten().collect(), every }
}
