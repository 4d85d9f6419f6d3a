//! Obstacles that no mirror can do with: in the camera, in the mirror, or in the way of every pixel.

use super::SourceError;
use crate::design::Design;
use crate::geom::{DVec2, DVec3, Ray};
use crate::optics::CameraModel;
use crate::parallel;
use crate::profile::{Complaint, Complaints};
use crate::render::reflected;
use crate::trace::Obstacles;

/// Most columns of the frame whose rays are looked at: a leg of a mounting is wider, and there is no time to lose.
const MOST_COLUMNS: u32 = 200;

/// Refuses obstacles that no mirror can do with.
///
/// # Errors
/// [`SourceError::Faulty`], with the obstacle's place in the profile: where the camera's entrance pupil or a point of
/// the mirror that a pixel sees is inside it, or where every pixel is hidden.
pub(super) fn check(design: &Design) -> Result<(), SourceError> {
    let Some(obstacles) = Obstacles::new(&design.obstacles, design.view.as_ref()) else {
        return Ok(());
    };
    let pupil = design.camera.chart.pupil();
    // (The camera's body, the last one, has it on its front face.)
    let is_given = |number: &u32| (*number as usize) < design.profile.obstacles.len();
    if let Some(number) = pupil.and_then(|pupil| obstacles.containing(pupil)).filter(is_given) {
        let found = "the entrance pupil inside it";
        return Err(refused(design, number, "must leave the camera free", found, PUPIL));
    }
    let seen = seen(design, &obstacles);
    if let Some((number, at)) = seen.iter().find_map(|pixel| Some((pixel.inside?, pixel.at))) {
        let at = at - DVec3::Z * design.mounting.mean_mm;
        let found =
            format!("the mirror's point ({:.3}, {:.3}, {:.3}) mm inside it", at.x, at.y, at.z);
        return Err(refused(design, number, "must stand beside the mirror", &found, MIRROR));
    }
    let hidden: Vec<u32> = seen.iter().filter_map(|pixel| pixel.hidden).collect();
    if !seen.is_empty() && hidden.len() == seen.len() {
        let count = |number: u32| hidden.iter().filter(|other| **other == number).count();
        let most =
            (0..design.obstacles.len() as u32).max_by_key(|number| (count(*number), !number));
        let found = "none that sees past it";
        return Err(refused(design, most.unwrap_or(0), "must leave a pixel free", found, HIDDEN));
    }
    Ok(())
}

const PUPIL: &str = "places are millimetres from the middle of the mirror; `morion check` tells where the entrance \
                     pupil is";
const MIRROR: &str = "places are millimetres from the middle of the mirror, Z towards the camera";
const HIDDEN: &str = "every pixel is behind obstacles; move or shrink them";

/// A pixel that sees the mirror.
struct SeenPixel {
    /// Where it sees the mirror, mm.
    at: DVec3,
    /// The obstacle in which that is.
    inside: Option<u32>,
    /// The obstacle that hides it.
    hidden: Option<u32>,
}

/// The pixels that see the designed mirror, of a frame that is thinned.
fn seen(design: &Design, obstacles: &Obstacles) -> Vec<SeenPixel> {
    let [width, height] = design.camera.pixels;
    let columns = width.min(MOST_COLUMNS);
    let count =
        (u64::from(height) * u64::from(columns) / u64::from(width)).clamp(1, 1 << 15) as u32;
    let camera = design.camera;
    let top_mm = obstacles.above_mm().max(2.0 * design.mounting.size_mm[2]);
    let place =
        |k: u32, count: u32, size: u32| (f64::from(k) + 0.5) * f64::from(size) / f64::from(count);
    parallel::gather(count as usize, 1, |rows| {
        rows.flat_map(|row| {
            let y = place(row as u32, count, height);
            let points: Vec<DVec2> =
                (0..columns).map(|k| camera.image_point(place(k, columns, width), y)).collect();
            let pixel = |(point, leaving): (&DVec2, Option<Ray>)| {
                let leaving = leaving?;
                let ray = camera.ray(*point, top_mm);
                let hidden = obstacles.on_the_way(&ray, Some(&leaving));
                let inside = hidden.and_then(|_| obstacles.containing(leaving.origin));
                Some(SeenPixel { at: leaving.origin, inside, hidden })
            };
            let reflected = reflected(design, &points);
            points.iter().zip(reflected).filter_map(pixel).collect::<Vec<_>>()
        })
        .collect()
    })
}

fn refused(design: &Design, number: u32, must: &str, found: &str, hint: &str) -> SourceError {
    let profile = &design.profile;
    let name = &design.obstacles[number as usize].name;
    let ((line, column), what) = match (profile.obstacles.get(number as usize), profile.camera_body)
    {
        (Some(spec), _) => (spec.place, format!("obstacle \"{name}\"")),
        (None, Some(body)) => (body.place, format!("{}.body_mm", camera_table(&profile.camera))),
        (None, None) => ((1, 1), name.clone()),
    };
    SourceError::Faulty(Complaints(vec![Complaint {
        file: profile.named.clone(),
        line,
        column,
        message: format!("{what} {must}, found {found}"),
        hint: Some(hint.to_owned()),
    }]))
}

fn camera_table(camera: &CameraModel) -> &'static str {
    match camera {
        CameraModel::Orthographic { .. } => "camera.orthographic",
        CameraModel::Pinhole { .. } => "camera.pinhole",
        CameraModel::Calibrated { .. } => "camera.calibrated",
    }
}
