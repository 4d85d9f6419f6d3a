//! The exchange structure's data section (ISO 10303-21): numbered instances, geometry and topology.

use super::spline::Axis;
use crate::geom::{DVec2, DVec3};
use std::fmt::{Display, Write};

/// The number of an instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Id(u32);

impl Display for Id {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "#{}", self.0)
    }
}

/// A vertex and where it is.
#[derive(Debug, Clone, Copy)]
pub struct Vertex {
    pub id: Id,
    pub point: Id,
    pub at: DVec3,
}

/// An edge between two vertices.
#[derive(Debug, Clone, Copy)]
pub struct Edge {
    pub id: Id,
    pub from: Vertex,
    pub to: Vertex,
}

/// An edge as a loop runs along it: in its own direction or against it.
#[derive(Debug, Clone, Copy)]
pub struct Way {
    pub edge: Edge,
    pub forward: bool,
}

impl Edge {
    pub fn forward(self) -> Way {
        Way { edge: self, forward: true }
    }

    pub fn backward(self) -> Way {
        Way { edge: self, forward: false }
    }
}

/// A loop the other way round.
pub fn reversed(ways: &[Way]) -> Vec<Way> {
    ways.iter().rev().map(|way| Way { forward: !way.forward, ..*way }).collect()
}

/// What a face is of; its name in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// The mirror.
    Optical,
    /// The flat land or the middle inside a round mirror.
    Land,
    /// What leads from the mirror's edge down to the base or to the rim.
    Wall,
    /// The flat rim around it.
    Rim,
    /// The outer walls of what is around it.
    Side,
    /// The bottom.
    Base,
    /// A through hole, counted from 1.
    Hole(usize),
    /// A mark, counted from 1.
    Mark(usize),
}

impl Display for Part {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Optical => f.write_str("OPTICAL"),
            Self::Land => f.write_str("LAND"),
            Self::Wall => f.write_str("WALL"),
            Self::Rim => f.write_str("RIM"),
            Self::Side => f.write_str("SIDE"),
            Self::Base => f.write_str("BASE"),
            Self::Hole(k) => write!(f, "HOLE_{k}"),
            Self::Mark(k) => write!(f, "MARK_{k}"),
        }
    }
}

/// Instances written so far.
#[derive(Debug, Default)]
pub struct Data {
    pub text: String,
    /// The mirror's faces.
    pub optical: Vec<Id>,
    last: u32,
    holes: usize,
}

impl Data {
    /// The name of the next through hole.
    pub fn next_hole(&mut self) -> Part {
        self.holes += 1;
        Part::Hole(self.holes)
    }

    /// Writes an instance.
    pub fn add(&mut self, what: impl Display) -> Id {
        self.last += 1;
        // Writing to memory cannot fail.
        let _ = writeln!(self.text, "#{}={what};", self.last);
        Id(self.last)
    }

    pub fn point(&mut self, at: DVec3) -> Id {
        let [x, y, z] = at.to_array().map(real);
        self.add(format_args!("CARTESIAN_POINT('',({x},{y},{z}))"))
    }

    pub fn flat_point(&mut self, at: DVec2) -> Id {
        let [x, y] = at.to_array().map(real);
        self.add(format_args!("CARTESIAN_POINT('',({x},{y}))"))
    }

    fn direction(&mut self, way: DVec3) -> Id {
        let [x, y, z] = way.to_array().map(real);
        self.add(format_args!("DIRECTION('',({x},{y},{z}))"))
    }

    /// A place with the directions of its Z and X.
    pub fn placement(&mut self, at: DVec3, z: DVec3, x: DVec3) -> Id {
        let (at, z, x) = (self.point(at), self.direction(z), self.direction(x));
        self.add(format_args!("AXIS2_PLACEMENT_3D('',{at},{z},{x})"))
    }

    pub fn vertex(&mut self, at: DVec3) -> Vertex {
        let point = self.point(at);
        self.vertex_at(point, at)
    }

    /// The vertex at a point that is there already.
    pub fn vertex_at(&mut self, point: Id, at: DVec3) -> Vertex {
        Vertex { id: self.add(format_args!("VERTEX_POINT('',{point})")), point, at }
    }

    pub fn edge(&mut self, from: Vertex, to: Vertex, curve: Id) -> Edge {
        let (a, b) = (from.id, to.id);
        Edge { id: self.add(format_args!("EDGE_CURVE('',{a},{b},{curve},.T.)")), from, to }
    }

    /// A straight edge.
    pub fn straight(&mut self, from: Vertex, to: Vertex) -> Edge {
        let way = self.direction((to.at - from.at).normalize());
        let vector = self.add(format_args!("VECTOR('',{way},1.)"));
        let line = self.add(format_args!("LINE('',{},{vector})", from.point));
        self.edge(from, to, line)
    }

    /// A circle about the vertical through `centre`, counterclockwise from above from +X.
    pub fn circle(&mut self, centre: DVec3, radius: f64) -> Id {
        let place = self.placement(centre, DVec3::Z, DVec3::X);
        self.add(format_args!("CIRCLE('',{place},{})", real(radius)))
    }

    /// A whole circle as an edge.
    pub fn round(&mut self, centre: DVec3, radius: f64) -> Edge {
        let start = self.vertex(centre + DVec3::X * radius);
        let circle = self.circle(centre, radius);
        self.edge(start, start, circle)
    }

    /// The cubic spline of these control points, in space or in the plane.
    pub fn spline(&mut self, points: &[Id], axis: &Axis) -> Id {
        let closed = if points.first() == points.last() { "T" } else { "F" };
        let (points, (many, knots)) = (list(points), knots(axis));
        self.add(format_args!(
            "B_SPLINE_CURVE_WITH_KNOTS('',3,{points},.UNSPECIFIED.,.{closed}.,.F.,{many},{knots},\
             .UNSPECIFIED.)"
        ))
    }

    /// The spline surface of these control points, a line of them along v for each of u's; along
    /// an axis without knots it is straight, 0 to 1.
    pub fn spline_surface(&mut self, lines: &[Vec<Id>], axes: [Option<&Axis>; 2]) -> Id {
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

    /// What a curve in the XZ plane makes about the Z axis.
    pub fn revolution(&mut self, curve: Id) -> Id {
        let (origin, up) = (self.point(DVec3::ZERO), self.direction(DVec3::Z));
        let axis = self.add(format_args!("AXIS1_PLACEMENT('',{origin},{up})"));
        self.add(format_args!("SURFACE_OF_REVOLUTION('',{curve},{axis})"))
    }

    /// A curve in space with what it is in the parameters of a surface.
    pub fn on_surface(&mut self, curve: Id, surface: Id, flat: Id) -> Id {
        let context = self.add(
            "(GEOMETRIC_REPRESENTATION_CONTEXT(2)PARAMETRIC_REPRESENTATION_CONTEXT()\
             REPRESENTATION_CONTEXT('2D SPACE',''))",
        );
        let shown = self.add(format_args!("DEFINITIONAL_REPRESENTATION('',({flat}),{context})"));
        let flat = self.add(format_args!("PCURVE('',{surface},{shown})"));
        self.add(format_args!("SURFACE_CURVE('',{curve},({flat}),.CURVE_3D.)"))
    }

    /// A circle about the origin of a surface's parameters.
    pub fn flat_circle(&mut self, radius: f64) -> Id {
        let centre = self.flat_point(DVec2::ZERO);
        let x = self.add("DIRECTION('',(1.,0.))");
        let place = self.add(format_args!("AXIS2_PLACEMENT_2D('',{centre},{x})"));
        self.add(format_args!("CIRCLE('',{place},{})", real(radius)))
    }

    pub fn face_loop(&mut self, ways: &[Way]) -> Id {
        let ways: Vec<Id> = ways
            .iter()
            .map(|way| {
                let flag = if way.forward { "T" } else { "F" };
                self.add(format_args!("ORIENTED_EDGE('',*,*,{},.{flag}.)", way.edge.id))
            })
            .collect();
        let ways = list(&ways);
        self.add(format_args!("EDGE_LOOP('',{ways})"))
    }

    /// A face, the outer loop first; `same` when the surface's normal leads out of the body.
    pub fn face(&mut self, part: Part, loops: &[Vec<Way>], surface: Id, same: bool) -> Id {
        let mut bounds = Vec::new();
        for (k, ways) in loops.iter().enumerate() {
            let name = if k == 0 { "FACE_OUTER_BOUND" } else { "FACE_BOUND" };
            let ways = self.face_loop(ways);
            bounds.push(self.add(format_args!("{name}('',{ways},.T.)")));
        }
        let (bounds, flag) = (list(&bounds), if same { "T" } else { "F" });
        let face = self.add(format_args!("ADVANCED_FACE('{part}',{bounds},{surface},.{flag}.)"));
        if part == Part::Optical {
            self.optical.push(face);
        }
        face
    }

    /// A plane face with this normal, out of the body.
    pub fn flat_face(&mut self, part: Part, loops: &[Vec<Way>], at: DVec3, normal: DVec3) -> Id {
        let across = if normal.x == 0.0 { DVec3::X } else { DVec3::Y };
        let place = self.placement(at, normal, across);
        let plane = self.add(format_args!("PLANE('',{place})"));
        self.face(part, loops, plane, true)
    }

    /// An upright cylinder.
    pub fn cylinder(&mut self, centre: DVec2, radius: f64) -> Id {
        let place = self.placement(centre.extend(0.0), DVec3::Z, DVec3::X);
        self.add(format_args!("CYLINDRICAL_SURFACE('',{place},{})", real(radius)))
    }

    /// An upright cylinder's face from one round edge to another, with a seam; `same`: material is inside.
    pub fn upright(
        &mut self,
        part: Part,
        [low, high]: [Edge; 2],
        (centre, radius): (DVec2, f64),
        same: bool,
    ) -> Id {
        let surface = self.cylinder(centre, radius);
        let seam = self.straight(low.from, high.from);
        let ways = [low.forward(), seam.forward(), high.backward(), seam.backward()];
        let ways = if same { ways.to_vec() } else { reversed(&ways) };
        self.face(part, &[ways], surface, same)
    }

    /// The face on `surface`, whose normal leads up if `same`, from a point to a closed edge.
    pub fn fan(&mut self, part: Part, middle: Vertex, rim: Edge, surface: Id, same: bool) -> Id {
        let seam = self.straight(middle, rim.from);
        self.face(part, &[vec![rim.forward(), seam.backward(), seam.forward()]], surface, same)
    }
}

/// `(#1,#2,...)`.
pub fn list(ids: &[Id]) -> String {
    let ids: Vec<String> = ids.iter().map(Id::to_string).collect();
    format!("({})", ids.join(","))
}

/// Multiplicities and values of a cubic's knots.
fn knots(axis: &Axis) -> (String, String) {
    let breaks = axis.breaks();
    let ones = ",1".repeat(breaks.len() - 2);
    let values: Vec<String> = breaks.iter().map(|&k| digits(k, 13)).collect();
    (format!("(4{ones},4)"), format!("({})", values.join(",")))
}

/// A number to 1e-10: what matters of millimetres.
pub fn real(x: f64) -> String {
    digits(x, 10)
}

/// A number to so many decimals, without those that are 0.
fn digits(x: f64, decimals: usize) -> String {
    let text = format!("{:.decimals$}", x + 0.0);
    let text = text.trim_end_matches('0');
    if text == "-0." { "0.".into() } else { text.into() }
}

/// A string in quotes: printable ASCII of at most 256 characters.
pub fn quoted(text: &str) -> String {
    let cut: String = super::super::Label::plain(text).chars().take(256).collect();
    format!("'{}'", cut.replace('\\', "\\\\").replace('\'', "''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_reals_with_the_digits_that_matter() {
        for (x, text) in [
            (0.0, "0."),
            (-0.0, "0."),
            (-1e-12, "0."),
            (12.0, "12."),
            (-0.5, "-0.5"),
            (1.0 / 3.0, "0.3333333333"),
            (1e6 + 1e-10, "1000000.0000000001"),
        ] {
            assert_eq!(real(x), text);
        }
    }

    #[test]
    fn strings_end_where_they_should() {
        assert_eq!(quoted("it's\n"), "'it''s?'");
        assert_eq!(quoted("a\\b"), "'a\\\\b'");
        assert_eq!(quoted(&"x".repeat(300)).len(), 258);
    }

    #[test]
    fn loops_turn_round() {
        let mut data = Data::default();
        let [a, b] = [DVec3::ZERO, DVec3::X].map(|at| data.vertex(at));
        let (there, back) = (data.straight(a, b), data.straight(b, a));
        let ways = reversed(&[there.forward(), back.backward()]);
        assert_eq!((ways[0].edge.id, ways[0].forward), (back.id, true));
        assert_eq!((ways[1].edge.id, ways[1].forward), (there.id, false));
        assert!(
            data.text.starts_with("#1=CARTESIAN_POINT('',(0.,0.,0.));\n#2=VERTEX_POINT('',#1);\n")
        );
    }
}
