//! Obstacles in the part's frame: those of the profile, and the camera's body.

use super::Mounting;
use crate::geom::{Cuboid, DVec3, Obstacle, ObstacleShape};
use crate::optics::Camera;
use crate::profile::Profile;

/// Name of the camera's body among the obstacles.
const BODY: &str = "camera body";

/// The obstacles of a profile, in its order, and last the camera's body; mm of the part's frame.
pub(super) fn placed(profile: &Profile, camera: &Camera, mounting: &Mounting) -> Vec<Obstacle> {
    let middle = DVec3::Z * mounting.mean_mm;
    let given = profile.obstacles.iter().map(|spec| spec.obstacle.shifted(middle));
    given.chain(body(profile, camera)).collect()
}

/// The camera's body: a box behind its entrance pupil, whose front face goes through that.
fn body(profile: &Profile, camera: &Camera) -> Option<Obstacle> {
    let size = DVec3::from_array(profile.camera_body?.size_mm);
    let pupil = camera.chart.pupil()?;
    let ([right, up], back) = (camera.picture.axes(), camera.axis());
    let centre_mm = pupil + back * (0.5 * size.z);
    let shape = Cuboid { centre_mm, half_mm: 0.5 * size, axes: [right, up, back] };
    Some(Obstacle { name: BODY.to_owned(), shape: ObstacleShape::Cuboid(shape) })
}
