//! Rectangular panels: untrimmed spline faces, and the walls under their sides.

use super::b_spline::{BSplineSurface, KnotVector};
use super::face_role::FaceRole;
use super::part21::{DataSection, InstanceId};
use super::topology::{BrepEdge, BrepVertex, OrientedEdge};
use super::wall_foot::WallFoot;
use crate::geom::{DVec2, DVec3};

/// A B-spline surface that is written.
pub(super) struct WrittenSurface {
    net: BSplineSurface,
    /// Numbers of its control points, a line along v for each of u's.
    ids: Vec<Vec<InstanceId>>,
    /// Its own number.
    pub surface: InstanceId,
}

/// A side of a surface: control points in its direction.
pub(super) struct SurfaceSide {
    ids: Vec<InstanceId>,
    points: Vec<DVec3>,
    axis: KnotVector,
    /// Along an axis of the plane, out of the surface.
    out: DVec2,
}

impl WrittenSurface {
    /// Writes `net`; `known` are control points that are there already.
    pub(super) fn write(
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
    pub(super) fn sides(&self) -> [SurfaceSide; 4] {
        let [u, v] = &self.net.axes;
        let (last_u, last_v) = (u.count() - 1, v.count() - 1);
        let side = |out: DVec2, axis: KnotVector, places: Vec<(usize, usize)>| SurfaceSide {
            ids: places.iter().map(|&(i, j)| self.ids[i][j]).collect(),
            points: places.iter().map(|&(i, j)| self.net.control_row(i)[j]).collect(),
            axis,
            out,
        };
        [
            side(DVec2::NEG_Y, u.clone(), (0..=last_u).map(|i| (i, 0)).collect()),
            side(DVec2::X, v.clone(), (0..=last_v).map(|j| (last_u, j)).collect()),
            side(DVec2::Y, u.reversed(), (0..=last_u).rev().map(|i| (i, last_v)).collect()),
            side(DVec2::NEG_X, v.reversed(), (0..=last_v).rev().map(|j| (0, j)).collect()),
        ]
    }
}

impl SurfaceSide {
    /// Control points of the foot of the wall below it; of a `folded` mirror a side begins or ends on the ridge.
    fn feet(&self, (foot_mm, shape): (f64, WallFoot), folded: bool) -> Vec<DVec3> {
        let WallFoot::Drafted(slant) = shape else {
            return self.points.iter().map(|p| p.truncate().extend(foot_mm)).collect();
        };
        let sites = self.axis.sites();
        let [first, last] = [sites[0], sites[sites.len() - 1]];
        // At its corners the foot is moved along the side too, by as much.
        let corner = |p: &DVec3| if folded && p.y == 0.0 { 0.0 } else { 1.0 };
        let ends = [-corner(&self.points[0]), corner(&self.points[self.points.len() - 1])];
        let feet: Vec<DVec2> = sites
            .iter()
            .map(|&s| {
                let (from, basis) = self.axis.basis(s);
                let p: DVec3 = (0..4).map(|k| basis[k] * self.points[from + k]).sum();
                let along = ends[0] + (ends[1] - ends[0]) * (s - first) / (last - first);
                let way = self.out + along * self.out.perp();
                p.truncate() + slant * (p.z - foot_mm).abs() * way
            })
            .collect();
        let [x, y] = [0, 1].map(|axis: usize| {
            let values: Vec<f64> = feet.iter().map(|foot| foot[axis]).collect();
            self.axis.fit(1, &values)
        });
        x.into_iter().zip(y).map(|(x, y)| DVec3::new(x, y, foot_mm)).collect()
    }
}

/// The net reflected in Y = 0.
fn reflected(net: &BSplineSurface) -> BSplineSurface {
    let [u, v] = &net.axes;
    let flip = |p: &DVec3| DVec3::new(p.x, 0.0 - p.y, p.z);
    let points = (0..u.count()).flat_map(|i| net.control_row(i).iter().rev().map(flip)).collect();
    BSplineSurface { axes: [u.clone(), v.reversed()], points }
}

/// Vertices of panels' corners that are written.
#[derive(Default)]
pub(super) struct CornerVertices(Vec<(InstanceId, BrepVertex)>);

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

    pub(super) fn edge(&mut self, data: &mut DataSection, side: &SurfaceSide) -> BrepEdge {
        let last = side.ids.len() - 1;
        let from = self.at(data, side.ids[0], side.points[0]);
        let to = self.at(data, side.ids[last], side.points[last]);
        let curve = data.spline_curve(&side.ids, &side.axis);
        data.edge(from, to, curve)
    }
}

/// Writes the faces of one panel or two and their walls to their foot at a height, mm; the walls' feet, counterclockwise
/// from above.
pub(super) fn write_panels(
    data: &mut DataSection,
    net: &BSplineSurface,
    [straight, folded]: [bool; 2],
    foot: (f64, WallFoot),
    faces: &mut Vec<InstanceId>,
) -> Vec<OrientedEdge> {
    let sides = optical_faces(data, net, folded, faces);
    let walls: Vec<Vec<WallTop>> = if straight {
        sides.into()
    } else {
        sides.into_iter().flatten().map(|side| vec![side]).collect()
    };
    write_walls(data, &walls, [straight, folded], foot, faces)
}

/// The top of a wall: a side of a panel.
type WallTop = (SurfaceSide, BrepEdge);

/// Writes the optical face of each panel, the one of the least Y first; its outer sides, of both panels those on the
/// same side of the part together, counterclockwise.
fn optical_faces(
    data: &mut DataSection,
    net: &BSplineSurface,
    folded: bool,
    faces: &mut Vec<InstanceId>,
) -> [Vec<WallTop>; 4] {
    let mut corners = CornerVertices::default();
    let mut written = vec![WrittenSurface::write(data, net, |_, _| None)];
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
    let mut walls: [Vec<WallTop>; 4] = Default::default();
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
    walls
}

/// Writes the walls from their tops to their foot at a height, mm, planes if they are `straight`; their feet.
fn write_walls(
    data: &mut DataSection,
    walls: &[Vec<WallTop>],
    [straight, folded]: [bool; 2],
    foot: (f64, WallFoot),
    faces: &mut Vec<InstanceId>,
) -> Vec<OrientedEdge> {
    let below: Vec<Vec<DVec3>> = walls.iter().map(|wall| wall[0].0.feet(foot, folded)).collect();
    let posts: Vec<BrepEdge> = walls
        .iter()
        .zip(&below)
        .map(|(wall, below)| {
            let top = wall[0].1.from;
            let low = data.vertex(below[0]);
            match foot {
                (_, WallFoot::Below) => data.line_edge(low, top),
                (_, WallFoot::Drafted(_)) => data.slanted_edge(low, top),
            }
        })
        .collect();
    let mut feet = Vec::new();
    for (k, wall) in walls.iter().enumerate() {
        let (start, end) = (posts[k], posts[(k + 1) % posts.len()]);
        let (foot, surface) = if straight {
            (data.line_edge(start.from, end.from), None)
        } else {
            let (foot, surface) = ruled(data, &wall[0].0, [start.from, end.from], &below[k]);
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

/// The middle of the parameters.
fn centre(net: &BSplineSurface) -> DVec2 {
    let [u, v] = net.axes.each_ref().map(|axis| {
        let breaks = axis.breaks();
        0.5 * (breaks[0] + breaks[breaks.len() - 1])
    });
    DVec2::new(u, v)
}

/// The ruled wall under a side that is not straight: its foot and its surface.
fn ruled(
    data: &mut DataSection,
    side: &SurfaceSide,
    ends: [BrepVertex; 2],
    below: &[DVec3],
) -> (BrepEdge, InstanceId) {
    let last = side.ids.len() - 1;
    let feet: Vec<InstanceId> = (0..=last)
        .map(|k| match k {
            0 => ends[0].point,
            _ if k == last => ends[1].point,
            _ => data.point(below[k]),
        })
        .collect();
    let curve = data.spline_curve(&feet, &side.axis);
    let foot = data.edge(ends[0], ends[1], curve);
    let lines: Vec<Vec<InstanceId>> =
        feet.iter().zip(&side.ids).map(|(&a, &b)| vec![a, b]).collect();
    (foot, data.spline_surface(&lines, [Some(&side.axis), None]))
}
