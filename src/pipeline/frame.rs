//! The frame-fill check: a build up to the witness, in memory, and what the sensor's pixels are
//! good for.

use super::check_file::{pixel_classes, tolerance_px};
use super::files::Folder;
use super::in_memory_build::{InMemoryBuild, build_in_memory};
use super::observer::StageTimer;
use super::{Error, Observer, Source, Stage, designed, remedy, verdict};
use crate::design::{Design, design};
use crate::optics::{Camera, CameraModel};
use crate::parallel;
use crate::pencil::{Pencil, map_pencils, mirror_symmetric_weights};
use crate::profile::{Layout, Profile, shipped};
use crate::report::{Answer, FrameReport, PixelSolidAngle, ProfileId, RoundMirror};
use crate::trace::{Coverage, MinMeanMax};
use std::path::Path;

/// Checks how the profile of `source` fills its frame: designs, meshes, closes, writes in memory, reads
/// back and traces it, and writes `frame.json`, `frame.csv` and `frame.png` into `out`/NAME. The
/// verdict is negative below a share of `min` filled pixels; without it, below the one that a build is held
/// to.
///
/// # Errors
/// [`enum@Error`] when a stage cannot be done, or the profile has no projection to fill a frame with.
pub fn frame(
    source: &Source,
    out: &Path,
    min: Option<f64>,
    observer: &dyn Observer,
) -> Result<FrameReport, Error> {
    let profile = &source.profile;
    if profile.projection.is_none() {
        return Err(Error::NoProjection {
            work: "check the frame of",
            profile: profile.name.clone(),
        });
    }
    let min = min.unwrap_or(profile.acceptance_limits().frame_filled.value);
    let clock = StageTimer::new(observer);
    let design = clock.stage(Stage::Design, || designed(source))?;
    let InMemoryBuild { frame: found, seen: (_, witness), .. } =
        build_in_memory(&clock, profile, &design)?;
    let (Some(found), Some(view)) = (found, &design.view) else {
        unreachable!("a projection was asked for");
    };

    let camera = &design.camera;
    let classes = pixel_classes(profile, &design, &witness);
    let tolerance = tolerance_px(profile);
    let coverage = clock.always(Stage::Coverage, || {
        let coverage = Coverage::new(
            &witness,
            &classes,
            camera,
            view,
            design.mirror.outline.bounds().size().x,
        );
        let note = format!("{:.3} deg around", coverage.azimuth_deg);
        (coverage, note)
    });
    let usr = solid_angles(&design, camera.pixels);
    let mut reasons = Vec::new();
    if !(found.filled >= min) {
        reasons.push(format!(
            "{:.3} % of the frame see their part of the world within {tolerance} px, under the \
             {:.3} % asked for{}",
            100.0 * found.filled,
            100.0 * min,
            remedy::filling(profile).map_or(String::new(), |way| format!("; {way}"))
        ));
    }
    let report = FrameReport {
        schema: 1,
        profile: ProfileId { name: profile.name.clone(), sha256: profile.sha256.clone() },
        frame: found,
        coverage,
        resolution: resolution(usr.iter().map(|usr| (*usr, 1))),
        round_mirrors: round_mirrors(camera)?,
        min,
        verdict: verdict::of(&reasons),
        reasons,
    };
    let png = clock.stage(Stage::Picture, || {
        let png = report.png(&classes, &usr).map_err(|e| Error::Picture(e.to_string()))?;
        let note = format!("{} kB", png.len() / 1000);
        Ok::<_, Error>((png, note))
    })?;
    let folder = Folder::create(&out.join(&profile.name))?;
    clock.stage(Stage::Report, || {
        let text =
            |name: &str, text: &str| folder.stage(name, |out| out.write_all(text.as_bytes()));
        let files = vec![
            folder.stage("frame.png", |out| out.write_all(&png))?,
            text("frame.csv", &report.csv())?,
            text("frame.json", &report.json())?,
        ];
        folder.replace(files, &[])?;
        Ok::<_, Error>(((), folder.path().display().to_string()))
    })?;
    Ok(report)
}

/// Solid angle of every pixel in the first of `columns` and `rows` of the sensor, usr.
fn solid_angles(design: &Design, [columns, rows]: [u32; 2]) -> Vec<Option<f64>> {
    let Design { mirror, camera, view, .. } = design;
    let usr = 1e6 * camera.pixel_mm * camera.pixel_mm;
    let each = |pencil: &Pencil| pencil.solid_angle() * usr;
    map_pencils(mirror, camera, view.as_ref(), [0..columns, 0..rows], each)
}

/// Figures of pixels, each with the number that it stands for.
fn resolution(pixels: impl Iterator<Item = (Option<f64>, u64)>) -> PixelSolidAngle {
    let (mut count, mut sum) = (0, 0.0);
    let (mut min, mut max) = (f64::INFINITY, f64::NEG_INFINITY);
    for (usr, weight) in pixels.filter_map(|(usr, weight)| Some((usr?, weight))) {
        count += weight;
        sum += usr * weight as f64;
        (min, max) = (min.min(usr), max.max(usr));
    }
    let any = count > 0;
    PixelSolidAngle {
        pixels: count,
        pixel_usr: any.then_some(MinMeanMax { min, mean: sum / count as f64, max }),
        ratio: any.then_some(max / min),
        total_sr: sum * 1e-6,
    }
}

/// The shipped round mirrors on a sensor of as many pixels, inscribed in it.
fn round_mirrors(camera: &Camera) -> Result<Vec<RoundMirror>, Error> {
    let side = camera.pixels[0].min(camera.pixels[1]);
    let rounds: Vec<Profile> = shipped()
        .iter()
        .map(|shipped| {
            Profile::parse(shipped.name, shipped.name, shipped.text.as_bytes())
                .expect("shipped profiles are valid")
        })
        .filter(|profile| matches!(profile.layout, Layout::Disc | Layout::Annulus { .. }))
        // Those that are inscribed in their own sensor.
        .filter(|profile| profile.camera.pixels()[0] == profile.camera.pixels()[1])
        .map(|profile| Profile { camera: inscribed(&profile.camera, side), ..profile })
        .collect();
    let row = |profile: &Profile| {
        let design = design(profile, None)
            .map_err(|source| Error::Design { profile: profile.name.clone(), source })?;
        // A quarter stands for all of it.
        let half = side.div_ceil(2);
        let usr = solid_angles(&design, [half; 2]);
        let both = mirror_symmetric_weights(side)
            .flat_map(|y| mirror_symmetric_weights(side).map(move |x| u64::from(x * y)));
        let resolution = resolution(usr.into_iter().zip(both));
        Ok(RoundMirror { profile: profile.name.clone(), resolution })
    };
    parallel::map_slice(&rounds, 1, row).into_iter().collect()
}

/// The camera of a mirror that fills its square sensor, with a sensor of `side` pixels.
fn inscribed(camera: &CameraModel, side: u32) -> CameraModel {
    let pixels = [side; 2];
    match *camera {
        CameraModel::Orthographic { .. } => CameraModel::Orthographic { pixels },
        CameraModel::Pinhole { pixels: [width, _], focal_px, distance_mm } => {
            let focal_px = focal_px * f64::from(side) / f64::from(width);
            CameraModel::Pinhole { pixels, focal_px, distance_mm }
        }
    }
}
