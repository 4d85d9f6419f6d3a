//! `morion frame`: a build up to the witness, in memory, and what the sensor's pixels are
//! good for.

use super::in_memory_build::{InMemoryBuild, build_in_memory};
use super::run::{Command, Run};
use super::{Error, Stage};
use crate::design::{Design, design};
use crate::optics::{Camera, CameraModel};
use crate::parallel;
use crate::pencil::{Pencil, map_pencils, mirror_symmetric_weights};
use crate::profile::{Layout, Profile, shipped};
use crate::report::Answer;
use crate::results::{FrameReport, PixelSolidAngle, RoundMirror};
use crate::trace::{Coverage, FrameFill, MinMeanMax};
use crate::verdict::{self, pixel_classes, tolerance_px};

/// How the frame's filling is checked: designs, meshes, closes, writes in memory, reads back and traces the
/// mirror, and writes `frame.json`, `frame.csv` and `frame.png` into NAME.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FrameOptions {
    /// The least share of filled pixels; none: the one that a build is held to.
    pub min: Option<f64>,
}

impl Command for FrameOptions {
    type Report = FrameReport;

    fn check(&self, profile: &Profile) -> Result<(), Error> {
        match profile.projection {
            Some(_) => Ok(()),
            None => Err(no_projection(profile)),
        }
    }

    fn run(&self, run: &mut Run) -> Result<FrameReport, Error> {
        let profile = run.profile;
        let min = self.min.unwrap_or(profile.acceptance_limits().frame_filled.value);
        let design = run.design()?;
        let InMemoryBuild { frame, seen: (_, traced), .. } = build_in_memory(run, &design)?;
        let (Some(frame), Some(view)) = (frame, &design.view) else {
            return Err(no_projection(profile));
        };
        let camera = &design.camera;
        let classes = pixel_classes(profile, &design, &traced);
        let coverage = run.timer.always(Stage::Coverage, || {
            let width_mm = design.mirror.outline.bounds().size().x;
            let coverage = Coverage::new(&traced, &classes, camera, view, width_mm);
            let note = format!("{:.3} deg around", coverage.azimuth_deg);
            (coverage, note)
        });
        let usr = solid_angles(&design, camera.pixels);
        let reasons: Vec<String> = unfilled(profile, &frame, min).into_iter().collect();
        let report = FrameReport {
            schema: 1,
            profile: profile.into(),
            frame,
            coverage,
            resolution: resolution(usr.iter().map(|usr| (*usr, 1))),
            round_mirrors: round_mirrors(camera)?,
            min,
            verdict: verdict::of(&reasons),
            reasons,
        };
        let png = run.picture(|| report.png(&classes, &usr))?;
        run.publish(Stage::Report, |files, _| {
            files.add_bytes("frame.png", &png)?;
            files.add_bytes("frame.csv", report.csv().as_bytes())?;
            files.add_report("frame.json", &report.json())?;
            Ok(())
        })?;
        Ok(report)
    }
}

fn no_projection(profile: &Profile) -> Error {
    Error::NoProjection { work: "check the frame of", profile: profile.name.clone() }
}

/// That fewer pixels than `min` are filled.
fn unfilled(profile: &Profile, frame: &FrameFill, min: f64) -> Option<String> {
    let way = || verdict::filling(profile).map_or(String::new(), |way| format!("; {way}"));
    (!(frame.filled >= min)).then(|| {
        format!(
            "{:.3} % of the frame see their part of the world within {} px, under the {:.3} % asked for{}",
            100.0 * frame.filled,
            tolerance_px(profile),
            100.0 * min,
            way()
        )
    })
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
        let design = design(profile)
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
