//! The face that a program of a lathe leaves of a mirror.

use super::cut_slopes::{CutSlopes, SlopeSource};
use super::polar_face::{PolarFace, PolarLimits, UncutPlace};
use super::program_cut::ProgramCut;
use super::turned_shape::TurnedShape;
use crate::design::Design;
use crate::geom::{DVec2, DVec3};
use crate::parallel;
use crate::program::{ToolMove, TurnedSlopes, TurnedSurface, TurningPath, nose_below};
use crate::results::{CutDeparture, CuttingFault, ProgramFacts, SlopeOrigin};
use crate::turning::DiscSections;
use std::f64::consts::TAU;

/// The most facets of a face whose cusps they follow.
const MOST_FACETS: f64 = 6e6;
/// What a rapid move may be below the mirror, mm: the rounding of programs.
const TOUCH_MM: f64 = 2e-3;
/// Places along a rapid move of which C is known at which it is held against a disc.
const ALONG: usize = 64;

/// The face that `path` leaves of the mirror of `design`, which a lathe goes around as `shape` tells, with a nose.
///
/// # Errors
/// [`CuttingFault`] where no move comes over a place of the mirror.
pub(crate) fn turned_cut(
    design: &Design,
    shape: &TurnedShape,
    path: &TurningPath,
    nose_mm: f64,
) -> Result<ProgramCut, CuttingFault> {
    let surface = TurnedSurface::new(path, nose_mm);
    let radii_mm = shape.radii_mm;
    let feed_mm = feed_over(path, radii_mm, nose_mm).ok_or(CuttingFault::Elsewhere)?;
    let limits = PolarLimits {
        radii_mm,
        rim: &|azimuth| shape.rim_mm(azimuth),
        corners: shape.disc.map_or(&[], DiscSections::corners),
        azimuths: shape.azimuths(nose_mm, feed_mm),
        most: MOST_FACETS,
    };
    let PolarFace { mesh, steps, apart_mm, follows_cusps, peaks } =
        PolarFace::new(&surface, limits)
            .map_err(|UncutPlace(at_mm)| CuttingFault::Uncut { at_mm })?;
    let vertex = |k: usize| match k.checked_sub(steps.len()) {
        None => (mesh.vertices[k], steps[k]),
        Some(peak) => peaks[peak],
    };
    let count = steps.len() + peaks.len();
    let [highest, lowest] = extremes(design, count, |k| {
        let (at, step) = vertex(k);
        (at, path.tool.moves[step].line)
    });
    let slopes = (!follows_cusps).then(|| {
        let source = SlopeSource::Turned(TurnedSlopes::new(surface));
        CutSlopes::new(source, mesh.triangles.len())
    });
    let [cutting_mm, rapid_mm] = path.tool.lengths_mm();
    let facts = ProgramFacts {
        ball_mm: None,
        radius_mm: None,
        corner_mm: None,
        nose_mm: Some(nose_mm),
        lines: path.tool.lines,
        moves: path.tool.moves.len(),
        cutting_mm,
        rapid_mm,
        cutting_min: path.cutting_min(),
        apart_mm,
        angle_deg: None,
        parallel: None,
        optical_triangles: mesh.triangles.len(),
        slopes: SlopeOrigin::of(slopes.is_some()),
        highest,
        lowest,
    };
    let below = path.tool.lowest().filter(|step| step.to.z < 0.0);
    let below = below.map(|step| CuttingFault::BelowBase { line: step.line, z_mm: step.to.z });
    let faults = rapid(shape, path, nose_mm).into_iter().chain(below).collect();
    Ok(ProgramCut { mesh, facts, faults, slopes })
}

/// The most and the least that a face leaves on the mirror, of so many places, each with the line that cuts it.
fn extremes(
    design: &Design,
    count: usize,
    place: impl Fn(usize) -> (DVec3, u32) + Sync,
) -> [CutDeparture; 2] {
    let departures = parallel::map(count, 1 << 12, |k| {
        let (v, line) = place(k);
        let place = design.mirror.local_surface_over(v.truncate(), v.z)?;
        let off_um = 1e3 * (v.z - place.at.z) * place.normal().z;
        Some(CutDeparture { off_um, at_mm: v.to_array(), line })
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
    for (step, turns) in cutting.filter(|(step, turns)| **turns != 0.0 && over(step)) {
        // Where C is commanded, Z follows the mirror around the axis: the way inwards alone is the feed.
        let way = if path.is_commanded() {
            (step.to.x - step.from.x).abs()
        } else {
            step.from.distance(step.to)
        };
        if way > 0.0 {
            length += way;
            all += turns.abs();
        }
    }
    (length > 0.0).then(|| length / all)
}

/// A rapid move through the mirror, or one with a feed while C stands: its nose is lower than the mirror.
fn rapid(shape: &TurnedShape, path: &TurningPath, nose_mm: f64) -> Option<CuttingFault> {
    if path.is_commanded() {
        return standing(shape, path, nose_mm);
    }
    let rapids = path.tool.moves.iter().filter(|step| step.feed.is_none());
    rapids.into_iter().find_map(|step| {
        let is_cut =
            |at: &&DVec2| nose_below(step, nose_mm, at.x).is_some_and(|z| z < at.y - TOUCH_MM);
        let deep = shape.meridian.iter().find(is_cut)?;
        Some(CuttingFault::Rapid { line: step.line, at_mm: [deep.x, 0.0] })
    })
}

/// The same where C is commanded.
fn standing(shape: &TurnedShape, path: &TurningPath, nose_mm: f64) -> Option<CuttingFault> {
    let all = path.tool.moves.iter().zip(&path.commanded).zip(&path.turns);
    all.filter(|(_, turns)| **turns == 0.0).find_map(|((step, turn), _)| {
        (0..=ALONG).find_map(|k| {
            let share = k as f64 / ALONG as f64;
            let at = step.from.lerp(step.to, share);
            let azimuth = TAU * (turn.begin + turn.turns() * share);
            let centre = DVec2::new(at.x + nose_mm, at.z + nose_mm);
            let deep = shape.cut_by((azimuth, centre), nose_mm, TOUCH_MM)?;
            Some(CuttingFault::Rapid { line: step.line, at_mm: [deep.x, deep.y] })
        })
    })
}
