//! The faces of a mirror and the walls down from its edge.

use super::b_spline::{BSplineSurface, KnotVector};
use super::face_role::FaceRole;
use super::fit::{FittedFaces, FittedMirror};
use super::hole::write_hole;
use super::panels::{WrittenSurface, write_panels};
use super::part21::{DataSection, InstanceId};
use super::rim_curve::RimCurve;
use super::topology::{BrepEdge, BrepVertex, OrientedEdge};
use super::wall_foot::WallFoot;
use crate::geom::{DVec2, DVec3, NumberedHole};

/// Writes the faces of a mirror and the walls down to `foot_mm`, with the holes in a land inside it, whose lower ends go to
/// `lows`; the foot of the walls, counterclockwise from above.
pub(super) fn write_mirror(
    data: &mut DataSection,
    fit: &FittedMirror,
    foot_mm: f64,
    (in_land, lows): (&[NumberedHole], &mut Vec<BrepEdge>),
    faces: &mut Vec<InstanceId>,
) -> Vec<OrientedEdge> {
    match &fit.faces {
        FittedFaces::Panel { net, straight, folded } => {
            write_panels(data, net, [*straight, *folded], (foot_mm, fit.foot), faces)
        }
        FittedFaces::Panels(panels) => panels.write(data, foot_mm, faces),
        FittedFaces::Trimmed { net, outer: (outer_mm, outer), inner, middle_mm } => {
            let outer = cut(data, net, outer, *outer_mm, inner.as_ref(), *middle_mm, faces);
            wall(data, outer, *outer_mm, (foot_mm, WallFoot::Below), faces)
        }
        FittedFaces::Revolved { radius, points } => {
            let outer = turned(data, radius, points, in_land, lows, faces);
            wall(data, outer, points[points.len() - 1].x, (foot_mm, fit.foot), faces)
        }
    }
}

/// The wall of a round mirror from its rim to its foot at `foot_mm`, below it or, of a mould, above it; the foot.
fn wall(
    data: &mut DataSection,
    rim: BrepEdge,
    rim_mm: f64,
    (foot_mm, foot): (f64, WallFoot),
    faces: &mut Vec<InstanceId>,
) -> Vec<OrientedEdge> {
    if let WallFoot::Drafted(slant) = foot {
        let rim_at = DVec2::new(rim_mm, rim.from.at.z);
        let radius_mm = rim_mm + slant * (rim_at.y - foot_mm).abs();
        let foot_at = DVec2::new(radius_mm, foot_mm);
        let foot = data.circle_edge(DVec3::Z * foot_mm, radius_mm);
        let is_sunk = rim_at.y < foot_mm;
        let ends = if is_sunk { [rim_at, foot_at] } else { [foot_at, rim_at] };
        let edges = if is_sunk { [rim, foot] } else { [foot, rim] };
        let cone = data.cylinder_or_cone(DVec2::ZERO, ends);
        faces.push(data.turned_face(FaceRole::Wall, edges, cone, !is_sunk));
        return vec![foot.forward()];
    }
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
    in_land: &[NumberedHole],
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
        for hole in in_land {
            let [low, high] = write_hole(data, hole, faces);
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
