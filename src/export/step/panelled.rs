//! Panels with steps between them: untrimmed spline faces, and plane walls through the pinhole between them and below their
//! outer sides.

use super::b_spline::BSplineSurface;
use super::face_role::FaceRole;
use super::panels::{CornerVertices, WrittenSurface};
use super::part21::{DataSection, InstanceId};
use super::topology::{BrepEdge, BrepVertex, OrientedEdge, reversed};
use crate::geom::{Chart, DVec2, DVec3, DividingLine, Panels, Rect};
use crate::num::sort_by_number;

/// Sides of a rectangle.
const SIDES: usize = 4;

/// The fitted surfaces of panels with steps between them.
#[derive(Debug, Clone)]
pub(super) struct FittedPanels {
    /// The rectangles of the chart, mm.
    pub parts: Panels,
    /// The surface over each, its sides in planes through the pinhole.
    pub nets: Vec<BSplineSurface>,
    /// The chart of the pinhole.
    pub chart: Chart,
}

impl FittedPanels {
    /// How many control points the largest of the surfaces has along each axis.
    pub(super) fn size(&self) -> [usize; 2] {
        let sizes = self.nets.iter().map(BSplineSurface::size);
        sizes.max_by_key(|[u, v]| u * v).unwrap_or_default()
    }

    /// Writes the faces of the panels, of the walls between them and of those down to `foot_mm`; the feet of these,
    /// anticlockwise from above.
    pub(super) fn write(
        &self,
        data: &mut DataSection,
        foot_mm: f64,
        faces: &mut Vec<InstanceId>,
    ) -> Vec<OrientedEdge> {
        let mut corners = CornerVertices::default();
        let mut sides = Vec::new();
        for net in &self.nets {
            let written = WrittenSurface::write(data, net, |_, _| None);
            let edges = written.sides().map(|side| corners.edge(data, &side));
            let boundary = edges.map(BrepEdge::forward).to_vec();
            faces.push(data.face(FaceRole::Optical, &[boundary], written.surface, true));
            sides.push(edges);
        }
        let mut walls = Walls { panels: self, sides, steps: Vec::new() };
        for line in self.parts.dividing_lines() {
            walls.write_between(data, &line, faces);
        }
        walls.write_outer(data, foot_mm, faces)
    }

    /// A normal of the plane through the pinhole in which the coordinate `axis` of the chart is `at`, towards larger ones.
    fn normal(&self, axis: usize, at: f64) -> DVec3 {
        let along = if axis == 0 { DVec3::X } else { DVec3::Y };
        (along + DVec3::Z * (at * self.chart.vergence - self.chart.lean[axis])).normalize()
    }
}

/// Walls along the rays of the pinhole.
struct Walls<'a> {
    panels: &'a FittedPanels,
    /// The sides of each panel, anticlockwise, the one of the least y first.
    sides: Vec<[BrepEdge; SIDES]>,
    /// Steps that are written: straight edges along rays from the corner of one panel to that of another.
    steps: Vec<BrepEdge>,
}

impl Walls<'_> {
    /// The edge along a ray from one corner to another.
    fn step(&mut self, data: &mut DataSection, from: BrepVertex, to: BrepVertex) -> OrientedEdge {
        let ends = [from.id, to.id];
        for edge in &self.steps {
            if ends == [edge.from.id, edge.to.id] {
                return edge.forward();
            }
            if ends == [edge.to.id, edge.from.id] {
                return edge.backward();
            }
        }
        let edge = data.slanted_edge(from, to);
        self.steps.push(edge);
        edge.forward()
    }

    /// The sides in their order with the steps between them.
    fn chain(&mut self, data: &mut DataSection, sides: &[OrientedEdge]) -> Vec<OrientedEdge> {
        let mut chain: Vec<OrientedEdge> = Vec::new();
        for &side in sides {
            if let Some(last) = chain.last() {
                chain.push(self.step(data, last.to(), side.from()));
            }
            chain.push(side);
        }
        chain
    }

    /// Writes the wall on a line between panels.
    fn write_between(
        &mut self,
        data: &mut DataSection,
        line: &DividingLine,
        faces: &mut Vec<InstanceId>,
    ) {
        let rising = |side: usize, k: &usize| {
            // The panel below the line meets it with its upper side: sides 1 and 2 of those at most x and at most y.
            let edges = &self.sides[*k];
            match (line.axis, side) {
                (0, 0) => edges[1].forward(),
                (0, _) => edges[3].backward(),
                (_, 0) => edges[2].backward(),
                _ => edges[0].forward(),
            }
        };
        let sides = [0, 1].map(|side| {
            line.sides[side].iter().map(|k| rising(side, k)).collect::<Vec<OrientedEdge>>()
        });
        let chains = sides.each_ref().map(|sides| self.chain(data, sides));
        let ends = chains.each_ref().map(|chain| [chain[0].from(), chain[chain.len() - 1].to()]);
        let lower = usize::from(ends[1][0].at.z < ends[0][0].at.z);
        let upper = 1 - lower;
        let mut boundary = chains[lower].clone();
        boundary.push(self.step(data, ends[lower][1], ends[upper][1]));
        boundary.extend(reversed(&chains[upper]));
        boundary.push(self.step(data, ends[upper][0], ends[lower][0]));
        // The wall faces the lower panel. Its lower side, then its upper one backwards, run anticlockwise seen from
        // larger x and from smaller y.
        if (lower == 1) != (line.axis == 0) {
            boundary = reversed(&boundary);
        }
        let normal = self.panels.normal(line.axis, line.at);
        let out = if lower == 1 { normal } else { -normal };
        faces.push(data.plane_face(FaceRole::Wall, &[boundary], ends[lower][0].at, out));
    }

    /// Writes the walls from the outer sides down to `foot_mm`; their feet.
    fn write_outer(
        &mut self,
        data: &mut DataSection,
        foot_mm: f64,
        faces: &mut Vec<InstanceId>,
    ) -> Vec<OrientedEdge> {
        let chains = [0, 1, 2, 3].map(|side| {
            let sides = self.outer_sides(side);
            self.chain(data, &sides)
        });
        let FittedPanels { parts, chart, .. } = self.panels;
        let Rect { min, max } = parts.bounds();
        let corners = [min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)];
        let feet = corners.map(|q| data.vertex(chart.ray_at(q, foot_mm).extend(foot_mm)));
        let posts = [0, 1, 2, 3].map(|k| data.slanted_edge(feet[k], chains[k][0].from()));
        let feet = [0, 1, 2, 3].map(|k| data.line_edge(feet[k], feet[(k + 1) % SIDES]).forward());
        for (k, chain) in chains.iter().enumerate() {
            let mut boundary = vec![feet[k], posts[(k + 1) % SIDES].forward()];
            boundary.extend(reversed(chain));
            boundary.push(posts[k].backward());
            let axis = (k + 1) % 2;
            let (at, way) = if k % 3 == 0 { (min[axis], -1.0) } else { (max[axis], 1.0) };
            let out = way * self.panels.normal(axis, at);
            faces.push(data.plane_face(FaceRole::Wall, &[boundary], feet[k].from().at, out));
        }
        feet.to_vec()
    }

    /// The panels' sides on a side of the outline, anticlockwise.
    fn outer_sides(&self, side: usize) -> Vec<OrientedEdge> {
        let Panels(parts) = &self.panels.parts;
        let Rect { min, max } = self.panels.parts.bounds();
        let on_side = |rect: &Rect| match side {
            0 => rect.min.y == min.y,
            1 => rect.max.x == max.x,
            2 => rect.max.y == max.y,
            _ => rect.min.x == min.x,
        };
        let along = |rect: &Rect| match side {
            0 => rect.min.x,
            1 => rect.min.y,
            2 => -rect.max.x,
            _ => -rect.max.y,
        };
        let mut found: Vec<usize> = (0..parts.len()).filter(|&k| on_side(&parts[k])).collect();
        sort_by_number(&mut found, |&k| along(&parts[k]));
        found.into_iter().map(|k| self.sides[k][side].forward()).collect()
    }
}
