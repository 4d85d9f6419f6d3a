//! What a triangulation knows of its vertices: their position, or also the mirror's values there.

use crate::geom::{DVec2, DVec3};
use crate::mesh::bound::vertex::SurfaceVertex;
use crate::mesh::sizing::field::SizingField;
use crate::mesh::sizing::local_model::LocalModel;
use glam::{DMat3, Vec3Swizzles};

/// A vertex of an editable triangulation, from which the oversize of its triangles follows.
pub(crate) trait VertexModel: Copy + Send + Sync {
    /// Whether the triangles of a flip are judged by the local model at their own centroids each, and not by one for
    /// all: otherwise flips by the mirror's values would go round in circles.
    const MODEL_AT_CENTROID: bool;

    /// Coordinates in the mirror's chart, mm.
    fn q(&self) -> DVec2;

    /// Oversize of a triangle where `model` holds: its area over the one that the limits allow.
    fn oversize(sizing: &SizingField, model: &LocalModel, triangle: [&Self; 3]) -> f64;

    /// An estimate of the vertex at positions near this one, from the values at its `neighbours`.
    fn extrapolated<'a>(
        &self,
        neighbours: impl Iterator<Item = &'a Self>,
    ) -> impl Fn(DVec2) -> Self
    where
        Self: 'a;
}

/// The position alone: oversizes are those of the quadratic model.
impl VertexModel for DVec2 {
    const MODEL_AT_CENTROID: bool = false;

    #[inline]
    fn q(&self) -> DVec2 {
        *self
    }

    #[inline]
    fn oversize(sizing: &SizingField, model: &LocalModel, [a, b, c]: [&Self; 3]) -> f64 {
        sizing.oversize(model, b - a, c - a)
    }

    fn extrapolated<'a>(&self, _: impl Iterator<Item = &'a Self>) -> impl Fn(DVec2) -> Self {
        |q| q
    }
}

/// Position and the mirror's values: oversizes follow from these.
impl VertexModel for SurfaceVertex {
    const MODEL_AT_CENTROID: bool = true;

    #[inline]
    fn q(&self) -> DVec2 {
        self.q
    }

    #[inline]
    fn oversize(sizing: &SizingField, model: &LocalModel, triangle: [&Self; 3]) -> f64 {
        sizing.oversize_by_vertices(model, triangle)
    }

    fn extrapolated<'a>(
        &self,
        neighbours: impl Iterator<Item = &'a Self>,
    ) -> impl Fn(DVec2) -> Self {
        // Least squares: the Hessian that turns differences of position into differences of the gradient.
        let (mut squares, mut changes) = (DVec3::ZERO, DVec3::ZERO);
        for other in neighbours {
            let (d, g) = (other.q - self.q, other.gradient - self.gradient);
            squares += DVec3::new(d.x * d.x, d.x * d.y, d.y * d.y);
            changes += DVec3::new(d.x * g.x, d.x * g.y + d.y * g.x, d.y * g.y);
        }
        let DVec3 { x: xx, y: xy, z: yy } = squares;
        let normal = DMat3::from_cols_array(&[xx, xy, 0.0, xy, xx + yy, xy, 0.0, xy, yy]);
        let hessian = normal.inverse() * changes;
        let own = *self;
        move |q| {
            let d = q - own.q;
            let bend = DVec2::new(hessian.xy().dot(d), hessian.yz().dot(d));
            let h = own.h + (own.gradient + bend * 0.5).dot(d);
            Self { q, h, gradient: own.gradient + bend, ..own }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Chart, Outline, Precision, Rect};
    use crate::mesh::bound::error_bound::Limits;
    use crate::mesh::bound::error_bounder::ErrorBounder;
    use crate::mesh::bound::imaging_problem::ImagingProblem;
    use crate::mirror::{Mirror, Surface, TensorLegendre};
    use crate::num::legendre::Series;
    use crate::num::sample::Draws;

    const HALF_MM: f64 = 10.0;
    const TOP: Chart = Chart::on_axis(0.0, 0.0);

    /// The mirror of height a x^2 + b x y + c y^2 + d x^3.
    fn mirror([a, b, c, d]: [f64; 4]) -> Mirror {
        // u^2 = (2 P2 + 1) / 3 and u^3 = (2 P3 + 3 P1) / 5.
        let (square, cube) = (HALF_MM * HALF_MM, HALF_MM * HALF_MM * HALF_MM);
        let series = Series::from_fn(4, 3, |i, j| match (i, j) {
            (0, 0) => (a + c) * square / 3.0,
            (2, 0) => a * square * 2.0 / 3.0,
            (0, 2) => c * square * 2.0 / 3.0,
            (1, 1) => b * square,
            (1, 0) => d * cube * 0.6,
            (3, 0) => d * cube * 0.4,
            _ => 0.0,
        });
        let half = DVec2::splat(HALF_MM);
        let sheet = TensorLegendre { series, centre: DVec2::ZERO, half, scale_mm: 1.0 };
        Mirror {
            surface: Surface::Tensor(sheet),
            chart: TOP,
            outline: Outline::Rect(Rect { min: -half, max: half }),
            folded: false,
            mirror_symmetric: [false; 2],
        }
    }

    const LIMITS: Limits =
        Limits { chord_mm: Some(1e-3), facet_mm: None, precision: Precision::Double };

    fn vertices(mirror: &Mirror, at: [DVec2; 3]) -> [SurfaceVertex; 3] {
        let bounder = ErrorBounder::new(mirror, &TOP, None, Precision::Double);
        at.map(|q| bounder.vertex_at(q))
    }

    /// A triangle of about 1 mm.
    fn triangle(r: &mut Draws) -> [DVec2; 3] {
        let at = DVec2::new(r.inside([-8.0, 8.0]), r.inside([-8.0, 8.0]));
        let corner = |way: DVec2, r: &mut Draws| at + way + 0.3 * DVec2::new(r.unit(), r.unit());
        [corner(DVec2::ZERO, r), corner(DVec2::X, r), corner(DVec2::Y, r)]
    }

    #[test]
    fn model_and_mirror_agree_where_the_model_is_exact_and_only_there() {
        let mut r = Draws::new(5);
        for (form, exact) in [([0.02, 0.01, 0.03, 0.0], true), ([0.02, 0.01, -0.03, 1e-3], false)] {
            let mirror = mirror(form);
            let problem = ImagingProblem { mirror: &mirror, camera: TOP, view: None };
            let sizing = SizingField::new(&problem, mirror.outline.bounds(), LIMITS);
            let mut farthest = 0.0f64;
            for _ in 0..100 {
                let at = triangle(&mut r);
                let known = vertices(&mirror, at);
                // The model of the first corner's place.
                let model = sizing.at(at[0]);
                let by_model = DVec2::oversize(&sizing, &model, at.each_ref());
                let by_mirror = SurfaceVertex::oversize(&sizing, &model, known.each_ref());
                assert!(by_model > 1.0, "{by_model}");
                farthest = farthest.max((by_mirror / by_model - 1.0).abs());
            }
            println!("{form:?}: off by {farthest:e}");
            assert_eq!(farthest < 1e-9, exact, "{farthest:e}");
        }
    }

    #[test]
    fn a_corner_beside_another_is_foreseen_with_an_error_of_third_order() {
        let mut r = Draws::new(6);
        let ring = [DVec2::X, DVec2::new(0.4, 0.9), DVec2::NEG_X, DVec2::new(-0.3, -1.1)];
        for cubic in [0.0, 1e-3] {
            let mirror = mirror([0.02, 0.01, -0.03, cubic]);
            let at = |q: DVec2| vertices(&mirror, [q; 3])[0];
            for _ in 0..50 {
                let q = DVec2::new(r.inside([-8.0, 8.0]), r.inside([-8.0, 8.0]));
                let step = DVec2::new(r.inside([-0.1, 0.1]), r.inside([-0.1, 0.1]));
                let off = |size: f64| {
                    let neighbours = ring.map(|way| at(q + way * size));
                    let foreseen = at(q).extrapolated(neighbours.iter())(q + step * size);
                    let found = at(q + step * size);
                    assert_eq!(foreseen.q, found.q);
                    [(foreseen.h - found.h).abs(), foreseen.gradient.distance(found.gradient)]
                };
                let [far, near] = [off(1.0), off(0.5)];
                // h''' = 6e-3 / mm^2, and gradients tell h'' with what it changes over the ring.
                let (height, gradient) = (cubic * 0.1 * 0.1 * 6.0, cubic * 0.15 * 6.0 * 1.2);
                assert!(far[0] <= height + 1e-12 && far[1] <= gradient + 1e-12, "{far:?}");
                if cubic > 0.0 && far[1] > 1e-6 {
                    assert!((near[1] / far[1] - 0.25).abs() < 1e-3, "{far:?} {near:?}");
                }
            }
        }
    }
}
