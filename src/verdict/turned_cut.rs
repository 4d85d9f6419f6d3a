//! The face that a program of a lathe leaves of a mirror.

use super::polar_face::{self, PolarFace, PolarFault, PolarLimits};
use super::program_cut::ProgramCut;
use crate::design::Design;
use crate::geom::{DVec2, TriMesh};
use crate::parallel;
use crate::program::{ToolMove, TurnedSurface, TurningPath, nose_below};
use crate::results::{CutDeparture, CuttingFault, ProgramFacts};
use crate::turning::Meridian;

/// The most facets of a face that programs are written for, and of one that is read: estimates of both differ.
const MOST_FACETS: f64 = 4e6;
const MOST_READ: f64 = 6e6;
/// A share by which feeds are kept above the least that facets can follow.
const ROOM: f64 = 1.05;
/// What a rapid move may be below the mirror, mm: the rounding of programs.
const TOUCH_MM: f64 = 2e-3;

/// The least feed in a turn, mm, whose cut facets can follow, of a nose over a meridian.
pub(crate) fn narrowest_feed_mm(meridian: &Meridian, nose_mm: f64) -> f64 {
    let (length_mm, steepest) = (meridian.length_mm(), meridian.steepest());
    let facets = |feed_mm: f64| facets_of([length_mm, steepest], nose_mm, feed_mm);
    let [mut low, mut high] = [0.0, nose_mm];
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if facets(middle) <= MOST_FACETS { high = middle } else { low = middle }
    }
    ROOM * high
}

/// About how many facets it takes to follow turns so far apart, and the most.
pub(crate) fn turned_facets(meridian: &Meridian, nose_mm: f64, feed_mm: f64) -> [f64; 2] {
    [facets_of([meridian.length_mm(), meridian.steepest()], nose_mm, feed_mm), MOST_FACETS]
}

fn facets_of([length_mm, steepest]: [f64; 2], nose_mm: f64, feed_mm: f64) -> f64 {
    let azimuths = polar_face::azimuths(steepest, 0.5 * feed_mm / nose_mm);
    polar_face::facet_estimate(length_mm / feed_mm, azimuths)
}

/// The face that `path` leaves of the mirror of `design`, whose section is `meridian`, with a nose.
///
/// # Errors
/// [`CuttingFault`] where no move comes over a place of the mirror, or turns are too near each other to be followed.
pub(crate) fn turned_cut(
    design: &Design,
    meridian: &Meridian,
    path: &TurningPath,
    nose_mm: f64,
) -> Result<ProgramCut, CuttingFault> {
    let surface = TurnedSurface::new(path, nose_mm);
    let radii_mm = meridian.ends().map(|q| meridian.at(q).at.x);
    let feed_mm = feed_over(path, radii_mm, nose_mm).ok_or(CuttingFault::Elsewhere)?;
    let limits = PolarLimits {
        radii_mm,
        steepest: meridian.steepest(),
        tilt: 0.5 * feed_mm / nose_mm,
        most: MOST_READ,
    };
    let PolarFace { mesh, steps, apart_mm } =
        PolarFace::new(&surface, limits).map_err(|fault| match fault {
            PolarFault::Uncut(at_mm) => CuttingFault::Uncut { at_mm },
            PolarFault::Fine(apart_mm, facets) => {
                CuttingFault::Fine { apart_mm, facets, most: MOST_READ }
            }
        })?;
    let [highest, lowest] = extremes(design, &mesh, |k| path.tool.moves[steps[k]].line);
    let [cutting_mm, rapid_mm] = path.tool.lengths_mm();
    let facts = ProgramFacts {
        ball_mm: None,
        nose_mm: Some(nose_mm),
        lines: path.tool.lines,
        moves: path.tool.moves.len(),
        cutting_mm,
        rapid_mm,
        cutting_min: path.tool.cutting_min(),
        apart_mm,
        angle_deg: None,
        parallel: None,
        optical_triangles: mesh.triangles.len(),
        highest,
        lowest,
    };
    let below = path.tool.lowest().filter(|step| step.to.z < 0.0);
    let below = below.map(|step| CuttingFault::BelowBase { line: step.line, z_mm: step.to.z });
    let faults = rapid(meridian, path, nose_mm).into_iter().chain(below).collect();
    Ok(ProgramCut { mesh, facts, faults, warning: None })
}

/// The most and the least that a face leaves on the mirror, with the line that cuts each of its vertices.
fn extremes(
    design: &Design,
    mesh: &TriMesh,
    line: impl Fn(usize) -> u32 + Sync,
) -> [CutDeparture; 2] {
    let departures = parallel::map(mesh.vertices.len(), 1 << 12, |k| {
        let v = mesh.vertices[k];
        let place = design.mirror.local_surface_over(v.truncate(), v.z)?;
        let off_um = 1e3 * (v.z - place.at.z) * place.normal().z;
        Some(CutDeparture { off_um, at_mm: v.to_array(), line: line(k) })
    });
    let departures: Vec<CutDeparture> = departures.into_iter().flatten().collect();
    [1.0, -1.0].map(|sign| {
        let none = CutDeparture { off_um: f64::NAN, at_mm: [f64::NAN; 3], line: 0 };
        let all = departures.iter().copied();
        all.reduce(|a, b| if sign * b.off_um > sign * a.off_um { b } else { a }).unwrap_or(none)
    })
}

/// Mean feed in a turn of the moves that may cut a mirror between two radii, mm; none without one.
fn feed_over(path: &TurningPath, [inner, outer]: [f64; 2], nose_mm: f64) -> Option<f64> {
    let over = |step: &ToolMove| {
        let middle = 0.5 * (step.from.x + step.to.x) + nose_mm;
        middle > inner - nose_mm && middle < outer + nose_mm && step.from != step.to
    };
    let cutting = path.tool.moves.iter().zip(&path.turns);
    let (mut length, mut all) = (0.0, 0.0);
    for (step, turns) in cutting.filter(|(step, turns)| **turns > 0.0 && over(step)) {
        length += step.from.distance(step.to);
        all += turns;
    }
    (all > 0.0).then(|| length / all)
}

/// A rapid move through the mirror: its nose is lower than the meridian.
fn rapid(meridian: &Meridian, path: &TurningPath, nose_mm: f64) -> Option<CuttingFault> {
    let places: Vec<DVec2> = meridian.places().map(|place| place.at).collect();
    let rapids = path.tool.moves.iter().filter(|step| step.feed.is_none());
    rapids.into_iter().find_map(|step| {
        let is_cut =
            |at: &&DVec2| nose_below(step, nose_mm, at.x).is_some_and(|z| z < at.y - TOUCH_MM);
        let deep = places.iter().find(is_cut)?;
        Some(CuttingFault::Rapid { line: step.line, at_mm: [deep.x, 0.0] })
    })
}
