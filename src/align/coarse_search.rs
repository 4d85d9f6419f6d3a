//! Coarse alignment: the pose to some thousandth of the width, by a search from many starts.

use super::normal_equations::{AlignmentResidual, NormalEquations, biweight, residuals};
use super::reference_surface::ReferenceSurface;
use super::vertex_patch::thinned;
use super::{Pose, VertexPatch};
use crate::geom::DVec3;
use crate::num::{radians, sort_by_number};
use crate::parallel;

/// Number of vertices that are used.
const POINTS: usize = 600;
/// Rotation of the starts about each axis to either side, degrees.
const TURN_DEG: f64 = 12.0;
/// Offset of the middle of a mesh that lacks a side of the mirror, as a share of the width.
const BESIDE: f64 = 0.17;
/// Steps from each start, and the reach of residuals in each: it shrinks from one to the next.
const STEPS: i32 = 26;
const FIRST_REACH: f64 = 0.3;
const SHRINK: f64 = 0.82;
/// The last reach, by which the results of all starts are scored, as a share of the width.
const LAST_REACH: f64 = 0.01;
/// Share of a motion across the surface below which it is left to the fine fit.
const FLOOR: f64 = 0.02;
/// Starts that are tried together, and the share of the mesh on the mirror that ends the search.
const BATCH: usize = 9;
const ENOUGH: f64 = 0.85;
/// Factor by which a later start has to score better.
const BETTER: f64 = 1.02;
/// Largest weight of a vertex: vertices are chosen by area, and oblique ones must not count much more.
const AT_MOST: f64 = 1.5;

/// The best pose found, among starts ordered from small motions to large ones.
pub(super) fn coarse_search(patches: &[VertexPatch], reference: &ReferenceSurface) -> Pose {
    let points = thinned(patches, POINTS);
    let weight: f64 = points.iter().map(|point| point.area.length()).sum();
    let middle = points.iter().map(|point| point.at * point.area.length()).sum::<DVec3>() / weight;
    let starts = starts(middle, reference);
    let mut best = (Pose::IDENTITY, 0.0);
    for batch in starts.chunks(BATCH) {
        let found: Vec<(Pose, f64)> =
            parallel::map_slice(batch, 1, |&start| descend(&points, reference, start));
        for found in found {
            if found.1 > BETTER * best.1 {
                best = found;
            }
        }
        if best.1 > ENOUGH * weight {
            break;
        }
    }
    best.0
}

/// Starts that bring the mesh's middle to the mirror's, and such that leave it where it is; and, for
/// meshes that lack a side of the mirror, such that bring its middle beside the mirror's.
fn starts(middle: DVec3, reference: &ReferenceSurface) -> Vec<Pose> {
    let ways = [0.0, 1.0, -1.0];
    let mut turns = Vec::new();
    for k in 0..27 {
        turns.push(DVec3::new(ways[k % 3], ways[k / 3 % 3], ways[k / 9]) * radians(TURN_DEG));
    }
    sort_by_number(&mut turns, |turn| turn.length_squared());
    let mut starts = Vec::new();
    for from in [middle, reference.centre] {
        starts.extend(turns.iter().map(|&turn| Pose::about(from, reference.centre, turn)));
    }
    let aside = BESIDE * reference.width;
    for step in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y] {
        // None, and one about each axis to either side.
        let to = reference.centre + step * aside;
        starts.extend(turns[..7].iter().map(|&turn| Pose::about(middle, to, turn)));
    }
    starts
}

/// The pose that a start leads to, and how much of the mesh it puts on the mirror.
fn descend(points: &[VertexPatch], reference: &ReferenceSurface, start: Pose) -> (Pose, f64) {
    let foot = |p: DVec3| reference.project_approximately(p);
    let mut pose = start;
    let mut reach = FIRST_REACH * reference.width;
    let last = LAST_REACH * reference.width;
    for _ in 0..STEPS {
        let equations =
            NormalEquations::of(&residuals(points, &pose, foot), reference, |residual| {
                residual.area.min(AT_MOST) * biweight(residual.distance, reach)
            });
        if !(equations.weight > 0.0) {
            return (pose, 0.0);
        }
        let step = equations.solve(FLOOR);
        pose = pose.then(&step.pose(reference, 0.1 * reference.width));
        reach = (reach * SHRINK).max(last);
    }
    let on = |residual: &AlignmentResidual| {
        residual.area.min(AT_MOST) * biweight(residual.distance, last)
    };
    let score = residuals(points, &pose, foot).iter().flatten().map(on).sum();
    (pose, score)
}
