//! `morion render`: a picture of a scene in the mirror.

use super::in_memory_build::{InMemoryBuild, build_in_memory};
use super::page_figures::ErrorMapBuilder;
use super::run::{Command, Run};
use super::scenery::{PartScene, RenderOptions, SceneName, Scenery, WorldScene, stem};
use super::{Error, Stage};
use crate::design::Design;
use crate::geom::{Chart, DVec2, DVec3, Ray, Rect};
use crate::mirror::Mirror;
use crate::num::{cos, radians, sin};
use crate::optics::{Target, ThinnedFrame};
use crate::profile::Profile;
use crate::publish::FileError;
use crate::render::{
    CameraPicture, CameraView, Chessboard, Distance, Picture, ReflectedCentres, SetupDiagram,
    SmoothSight, TestWorld, TracedMesh, World, optical_normal, pixel_errors, reflected_on_chart,
    shaded_views,
};
use crate::report::pixel_error_map;
use crate::results::{RenderReport, SCHEMA};
use crate::trace::Scene;

/// Samples along each side of a pixel at edges.
const SAMPLES: u32 = 4;

impl Command for RenderOptions<'_> {
    type Report = RenderReport;

    fn check(&self, profile: &Profile) -> Result<(), Error> {
        match (SceneName::of(self)?, &profile.projection) {
            (SceneName::Errors, None) => Err(Error::NoProjection {
                work: "map the errors of",
                profile: profile.name.clone(),
            }),
            _ => Ok(()),
        }
    }

    fn run(&self, run: &mut Run) -> Result<RenderReport, Error> {
        let scenery = Scenery::read(self)?;
        // What is painted of the smooth mirror asks for no figure.
        let design = if self.smooth { run.design_unmeasured()? } else { run.design()? };
        let name = format!("render-{}.png", stem(self.scene));
        let (traced, (pixels, rays)) = match &scenery {
            Scenery::Part(scene) => {
                let InMemoryBuild { format, scene: mesh, .. } =
                    build_in_memory(run, &design, &mut |_| {})?;
                let (picture, png) = run.painted(|| self.part(&design, &mesh, *scene))?;
                run.files.add_bytes(&name, &png)?;
                (format.name(), ([picture.width, picture.height], picture.samples))
            }
            Scenery::Errors => {
                let (traced, errors) = self.errors(run, &design)?;
                let pixels = ThinnedFrame::new(design.camera.pixels).pixels();
                let png = run.picture(|| pixel_error_map(pixels, &errors).png())?;
                run.files.add_bytes(&name, &png)?;
                (traced, (pixels, errors.len() as u64))
            }
            Scenery::World(world) if self.smooth => {
                let sight = SmoothSight::new(&design);
                let view = CameraView::Smooth(&sight);
                ("design", self.write_world(run, &name, &design, (view, world))?)
            }
            Scenery::World(world) => {
                let mut centres = ReflectedCentres::default();
                let InMemoryBuild { format, scene, .. } =
                    build_in_memory(run, &design, &mut |strip| {
                        centres.add(strip);
                    })?;
                let mesh = TracedMesh { scene, centres };
                let view = CameraView::Mesh(&mesh);
                (format.name(), self.write_world(run, &name, &design, (view, world))?)
            }
        };
        run.timer.stage(Stage::Write, || {
            run.files.commit()?;
            Ok::<_, FileError>(((), name.clone()))
        })?;
        Ok(RenderReport {
            schema: SCHEMA,
            profile: run.profile.into(),
            scene: self.scene.to_owned(),
            traced,
            file: run.files.path_of(&name).display().to_string(),
            pixels,
            rays,
        })
    }
}

impl RenderOptions<'_> {
    /// Writes what the camera sees of a world, and returns the picture's pixels and the number of rays.
    fn write_world(
        &self,
        run: &mut Run,
        name: &str,
        design: &Design,
        (view, scene): (CameraView, &WorldScene),
    ) -> Result<([u32; 2], u64), Error> {
        let picture = |distance| CameraPicture::new(design, view, distance, SAMPLES);
        let (far, around) = (picture(Distance::Target), picture(Distance::Around));
        let mut write = |picture: &CameraPicture, world: &dyn World| {
            let mut rays = 0;
            run.timer.stage(Stage::Picture, || {
                run.files.add(name, |out| {
                    rays = picture.write_png(world, out)?;
                    Ok(())
                })?;
                Ok::<_, Error>(((picture.pixels(), rays), name.to_owned()))
            })
        };
        match scene {
            WorldScene::Grid => write(&far, &TestWorld::new()),
            // The camera is held so that the board, towards it, is at the picture's foot.
            WorldScene::Chessboard => write(&around.turned(), &chessboard(design, self.square_mm)),
            WorldScene::Panorama(world) => write(&far, &**world),
            WorldScene::Model(world) => write(&around, &**world),
        }
    }

    /// What is traced, and the pixel errors of the thinned frame.
    fn errors(
        &self,
        run: &Run,
        design: &Design,
    ) -> Result<(&'static str, Vec<Option<f64>>), Error> {
        let thinned = ThinnedFrame::new(design.camera.pixels);
        if self.smooth {
            let errors =
                run.timer.always(Stage::Trace, || (pixel_errors(design, thinned), String::new()));
            return Ok(("design", errors));
        }
        let mut errors = ErrorMapBuilder::new(design, ThinnedFrame::MOST_COLUMNS);
        let found = build_in_memory(run, design, &mut |strip| errors.add(strip))?;
        Ok((found.format.name(), errors.finish().errors))
    }

    /// The part itself.
    fn part(&self, design: &Design, mesh: &Scene, scene: PartScene) -> Picture {
        mesh.prepare_search();
        match scene {
            PartScene::Views => {
                shaded_views(mesh, |at| if self.smooth { optical_normal(design, at) } else { None })
            }
            PartScene::Cylinder => cylinder(design, mesh),
        }
    }
}

/// The board around the mirror of `design`: by default with squares as wide as the mirror.
fn chessboard(design: &Design, square_mm: Option<f64>) -> Chessboard {
    let outline = design.mirror.full_outline();
    let size = outline.bounds().size();
    let square = square_mm.unwrap_or_else(|| size.max_element());
    Chessboard::new(square, design.camera.chart.plane_mm, outline.reach(size))
}

/// How the mirror takes the image to a cylinder around it, as a picture.
fn cylinder(design: &Design, scene: &Scene) -> Picture {
    let setup = setup(design, scene);
    setup.picture(|at| {
        let (q, _) = design.camera.chart.coordinates(at.extend(setup.image_mm));
        reflected_on_chart(design, &[q])[0].map(|ray| ray.direction)
    })
}

/// Image, mirror, and a cylinder around it. Targets elsewhere are drawn on one that is near, as if from its middle.
fn setup<'a>(design: &Design, scene: &'a Scene) -> SetupDiagram<'a> {
    // Azimuths and elevation of the rays that are drawn, degrees; both ends of what the wall shows.
    const RAYS_DEG: ([f64; 5], f64) = ([-66.0, -33.0, 0.0, 33.0, 66.0], 9.0);
    const STEEPEST: f64 = 0.7;
    const STEPS: i32 = 96;
    let bounds = bounds_on_chart(&design.mirror, &design.camera.chart);
    let half_mm = bounds.size() * 0.5;
    let reach = bounds.min.abs().max(bounds.max.abs()).length();
    let radius_mm = match design.view.as_ref().map(|view| &view.target) {
        Some(&Target::Cylinder { radius_mm }) if radius_mm < 4.0 * reach => radius_mm,
        _ => 1.6 * reach,
    };
    let horizon = design.view.as_ref().map_or(design.camera.chart.plane_mm, |v| v.origin_mm);
    // Between mirror and pinhole the image is smaller than on the reference plane, and beside it where the camera leans.
    let chart = design.camera.chart;
    let image_mm = scene.above_mm().min(chart.plane_mm + 0.5 / chart.vergence);
    let step = |k: i32| f64::from(2 * k + 1) / f64::from(STEPS) - 1.0;
    let place = |x: i32, y: i32| bounds.centre() + half_mm * DVec2::new(step(x), step(y));
    let row = |y: i32| (0..STEPS).map(|x| place(x, y)).collect();
    let points: Vec<Vec<DVec2>> = (0..STEPS).map(row).collect();
    let ends: Vec<(DVec2, Ray)> = points
        .iter()
        .flat_map(|row| row.iter().copied().zip(reflected_on_chart(design, row)))
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
        Some([chart.ray_at(*q, image_mm).extend(image_mm), ray.origin, ray.at(t)])
    });
    let rays = drawn.collect();
    let heights_mm = [foot, horizon, top];
    let [min, max] = [bounds.min, bounds.max].map(|q| chart.ray_at(q, image_mm));
    SetupDiagram { scene, image: Rect { min, max }, image_mm, radius_mm, heights_mm, rays }
}

/// The rectangle around the mirror as the camera of chart `camera` sees it, on that chart.
fn bounds_on_chart(mirror: &Mirror, camera: &Chart) -> Rect {
    // Places along each rim, with the extremes of round ones among them.
    const PLACES: usize = 720;
    let outline = mirror.full_outline();
    if mirror.chart == *camera {
        return outline.bounds();
    }
    let seen = |q: &DVec2| camera.coordinates(mirror.position(*q, &mirror.at(*q))).0;
    let rims = outline.rims(PLACES);
    let places: Vec<DVec2> = rims.iter().flatten().map(seen).collect();
    let min = places.iter().copied().fold(DVec2::INFINITY, DVec2::min);
    let max = places.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
    Rect { min, max }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::TriMesh;
    use crate::pipeline::load;

    #[test]
    fn the_image_of_a_given_mirror_goes_as_far_as_the_camera_sees_it() {
        let text = "part = { width_mm = 80, height_mm = 60, base_mm = 5 }
            camera.pinhole = { pixels = [640, 480], focal_px = 900, distance_mm = 150 }
            mirror.polynomial = { radius_mm = -60, terms = [[3, 0, 1e-5]] }
            mesh.chord_um = 2
            export.formats = [\"stl\"]";
        let profile = Profile::parse("given", "given.toml", text.as_bytes()).unwrap();
        let design = crate::design::design(&profile).unwrap();
        assert_ne!(design.mirror.chart, design.camera.chart);
        let bounds = bounds_on_chart(&design.mirror, &design.camera.chart);
        // A convex mirror is nearest to the camera, and looks largest, in the middle of its sides.
        let half = 0.5 * bounds.size();
        for way in [DVec2::X, -DVec2::X, DVec2::Y, -DVec2::Y] {
            let is_seen = |share: f64| {
                let q = bounds.centre() + share * half * way;
                reflected_on_chart(&design, &[q])[0].is_some()
            };
            assert_eq!([0.999, 1.001].map(is_seen), [true, false], "{way}");
        }
    }

    #[test]
    fn rays_come_straight_from_a_camera_that_leans() {
        for name in ["driver", "floor", "conquistador", "calibrated"] {
            let design = crate::design::design(&load(name).unwrap()).unwrap();
            let place = design.mirror.position(DVec2::ZERO, &design.mirror.at(DVec2::ZERO));
            let size = DVec3::splat(1.0);
            let vertices = vec![place - size, place + size, place];
            let scene = Scene::new(TriMesh { vertices, triangles: vec![[0, 1, 2]] });
            let setup = setup(&design, &scene);
            assert_eq!(setup.rays.len(), 5, "{name}");
            for [image, mirror, _] in &setup.rays {
                let way = (*image - *mirror).normalize();
                let (q, _) = design.camera.chart.coordinates(*mirror);
                let sight = design.camera.chart.ray(q, image.z).direction;
                let off = way.cross(sight).length();
                assert!(off < 1e-12, "{name}: {off:e}");
                assert!(setup.image.contains(image.truncate()), "{name}");
            }
        }
    }
}
