//! The body as a boundary representation: the mirror's faces, the walls under them and the base, closed.

use super::FittedBody;
use super::border::write_border;
use super::cavity::write_cavity;
use super::face_role::FaceRole;
use super::hole::write_hole;
use super::mirror_faces::write_mirror;
use super::part21::{DataSection, InstanceId, list};
use super::topology::reversed;
use crate::geom::{DVec3, NumberedHole, PartFeatures};

/// Writes the body with its features, of which a cavity's floor goes with its `roof`; its number.
pub(super) fn write_body(
    data: &mut DataSection,
    FittedBody { mirror: fit, roof }: FittedBody,
    features: PartFeatures,
) -> InstanceId {
    let (mut faces, mut lows) = (Vec::new(), Vec::new());
    let holes: Vec<NumberedHole> = features.holes().collect();
    let land = features.border.and_then(|border| border.land.as_ref());
    let (in_land, holes) = holes.split_at(land.map_or(0, |land| land.holes.len()));
    let foot = write_mirror(data, fit, features.foot_mm(), (in_land, &mut lows), &mut faces);
    if let (Some(roof), Some(floor)) = (roof, features.floor) {
        lows.extend(write_cavity(data, roof, floor, &mut faces));
    }
    match features.border {
        Some(border) => {
            write_border(data, border, &foot, (&lows, holes), &mut faces);
        }
        None => {
            let mut base = vec![reversed(&foot)];
            base.extend(lows.iter().map(|low| vec![low.forward()]));
            for hole in holes {
                let [low, _] = write_hole(data, hole, &mut faces);
                base.push(vec![low.forward()]);
            }
            faces.push(data.plane_face(FaceRole::Base, &base, DVec3::ZERO, DVec3::NEG_Z));
        }
    }
    let shell = list(&faces);
    let shell = data.add(format_args!("CLOSED_SHELL('',{shell})"));
    data.add(format_args!("MANIFOLD_SOLID_BREP('mirror',{shell})"))
}
