//! `morion render`: a picture of a scene in the mirror.

use super::camera_view::{CameraView, Distance, TracedMesh, above, picture, reflected};
use super::files::Folder;
use super::in_memory_build::build_in_memory;
use super::observer::StageTimer;
use super::scenery::{RenderOptions, Scenery, stem};
use super::{Error, Observer, Source, Stage, designed};
use crate::design::Design;
use crate::geom::{DVec2, DVec3, Ray};
use crate::num::{cos, radians, sin};
use crate::optics::Target;
use crate::render::{Chessboard, Picture, SetupDiagram, TestWorld, World, shaded_views};
use crate::report::{ProfileId, RenderReport, SCHEMA};
use crate::trace::Scene;
use std::path::Path;

/// Samples along each side of a pixel at edges.
const SAMPLES: u32 = 4;

/// Renders what is `wanted` with the mirror of `source` into `out`/NAME/render-SCENE.png.
///
/// # Errors
/// [`enum@Error`] when there is no such scene, or a stage cannot be done; then there is no new file.
pub fn render(
    source: &Source,
    wanted: &RenderOptions,
    out: &Path,
    observer: &dyn Observer,
) -> Result<RenderReport, Error> {
    let profile = &source.profile;
    let clock = StageTimer::new(observer);
    let scenery = Scenery::read(wanted)?;
    let design = clock.stage(Stage::Design, || designed(source))?;
    let by_mesh = !wanted.smooth || scenery.shows_part();
    let mesh = if by_mesh { Some(build_in_memory(&clock, profile, &design)?) } else { None };
    let seen = mesh.as_ref().map(|reread| &reread.seen);
    let (png, picture) = clock.stage(Stage::Picture, || {
        let picture = taken(&design, seen, scenery, wanted);
        let png = picture.to_png().map_err(|e| Error::Picture(e.to_string()))?;
        let note = format!("{} kB", png.len() / 1000);
        Ok::<_, Error>(((png, picture), note))
    })?;
    let name = format!("render-{}.png", stem(wanted.scene));
    let folder = Folder::create(&out.join(&profile.name))?;
    clock.stage(Stage::Write, || {
        let staged = folder.stage(&name, |out| out.write_all(&png))?;
        staged.publish()?;
        Ok::<_, Error>(((), name.clone()))
    })?;
    Ok(RenderReport {
        schema: SCHEMA,
        profile: ProfileId { name: profile.name.clone(), sha256: profile.sha256.clone() },
        scene: wanted.scene.to_owned(),
        traced: mesh.as_ref().map_or("design", |reread| reread.format.name()),
        file: folder.path().join(name).display().to_string(),
        pixels: [picture.width, picture.height],
        rays: picture.samples,
    })
}

fn taken(
    design: &Design,
    seen: Option<&TracedMesh>,
    scenery: Scenery,
    wanted: &RenderOptions,
) -> Picture {
    let eye = seen.map_or(CameraView::Smooth, CameraView::Mesh);
    let far = |world: &dyn World| picture(design, eye, (world, Distance::Target), SAMPLES);
    let around = |world: &dyn World| picture(design, eye, (world, Distance::Around), SAMPLES);
    match (scenery, seen) {
        (Scenery::Grid, _) => far(&TestWorld::new()),
        // The camera is held so that the board, towards it, is at the picture's foot.
        (Scenery::Chessboard, _) => around(&chessboard(design, wanted.square_mm)).turned(),
        (Scenery::Views, Some((scene, _))) => {
            shaded_views(scene, |at| if wanted.smooth { optical(design, at) } else { None })
        }
        (Scenery::Panorama(world), _) => far(&*world),
        (Scenery::Model(world), _) => around(&*world),
        (Scenery::Cylinder, Some((scene, _))) => cylinder(design, scene),
        (Scenery::Views | Scenery::Cylinder, None) => unreachable!("the part is a mesh"),
    }
}

/// The board around the mirror of `design`: by default with squares as wide as the mirror.
fn chessboard(design: &Design, square_mm: Option<f64>) -> Chessboard {
    let outline = design.mirror.full_outline();
    let size = outline.bounds().size();
    let square = square_mm.unwrap_or_else(|| size.max_element());
    Chessboard::new(square, design.camera.chart.plane_mm, outline.reach(size))
}

/// How the mirror takes the image to a cylinder around it. Targets elsewhere are drawn on one that is
/// near, as if from its middle.
fn cylinder(design: &Design, scene: &Scene) -> Picture {
    // Azimuths and elevation of the rays that are drawn, degrees; both ends of what the wall shows.
    const RAYS_DEG: ([f64; 5], f64) = ([-66.0, -33.0, 0.0, 33.0, 66.0], 9.0);
    const STEEPEST: f64 = 0.7;
    const STEPS: i32 = 96;
    let half_mm = design.mirror.full_outline().bounds().size() * 0.5;
    let reach = half_mm.length();
    let radius_mm = match design.view.as_ref().map(|view| view.target) {
        Some(Target::Cylinder { radius_mm }) if radius_mm < 4.0 * reach => radius_mm,
        _ => 1.6 * reach,
    };
    let horizon = design.view.as_ref().map_or(design.camera.chart.plane_mm, |v| v.origin_mm);
    // Between mirror and pinhole the image is smaller than on the reference plane.
    let chart = design.camera.chart;
    let image_mm = above(scene).min(chart.plane_mm + 0.5 / chart.vergence);
    let shrink = chart.view_scale(image_mm);
    let step = |k: i32| f64::from(2 * k + 1) / f64::from(STEPS) - 1.0;
    let row = |y: i32| (0..STEPS).map(|x| half_mm * DVec2::new(step(x), step(y))).collect();
    let points: Vec<Vec<DVec2>> = (0..STEPS).map(row).collect();
    let ends: Vec<(DVec2, Ray)> = points
        .iter()
        .flat_map(|row| row.iter().copied().zip(reflected(design, row)))
        .filter_map(|(q, end)| Some((q, end?)))
        .collect();
    let rise = |ray: &Ray| ray.direction.z / ray.direction.truncate().length();
    let steepest = |ends: &[(DVec2, Ray)], sign: f64| {
        let rises = ends.iter().map(|(_, ray)| sign * rise(ray));
        sign * rises.fold(0.0, f64::max).min(STEEPEST)
    };
    let [foot, top] = [-1.0, 1.0].map(|sign| horizon + radius_mm * steepest(&ends, sign));
    let (azimuths, elevation) = RAYS_DEG;
    let drawn = azimuths.into_iter().filter_map(|azimuth| {
        let [a, e] = [azimuth, elevation].map(radians);
        let wanted = DVec3::new(cos(e) * sin(a), cos(e) * cos(a), sin(e));
        let nearest = |(_, ray): &&(DVec2, Ray)| ray.direction.dot(wanted);
        let (q, ray) = ends.iter().max_by(|a, b| nearest(a).total_cmp(&nearest(b)))?;
        let (o, d) = (ray.origin.truncate(), ray.direction.truncate());
        let (a, b) = (d.length_squared(), o.dot(d));
        let inside = radius_mm * radius_mm - o.length_squared();
        let t = ((b * b + a * inside).max(0.0).sqrt() - b) / a;
        Some([(q * shrink).extend(image_mm), ray.origin, ray.at(t)])
    });
    let rays = drawn.collect();
    let heights_mm = [foot, horizon, top];
    let half_mm = half_mm * shrink;
    let setup = SetupDiagram { scene, half_mm, image_mm, radius_mm, heights_mm, rays };
    let shown = |q: DVec2| reflected(design, &[q / shrink])[0].map(|ray| ray.direction);
    setup.picture(shown)
}

/// The designed mirror's unit normal at a place of its optical face.
fn optical(design: &Design, at: DVec3) -> Option<DVec3> {
    let mirror = &design.mirror;
    let (place, height) = mirror.chart.coordinates(at);
    let point = mirror.row(place.y).at(place.x);
    let near = 1e-3 * mirror.outline.bounds().size().max_element();
    let on_face = mirror.full_outline().contains(place) && (height - point.f).abs() < near;
    on_face.then(|| mirror.normal(place, &point).normalize())
}
