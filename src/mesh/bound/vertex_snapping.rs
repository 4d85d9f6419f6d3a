//! Vertex snapping: vertices go where single precision rounds them to points that are nearly on the mirror.
//!
//! Rounding to single precision moves a vertex off the mirror by up to half a step of its digits, which tilts small
//! facets, and slivers the most. The distance differs from place to place as if at random: of some tens of places
//! within nanometres one is nearly on the mirror, and there the vertex goes (theory, after T48).

use super::error_bounder::ErrorBounder;
use super::tuning::TUNING;
use super::vertex::SurfaceVertex;
use crate::geom::{DVec2, DVec3, Outline, Precision, Rect};

/// The second direction that is tried, in the frame of the first one.
const OBLIQUE: DVec2 = DVec2::new(0.8, 0.6);
/// Relative distance up to which a vertex counts as on an arc of the rim: rounded X and Y leave it by less.
const ON_ARC: f64 = 1e-6;

/// Share of a rounding error that snapping leaves, as sizes of facets are foreseen: of up to half a `step` of the
/// digits of Z (mm), where vertices may be moved on a mirror of this `size` (mm) and slope.
pub(crate) fn rounding_left(step: f64, slope: f64, size: f64) -> f64 {
    (1.0 - 2.0 * TUNING.snap_farthest * size * slope / step).max(TUNING.least_rounding_left)
}

impl ErrorBounder<'_> {
    /// The vertex at `q`, or nanometres beside it where rounding hardly moves it off the mirror, as the file has it.
    pub(crate) fn snapped_vertex(&self, q: DVec2) -> SurfaceVertex {
        let vertex = self.vertex_at(self.rounded(q));
        if self.precision == Precision::Double {
            return vertex;
        }
        let to = self.best_rounded(&vertex);
        if to == vertex.q { vertex } else { self.vertex_at(to) }
    }

    /// `q` as the file has it: under vertical rays X and Y are its numbers.
    fn rounded(&self, q: DVec2) -> DVec2 {
        let single = self.mirror().chart.is_plan() && self.precision == Precision::Single;
        if single { q.as_vec2().as_dvec2() } else { q }
    }

    /// The directions in which a vertex may be moved: anywhere, or along the side that it is on.
    fn directions(&self, v: &SurfaceVertex) -> [Option<DVec2>; 2] {
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
        // Up the mirror, and obliquely, where other digits are met.
        let up = v.gradient.try_normalize();
        [up, up.map(|up| up.rotate(OBLIQUE))]
    }

    /// The position beside `v` whose rounded vertex is nearest to the mirror, of those tried.
    fn best_rounded(&self, v: &SurfaceVertex) -> DVec2 {
        let chart = &self.mirror().chart;
        let (grow, tangent) = (1.0 / (1.0 + chart.vergence * v.h), chart.tangent_at(v.q));
        // The differential of the vertex's position.
        let rise = v.gradient * (grow * grow);
        let moved = |d: DVec2| {
            let up = rise.dot(d);
            v.at + (d * grow - tangent * up).extend(up)
        };
        let normal = (-v.slope(chart)).extend(1.0);
        let off = |at: DVec3| (at.as_vec3().as_dvec3() - at).dot(normal).abs();
        let steps = v.at.abs() * f64::from(f32::EPSILON);
        let farthest = TUNING.snap_farthest * self.part.size().max_element();
        let positions = TUNING.snap_positions;
        let mut best = (off(v.at), v.q);
        for direction in self.directions(v).into_iter().flatten() {
            let climb = (steps.z / rise.dot(direction).abs()).min(farthest) / f64::from(positions);
            let step = steps.x.max(steps.y).max(climb);
            for k in (1..=positions).flat_map(|k| [k, -k]) {
                if best.0 <= TUNING.snap_near * steps.z {
                    return best.1;
                }
                let q = self.rounded(v.q + direction * (f64::from(k) * step));
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
    use crate::mirror::{Mirror, Surface, TensorLegendre};
    use crate::num::legendre::Series;
    use crate::num::sample::Draws;

    /// Distances of rounded vertices from the mirror, in steps of the digits of Z, sorted.
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
            chart: Chart::on_axis(vergence, 25.0),
            outline: Outline::Rect(rect),
            folded: false,
            mirror_symmetric: [false; 2],
        };
        let bounder = ErrorBounder::new(&mirror, &mirror.chart, None, Precision::Single);
        let mut r = Draws::new(3);
        let mut off: Vec<f64> = (0..1000)
            .map(|_| {
                let q = DVec2::new(r.inside([3.0, 20.0]), r.inside([3.0, 20.0]));
                let v = if chosen {
                    bounder.snapped_vertex(q)
                } else {
                    bounder.vertex_at(bounder.rounded(q))
                };
                assert!((v.q - q).length() < 1e-4, "{q} went to {}", v.q);
                v.rounding.abs() / (v.at.z * f64::from(f32::EPSILON))
            })
            .collect();
        off.sort_by(f64::total_cmp);
        off
    }

    #[test]
    fn vertices_go_where_rounding_hits_the_mirror() {
        for vergence in [0.0, 0.005] {
            let [usual, chosen] = [false, true].map(|chosen| off(vergence, chosen));
            // Rounding errors are spread evenly up to half a step; a step is less in a binade's top.
            assert!(usual[500] > 0.1, "{}", usual[500]);
            assert!(
                chosen[500] <= TUNING.snap_near && chosen[990] < 0.1,
                "{} {}",
                chosen[500],
                chosen[990]
            );
        }
    }
}
