//! The face that a program of any making cuts: what its moves leave of the mirror.

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
use crate::program::{PathCoverage, SweptBall, SweptPlace, ToolMove, ToolPath};
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
/// Halvings of the interval in which a cusp is searched for.
const HALVINGS: usize = 24;

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
    /// The least distance of lines, mm, whose cut of `mirror` facets can follow, and a little.
    #[must_use]
    pub(crate) fn narrowest_mm(mirror: &Mirror) -> f64 {
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
        let outlines = plan_outlines(&design.mirror);
        let corners = bounding_corners(&outlines);
        let lines = contact_lines(&design.mirror, &path.moves, ball_mm);
        let coverage =
            PathCoverage::new(&lines.moves, lines.every, corners).ok_or(CuttingFault::Elsewhere)?;
        let swept = SweptBall::new(&path.moves, ball_mm, corners);
        let raster = BallRaster { ball_mm, stepover_mm: coverage.apart_mm, angle: coverage.angle };
        let is_parallel = coverage.parallel >= PARALLEL;
        let pitch_mm = raster.stepover_mm / ROWS as f64;
        let along_mm = if is_parallel { ALONG * raster.stepover_mm } else { pitch_mm };
        let facets = facet_estimate(&outlines, &raster, along_mm);
        if !(facets <= MOST_FACETS) {
            let apart_mm = raster.stepover_mm;
            return Err(CuttingFault::Fine { apart_mm, facets, most: MOST_FACETS });
        }
        // Cusps are half-way between lines. With rows beside them errors are off by up to 2.3 % of themselves, else by 1.
        let row_mm = coverage.line_mm + 0.5 * coverage.apart_mm;
        let lattice = FaceLattice { raster, along_mm, row_mm };
        let height = |at: DVec2| Some(swept.lowest(at)?.z_mm);
        let cusps = CuspSearch { swept: &swept, raster, pitch_mm };
        let snapping = |_| {
            let cusps = &cusps;
            move |x, y| if is_parallel { cusps.snap(x, y) } else { y }
        };
        let mesh = face_of_cut(&outlines, lattice, &height, snapping).map_err(|error| {
            match error {
                MachiningError::Uncut { at } => CuttingFault::Uncut { at_mm: at.to_array() },
                // (Nothing else is asked of a lattice.)
                other => CuttingFault::Face { why: other.to_string() },
            }
        })?;
        Ok(Self::of_face(design, path, (coverage, &swept), mesh))
    }

    fn of_face(
        design: &Design,
        path: &ToolPath,
        (coverage, swept): (PathCoverage, &SweptBall),
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
            apart_mm: coverage.apart_mm,
            angle_deg: Some(degrees(coverage.angle)),
            parallel: Some(coverage.parallel),
            optical_triangles: mesh.triangles.len(),
            highest: extreme(1.0),
            lowest: extreme(-1.0),
        };
        // Facets of a pitch p that do not follow the cusps of lines w apart chord those off: of slopes that are even between
        // -w / 2R and w / 2R a share p / w of the root mean square is lost, an eighth across lines along the lattice's rows, and
        // sqrt(2) / 8 = 0.18 across its diagonals.
        let warning = (coverage.parallel < PARALLEL).then(|| {
            "the lines of the program run in several directions: facets cut off the cusps between them, and errors may be told \
             up to a fifth too small"
                .to_owned()
        });
        Self { mesh, facts, faults, warning }
    }
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

/// Places in which the cuts of two moves meet, by search.
struct CuspSearch<'a> {
    swept: &'a SweptBall,
    raster: BallRaster,
    /// From row to row of the lattice, mm.
    pitch_mm: f64,
}

impl CuspSearch<'_> {
    /// y of the cusp within half a row of the place (`x`, `y`), x along the raster's lines; y itself where there is none.
    fn snap(&self, x: f64, y: f64) -> f64 {
        let (along, across) = (self.raster.along(), self.raster.along().perp());
        let at = |y: f64| along * x + across * y;
        let half = 0.5 * self.pitch_mm;
        let lowest = |y: f64| self.swept.lowest(at(y));
        let (Some(before), Some(after)) = (lowest(y - half), lowest(y + half)) else { return y };
        let rises = |place: &SweptPlace| place.slope.dot(across);
        // Up to a cusp the cut rises and beyond it falls, by about half a stepover over the radius each.
        let least = 0.25 * self.raster.stepover_mm / self.raster.ball_mm;
        if before.step == after.step || !(rises(&before) - rises(&after) > least) {
            return y;
        }
        let [mut low, mut high] = [y - half, y + half];
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let of = |place: &SweptPlace| self.swept.of_step(place.step, at(middle));
            // Beyond its ball a move cuts nothing.
            let is_before = match (of(&before), of(&after)) {
                (Some((a, _)), Some((b, _))) => a < b,
                (a, _) => a.is_some(),
            };
            if is_before { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }
}
