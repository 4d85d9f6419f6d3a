//! What one sees of a profile: picture, maps, figures, pixels and the part; of the smooth mirror what follows a
//! slider, and with the part's shadows what comes after it.

use super::failure::RequestFailure;
use super::work_queue::NewestRequest;
use crate::design::Design;
use crate::geom::DVec3;
use crate::num::stats::Summary;
use crate::num::{asin, atan2, degrees};
use crate::optics::ThinnedFrame;
use crate::parallel;
use crate::pipeline::{
    Command, Observer, RenderOptions, SourceError, coarse_part, designed, drawn_spots, glb,
    mesh_label, shadowed, sharpness_map, still,
};
use crate::profile::{Profile, ShapeSpec};
use crate::raster::palette::hexadecimal;
use crate::raster::{FalseColourMap, Srgb, key_text};
use crate::render::{
    CameraPicture, CameraView, Distance, SmoothSight, TestWorld, pixel_errors, pixel_errors_of,
    reflected,
};
use crate::report::{AnswerRows, MapLetter, PlainSharpness, map_letters, pixel_error_map};
use crate::results::{SharpnessFacts, error_px};
use crate::verdict::sharpness::{SampledSpots, reason, sharpness};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::{Value as Json, json};

/// Most columns of a picture that follows a slider.
const PREVIEW_COLUMNS: u32 = 320;

/// How fine is what follows a slider.
struct Detail {
    /// Samples along each side of a pixel at edges of the picture.
    samples: u32,
    /// Pixels along the longer side of the frame whose spots are looked at.
    spots: u32,
    /// Pixels of the picture along each side to a ray that looks for shadows.
    shadow_px: u32,
}

impl Detail {
    /// Of the designed mirror.
    const DESIGN: Self = Self { samples: 2, spots: 64, shadow_px: 1 };
    /// Of a sketch of it: halves and quarters of that.
    const SKETCH: Self = Self { samples: 1, spots: 32, shadow_px: 2 };
}

/// The profile of a text that reads no file.
///
/// # Errors
/// [`RequestFailure`] with every complaint, and for a profile that names a file.
pub(super) fn checked(name: &str, text: &str) -> Result<Profile, RequestFailure> {
    let parsed = Profile::parse(name, &format!("{name}.toml"), text.as_bytes());
    let profile = parsed.map_err(SourceError::Faulty)?;
    match named_file(&profile) {
        Some(key) => Err(RequestFailure::of_text(files_refused(key))),
        None => Ok(profile),
    }
}

/// The key of a file that `profile` names.
pub(super) fn named_file(profile: &Profile) -> Option<&'static str> {
    match &profile.shape {
        ShapeSpec::Grid { .. } => Some("mirror.grid.file"),
        _ if profile.camera_file.is_some() => Some("camera.calibrated.file"),
        _ if profile.obstacles.iter().any(|spec| spec.file.is_some()) => Some("obstacle.stl.file"),
        _ => profile.tolerance.map_file.as_ref().map(|_| "tolerance.map_file"),
    }
}

/// That the studio takes no profile with this key.
pub(super) fn files_refused(key: &str) -> String {
    format!(
        "{key} names a file, and the studio reads no files; use the other commands for this profile"
    )
}

/// The small picture and the maps that follow a slider, and what is judged by them.
pub(super) fn preview(design: &Design, is_sketch: bool) -> Result<Json, RequestFailure> {
    let detail = if is_sketch { Detail::SKETCH } else { Detail::DESIGN };
    let sight = SmoothSight::new(design);
    let centres = sight.centres(design.camera.at_most(PREVIEW_COLUMNS));
    let pixels = centres.camera.pixels;
    let picture = || {
        let view = CameraView::Smooth(&sight);
        CameraPicture::new(design, view, Distance::Target, detail.samples)
            .of_centres(&centres)
            .picture(&TestWorld::new())
            .to_png()
    };
    let (png, mut seen) = parallel::join(picture, || {
        let spots = SampledSpots::in_squares(design, detail.spots);
        let sharp = spots.sharpness(&design.profile, design);
        let sizes = sharp.as_ref().and_then(|facts| spots.sizes(design, facts));
        let spots = sizes.as_ref().map(drawn_spots);
        let mut errors = pixel_errors_of(design, &centres);
        leave_out_shadows(design, (&mut errors, pixels), detail.shadow_px);
        Seen { pixels, errors, summary: None, spots, sharp }.told(design)
    });
    seen["picture"] = BASE64_STANDARD.encode(png?).into();
    seen["pixels"] = json!(pixels);
    Ok(seen)
}

/// The maps in their full size, and what is judged by the figures of the whole mirror.
pub(super) fn estimate(profile: &Profile) -> Result<Json, RequestFailure> {
    let design = designed(profile)?;
    let frame = ThinnedFrame::new(design.camera.pixels);
    let sharp = sharpness(profile, &design);
    let spots = sharpness_map(&design, sharp.as_ref());
    let (pixels, mut errors) = (frame.pixels(), pixel_errors(&design, frame));
    leave_out_shadows(&design, (&mut errors, pixels), 1);
    let summary = design.facts.pixel_error_px;
    Ok(Seen { pixels, errors, summary, spots, sharp }.told(&design))
}

/// Leaves out the errors of pixels to which the part or an obstacle hides what they see, by one ray to `each` pixels along each side.
fn leave_out_shadows(design: &Design, (errors, pixels): (&mut [Option<f64>], [u32; 2]), each: u32) {
    if design.view.is_none() {
        return;
    }
    let coarse = pixels.map(|n| n.div_ceil(each));
    let Some(shadowed) = shadowed(design, coarse) else { return };
    let [each, columns, width] = [each, pixels[0], coarse[0]].map(|n| n as usize);
    for (k, error) in errors.iter_mut().enumerate() {
        let (row, column) = (k / columns / each, k % columns / each);
        if shadowed[row * width + column] {
            *error = None;
        }
    }
}

/// Ends work once a change of the profile comes: a picture follows that first.
impl Observer for NewestRequest {
    fn is_stopped(&self) -> bool {
        self.is_superseded()
    }
}

/// The picture as `morion render --scene grid` writes it, of the mesh with its shadows, PNG, as long as the profile is `wanted`.
pub(super) fn picture(
    profile: &Profile,
    wanted: &NewestRequest,
) -> Result<Vec<u8>, RequestFailure> {
    let options = RenderOptions { scene: "grid", ..RenderOptions::default() };
    let made = options.in_memory(profile, wanted);
    if wanted.is_superseded() {
        return Err(RequestFailure::superseded());
    }
    let (_, files) = made?;
    let file = files.into_iter().next();
    Ok(file.ok_or_else(|| RequestFailure::said(500, "there is no picture"))?.bytes)
}

/// The part from a coarse mesh of its own, GLB, and its size.
pub(super) fn part(design: &Design) -> Result<Json, RequestFailure> {
    let part = coarse_part(design).and_then(|part| glb(&part, &mesh_label(design, None)));
    let glb = part.ok_or_else(no_mesh)?;
    Ok(json!({ "glb": BASE64_STANDARD.encode(glb), "size": design.mounting.size() }))
}

/// The still picture of the part, for browsers that cannot turn it and for paper.
pub(super) fn part_still(design: &Design) -> Result<Vec<u8>, RequestFailure> {
    coarse_part(design).and_then(|part| still(&part)).ok_or_else(no_mesh)
}

fn no_mesh() -> RequestFailure {
    RequestFailure::of_text("the part has no mesh to show")
}

/// What is seen of a design.
struct Seen {
    /// Columns and rows of the map of errors.
    pixels: [u32; 2],
    /// Its errors, px; none where nothing is seen.
    errors: Vec<Option<f64>>,
    /// What the errors come to over the whole mirror; without it the map's are taken.
    summary: Option<Summary>,
    /// The map of spots.
    spots: Option<FalseColourMap>,
    /// How sharp the picture is.
    sharp: Option<SharpnessFacts>,
}

impl Seen {
    /// Maps and judgement as data of the page.
    fn told(&self, design: &Design) -> Json {
        let Self { pixels, errors, summary, spots, sharp } = self;
        let has_target = design.view.is_some();
        json!({
            "frame": design.camera.pixels,
            "errors": has_target.then(|| map(&pixel_error_map(*pixels, errors))),
            "spots": spots.as_ref().map(map),
            "judged": judged(design, errors, *summary, sharp.as_ref()),
        })
    }
}

/// A map as data of the page.
fn map(map: &FalseColourMap) -> Json {
    let key = |(k, (srgb, text)): (usize, &(Srgb, String))| {
        let (colour, text) = (hexadecimal(*srgb), key_text(k, text));
        json!({ "colour": colour, "text": text })
    };
    let keys: Vec<Json> = map.keys.iter().enumerate().map(key).collect();
    let letter = |MapLetter { letter, at_percent, ink }: MapLetter| {
        let colour = hexadecimal(ink);
        json!({ "letter": letter, "at_percent": at_percent, "colour": colour })
    };
    let letters: Vec<Json> = map_letters(map).into_iter().map(letter).collect();
    json!({
        "png": map.bare_png().ok().map(|png| BASE64_STANDARD.encode(png)),
        "title": map.title,
        "ticks": map.ticks,
        "stops": map.scale_colours().map(hexadecimal),
        "keys": keys,
        "letters": letters,
    })
}

/// What is to be said of the smooth mirror, and whether it is within the limits; null without a projection.
fn judged(
    design: &Design,
    errors: &[Option<f64>],
    known: Option<Summary>,
    sharp: Option<&SharpnessFacts>,
) -> Json {
    let seen: Vec<f64> = errors.iter().flatten().copied().collect();
    let summary = known.or_else(|| Summary::weighted(seen.iter().map(|px| (*px, 1.0)).collect()));
    let limits = design.profile.acceptance_limits();
    let [rms, max, least] =
        [limits.pixel_error_rms_px, limits.pixel_error_max_px, limits.frame_filled]
            .map(|limit| limit.value);
    let filled = seen.iter().filter(|px| **px <= max).count() as f64 / errors.len().max(1) as f64;
    let lost = errors.len() - seen.len();
    let mut facts = AnswerRows::default();
    let mut reasons = Vec::new();
    let has_target = design.view.is_some();
    if has_target {
        let found = summary.map_or("no pixel shows the target".into(), |found| {
            let [rms, max] = [found.rms, found.max].map(error_px);
            format!("off by {rms} px RMS, {max} px at most")
        });
        facts.add("picture", format!("{found}; allowed {rms} and {max}"));
        let share = 1e2 * lost as f64 / errors.len().max(1) as f64;
        let percent = 1e2 * filled;
        facts.add(
            "frame",
            format!(
                "{percent:.2} % of the pixels are filled, asked {:.2} %; {share:.2} % see no mirror, or \
                 the part itself",
                1e2 * least
            ),
        );
        if !summary.is_some_and(|found| found.rms <= rms) {
            reasons.push("the RMS pixel error is over its limit".to_owned());
        }
        if !summary.is_some_and(|found| found.max <= max) {
            reasons.push("the largest pixel error is over its limit".to_owned());
        }
        if !(filled >= least) {
            reasons.push("too few pixels are filled".to_owned());
        }
        reasons.extend(reason(&design.profile, sharp).map(|reason| reason.to_string()));
    }
    let sharp = sharp.map(PlainSharpness);
    facts.append(AnswerRows::of(&[&design.mounting, &sharp]));
    let facts: Vec<_> = facts.plain().collect();
    json!({
        "verdict": has_target.then_some(if reasons.is_empty() { "pass" } else { "fail" }),
        "reasons": reasons,
        "facts": facts,
        "pixels_lost": has_target.then_some(lost),
    })
}

/// The camera ray of a pixel's centre, where it meets the smooth mirror, and what it sees there.
///
/// # Errors
/// [`RequestFailure`] where there is no such pixel, or no mirror.
pub(super) fn pixel(design: &Design, [x, y]: [u32; 2]) -> Result<Json, RequestFailure> {
    let camera = &design.camera;
    let [columns, rows] = camera.pixels;
    if x >= columns || y >= rows {
        let sentence = format!("the frame has the pixels 0, 0 to {}, {}", columns - 1, rows - 1);
        return Err(RequestFailure::of_text(sentence));
    }
    let image = camera.image_point(f64::from(x) + 0.5, f64::from(y) + 0.5);
    let [.., top_mm] = design.mounting.size_mm;
    let arriving = camera.ray(image, top_mm);
    let ray = json!({ "from_mm": arriving.origin.to_array(), "direction": arriving.direction.to_array() });
    let Some(leaving) = reflected(design, &[image])[0] else {
        return Ok(json!({ "x": x, "y": y, "ray": ray, "hit_mm": null }));
    };
    let view = design.view.as_ref();
    let (at, direction) = (leaving.origin, leaving.direction);
    let shown = view.map_or(direction, |view| view.direction_from_origin(at, direction));
    let [azimuth_deg, elevation_deg] = angles(shown);
    let error = view.map(|view| (view.image_of(at, direction, image) - image).length());
    let error_px = error.map(|mm| mm / camera.pixel_mm).filter(|px| px.is_finite());
    Ok(json!({
        "x": x, "y": y, "ray": ray,
        "hit_mm": at.to_array(),
        "direction": direction.to_array(),
        "azimuth_deg": azimuth_deg,
        "elevation_deg": elevation_deg,
        "error_px": error_px,
    }))
}

/// Azimuth from +Y to +X and elevation towards +Z, degrees.
fn angles(direction: DVec3) -> [f64; 2] {
    let elevation = asin(direction.z.clamp(-1.0, 1.0));
    [atan2(direction.x, direction.y), elevation].map(degrees)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::shipped;
    use crate::studio::work_queue::{Subject, WorkQueue};
    use std::sync::Arc;

    #[test]
    fn a_picture_that_is_no_longer_wanted_is_not_made() {
        let known = shipped().iter().find(|shipped| shipped.name == "parabolic").unwrap();
        let profile = checked(known.name, known.text).unwrap();
        let subject = Arc::<Subject>::default();
        let wanted = subject.newest();
        assert!(picture(&profile, &wanted).is_ok());
        let (queue, jobs) = WorkQueue::new();
        drop(jobs);
        assert!(queue.newest(&subject, || ()).is_none());
        assert!(picture(&profile, &wanted).unwrap_err().is_superseded());
        assert!(!subject.newest().is_superseded());
    }
}
