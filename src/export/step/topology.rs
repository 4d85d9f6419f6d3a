//! Geometry and topology of a boundary representation (ISO 10303-42) as instances of a data section.

use super::b_spline::KnotVector;
use super::face_role::FaceRole;
use super::part21::{DataSection, InstanceId, WrittenFace, digits, list, quoted, real};
use crate::geom::{DVec2, DVec3};
use crate::num::atan2;

/// A vertex and where it is.
#[derive(Debug, Clone, Copy)]
pub(super) struct BrepVertex {
    pub id: InstanceId,
    pub point: InstanceId,
    pub at: DVec3,
}

/// An edge between two vertices.
#[derive(Debug, Clone, Copy)]
pub(super) struct BrepEdge {
    pub id: InstanceId,
    pub from: BrepVertex,
    pub to: BrepVertex,
}

/// An edge as a loop runs along it: in its own direction or against it.
#[derive(Debug, Clone, Copy)]
pub(super) struct OrientedEdge {
    pub edge: BrepEdge,
    pub forward: bool,
}

impl BrepEdge {
    pub(super) fn forward(self) -> OrientedEdge {
        OrientedEdge { edge: self, forward: true }
    }

    pub(super) fn backward(self) -> OrientedEdge {
        OrientedEdge { edge: self, forward: false }
    }
}

impl OrientedEdge {
    /// Where the loop comes from.
    pub(super) fn from(self) -> BrepVertex {
        if self.forward { self.edge.from } else { self.edge.to }
    }

    /// Where the loop goes.
    pub(super) fn to(self) -> BrepVertex {
        if self.forward { self.edge.to } else { self.edge.from }
    }
}

/// A loop in the opposite direction.
pub(super) fn reversed(boundary: &[OrientedEdge]) -> Vec<OrientedEdge> {
    boundary.iter().rev().map(|edge| OrientedEdge { forward: !edge.forward, ..*edge }).collect()
}

impl DataSection {
    pub(super) fn point(&mut self, at: DVec3) -> InstanceId {
        let [x, y, z] = at.to_array().map(real);
        self.add(format_args!("CARTESIAN_POINT('',({x},{y},{z}))"))
    }

    pub(super) fn point_2d(&mut self, at: DVec2) -> InstanceId {
        let [x, y] = at.to_array().map(real);
        self.add(format_args!("CARTESIAN_POINT('',({x},{y}))"))
    }

    fn direction(&mut self, along: DVec3) -> InstanceId {
        let [x, y, z] = along.to_array().map(real);
        self.add(format_args!("DIRECTION('',({x},{y},{z}))"))
    }

    /// A place with the directions of its Z and X.
    pub(super) fn placement(&mut self, at: DVec3, z: DVec3, x: DVec3) -> InstanceId {
        let (at, z, x) = (self.point(at), self.direction(z), self.direction(x));
        self.add(format_args!("AXIS2_PLACEMENT_3D('',{at},{z},{x})"))
    }

    pub(super) fn vertex(&mut self, at: DVec3) -> BrepVertex {
        let point = self.point(at);
        self.vertex_at(point, at)
    }

    /// The vertex at a point that is there already.
    pub(super) fn vertex_at(&mut self, point: InstanceId, at: DVec3) -> BrepVertex {
        BrepVertex { id: self.add(format_args!("VERTEX_POINT('',{point})")), point, at }
    }

    pub(super) fn edge(&mut self, from: BrepVertex, to: BrepVertex, curve: InstanceId) -> BrepEdge {
        let (a, b) = (from.id, to.id);
        BrepEdge { id: self.add(format_args!("EDGE_CURVE('',{a},{b},{curve},.T.)")), from, to }
    }

    /// A straight edge.
    pub(super) fn line_edge(&mut self, from: BrepVertex, to: BrepVertex) -> BrepEdge {
        self.edge_along(from, to, (to.at - from.at).normalize())
    }

    /// A straight edge in any direction, which is told by the difference of its ends: a unit vector of as many digits
    /// would leave the end of a long one beside its vertex.
    pub(super) fn slanted_edge(&mut self, from: BrepVertex, to: BrepVertex) -> BrepEdge {
        self.edge_along(from, to, to.at - from.at)
    }

    fn edge_along(&mut self, from: BrepVertex, to: BrepVertex, along: DVec3) -> BrepEdge {
        let edge = self.direction(along);
        let vector = self.add(format_args!("VECTOR('',{edge},1.)"));
        let line = self.add(format_args!("LINE('',{},{vector})", from.point));
        self.edge(from, to, line)
    }

    /// A circle about the vertical through `centre`, counterclockwise from above from +X.
    pub(super) fn circle(&mut self, centre: DVec3, radius: f64) -> InstanceId {
        let place = self.placement(centre, DVec3::Z, DVec3::X);
        self.add(format_args!("CIRCLE('',{place},{})", real(radius)))
    }

    /// A whole circle as an edge.
    pub(super) fn circle_edge(&mut self, centre: DVec3, radius: f64) -> BrepEdge {
        let start = self.vertex(centre + DVec3::X * radius);
        let circle = self.circle(centre, radius);
        self.edge(start, start, circle)
    }

    /// The cubic spline of these control points, in space or in the plane.
    pub(super) fn spline_curve(&mut self, points: &[InstanceId], axis: &KnotVector) -> InstanceId {
        let closed = if points.first() == points.last() { "T" } else { "F" };
        let (points, (many, knots)) = (list(points), knots(axis));
        self.add(format_args!(
            "B_SPLINE_CURVE_WITH_KNOTS('',3,{points},.UNSPECIFIED.,.{closed}.,.F.,{many},{knots},\
             .UNSPECIFIED.)"
        ))
    }

    /// The spline surface of these control points, a line of them along v for each of u's; along
    /// an axis without knots it is straight, 0 to 1.
    pub(super) fn spline_surface(
        &mut self,
        lines: &[Vec<InstanceId>],
        axes: [Option<&KnotVector>; 2],
    ) -> InstanceId {
        let lines: Vec<String> = lines.iter().map(|line| list(line)).collect();
        let degree = axes.map(|axis| if axis.is_some() { 3 } else { 1 });
        let straight = || ("(2,2)".to_owned(), "(0.,1.)".to_owned());
        let [(u, us), (v, vs)] = axes.map(|axis| axis.map_or_else(straight, knots));
        self.add(format_args!(
            "B_SPLINE_SURFACE_WITH_KNOTS('',{},{},({}),.UNSPECIFIED.,.F.,.F.,.F.,{u},{v},{us},\
             {vs},.UNSPECIFIED.)",
            degree[0],
            degree[1],
            lines.join(",")
        ))
    }

    /// The surface of revolution of a curve in the XZ plane about the Z axis.
    pub(super) fn surface_of_revolution(&mut self, curve: InstanceId) -> InstanceId {
        let (origin, up) = (self.point(DVec3::ZERO), self.direction(DVec3::Z));
        let axis = self.add(format_args!("AXIS1_PLACEMENT('',{origin},{up})"));
        self.add(format_args!("SURFACE_OF_REVOLUTION('',{curve},{axis})"))
    }

    /// A curve in space together with its image in the parameters of a surface.
    pub(super) fn surface_curve(
        &mut self,
        curve: InstanceId,
        surface: InstanceId,
        flat: InstanceId,
    ) -> InstanceId {
        let context = self.add(
            "(GEOMETRIC_REPRESENTATION_CONTEXT(2)PARAMETRIC_REPRESENTATION_CONTEXT()\
             REPRESENTATION_CONTEXT('2D SPACE',''))",
        );
        let shown = self.add(format_args!("DEFINITIONAL_REPRESENTATION('',({flat}),{context})"));
        let flat = self.add(format_args!("PCURVE('',{surface},{shown})"));
        self.add(format_args!("SURFACE_CURVE('',{curve},({flat}),.CURVE_3D.)"))
    }

    /// A circle about the origin of a surface's parameters.
    pub(super) fn circle_2d(&mut self, radius: f64) -> InstanceId {
        let centre = self.point_2d(DVec2::ZERO);
        let x = self.add("DIRECTION('',(1.,0.))");
        let place = self.add(format_args!("AXIS2_PLACEMENT_2D('',{centre},{x})"));
        self.add(format_args!("CIRCLE('',{place},{})", real(radius)))
    }

    pub(super) fn edge_loop(&mut self, boundary: &[OrientedEdge]) -> InstanceId {
        let boundary: Vec<InstanceId> = boundary
            .iter()
            .map(|edge| {
                let flag = if edge.forward { "T" } else { "F" };
                self.add(format_args!("ORIENTED_EDGE('',*,*,{},.{flag}.)", edge.edge.id))
            })
            .collect();
        let boundary = list(&boundary);
        self.add(format_args!("EDGE_LOOP('',{boundary})"))
    }

    /// A face, the outer loop first; `same` when the surface's normal leads out of the body. In a cavity all of that is
    /// turned round.
    pub(super) fn face(
        &mut self,
        role: FaceRole,
        loops: &[Vec<OrientedEdge>],
        surface: InstanceId,
        same: bool,
    ) -> InstanceId {
        self.face_towards(role, loops, surface, same, None)
    }

    /// A face as [`Self::face`] has it, of which the outward normal's X and Y are known if it is an upright plane.
    fn face_towards(
        &mut self,
        role: FaceRole,
        loops: &[Vec<OrientedEdge>],
        surface: InstanceId,
        same: bool,
        out: Option<DVec2>,
    ) -> InstanceId {
        let flag = |holds: bool| if holds { "T" } else { "F" };
        let (role, same) = match self.is_cavity {
            true => (FaceRole::Cavity, !same),
            false => (role, same),
        };
        let forward = flag(!self.is_cavity);
        let mut bounds = Vec::new();
        for (k, boundary) in loops.iter().enumerate() {
            let name = if k == 0 { "FACE_OUTER_BOUND" } else { "FACE_BOUND" };
            let boundary = self.edge_loop(boundary);
            bounds.push(self.add(format_args!("{name}('',{boundary},.{forward}.)")));
        }
        let (bounds, flag) = (list(&bounds), flag(same));
        let name = quoted(&role.to_string());
        let id = self.add(format_args!("ADVANCED_FACE({name},{bounds},{surface},.{flag}.)"));
        self.faces.push(WrittenFace { id, role, out });
        id
    }

    /// A plane face with this normal, out of the body.
    pub(super) fn plane_face(
        &mut self,
        role: FaceRole,
        loops: &[Vec<OrientedEdge>],
        at: DVec3,
        normal: DVec3,
    ) -> InstanceId {
        let across = if normal.x == 0.0 { DVec3::X } else { DVec3::Y };
        let place = self.placement(at, normal, across);
        let plane = self.add(format_args!("PLANE('',{place})"));
        let out = (normal.z == 0.0).then_some(normal.truncate());
        self.face_towards(role, loops, plane, true, out)
    }

    /// An upright cylinder.
    pub(super) fn cylinder(&mut self, centre: DVec2, radius: f64) -> InstanceId {
        let place = self.placement(centre.extend(0.0), DVec3::Z, DVec3::X);
        self.add(format_args!("CYLINDRICAL_SURFACE('',{place},{})", real(radius)))
    }

    /// The upright cylinder or cone between two circles, or a circle and a point, of such radius and Z.
    pub(super) fn cylinder_or_cone(&mut self, axis: DVec2, [low, high]: [DVec2; 2]) -> InstanceId {
        if low.x == high.x {
            return self.cylinder(axis, low.x);
        }
        // Its radius grows along the placement's Z.
        let wider = if high.x > low.x { DVec3::Z } else { DVec3::NEG_Z };
        let place = self.placement(axis.extend(low.y), wider, DVec3::X);
        let half_angle = atan2((high.x - low.x).abs(), high.y - low.y);
        self.add(format_args!("CONICAL_SURFACE('',{place},{},{half_angle})", real(low.x)))
    }

    /// An upright cylinder's face from one round edge to another, with a seam; `same`: material is inside.
    pub(super) fn cylinder_face(
        &mut self,
        role: FaceRole,
        edges: [BrepEdge; 2],
        (centre, radius): (DVec2, f64),
        same: bool,
    ) -> InstanceId {
        let surface = self.cylinder(centre, radius);
        self.turned_face(role, edges, surface, same)
    }

    /// The face of an upright cylinder or cone from one round edge to another, with a seam; `same`: material is inside.
    pub(super) fn turned_face(
        &mut self,
        role: FaceRole,
        [low, high]: [BrepEdge; 2],
        surface: InstanceId,
        same: bool,
    ) -> InstanceId {
        let seam = if low.from.at.truncate() == high.from.at.truncate() {
            self.line_edge(low.from, high.from)
        } else {
            self.slanted_edge(low.from, high.from)
        };
        let boundary = [low.forward(), seam.forward(), high.backward(), seam.backward()];
        let boundary = if same { boundary.to_vec() } else { reversed(&boundary) };
        self.face(role, &[boundary], surface, same)
    }

    /// The face on `surface`, whose normal leads up if `same`, from a point to a closed edge.
    pub(super) fn fan_face(
        &mut self,
        role: FaceRole,
        middle: BrepVertex,
        rim: BrepEdge,
        surface: InstanceId,
        same: bool,
    ) -> InstanceId {
        let seam = self.line_edge(middle, rim.from);
        self.face(role, &[vec![rim.forward(), seam.backward(), seam.forward()]], surface, same)
    }
}

/// Multiplicities and values of a cubic's knots.
fn knots(axis: &KnotVector) -> (String, String) {
    let breaks = axis.breaks();
    let ones = ",1".repeat(breaks.len() - 2);
    let values: Vec<String> = breaks.iter().map(|&k| digits(k, 13)).collect();
    (format!("(4{ones},4)"), format!("({})", values.join(",")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loops_turn_round() {
        let mut data = DataSection::default();
        let [a, b] = [DVec3::ZERO, DVec3::X].map(|at| data.vertex(at));
        let (there, back) = (data.line_edge(a, b), data.line_edge(b, a));
        let boundary = reversed(&[there.forward(), back.backward()]);
        assert_eq!((boundary[0].edge.id, boundary[0].forward), (back.id, true));
        assert_eq!((boundary[1].edge.id, boundary[1].forward), (there.id, false));
        assert!(
            data.text.starts_with("#1=CARTESIAN_POINT('',(0.,0.,0.));\n#2=VERTEX_POINT('',#1);\n")
        );
    }
}
