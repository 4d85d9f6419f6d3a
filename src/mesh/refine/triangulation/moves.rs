//! Moves of a vertex to where the triangles around it have smaller errors.

use super::{EditableTriangulation, TUNING, VertexLink};
use crate::geom::{DVec2, turn};
use crate::mesh::refine::vertex_model::VertexModel;
use crate::mesh::sizing::local_model::LocalModel;
use glam::DMat2;

/// An inner vertex that may be moved, with what stays the same meanwhile.
struct VertexMove<'n, C> {
    net: &'n EditableTriangulation<C>,
    link: VertexLink,
    own: &'n C,
    /// The local model at the vertex.
    model: LocalModel,
}

impl<C: VertexModel> EditableTriangulation<C> {
    /// A position with smaller errors around the inner vertex `v`, if one of them is over the oversize `threshold`.
    /// Steps are measured in `cell`s; `vertex` is the vertex at a position.
    pub(crate) fn better_position(
        &self,
        v: u32,
        threshold: f64,
        cell: impl FnOnce(DVec2) -> DMat2,
        vertex: impl Fn(DVec2) -> C,
    ) -> Option<C> {
        let link = self.link(v)?;
        let own = &self.vertices[v as usize];
        let moved = VertexMove { net: self, link, own, model: self.sizing.at(own.q()) };
        let (worst, here) = moved.now();
        if !(worst > threshold) {
            return None;
        }
        let step = moved.step(&cell(own.q()), here)?;
        moved.first_gain(step, here, vertex)
    }
}

impl<C: VertexModel> VertexMove<'_, C> {
    /// Oversize of the triangle between the vertex at `p` and an edge of its link.
    fn oversize(&self, p: &C, edge: [u32; 2]) -> f64 {
        let [b, c] = edge.map(|w| &self.net.vertices[w as usize]);
        self.net.oversize_of(&self.model, [p, b, c])
    }

    /// A power of the oversize whose sum is nearly the largest, and smooth; a higher one for the image, whose errors
    /// differ more between neighbours.
    fn power(&self, oversize: f64) -> f64 {
        let squared = |x: f64| x * x;
        let fourth = squared(squared(oversize));
        if self.net.sizing.limits_image() { squared(fourth) } else { fourth }
    }

    /// The sum of powers around the vertex at `p`.
    fn sum(&self, p: &C) -> f64 {
        self.link.edges().iter().map(|&edge| self.power(self.oversize(p, edge))).sum::<f64>()
    }

    /// Whether the sum of powers around the vertex at `p` is less than `most`. They are not negative, so that a part of
    /// the sum may be enough to say no.
    fn is_sum_below(&self, p: &C, most: f64) -> bool {
        let mut sum = 0.0;
        for &edge in self.link.edges() {
            sum += self.power(self.oversize(p, edge));
            if sum >= most {
                return false;
            }
        }
        sum < most
    }

    /// The largest oversize around the vertex where it is, and the sum of powers.
    fn now(&self) -> (f64, f64) {
        let (mut worst, mut sum) = (0.0, 0.0);
        for &edge in self.link.edges() {
            let oversize = self.oversize(self.own, edge);
            worst = f64::max(worst, oversize);
            sum += self.power(oversize);
        }
        (worst, sum)
    }

    /// The step to the minimum of a quadratic model of the sum, which is `here` now, along the axes of `cell`; none
    /// where the model foresees too little gain.
    fn step(&self, cell: &DMat2, here: f64) -> Option<DVec2> {
        let q = self.own.q();
        let neighbours = self.link.edges().iter().map(|&[b, _]| &self.net.vertices[b as usize]);
        let near = self.own.extrapolated(neighbours);
        let mut way = DVec2::ZERO;
        let mut gain = 0.0;
        for axis in [cell.x_axis, cell.y_axis] {
            let (up, down) = (
                self.sum(&near(q + axis * TUNING.move_step)),
                self.sum(&near(q - axis * TUNING.move_step)),
            );
            let bend = up + down - 2.0 * here;
            let step = if bend > 0.0 { 0.5 * (down - up) / bend } else { (down - up).signum() };
            if step.is_finite() {
                let longest = TUNING.longest_move;
                way += axis * (TUNING.move_step * step.clamp(-longest, longest));
                gain += if bend > 0.0 { 0.25 * step * (down - up) } else { f64::INFINITY };
            }
        }
        let too_small = gain < TUNING.foreseen_gain * (1.0 - TUNING.move_gain) * here;
        (!too_small).then_some(way)
    }

    /// Twice the areas of the triangles around the vertex at `p`.
    fn areas(&self, p: DVec2) -> impl Iterator<Item = f64> + '_ {
        self.link.edges().iter().map(move |&[b, c]| turn(p, self.net.q(b), self.net.q(c)))
    }

    fn smallest_area(&self, p: DVec2) -> f64 {
        self.areas(p).fold(f64::INFINITY, f64::min)
    }

    /// The vertex after the longest share of `step` that makes the sum, now `here`, smaller without making slivers.
    fn first_gain(&self, step: DVec2, here: f64, vertex: impl Fn(DVec2) -> C) -> Option<C> {
        let q = self.own.q();
        let least =
            (TUNING.sliver_area * self.areas(q).sum::<f64>() / 3.0).min(self.smallest_area(q));
        let most = TUNING.move_gain * here;
        let gains = |to: &C| self.smallest_area(to.q()) >= least && self.is_sum_below(to, most);
        TUNING.move_shares.into_iter().map(|share| vertex(q + step * share)).find(gains)
    }
}
