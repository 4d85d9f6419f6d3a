//! The mirror's faces, the walls under them and the base plane, closed to a body.

use super::border::{border, drill};
use super::fit::{Fit, Form};
use super::part21::{Data, Edge, Id, Part, Vertex, Way, list, reversed};
use super::rim::Rim;
use super::spline::{Axis, Net};
use crate::geom::{Border, DVec2, DVec3, Land};

/// Writes the body; its number.
pub fn body(data: &mut Data, fit: &Fit, stock: Option<&Border>) -> Id {
    let (mut faces, mut lows) = (Vec::new(), Vec::new());
    let foot_mm = stock.map_or(0.0, |stock| stock.top_mm);
    let foot = match &fit.form {
        Form::Panel { net, straight, folded } => {
            panels(data, net, [*straight, *folded], foot_mm, &mut faces)
        }
        Form::Cut { net, outer: (outer_mm, outer), inner, middle_mm } => {
            let outer = cut(data, net, outer, *outer_mm, inner.as_ref(), *middle_mm, &mut faces);
            wall(data, outer, *outer_mm, foot_mm, &mut faces)
        }
        Form::Turned { radius, points } => {
            let land = stock.and_then(|stock| stock.land.as_ref());
            let outer = turned(data, radius, points, land, &mut lows, &mut faces);
            wall(data, outer, points[points.len() - 1].x, foot_mm, &mut faces)
        }
    };
    match stock {
        Some(stock) => border(data, stock, &foot, &lows, &mut faces),
        None => {
            faces.push(data.flat_face(Part::Base, &[reversed(&foot)], DVec3::ZERO, DVec3::NEG_Z))
        }
    }
    let shell = list(&faces);
    let shell = data.add(format_args!("CLOSED_SHELL('',{shell})"));
    data.add(format_args!("MANIFOLD_SOLID_BREP('mirror',{shell})"))
}

/// A net whose control points are written.
struct Sheet {
    net: Net,
    /// Their numbers, a line along v for each of u's.
    ids: Vec<Vec<Id>>,
    surface: Id,
}

/// A side of a sheet: control points in its direction.
struct Side {
    ids: Vec<Id>,
    points: Vec<DVec3>,
    axis: Axis,
}

impl Sheet {
    /// Writes `net`; `known` are control points that are there already.
    fn write(data: &mut Data, net: &Net, known: impl Fn(usize, usize) -> Option<Id>) -> Self {
        let [u, v] = &net.axes;
        let mut ids = Vec::new();
        for i in 0..u.count() {
            let line = net.line(i).iter().enumerate();
            ids.push(line.map(|(j, &p)| known(i, j).unwrap_or_else(|| data.point(p))).collect());
        }
        let surface = data.spline_surface(&ids, [Some(u), Some(v)]);
        Self { net: net.clone(), ids, surface }
    }

    /// The four sides counterclockwise from above, that of the least v first.
    fn sides(&self) -> [Side; 4] {
        let [u, v] = &self.net.axes;
        let (last_u, last_v) = (u.count() - 1, v.count() - 1);
        let side = |axis: Axis, places: Vec<(usize, usize)>| Side {
            ids: places.iter().map(|&(i, j)| self.ids[i][j]).collect(),
            points: places.iter().map(|&(i, j)| self.net.line(i)[j]).collect(),
            axis,
        };
        [
            side(u.clone(), (0..=last_u).map(|i| (i, 0)).collect()),
            side(v.clone(), (0..=last_v).map(|j| (last_u, j)).collect()),
            side(u.reversed(), (0..=last_u).rev().map(|i| (i, last_v)).collect()),
            side(v.reversed(), (0..=last_v).rev().map(|j| (0, j)).collect()),
        ]
    }
}

/// The net reflected in Y = 0.
fn reflected(net: &Net) -> Net {
    let [u, v] = &net.axes;
    let flip = |p: &DVec3| DVec3::new(p.x, 0.0 - p.y, p.z);
    let points = (0..u.count()).flat_map(|i| net.line(i).iter().rev().map(flip)).collect();
    Net { axes: [u.clone(), v.reversed()], points }
}

/// Corners met so far.
#[derive(Default)]
struct Corners(Vec<(Id, Vertex)>);

impl Corners {
    fn at(&mut self, data: &mut Data, point: Id, at: DVec3) -> Vertex {
        match self.0.iter().find(|(id, _)| *id == point) {
            Some((_, vertex)) => *vertex,
            None => {
                let vertex = data.vertex_at(point, at);
                self.0.push((point, vertex));
                vertex
            }
        }
    }

    fn edge(&mut self, data: &mut Data, side: &Side) -> Edge {
        let last = side.ids.len() - 1;
        let from = self.at(data, side.ids[0], side.points[0]);
        let to = self.at(data, side.ids[last], side.points[last]);
        let curve = data.spline(&side.ids, &side.axis);
        data.edge(from, to, curve)
    }
}

/// Faces of one panel or two and their walls down to `foot_mm`; the walls' feet, counterclockwise
/// from above.
fn panels(
    data: &mut Data,
    net: &Net,
    [straight, folded]: [bool; 2],
    foot_mm: f64,
    faces: &mut Vec<Id>,
) -> Vec<Way> {
    let mut corners = Corners::default();
    let designed = Sheet::write(data, net, |_, _| None);
    let mut walls: [Vec<(Side, Edge)>; 4] = Default::default();
    let mut sheets = vec![designed];
    if folded {
        let other = reflected(net);
        let ids = &sheets[0].ids;
        let last = net.axes[1].count() - 1;
        let on_ridge =
            |i: usize, j: usize| (net.line(i)[last - j].y == 0.0).then(|| ids[i][last - j]);
        let other = Sheet::write(data, &other, on_ridge);
        let below = net.at(centre(net)).y > 0.0;
        sheets.insert(if below { 0 } else { 1 }, other);
    }
    let mut ridge: Option<Edge> = None;
    let upmost = sheets.len() - 1;
    for (k, sheet) in sheets.iter().enumerate() {
        let mut ways = Vec::new();
        for (s, side) in sheet.sides().into_iter().enumerate() {
            match (s, ridge) {
                (0, Some(ridge)) => ways.push(ridge.backward()),
                _ => {
                    let edge = corners.edge(data, &side);
                    ways.push(edge.forward());
                    if s == 2 && k < upmost {
                        ridge = Some(edge);
                    } else if s == 3 {
                        walls[s].insert(0, (side, edge));
                    } else {
                        walls[s].push((side, edge));
                    }
                }
            }
        }
        faces.push(data.face(Part::Optical, &[ways], sheet.surface, true));
    }
    let walls: Vec<Vec<(Side, Edge)>> = if straight {
        walls.into()
    } else {
        walls.into_iter().flatten().map(|wall| vec![wall]).collect()
    };
    let low = |vertex: Vertex| vertex.at.truncate().extend(foot_mm);
    let posts: Vec<Edge> = walls
        .iter()
        .map(|wall| {
            let top = wall[0].1.from;
            let foot = data.vertex(low(top));
            data.straight(foot, top)
        })
        .collect();
    let mut feet = Vec::new();
    for (k, wall) in walls.iter().enumerate() {
        let (start, end) = (posts[k], posts[(k + 1) % posts.len()]);
        let (foot, surface) = if straight {
            (data.straight(start.from, end.from), None)
        } else {
            let (foot, surface) = ruled(data, &wall[0].0, [start.from, end.from], foot_mm);
            (foot, Some(surface))
        };
        let mut ways = vec![foot.forward(), end.forward()];
        ways.extend(wall.iter().rev().map(|(_, edge)| edge.backward()));
        ways.push(start.backward());
        faces.push(match surface {
            Some(surface) => data.face(Part::Wall, &[ways], surface, true),
            None => {
                let along = (end.from.at - start.from.at).normalize();
                data.flat_face(Part::Wall, &[ways], start.from.at, along.cross(DVec3::Z))
            }
        });
        feet.push(foot.forward());
    }
    feet
}

fn centre(net: &Net) -> DVec2 {
    let [u, v] = net.axes.each_ref().map(|axis| {
        let breaks = axis.breaks();
        0.5 * (breaks[0] + breaks[breaks.len() - 1])
    });
    DVec2::new(u, v)
}

/// The vertical wall under a side that is not straight: its foot and its surface.
fn ruled(data: &mut Data, side: &Side, ends: [Vertex; 2], foot_mm: f64) -> (Edge, Id) {
    let last = side.ids.len() - 1;
    let feet: Vec<Id> = (0..=last)
        .map(|k| match k {
            0 => ends[0].point,
            _ if k == last => ends[1].point,
            _ => data.point(side.points[k].truncate().extend(foot_mm)),
        })
        .collect();
    let curve = data.spline(&feet, &side.axis);
    let foot = data.edge(ends[0], ends[1], curve);
    let lines: Vec<Vec<Id>> = feet.iter().zip(&side.ids).map(|(&a, &b)| vec![a, b]).collect();
    (foot, data.spline_surface(&lines, [Some(&side.axis), None]))
}

/// The wall of a round mirror from its rim down to `foot_mm`; the wall's foot.
fn wall(data: &mut Data, rim: Edge, rim_mm: f64, foot_mm: f64, faces: &mut Vec<Id>) -> Vec<Way> {
    let foot = data.round(DVec3::Z * foot_mm, rim_mm);
    faces.push(data.upright(Part::Wall, [foot, rim], (DVec2::ZERO, rim_mm), true));
    vec![foot.forward()]
}

/// Faces of a mirror cut out of `net`; its outer rim.
fn cut(
    data: &mut Data,
    net: &Net,
    outer: &Rim,
    outer_mm: f64,
    inner: Option<&(f64, Rim)>,
    middle_mm: f64,
    faces: &mut Vec<Id>,
) -> Edge {
    let surface = Sheet::write(data, net, |_, _| None).surface;
    let (outer, _) = rim(data, outer, outer_mm, surface);
    let mut loops = vec![vec![outer.forward()]];
    if let Some((inner_mm, inner)) = inner {
        let (edge, ids) = rim(data, inner, *inner_mm, surface);
        loops.push(vec![edge.backward()]);
        let middle = data.vertex(DVec3::Z * middle_mm);
        let lines = [vec![middle.point; ids.len()], ids];
        let land = data.spline_surface(&lines, [None, Some(&inner.angles)]);
        faces.push(data.fan(Part::Land, middle, edge, land, true));
    }
    faces.push(data.face(Part::Optical, &loops, surface, true));
    outer
}

/// The edge of a rim over a circle of `surface`'s parameters, and its control points' numbers.
fn rim(data: &mut Data, rim: &Rim, radius: f64, surface: Id) -> (Edge, Vec<Id>) {
    let (start, rest) = (rim.points[0], &rim.points[1..rim.points.len() - 1]);
    let vertex = data.vertex(start);
    let mut ids = vec![vertex.point];
    ids.extend(rest.iter().map(|&p| data.point(p)));
    ids.push(vertex.point);
    let curve = data.spline(&ids, &rim.angles);
    let flat = data.flat_circle(radius);
    let curve = data.on_surface(curve, surface, flat);
    (data.edge(vertex, vertex, curve), ids)
}

/// Faces of a surface of revolution, and of the holes in the land inside it, whose lower ends go to
/// `lows`; its outer rim.
fn turned(
    data: &mut Data,
    radius: &Axis,
    points: &[DVec3],
    land: Option<&Land>,
    lows: &mut Vec<Edge>,
    faces: &mut Vec<Id>,
) -> Edge {
    let ids: Vec<Id> = points.iter().map(|&p| data.point(p)).collect();
    let last = points.len() - 1;
    let [start, end] = [0, last].map(|k| data.vertex_at(ids[k], points[k]));
    let meridian = data.spline(&ids, radius);
    let seam = data.edge(start, end, meridian);
    let surface = data.revolution(meridian);
    let mut rim = |vertex: Vertex| {
        let circle = data.circle(DVec3::Z * vertex.at.z, vertex.at.x);
        data.edge(vertex, vertex, circle)
    };
    let outer = rim(end);
    let mut ways = vec![outer.forward(), seam.backward()];
    if start.at.x > 0.0 {
        let inner = rim(start);
        ways.push(inner.backward());
        let mut loops = vec![vec![inner.forward()]];
        for hole in land.into_iter().flat_map(|land| &land.holes) {
            let [low, high] = drill(data, hole, start.at.z, faces);
            loops.push(vec![high.backward()]);
            lows.push(low);
        }
        faces.push(data.flat_face(Part::Land, &loops, DVec3::Z * start.at.z, DVec3::Z));
    }
    ways.push(seam.forward());
    // Its normal is that of its circles times its meridian: down.
    faces.push(data.face(Part::Optical, &[ways], surface, false));
    outer
}
