//! The face that a program of any making cuts: what its moves leave of the mirror.

use super::cusp_search::CuspSearch;
use super::turns_face::RoundFace;
use crate::design::Design;
use crate::forming::ParallelSurface;
use crate::geom::{DVec2, DVec3, TriMesh};
use crate::machining::{
    BallRaster, FaceLattice, MachiningError, ROWS, bounding_corners, face_of_cut, facet_estimate,
    plan_outlines,
};
use crate::mirror::Mirror;
use crate::num::degrees;
use crate::parallel;
use crate::profile::FinishingPath;
use crate::program::{PathCoverage, SweptBall, ToolMove, ToolPath, TurnCoverage};
use crate::results::{CutDeparture, CuttingFault, ProgramFacts};

/// The most facets of a face.
const MOST_FACETS: f64 = 6e6;
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
    /// What is less certain than the figures say.
    pub warning: Option<String>,
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

    /// What `path` cuts of the mirror of `design` with a ball.
    ///
    /// # Errors
    /// [`CuttingFault`] where no move comes over a place of the mirror, or lines are too near each other to be followed.
    pub(crate) fn new(
        design: &Design,
        path: &ToolPath,
        ball_mm: f64,
    ) -> Result<Self, CuttingFault> {
        let corners = bounding_corners(&plan_outlines(&design.mirror));
        let lines = contact_lines(&design.mirror, &path.moves, ball_mm);
        let coverage =
            PathCoverage::new(&lines.moves, lines.every, corners).ok_or(CuttingFault::Elsewhere)?;
        let swept = SweptBall::new(&path.moves, ball_mm, corners);
        if let Some((mesh, apart_mm)) = cut_by_turns(&design.mirror, &swept, &lines)? {
            let lines = LineFacts { apart_mm, angle_deg: None, parallel: None };
            return Ok(Self::of_face(design, path, (lines, &swept), mesh));
        }
        let PathCoverage { apart_mm, angle, parallel, .. } = coverage;
        let mesh = cut_by_lines(&design.mirror, &swept, coverage)?;
        let [angle_deg, parallel] = [degrees(angle), parallel].map(Some);
        let lines = LineFacts { apart_mm, angle_deg, parallel };
        Ok(Self::of_face(design, path, (lines, &swept), mesh))
    }

    fn of_face(
        design: &Design,
        path: &ToolPath,
        (lines, swept): (LineFacts, &SweptBall),
        mesh: TriMesh,
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
        let facts = ProgramFacts {
            ball_mm: Some(swept.radius_mm()),
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
            highest: extreme(1.0),
            lowest: extreme(-1.0),
        };
        // Facets of a pitch p that do not follow the cusps of lines w apart chord those off: of slopes that are even between
        // -w / 2R and w / 2R a share p / w of the root mean square is lost, an eighth across lines along the lattice's rows, and
        // sqrt(2) / 8 = 0.18 across its diagonals.
        let is_crossed = lines.parallel.is_some_and(|parallel| parallel < PARALLEL);
        let warning = is_crossed.then(|| {
            "the lines of the program run in several directions: facets cut off the cusps between them, and errors may be told \
             up to a fifth too small"
                .to_owned()
        });
        Self { mesh, facts, faults, warning }
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

/// The cut of turns about the axis of a round mirror, and how far apart they are, mm; none of other lines.
fn cut_by_turns(
    mirror: &Mirror,
    swept: &SweptBall,
    lines: &ContactLines,
) -> Result<Option<(TriMesh, f64)>, CuttingFault> {
    let Some(round) = RoundFace::new(mirror) else { return Ok(None) };
    let turns = TurnCoverage::new(&lines.moves, lines.every, round.radii_mm());
    let Some(turns) = turns else { return Ok(None) };
    let mesh = round.cut(swept, &turns, MOST_FACETS).transpose()?;
    Ok(mesh.map(|mesh| (mesh, turns.apart_mm)))
}

/// The cut of lines that cover `mirror` so.
fn cut_by_lines(
    mirror: &Mirror,
    swept: &SweptBall,
    coverage: PathCoverage,
) -> Result<TriMesh, CuttingFault> {
    let outlines = plan_outlines(mirror);
    let PathCoverage { apart_mm, angle, parallel, .. } = coverage;
    let raster = BallRaster { ball_mm: swept.radius_mm(), stepover_mm: apart_mm, angle };
    let is_parallel = parallel >= PARALLEL;
    let pitch_mm = raster.stepover_mm / ROWS as f64;
    let along_mm = if is_parallel { ALONG * raster.stepover_mm } else { pitch_mm };
    let facets = facet_estimate(&outlines, &raster, along_mm);
    if !(facets <= MOST_FACETS) {
        return Err(CuttingFault::Fine { apart_mm, facets, most: MOST_FACETS });
    }
    // Cusps are half-way between lines. With rows beside them errors are off by up to 2.3 % of themselves, else by 1.
    let row_mm = coverage.line_mm + 0.5 * coverage.apart_mm;
    let lattice = FaceLattice { raster, along_mm, row_mm };
    let height = |at: DVec2| Some(swept.lowest(at)?.z_mm);
    let ways = [raster.along(), raster.along().perp()];
    let cusps = CuspSearch { swept, ways, apart_mm, pitch_mm };
    let snapping = |_| {
        let cusps = &cusps;
        move |x, y| if is_parallel { cusps.near(x, y).unwrap_or(y) } else { y }
    };
    face_of_cut(&outlines, lattice, &height, snapping).map_err(|error| match error {
        MachiningError::Uncut { at } => CuttingFault::Uncut { at_mm: at.to_array() },
        // (Nothing else is asked of a lattice.)
        other => CuttingFault::Face { why: other.to_string() },
    })
}

/// Lines along which a ball touches a mirror.
struct ContactLines {
    /// As moves of the place of contact.
    moves: Vec<ToolMove>,
    /// One of so many moves is among them.
    every: usize,
}

/// The lines along which a ball that cuts the mirror touches it on its cutting moves: its centre is on the surface that is
/// parallel to the mirror.
fn contact_lines(mirror: &Mirror, moves: &[ToolMove], ball_mm: f64) -> ContactLines {
    let cutting: Vec<&ToolMove> = moves.iter().filter(|step| step.feed.is_some()).collect();
    let every = cutting.len().div_ceil(MOST_LINES).max(1);
    let centres = ParallelSurface { mirror, offset_mm: ball_mm };
    let contact = |tip: DVec3| Some(centres.place_over(tip.truncate())?.at);
    let chosen: Vec<&ToolMove> = cutting.into_iter().step_by(every).collect();
    // Moves off the mirror and what goes on beyond its rim touch nothing.
    let moves = parallel::map_slice(&chosen, 1 << 8, |step| {
        Some(ToolMove { from: contact(step.from)?, to: contact(step.to)?, ..**step })
    });
    ContactLines { moves: moves.into_iter().flatten().collect(), every }
}
