//! Holes: cylinders, cones and plane rings about an axis along Z.

use super::face_role::FaceRole;
use super::part21::{DataSection, InstanceId, real};
use super::topology::BrepEdge;
use crate::geom::{DVec2, DVec3, NumberedHole};
use crate::num::atan2;

/// Writes the faces of a hole; the circle in which it opens in the base, and the highest one.
pub(super) fn write_hole(
    data: &mut DataSection,
    hole: &NumberedHole,
    faces: &mut Vec<InstanceId>,
) -> [BrepEdge; 2] {
    let (role, hole) = (FaceRole::Hole(*hole), &hole.meridian);
    let mouth = data.circle_edge(hole.axis.extend(0.0), hole.mouth_radius());
    let mut last = mouth;
    for [low, high] in hole.pieces() {
        let middle = hole.axis.extend(high.y);
        if high.x == 0.0 {
            faces.push(ground(data, role, (hole.axis, last), [low, high]));
            continue;
        }
        let edge = data.circle_edge(middle, high.x);
        faces.push(if low.x == high.x {
            data.cylinder_face(role, [last, edge], (hole.axis, low.x), false)
        } else if low.y == high.y {
            let rings = [vec![last.backward()], vec![edge.forward()]];
            data.plane_face(role, &rings, middle, DVec3::NEG_Z)
        } else {
            let cone = cone(data, hole.axis, [low, high]);
            data.turned_face(role, [last, edge], cone, false)
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
    let cone = cone(data, axis, [low, high]);
    let seam = data.vertex(tip);
    let seam = data.slanted_edge(seam, rim.from);
    data.face(role, &[vec![rim.backward(), seam.backward(), seam.forward()]], cone, false)
}

/// The cone about an upright axis between two circles, or a circle and a point, of such radius and Z.
pub(super) fn cone(data: &mut DataSection, axis: DVec2, [low, high]: [DVec2; 2]) -> InstanceId {
    // Its radius grows along the placement's Z.
    let wider = if high.x > low.x { DVec3::Z } else { DVec3::NEG_Z };
    let place = data.placement(axis.extend(low.y), wider, DVec3::X);
    let half_angle = atan2((high.x - low.x).abs(), high.y - low.y);
    data.add(format_args!("CONICAL_SURFACE('',{place},{},{half_angle})", real(low.x)))
}
