//! One step of the fit: weighted residuals -> normal equations of the six degrees of freedom ->
//! the motion that makes them small, and what it leaves open.

use super::reference_surface::{ProjectedPoint, ReferenceSurface};
use super::{FreeMotion, Pose, VertexPatch};
use crate::geom::DVec3;
use crate::num::sort_by_number;
use crate::parallel;
use nalgebra::{Matrix6, SymmetricEigen, Vector6};

/// Vertices that a thread handles at a time; fixed, so that sums do not depend on the threads.
const CHUNK: usize = 4096;

/// Residual of a vertex: its distance from the mirror along the normal.
#[derive(Debug, Clone, Copy)]
pub(super) struct AlignmentResidual {
    /// Position of the vertex, mm.
    pub at: DVec3,
    /// The mirror's normal there.
    pub normal: DVec3,
    /// Distance above the mirror, mm.
    pub distance: f64,
    /// Its share of the mirror, mm^2.
    pub area: f64,
}

impl AlignmentResidual {
    /// The residual of a patch in the part frame over its projection `foot`; `None` where its facets are
    /// not seen from the camera. A wall along the camera's rays has no share.
    fn new(patch: &VertexPatch, foot: &ProjectedPoint) -> Option<Self> {
        let area = patch.area.dot(foot.up) / foot.normal.dot(foot.up);
        (area > 0.0).then(|| Self {
            at: patch.at,
            normal: foot.normal,
            distance: foot.distance(patch.at),
            area,
        })
    }
}

/// The residuals of `patches` after `pose`, in their order.
pub(super) fn residuals(
    patches: &[VertexPatch],
    pose: &Pose,
    foot: impl Fn(DVec3) -> Option<ProjectedPoint> + Sync,
) -> Vec<Option<AlignmentResidual>> {
    let residual = |patch: &VertexPatch| {
        let patch = patch.moved(pose);
        AlignmentResidual::new(&patch, &foot(patch.at)?)
    };
    parallel::map_slice(patches, CHUNK, residual)
}

/// Tukey's biweight: 1 for no distance, 0 from `reach` on.
pub(super) fn biweight(distance: f64, reach: f64) -> f64 {
    let share = distance / reach;
    let rest = 1.0 - share * share;
    if rest > 0.0 { rest * rest } else { 0.0 }
}

/// Normal equations of a small motion about the reference's centre: a shift in mm, and a turn as mm at
/// the reference's radius of gyration.
pub(super) struct NormalEquations {
    matrix: Matrix6<f64>,
    side: Vector6<f64>,
    /// Sum of the weights.
    pub weight: f64,
    /// Weighted sum of the squared distances.
    pub squares: f64,
}

impl NormalEquations {
    /// Sums up, in fixed order, the residuals with the weights `weight`.
    pub(super) fn of(
        residuals: &[Option<AlignmentResidual>],
        reference: &ReferenceSurface,
        weight: impl Fn(&AlignmentResidual) -> f64 + Sync,
    ) -> Self {
        let sum = |chunk: &[Option<AlignmentResidual>]| {
            let mut sums = Self::zero();
            for residual in chunk.iter().flatten() {
                let weight = weight(residual);
                if weight > 0.0 {
                    sums.add(residual, reference, weight);
                }
            }
            sums
        };
        parallel::map_chunks(residuals, CHUNK, sum).into_iter().fold(
            Self::zero(),
            |mut all, part| {
                all.matrix += part.matrix;
                all.side += part.side;
                all.weight += part.weight;
                all.squares += part.squares;
                all
            },
        )
    }

    fn zero() -> Self {
        Self { matrix: Matrix6::zeros(), side: Vector6::zeros(), weight: 0.0, squares: 0.0 }
    }

    fn add(&mut self, residual: &AlignmentResidual, reference: &ReferenceSurface, weight: f64) {
        let AlignmentResidual { at, normal, distance, .. } = *residual;
        let lever = (at - reference.centre).cross(normal) / reference.gyration;
        let row = [normal.x, normal.y, normal.z, lever.x, lever.y, lever.z];
        for j in 0..6 {
            let scaled = weight * row[j];
            self.side[j] += scaled * distance;
            for (i, entry) in row.iter().enumerate().take(j + 1) {
                self.matrix[(i, j)] += scaled * entry;
            }
        }
        self.weight += weight;
        self.squares += weight * distance * distance;
    }

    /// The motion that minimises the weighted squares. Directions in which the surface moves along
    /// itself, up to the share `floor` of the motion, are left out.
    pub(super) fn solve(&self, floor: f64) -> GaussNewtonStep {
        let mut matrix = self.matrix / self.weight;
        matrix.fill_lower_triangle_with_upper_triangle();
        let SymmetricEigen { eigenvectors, eigenvalues } = SymmetricEigen::new(matrix);
        let largest = eigenvalues.max();
        let least = floor * floor * largest;
        let mut step =
            GaussNewtonStep { motion: Vector6::zeros(), condition: 1.0, free: Vec::new() };
        for (k, &value) in eigenvalues.iter().enumerate() {
            let direction: Vector6<f64> = eigenvectors.column(k).into();
            if value > least {
                step.motion -= direction * (direction.dot(&self.side) / self.weight / value);
                step.condition = step.condition.max((largest / value).sqrt());
            } else {
                step.free.push(direction);
            }
        }
        step
    }
}

/// Solution of the normal equations.
pub(super) struct GaussNewtonStep {
    motion: Vector6<f64>,
    /// Square root of the ratio of the largest eigenvalue to the least that was used.
    pub condition: f64,
    free: Vec<Vector6<f64>>,
}

impl GaussNewtonStep {
    /// Length of the motion, mm.
    pub(super) fn length(&self) -> f64 {
        self.motion.norm()
    }

    /// The motion, cut down to a length of at most `most` mm.
    pub(super) fn pose(&self, reference: &ReferenceSurface, most: f64) -> Pose {
        let cut = (most / self.length().max(most)).min(1.0);
        let [shift, turn] = split(&(self.motion * cut));
        Pose::about(reference.centre, reference.centre + shift, turn / reference.gyration)
    }

    /// The directions that were left out.
    pub(super) fn free(&self, reference: &ReferenceSurface) -> Vec<FreeMotion> {
        let free = |direction: &Vector6<f64>| {
            let [shift, turn] = split(direction);
            if turn.length() < 1e-3 {
                return FreeMotion { direction: forwards(shift), through_mm: None };
            }
            // A turn and a shift across its axis are a turn about an axis somewhere else.
            let rate = turn / reference.gyration;
            let through = reference.centre + rate.cross(shift) / rate.length_squared();
            FreeMotion { direction: forwards(turn), through_mm: Some(through) }
        };
        self.free.iter().map(free).collect()
    }
}

/// The unit vector along `v` or against it whose largest component is positive.
fn forwards(v: DVec3) -> DVec3 {
    let largest = if v.max_element() >= -v.min_element() { 1.0 } else { -1.0 };
    v.normalize() * largest
}

fn split(vector: &Vector6<f64>) -> [DVec3; 2] {
    let [a, b, c, d, e, f] = vector.data.0[0];
    [DVec3::new(a, b, c), DVec3::new(d, e, f)]
}

/// 1.4826 times the distance that the vertices of half the area do not exceed: the standard
/// deviation of normal noise, whatever the other half does.
pub(super) fn robust_scale(residuals: &[Option<AlignmentResidual>]) -> f64 {
    const MOST: usize = 20_000;
    let known = residuals.iter().flatten();
    let every = known.clone().count() / MOST + 1;
    let mut distances: Vec<(f64, f64)> =
        known.step_by(every).map(|r| (r.distance.abs(), r.area)).collect();
    sort_by_number(&mut distances, |d| d.0);
    let half = 0.5 * distances.iter().map(|d| d.1).sum::<f64>();
    let mut sum = 0.0;
    let median = distances.iter().find(|d| {
        sum += d.1;
        sum >= half
    });
    1.4826 * median.map_or(0.0, |d| d.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_is_that_of_normal_noise_and_deaf_to_outliers() {
        // Quantiles of the normal distribution by Newton's method on its density's integral are not
        // needed: for a uniform distribution on [-1, 1] the median distance is 1/2.
        let of = |k: usize| {
            let distance =
                if k.is_multiple_of(20) { 1e3 } else { 2.0 * (k as f64 + 0.5) / 1e4 - 1.0 };
            Some(AlignmentResidual { at: DVec3::ZERO, normal: DVec3::Z, distance, area: 1.0 })
        };
        let residuals: Vec<_> = (0..10_000).map(of).chain([None]).collect();
        let found = robust_scale(&residuals);
        let exact = 1.4826 * 0.5 / 0.95;
        assert!((found / exact - 1.0).abs() < 2e-3, "{found} {exact}");
        assert_eq!(robust_scale(&[]), 0.0);
    }

    #[test]
    fn the_biweight_ends_smoothly() {
        assert_eq!([0.0, 2.0, 3.0].map(|d| biweight(d, 2.0)), [1.0, 0.0, 0.0]);
        assert_eq!(biweight(1.0, 2.0), 0.5625);
        assert_eq!(biweight(f64::NAN, 2.0), 0.0);
    }
}
