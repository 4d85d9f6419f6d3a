//! The cavity of a hollow part: its drains, and its faces, which are those of a body turned round.

use super::face_role::FaceRole;
use super::fit::FittedMirror;
use super::hole::write_bore;
use super::mirror_faces::write_mirror;
use super::part21::{DataSection, InstanceId};
use super::topology::{BrepEdge, reversed};
use crate::geom::{CavityFloor, DVec3};

/// Writes the faces of the cavity below the fitted `roof`; the circles in which its drains open in the base.
pub(super) fn write_cavity(
    data: &mut DataSection,
    roof: &FittedMirror,
    floor: &CavityFloor,
    faces: &mut Vec<InstanceId>,
) -> Vec<BrepEdge> {
    let drains: Vec<[BrepEdge; 2]> = floor
        .meridians()
        .enumerate()
        .map(|(k, drain)| write_bore(data, FaceRole::Drain(k + 1), &drain, faces))
        .collect();
    data.is_cavity = true;
    let foot = write_mirror(data, roof, floor.z_mm, (&[], &mut Vec::new()), faces);
    let mut loops = vec![reversed(&foot)];
    loops.extend(drains.iter().map(|[_, high]| vec![high.forward()]));
    let at = DVec3::Z * floor.z_mm;
    faces.push(data.plane_face(FaceRole::Cavity, &loops, at, DVec3::NEG_Z));
    data.is_cavity = false;
    drains.into_iter().map(|[low, _]| low).collect()
}
