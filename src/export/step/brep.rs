//! The mirror's faces, the walls under them and the base plane, closed to a body.

use super::b_spline::{BSplineSurface, KnotVector};
use super::border::{write_border, write_hole};
use super::fit::{FittedFaces, FittedMirror};
use super::part21::{DataSection, InstanceId, list};
use super::rim_curve::RimCurve;
use super::topology::{BrepEdge, BrepVertex, FaceRole, OrientedEdge, reversed};
use crate::geom::{Border, DVec2, DVec3, Land};

/// Writes the body; its number.
pub fn write_body(
    data: &mut DataSection,
    fit: &FittedMirror,
    border: Option<&Border>,
) -> InstanceId {
    let (mut faces, mut lows) = (Vec::new(), Vec::new());
    let foot_mm = border.map_or(0.0, |border| border.top_mm);
    let foot = match &fit.faces {
        FittedFaces::Panel { net, straight, folded } => {
            panels(data, net, [*straight, *folded], foot_mm, &mut faces)
        }
        FittedFaces::Trimmed { net, outer: (outer_mm, outer), inner, middle_mm } => {
            let outer = cut(data, net, outer, *outer_mm, inner.as_ref(), *middle_mm, &mut faces);
            wall(data, outer, *outer_mm, foot_mm, &mut faces)
        }
        FittedFaces::Revolved { radius, points } => {
            let land = border.and_then(|border| border.land.as_ref());
            let outer = turned(data, radius, points, land, &mut lows, &mut faces);
            wall(data, outer, points[points.len() - 1].x, foot_mm, &mut faces)
        }
    };
    match border {
        Some(border) => write_border(data, border, &foot, &lows, &mut faces),
        None => faces.push(data.plane_face(
            FaceRole::Base,
            &[reversed(&foot)],
            DVec3::ZERO,
            DVec3::NEG_Z,
        )),
    }
    let shell = list(&faces);
    let shell = data.add(format_args!("CLOSED_SHELL('',{shell})"));
    data.add(format_args!("MANIFOLD_SOLID_BREP('mirror',{shell})"))
}

/// A net whose control points are written.
struct WrittenSurface {
    net: BSplineSurface,
    /// Their numbers, a line along v for each of u's.
    ids: Vec<Vec<InstanceId>>,
    surface: InstanceId,
}

/// A side of a surface: control points in its direction.
struct SurfaceSide {
    ids: Vec<InstanceId>,
    points: Vec<DVec3>,
    axis: KnotVector,
}

impl WrittenSurface {
    /// Writes `net`; `known` are control points that are there already.
    fn write(
        data: &mut DataSection,
        net: &BSplineSurface,
        known: impl Fn(usize, usize) -> Option<InstanceId>,
    ) -> Self {
        let [u, v] = &net.axes;
        let mut ids = Vec::new();
        for i in 0..u.count() {
            let line = net.control_row(i).iter().enumerate();
            ids.push(line.map(|(j, &p)| known(i, j).unwrap_or_else(|| data.point(p))).collect());
        }
        let surface = data.spline_surface(&ids, [Some(u), Some(v)]);
        Self { net: net.clone(), ids, surface }
    }

    /// The four sides counterclockwise from above, that of the least v first.
    fn sides(&self) -> [SurfaceSide; 4] {
        let [u, v] = &self.net.axes;
        let (last_u, last_v) = (u.count() - 1, v.count() - 1);
        let side = |axis: KnotVector, places: Vec<(usize, usize)>| SurfaceSide {
            ids: places.iter().map(|&(i, j)| self.ids[i][j]).collect(),
            points: places.iter().map(|&(i, j)| self.net.control_row(i)[j]).collect(),
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
fn reflected(net: &BSplineSurface) -> BSplineSurface {
    let [u, v] = &net.axes;
    let flip = |p: &DVec3| DVec3::new(p.x, 0.0 - p.y, p.z);
    let points = (0..u.count()).flat_map(|i| net.control_row(i).iter().rev().map(flip)).collect();
    BSplineSurface { axes: [u.clone(), v.reversed()], points }
}

/// Corners met so far.
#[derive(Default)]
struct CornerVertices(Vec<(InstanceId, BrepVertex)>);

impl CornerVertices {
    fn at(&mut self, data: &mut DataSection, point: InstanceId, at: DVec3) -> BrepVertex {
        match self.0.iter().find(|(id, _)| *id == point) {
            Some((_, vertex)) => *vertex,
            None => {
                let vertex = data.vertex_at(point, at);
                self.0.push((point, vertex));
                vertex
            }
        }
    }

    fn edge(&mut self, data: &mut DataSection, side: &SurfaceSide) -> BrepEdge {
        let last = side.ids.len() - 1;
        let from = self.at(data, side.ids[0], side.points[0]);
        let to = self.at(data, side.ids[last], side.points[last]);
        let curve = data.spline_curve(&side.ids, &side.axis);
        data.edge(from, to, curve)
    }
}

/// Faces of one panel or two and their walls down to `foot_mm`; the walls' feet, counterclockwise
/// from above.
fn panels(
    data: &mut DataSection,
    net: &BSplineSurface,
    [straight, folded]: [bool; 2],
    foot_mm: f64,
    faces: &mut Vec<InstanceId>,
) -> Vec<OrientedEdge> {
    let mut corners = CornerVertices::default();
    let designed = WrittenSurface::write(data, net, |_, _| None);
    let mut walls: [Vec<(SurfaceSide, BrepEdge)>; 4] = Default::default();
    let mut written = vec![designed];
    if folded {
        let other = reflected(net);
        let ids = &written[0].ids;
        let last = net.axes[1].count() - 1;
        let on_ridge =
            |i: usize, j: usize| (net.control_row(i)[last - j].y == 0.0).then(|| ids[i][last - j]);
        let other = WrittenSurface::write(data, &other, on_ridge);
        let below = net.at(centre(net)).y > 0.0;
        written.insert(if below { 0 } else { 1 }, other);
    }
    let mut ridge: Option<BrepEdge> = None;
    let upmost = written.len() - 1;
    for (k, surface) in written.iter().enumerate() {
        let mut boundary = Vec::new();
        for (s, side) in surface.sides().into_iter().enumerate() {
            match (s, ridge) {
                (0, Some(ridge)) => boundary.push(ridge.backward()),
                _ => {
                    let edge = corners.edge(data, &side);
                    boundary.push(edge.forward());
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
        faces.push(data.face(FaceRole::Optical, &[boundary], surface.surface, true));
    }
    let walls: Vec<Vec<(SurfaceSide, BrepEdge)>> = if straight {
        walls.into()
    } else {
        walls.into_iter().flatten().map(|wall| vec![wall]).collect()
    };
    let low = |vertex: BrepVertex| vertex.at.truncate().extend(foot_mm);
    let posts: Vec<BrepEdge> = walls
        .iter()
        .map(|wall| {
            let top = wall[0].1.from;
            let foot = data.vertex(low(top));
            data.line_edge(foot, top)
        })
        .collect();
    let mut feet = Vec::new();
    for (k, wall) in walls.iter().enumerate() {
        let (start, end) = (posts[k], posts[(k + 1) % posts.len()]);
        let (foot, surface) = if straight {
            (data.line_edge(start.from, end.from), None)
        } else {
            let (foot, surface) = ruled(data, &wall[0].0, [start.from, end.from], foot_mm);
            (foot, Some(surface))
        };
        let mut boundary = vec![foot.forward(), end.forward()];
        boundary.extend(wall.iter().rev().map(|(_, edge)| edge.backward()));
        boundary.push(start.backward());
        faces.push(match surface {
            Some(surface) => data.face(FaceRole::Wall, &[boundary], surface, true),
            None => {
                let along = (end.from.at - start.from.at).normalize();
                data.plane_face(FaceRole::Wall, &[boundary], start.from.at, along.cross(DVec3::Z))
            }
        });
        feet.push(foot.forward());
    }
    feet
}

fn centre(net: &BSplineSurface) -> DVec2 {
    let [u, v] = net.axes.each_ref().map(|axis| {
        let breaks = axis.breaks();
        0.5 * (breaks[0] + breaks[breaks.len() - 1])
    });
    DVec2::new(u, v)
}

/// The vertical wall under a side that is not straight: its foot and its surface.
fn ruled(
    data: &mut DataSection,
    side: &SurfaceSide,
    ends: [BrepVertex; 2],
    foot_mm: f64,
) -> (BrepEdge, InstanceId) {
    let last = side.ids.len() - 1;
    let feet: Vec<InstanceId> = (0..=last)
        .map(|k| match k {
            0 => ends[0].point,
            _ if k == last => ends[1].point,
            _ => data.point(side.points[k].truncate().extend(foot_mm)),
        })
        .collect();
    let curve = data.spline_curve(&feet, &side.axis);
    let foot = data.edge(ends[0], ends[1], curve);
    let lines: Vec<Vec<InstanceId>> =
        feet.iter().zip(&side.ids).map(|(&a, &b)| vec![a, b]).collect();
    (foot, data.spline_surface(&lines, [Some(&side.axis), None]))
}

/// The wall of a round mirror from its rim down to `foot_mm`; the wall's foot.
fn wall(
    data: &mut DataSection,
    rim: BrepEdge,
    rim_mm: f64,
    foot_mm: f64,
    faces: &mut Vec<InstanceId>,
) -> Vec<OrientedEdge> {
    let foot = data.circle_edge(DVec3::Z * foot_mm, rim_mm);
    faces.push(data.cylinder_face(FaceRole::Wall, [foot, rim], (DVec2::ZERO, rim_mm), true));
    vec![foot.forward()]
}

/// Faces of a mirror cut out of `net`; its outer rim.
fn cut(
    data: &mut DataSection,
    net: &BSplineSurface,
    outer: &RimCurve,
    outer_mm: f64,
    inner: Option<&(f64, RimCurve)>,
    middle_mm: f64,
    faces: &mut Vec<InstanceId>,
) -> BrepEdge {
    let surface = WrittenSurface::write(data, net, |_, _| None).surface;
    let (outer, _) = rim(data, outer, outer_mm, surface);
    let mut loops = vec![vec![outer.forward()]];
    if let Some((inner_mm, inner)) = inner {
        let (edge, ids) = rim(data, inner, *inner_mm, surface);
        loops.push(vec![edge.backward()]);
        let middle = data.vertex(DVec3::Z * middle_mm);
        let lines = [vec![middle.point; ids.len()], ids];
        let land = data.spline_surface(&lines, [None, Some(&inner.angles)]);
        faces.push(data.fan_face(FaceRole::Land, middle, edge, land, true));
    }
    faces.push(data.face(FaceRole::Optical, &loops, surface, true));
    outer
}

/// The edge of a rim over a circle of `surface`'s parameters, and its control points' numbers.
fn rim(
    data: &mut DataSection,
    rim: &RimCurve,
    radius: f64,
    surface: InstanceId,
) -> (BrepEdge, Vec<InstanceId>) {
    let (start, rest) = (rim.points[0], &rim.points[1..rim.points.len() - 1]);
    let vertex = data.vertex(start);
    let mut ids = vec![vertex.point];
    ids.extend(rest.iter().map(|&p| data.point(p)));
    ids.push(vertex.point);
    let curve = data.spline_curve(&ids, &rim.angles);
    let flat = data.circle_2d(radius);
    let curve = data.surface_curve(curve, surface, flat);
    (data.edge(vertex, vertex, curve), ids)
}

/// Faces of a surface of revolution, and of the holes in the land inside it, whose lower ends go to
/// `lows`; its outer rim.
fn turned(
    data: &mut DataSection,
    radius: &KnotVector,
    points: &[DVec3],
    land: Option<&Land>,
    lows: &mut Vec<BrepEdge>,
    faces: &mut Vec<InstanceId>,
) -> BrepEdge {
    let ids: Vec<InstanceId> = points.iter().map(|&p| data.point(p)).collect();
    let last = points.len() - 1;
    let [start, end] = [0, last].map(|k| data.vertex_at(ids[k], points[k]));
    let meridian = data.spline_curve(&ids, radius);
    let seam = data.edge(start, end, meridian);
    let surface = data.surface_of_revolution(meridian);
    let mut rim = |vertex: BrepVertex| {
        let circle = data.circle(DVec3::Z * vertex.at.z, vertex.at.x);
        data.edge(vertex, vertex, circle)
    };
    let outer = rim(end);
    let mut boundary = vec![outer.forward(), seam.backward()];
    if start.at.x > 0.0 {
        let inner = rim(start);
        boundary.push(inner.backward());
        let mut loops = vec![vec![inner.forward()]];
        for hole in land.into_iter().flat_map(|land| &land.holes) {
            let [low, high] = write_hole(data, hole, start.at.z, faces);
            loops.push(vec![high.backward()]);
            lows.push(low);
        }
        faces.push(data.plane_face(FaceRole::Land, &loops, DVec3::Z * start.at.z, DVec3::Z));
    }
    boundary.push(seam.forward());
    // Its normal is that of its circles times its meridian: down.
    faces.push(data.face(FaceRole::Optical, &[boundary], surface, false));
    outer
}
