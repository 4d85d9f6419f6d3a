//! Whether the camera sees the mirror's face.

use super::facts::SAMPLES;
use crate::geom::DVec2;
use crate::mirror::Mirror;
use crate::optics::Camera;

/// A place of the mirror's chart, mm, where it turns its back to the camera; none where it faces it
/// everywhere. Under parallel rays a height over X and Y always does.
pub(super) fn back_facing_point(mirror: &Mirror, camera: &Camera) -> Option<DVec2> {
    if camera.chart.vergence == 0.0 {
        return None;
    }
    let turned = |line: Vec<(DVec2, f64)>| {
        let places: Vec<DVec2> = line.iter().map(|(q, _)| *q).collect();
        places.iter().zip(mirror.eval_many(&places)).find_map(|(&q, point)| {
            let at = mirror.position(q, &point);
            let (image, _) = camera.chart.coordinates(at);
            let ray = camera.chart.ray(image, at.z + 1.0);
            let faces = mirror.normal(q, &point).dot(ray.direction) < 0.0;
            (!faces).then_some(q)
        })
    };
    mirror.outline.samples(SAMPLES).into_iter().find_map(turned)
}
