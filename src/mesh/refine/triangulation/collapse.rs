//! Edge collapses: a vertex is drawn into a neighbour, which leaves fewer and larger triangles around it.

use super::{EditableTriangulation, NONE, TUNING, VertexModel};
use crate::geom::turn;

/// A collapse that makes the triangles around a vertex better.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Collapse {
    /// The vertex that is removed.
    from: u32,
    /// The neighbour into which it is drawn.
    into: u32,
    /// The largest oversize of the triangles that are then left around the first.
    oversize: f64,
}

impl<C: VertexModel> EditableTriangulation<C> {
    /// Whether triangle `t` has been removed by a collapse.
    pub(crate) fn is_removed(&self, t: u32) -> bool {
        self.triangles[t as usize][0] == NONE
    }

    /// The collapse of an edge of triangle `t` that leaves the smallest oversize, if that is under `most` and smaller
    /// than it was.
    pub(crate) fn best_collapse(&self, t: u32, most: f64) -> Option<Collapse> {
        let [a, b, c] = self.triangles[t as usize];
        let directed = [[a, b], [b, a], [b, c], [c, b], [c, a], [a, c]];
        let found = directed.into_iter().filter_map(|edge| self.collapse_of(edge));
        let found = found.filter(|found| found.oversize < most);
        found.min_by(|a, b| a.oversize.total_cmp(&b.oversize))
    }

    /// The collapse of `from` into `into`, if it is possible and makes the worst triangle better.
    fn collapse_of(&self, [from, into]: [u32; 2]) -> Option<Collapse> {
        let link = self.link(from)?;
        let edges = link.edges();
        // The two triangles beside the edge go; a third common neighbour would be in two sheets.
        let is_common = |w: u32| {
            w != into && self.around(into).any(|t| self.triangles[t as usize].contains(&w))
        };
        if edges.iter().filter(|[b, _]| is_common(*b)).count() != 2 {
            return None;
        }
        let [own, to] = [from, into].map(|v| &self.vertices[v as usize]);
        let area = edges.iter().map(|&[b, c]| turn(own.q(), self.q(b), self.q(c))).sum::<f64>();
        let least = TUNING.sliver_area * area / edges.len() as f64;
        let (mut before, mut after) = (0.0f64, 0.0f64);
        for &[b, c] in edges {
            let others = [b, c].map(|w| &self.vertices[w as usize]);
            before = before.max(self.oversize_at_centroid([own, others[0], others[1]]));
            if b == into || c == into {
                continue;
            }
            if !(turn(to.q(), others[0].q(), others[1].q()) > least) {
                return None;
            }
            after = after.max(self.oversize_at_centroid([to, others[0], others[1]]));
        }
        (after < TUNING.flip_gain * before).then_some(Collapse { from, into, oversize: after })
    }

    /// Collapses an edge; all triangles that were around the removed vertex, changed or removed.
    pub(crate) fn collapse(&mut self, Collapse { from, into, .. }: Collapse) -> Vec<u32> {
        let around: Vec<u32> = self.around(from).collect();
        for &t in &around {
            self.detach(t as usize);
            let triangle = &mut self.triangles[t as usize];
            if triangle.contains(&into) {
                *triangle = [NONE; 3];
                continue;
            }
            for v in triangle.iter_mut().filter(|v| **v == from) {
                *v = into;
            }
            self.attach(t as usize);
        }
        around
    }

    /// The vertices that are left and their triangles, in the order in which they came.
    pub(crate) fn into_parts(self) -> (Vec<C>, Vec<[u32; 3]>) {
        let mut places = vec![NONE; self.vertices.len()];
        let mut points = Vec::with_capacity(self.vertices.len());
        for (v, point) in self.vertices.into_iter().enumerate() {
            if self.first[v] != NONE {
                places[v] = points.len() as u32;
                points.push(point);
            }
        }
        let left = self.triangles.into_iter().filter(|triangle| triangle[0] != NONE);
        (points, left.map(|triangle| triangle.map(|v| places[v as usize])).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Chart, DVec2, Outline, Precision, Rect};
    use crate::mesh::bound::error_bound::Limits;
    use crate::mesh::bound::imaging_problem::ImagingProblem;
    use crate::mesh::sizing::field::SizingField;
    use crate::mesh::sizing::local_model::LocalModel;
    use crate::mirror::{Mirror, Surface, TensorLegendre};
    use crate::num::legendre::Series;

    /// A corner of triangles that are the worse the longer they are for their height.
    #[derive(Debug, Clone, Copy, PartialEq)]
    struct Bare(DVec2);

    impl VertexModel for Bare {
        const MODEL_AT_CENTROID: bool = true;

        fn q(&self) -> DVec2 {
            self.0
        }

        fn oversize(_: &SizingField, _: &LocalModel, [a, b, c]: [&Self; 3]) -> f64 {
            let (a, b, c) = (a.0, b.0, c.0);
            let sides = [a.distance_squared(b), b.distance_squared(c), c.distance_squared(a)];
            sides.into_iter().fold(0.0, f64::max) / turn(a, b, c)
        }

        fn extrapolated<'a>(&self, _: impl Iterator<Item = &'a Self>) -> impl Fn(DVec2) -> Self {
            Self
        }
    }

    /// The sizing field of a plane.
    fn sizing() -> SizingField {
        let half = DVec2::splat(10.0);
        let series = Series::from_fn(2, 2, |_, _| 0.0);
        let sheet = TensorLegendre { series, centre: DVec2::ZERO, half, scale_mm: 1.0 };
        let chart = Chart::on_axis(0.0, 0.0);
        let outline = Outline::Rect(Rect { min: -half, max: half });
        let surface = Surface::Tensor(sheet);
        let mirror =
            Mirror { surface, chart, outline, folded: false, mirror_symmetric: [false; 2] };
        let problem = ImagingProblem { mirror: &mirror, camera: chart, view: None };
        let precision = Precision::Double;
        let limits = Limits { chord_mm: Some(1e-3), facet_mm: None, precision };
        SizingField::new(&problem, outline.bounds(), limits)
    }

    /// A square of side 2 with its corners 0 to 3, and the inner one 4.
    fn square(sizing: &SizingField, x: f64, y: f64) -> EditableTriangulation<Bare> {
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (x, y)];
        let vertices = corners.map(|(x, y)| Bare(DVec2::new(x, y))).to_vec();
        EditableTriangulation::new(
            sizing,
            1.0,
            vertices,
            vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]],
        )
    }

    #[test]
    fn a_sliver_goes_with_its_corner_where_that_leaves_better_triangles() {
        let sizing = sizing();
        let mut net = square(&sizing, 0.9, -0.95);
        // Halves of the square are left; from corner 0 the inner one leaves the same, and a rim's corner
        // does not move.
        let collapse = net.best_collapse(0, 3.0).expect("a sliver");
        assert_eq!((collapse.from, collapse.oversize), (4, 2.0));
        assert_eq!(net.collapse_of([1, 4]), None);
        let around = net.collapse(collapse);
        let removed: Vec<bool> = (0..4).map(|t| net.is_removed(t)).collect();
        assert_eq!((around.len(), removed.iter().filter(|removed| **removed).count()), (4, 2));
        let (points, triangles) = net.into_parts();
        assert_eq!((points.len(), triangles.len()), (4, 2));
        let area = |[a, b, c]: [u32; 3]| {
            let [a, b, c] = [a, b, c].map(|v| points[v as usize].0);
            turn(a, b, c)
        };
        assert_eq!(triangles.into_iter().map(area).collect::<Vec<_>>(), [4.0; 2]);
        assert_eq!(square(&sizing, 0.9, -0.95).best_collapse(0, 1.9), None);
        // In the middle it does no harm.
        assert_eq!(square(&sizing, 0.0, 0.0).best_collapse(0, 3.0), None);
    }

    #[test]
    fn corners_that_share_more_than_two_neighbours_stay_apart() {
        let sizing = sizing();
        // 4 inside of (0, 1, 2), and 3 inside of (0, 1, 4).
        let at = |x: f64, y: f64| Bare(DVec2::new(x, y));
        let vertices =
            vec![at(-3.0, -2.0), at(3.0, -2.0), at(0.0, 4.0), at(0.0, -1.9), at(0.0, -1.8)];
        let triangles = vec![[0, 1, 3], [0, 3, 4], [3, 1, 4], [1, 2, 4], [2, 0, 4]];
        let net = EditableTriangulation::new(&sizing, 1.0, vertices, triangles);
        // 0 and 4 share 1, 2 and 3, and so do 1 and 4.
        assert_eq!([0, 1].map(|into| net.collapse_of([4, into])), [None; 2]);
        assert!(net.collapse_of([3, 4]).is_some());
    }
}
