//! Corners of facets where the file's digits nearly hit the mirror.
//!
//! Rounding to single precision moves a corner off the mirror by up to half a step of its digits, which
//! tilts small facets, and slivers the most. How far differs from place to place as if at random:
//! of some tens of places within nanometres one is nearly hit, and there the corner goes.

use super::error_bounder::{ErrorBounder, SurfaceVertex};
use crate::geom::{DVec2, DVec3, Outline, Precision, Rect};

/// Places that are tried on each side of a corner.
const TRIED: i32 = 24;
/// Most that a corner is moved, in sizes of the mirror: a two-hundredth of the facets when as many as
/// fit in memory cover it.
const FARTHEST: f64 = 1e-6;
/// Share of a step of the digits that a rounded corner may be off for no other place to be tried.
const NEAR: f64 = 0.02;
/// Share of a rounding error that is mostly left.
pub const LEAST_LEFT: f64 = 0.05;
/// The second way that is tried, seen from the first.
const ASIDE: DVec2 = DVec2::new(0.8, 0.6);
/// How near a corner is to an arc that it lies on, in radii: rounded X and Y leave it by less.
const ON_ARC: f64 = 1e-6;

/// What is left of a rounding error of up to half a `step` of the digits of Z, where corners may be
/// moved on a mirror of this `size` and of this slope.
pub fn rounding_left(step: f64, slope: f64, size: f64) -> f64 {
    (1.0 - 2.0 * FARTHEST * size * slope / step).max(LEAST_LEFT)
}

impl ErrorBounder<'_> {
    /// A corner at `q` or a few steps of its digits beside it, as the file will have it.
    pub(crate) fn corner(&self, q: DVec2) -> SurfaceVertex {
        let vertex = self.exactly(self.rounded(q));
        if self.precision == Precision::Double {
            return vertex;
        }
        let to = self.nearest(&vertex);
        if to == vertex.q { vertex } else { self.exactly(to) }
    }

    /// The corner at `q`.
    fn exactly(&self, q: DVec2) -> SurfaceVertex {
        self.vertex(q, self.mirror().surface.at(q))
    }

    /// Under parallel rays X and Y are numbers of the file.
    fn rounded(&self, q: DVec2) -> DVec2 {
        let is_plain = self.mirror().chart.vergence == 0.0;
        let single = is_plain && self.precision == Precision::Single;
        if single { q.as_vec2().as_dvec2() } else { q }
    }

    /// The directions in which a corner may be moved: anywhere, or along the side that it is on.
    fn ways(&self, v: &SurfaceVertex) -> [Option<DVec2>; 2] {
        let Rect { min, max } = self.part;
        let on = v.q.cmpeq(min) | v.q.cmpeq(max);
        if let Outline::Ring { inner, outer } = self.mirror().outline {
            let r = v.q.length();
            if [inner, outer].into_iter().any(|radius| (r - radius).abs() <= ON_ARC * outer) {
                return [(!on.any()).then(|| v.q.perp() / r), None];
            }
        }
        if on.any() {
            let along = if on.x { DVec2::Y } else { DVec2::X };
            return [(!on.all()).then_some(along), None];
        }
        // Up the mirror, and half aside, where other digits are met.
        let up = v.gradient.try_normalize();
        [up, up.map(|up| up.rotate(ASIDE))]
    }

    /// The place beside `v` whose rounded corner is nearest to the mirror, of those tried.
    fn nearest(&self, v: &SurfaceVertex) -> DVec2 {
        let chart = &self.mirror().chart;
        let k = chart.vergence;
        let grow = 1.0 / (1.0 + k * v.h);
        // The corner's differential.
        let rise = v.gradient * (grow * grow);
        let moved = |d: DVec2| {
            let up = rise.dot(d);
            v.at + (d * grow - v.q * (k * up)).extend(up)
        };
        let normal = (-v.slope(chart)).extend(1.0);
        let off = |at: DVec3| (at.as_vec3().as_dvec3() - at).dot(normal).abs();
        let steps = v.at.abs() * f64::from(f32::EPSILON);
        let farthest = FARTHEST * self.part.size().max_element();
        let mut best = (off(v.at), v.q);
        for way in self.ways(v).into_iter().flatten() {
            let climb = (steps.z / rise.dot(way).abs()).min(farthest) / f64::from(TRIED);
            let step = steps.x.max(steps.y).max(climb);
            for k in (1..=TRIED).flat_map(|k| [k, -k]) {
                if best.0 <= NEAR * steps.z {
                    return best.1;
                }
                let q = self.rounded(v.q + way * (f64::from(k) * step));
                let off = off(moved(q - v.q));
                if off < best.0 {
                    best = (off, q);
                }
            }
        }
        best.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Chart;
    use crate::mesh::bound::region::ImagingProblem;
    use crate::mirror::{Mirror, Surface, TensorLegendre};
    use crate::num::legendre::Series;
    use crate::num::sample::Draws;

    /// How far off the mirror rounded corners are, in steps of the digits of Z, sorted.
    fn off(vergence: f64, chosen: bool) -> Vec<f64> {
        let series = Series::from_fn(3, 3, |i, j| match (i, j) {
            (1, 0) => 5.0,
            (0, 1) => 3.0,
            (2, 0) => 2.0,
            (1, 1) => 1.0,
            _ => 0.0,
        });
        let half = DVec2::splat(30.0);
        let sheet = TensorLegendre { series, centre: DVec2::ZERO, half, scale_mm: 1.0 };
        let rect = Rect { min: -half, max: half };
        let mirror = Mirror {
            surface: Surface::Tensor(sheet),
            chart: Chart { vergence, plane_mm: 25.0 },
            outline: Outline::Rect(rect),
            folded: false,
            mirror_symmetric: [false; 2],
        };
        let sight = ImagingProblem { mirror: &mirror, camera: mirror.chart, view: None };
        let prover = ErrorBounder::over(rect, sight, Precision::Single);
        let mut r = Draws::new(3);
        let mut off: Vec<f64> = (0..1000)
            .map(|_| {
                let q = DVec2::new(r.inside([3.0, 20.0]), r.inside([3.0, 20.0]));
                let v = if chosen { prover.corner(q) } else { prover.exactly(prover.rounded(q)) };
                assert!((v.q - q).length() < 1e-4, "{q} went to {}", v.q);
                v.rounding.abs() / (v.at.z * f64::from(f32::EPSILON))
            })
            .collect();
        off.sort_by(f64::total_cmp);
        off
    }

    #[test]
    fn corners_go_where_rounding_hits_the_mirror() {
        for vergence in [0.0, 0.005] {
            let [usual, chosen] = [false, true].map(|chosen| off(vergence, chosen));
            // Rounding errors are spread evenly up to half a step; a step is less in a binade's top.
            assert!(usual[500] > 0.1, "{}", usual[500]);
            assert!(chosen[500] <= NEAR && chosen[990] < 0.1, "{} {}", chosen[500], chosen[990]);
        }
    }
}
