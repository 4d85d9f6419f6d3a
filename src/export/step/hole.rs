//! Holes: cylinders, cones and plane rings about an axis along Z.

use super::face_role::FaceRole;
use super::part21::{DataSection, InstanceId};
use super::topology::BrepEdge;
use crate::geom::{DVec2, DVec3, HoleMeridian, NumberedHole};

/// Writes the faces of a hole; the circle in which it opens in the base, and the highest one.
pub(super) fn write_hole(
    data: &mut DataSection,
    hole: &NumberedHole,
    faces: &mut Vec<InstanceId>,
) -> [BrepEdge; 2] {
    write_bore(data, FaceRole::Hole(*hole), &hole.meridian, faces)
}

/// The same of a hole's surface alone.
pub(super) fn write_bore(
    data: &mut DataSection,
    role: FaceRole,
    hole: &HoleMeridian,
    faces: &mut Vec<InstanceId>,
) -> [BrepEdge; 2] {
    let mouth = data.circle_edge(hole.axis.extend(0.0), hole.mouth_radius());
    let mut last = mouth;
    for [low, high] in hole.pieces() {
        let middle = hole.axis.extend(high.y);
        if high.x == 0.0 {
            faces.push(ground(data, role, (hole.axis, last), [low, high]));
            continue;
        }
        let edge = data.circle_edge(middle, high.x);
        faces.push(if low.y == high.y {
            let rings = [vec![last.backward()], vec![edge.forward()]];
            data.plane_face(role, &rings, middle, DVec3::NEG_Z)
        } else {
            let surface = data.cylinder_or_cone(hole.axis, [low, high]);
            data.turned_face(role, [last, edge], surface, false)
        });
        last = edge;
    }
    [mouth, last]
}

/// Writes the ground of a blind hole above a circle: a cone or a plane.
fn ground(
    data: &mut DataSection,
    role: FaceRole,
    (axis, rim): (DVec2, BrepEdge),
    [low, high]: [DVec2; 2],
) -> InstanceId {
    let tip = axis.extend(high.y);
    if low.y == high.y {
        return data.plane_face(role, &[vec![rim.backward()]], tip, DVec3::NEG_Z);
    }
    let cone = data.cylinder_or_cone(axis, [low, high]);
    let seam = data.vertex(tip);
    let seam = data.slanted_edge(seam, rim.from);
    data.face(role, &[vec![rim.backward(), seam.backward(), seam.forward()]], cone, false)
}
