//! `morion frame`: a build up to the witness, in memory, and what the sensor's pixels are
//! good for.

use super::in_memory_build::{InMemoryBuild, build_in_memory};
use super::run::{Command, Run};
use super::{Error, Stage};
use crate::design::{Design, design};
use crate::optics::{Camera, CameraModel, ThinnedFrame};
use crate::parallel;
use crate::pencil::{Pencil, map_pencils, mirror_symmetric_weights};
use crate::profile::{Layout, Profile, shipped};
use crate::report::Answer;
use crate::results::{FrameReport, LeastFilled, PixelSolidAngle, Reason, RoundMirror};
use crate::trace::{CoverageBuilder, MinMeanMax, ObstructionBuilder};
use crate::verdict;
use std::ops::Range;

/// How the frame's filling is checked: designs, meshes, closes, writes in memory, reads back and traces the
/// mirror, and writes `frame.json`, `frame.html`, `frame.csv` and `frame.png` into NAME.
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
        let camera = &design.camera;
        let Some(view) = &design.view else { return Err(no_projection(profile)) };
        let mut coverage = CoverageBuilder::new(camera, view);
        let mut obstructions = ObstructionBuilder::new(camera, view, design.obstacles.len());
        let thinned = ThinnedFrame::new(camera.pixels);
        let (mut map, mut map_usr) = (Vec::new(), Vec::new());
        let mut resolution = ResolutionBuilder::default();
        let InMemoryBuild { frame, .. } = build_in_memory(run, &design, &mut |strip| {
            coverage.add(strip);
            obstructions.add(strip);
            let rows = strip.rows.start as u32..strip.rows.end as u32;
            let usr = solid_angles(&design, [0..camera.pixels[0], rows]);
            resolution.add(usr.iter().map(|usr| (*usr, 1)));
            map.extend(thinned.thin(strip.rows.clone(), &strip.classes).copied());
            map_usr.extend(thinned.thin(strip.rows.clone(), &usr).copied());
        })?;
        let Some(frame) = frame else { return Err(no_projection(profile)) };
        let coverage = run.timer.always(Stage::Coverage, || {
            let coverage = coverage.finish(design.mirror.outline.bounds().size().x);
            let note = format!("{:.3} deg around", coverage.azimuth_deg);
            (coverage, note)
        });
        let unfilled = verdict::unfilled(&frame, LeastFilled::Asked(min));
        let reason = unfilled.map(|fault| {
            let way_out = verdict::filling(profile, &fault, frame.filled);
            Reason { way_out, ..fault.into() }
        });
        let reasons = Vec::from_iter(reason);
        let report = FrameReport {
            schema: 1,
            profile: profile.into(),
            frame,
            coverage,
            obstacles: obstructions.finish(design.obstacles.iter().map(|o| o.name.clone())),
            resolution: resolution.finish(),
            round_mirrors: round_mirrors(camera)?,
            min,
            verdict: verdict::of(&reasons),
            reasons,
        };
        let map = report.map(thinned.pixels(), &map, &map_usr);
        let png = run.picture(|| map.png())?;
        let page =
            report.html(run.profile, &map).map_err(|error| Error::Picture(error.to_string()))?;
        run.publish(Stage::Report, |files, _| {
            files.add_bytes("frame.png", &png)?;
            files.add_bytes("frame.html", page.as_bytes())?;
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

/// Solid angle of every pixel in these columns and rows of the sensor, usr.
fn solid_angles(design: &Design, [columns, rows]: [Range<u32>; 2]) -> Vec<Option<f64>> {
    let Design { mirror, camera, view, .. } = design;
    let usr = 1e6 * camera.pixel_mm * camera.pixel_mm;
    let each = |pencil: &Pencil| pencil.solid_angle() * usr;
    map_pencils(mirror, camera, view.as_ref(), [columns, rows], each)
}

/// Solid angles of pixels that come one after the other.
#[derive(Default)]
struct ResolutionBuilder {
    count: u64,
    sum: f64,
    range: Option<[f64; 2]>,
}

impl ResolutionBuilder {
    /// Adds the solid angles of pixels, each with the number that it stands for.
    fn add(&mut self, pixels: impl Iterator<Item = (Option<f64>, u64)>) {
        for (usr, weight) in pixels.filter_map(|(usr, weight)| Some((usr?, weight))) {
            self.count += weight;
            self.sum += usr * weight as f64;
            let [min, max] = self.range.unwrap_or([f64::INFINITY, f64::NEG_INFINITY]);
            self.range = Some([min.min(usr), max.max(usr)]);
        }
    }

    fn finish(self) -> PixelSolidAngle {
        let mean = self.sum / self.count as f64;
        PixelSolidAngle {
            pixels: self.count,
            pixel_usr: self.range.map(|[min, max]| MinMeanMax { min, mean, max }),
            ratio: self.range.map(|[min, max]| max / min),
            total_sr: self.sum * 1e-6,
        }
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
        let usr = solid_angles(&design, [0..half, 0..half]);
        let both = mirror_symmetric_weights(side)
            .flat_map(|y| mirror_symmetric_weights(side).map(move |x| u64::from(x * y)));
        let mut resolution = ResolutionBuilder::default();
        resolution.add(usr.into_iter().zip(both));
        Ok(RoundMirror { profile: profile.name.clone(), resolution: resolution.finish() })
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
        CameraModel::Calibrated {
            pixels: [width, _],
            focal_px,
            principal_px,
            distortion,
            distance_mm,
        } => {
            let scale = f64::from(side) / f64::from(width);
            let [focal_px, principal_px] =
                [focal_px, principal_px].map(|px| px.map(|px| px * scale));
            CameraModel::Calibrated { pixels, focal_px, principal_px, distortion, distance_mm }
        }
    }
}
