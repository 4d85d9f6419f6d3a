//! A frame is traced strip by strip, and no answer shows where the strips end.

use crate::support::{designed, meshed, profile, shipped_but};
use morion::internals::design::Design;
use morion::internals::geom::{Cuboid, Cylinder, DVec2, DVec3, Obstacle, ObstacleShape, Precision};
use morion::internals::optics::reflect;
use morion::internals::profile::Profile;
use morion::internals::solid::Solid;
use morion::internals::trace::{
    CameraTrace, Coverage, CoverageBuilder, ExpectedRay, FrameFill, FrameFillBuilder, Obstacles,
    Obstruction, ObstructionBuilder, Outcome, PixelClass, PixelRay, PixelTrace, Scene, TraceCounts,
    TraceStrip, TraceSummary, WantedPicture,
};
use std::sync::Arc;

/// A tolerance under which some pixels are lost by their content.
const TOLERANCE_PX: f64 = 2.0;

/// The part of a profile, and its design with a camera of so many pixels.
fn part(name: &str, facet_px: &str, pixels: [u32; 2]) -> (Design, Scene) {
    let edits = [("facet_px = 1", facet_px), ("pixels = [640, 480]", "pixels = [160, 120]")];
    part_of(&shipped_but(name, &edits), pixels)
}

fn part_of(profile: &Profile, pixels: [u32; 2]) -> (Design, Scene) {
    let mut design = designed(profile);
    let face = meshed(profile, &design).unwrap();
    let solid = Solid::from_face(&face.mesh, design.features(), Precision::Single).unwrap();
    design.camera.pixel_mm *= 160.0 / f64::from(pixels[0]);
    design.camera.pixels = pixels;
    (design, Scene::new(solid.mesh().clone()))
}

/// The expected rays of so many pixels in a row of the sensor.
fn expected(design: &Design, [first, row]: [u32; 2], count: usize) -> Vec<ExpectedRay> {
    let (camera, view) = (&design.camera, design.view.as_ref().unwrap());
    let outline = design.mirror.full_outline();
    let ray = |column: u32| {
        let point: DVec2 = camera.image_point(f64::from(column) + 0.5, f64::from(row) + 0.5);
        let mirror = design.mirror.row(point.y).at(point.x);
        let normal = design.mirror.normal(point, &mirror);
        let at = design.mirror.position(point, &mirror);
        let arriving = camera.ray(point, 0.0).direction;
        ExpectedRay {
            aimed: outline.contains(point),
            direction: view.direction_of(point, at),
            designed: view.shown(at, reflect(arriving, normal), point),
        }
    };
    (first..first + count as u32).map(ray).collect()
}

/// All that is found of a frame.
type Found = (
    Vec<PixelTrace>,
    Vec<PixelClass>,
    TraceCounts,
    FrameFill,
    (Coverage, Vec<Obstruction>),
    String,
);

fn found(design: &Design, scene: &Scene, strip_pixels: usize) -> (Found, usize) {
    let (camera, view) = (&design.camera, design.view.as_ref().unwrap());
    let trace = CameraTrace::new(scene, camera, scene.above_mm()).in_strips_of(strip_pixels);
    let (mut pixels, mut classes, mut strips) = (Vec::new(), Vec::new(), 0);
    let (mut summary, mut fill) = (TraceSummary::default(), FrameFillBuilder::default());
    let mut coverage = CoverageBuilder::new(camera, view);
    let mut hidden = ObstructionBuilder::new(camera, view, design.obstacles.len());
    let table = |at, rays: &[PixelRay]| expected(design, at, rays.len());
    let picture = WantedPicture { task: view, tolerance_mm: TOLERANCE_PX * camera.pixel_mm };
    // Normals of the file's own, beside those of the facets.
    let mesh = scene.mesh();
    let tilted = |facet: usize| {
        [DVec3::X, DVec3::Y, DVec3::Z].map(|by| mesh.area_vector(facet).normalize() + 0.01 * by)
    };
    let normals: Vec<[DVec3; 3]> = (0..mesh.triangles.len()).map(tilted).collect();
    let counts = TraceStrip::each(&trace, Some(&normals), Some(picture), table, |strip| {
        summary.add(strip);
        fill.add(strip);
        coverage.add(strip);
        hidden.add(strip);
        pixels.extend_from_slice(&strip.pixels);
        classes.extend_from_slice(&strip.classes);
        strips += 1;
    });
    let fill = fill.finish(camera.pixels, TOLERANCE_PX);
    let coverage = coverage.finish(design.mirror.outline.bounds().size().x);
    let errors = format!("{:?}", summary.errors());
    let hidden = hidden.finish(design.obstacles.iter().map(|obstacle| obstacle.name.clone()));
    ((pixels, classes, counts, fill, (coverage, hidden), errors), strips)
}

/// A wall in the north, and a leg in the south, where azimuths jump.
fn obstacles() -> Vec<Obstacle> {
    let wall = Cuboid::aligned(DVec3::new(3.0, 90.0, 10.0), DVec3::new(50.0, 4.0, 60.0));
    let leg = Cylinder {
        from_mm: DVec3::new(1.0, -70.0, -50.0),
        to_mm: DVec3::new(-1.0, -70.0, 60.0),
        radius_mm: 5.0,
        is_solid: true,
    };
    let named = |(name, shape): (&str, ObstacleShape)| Obstacle { name: name.into(), shape };
    [("wall", ObstacleShape::Cuboid(wall)), ("leg", ObstacleShape::Cylinder(leg))].map(named).into()
}

#[test]
fn no_answer_depends_on_the_strips() {
    let (mut lost, mut hidden) = (0, [0; 2]);
    for (name, facet_px, pixels) in [
        // Facets of many pixels, in rows that are compared in several runs, and of few.
        ("conquistador", "facet_px = 30", [531, 150]),
        ("conquistador", "facet_px = 1", [161, 203]),
        ("panoramic", "facet_px = 5", [97, 331]),
    ] {
        let (mut design, scene) = part(name, facet_px, pixels);
        design.obstacles = obstacles();
        let bodies = Obstacles::new(&design.obstacles, design.view.as_ref());
        let scene = scene.among(bodies.map(Arc::new));
        let (whole, strips) = found(&design, &scene, usize::MAX);
        assert_eq!(strips, 1);
        let (parts, strips) = found(&design, &scene, 1);
        assert!(strips >= 3, "{name}: {strips}");
        assert!(whole.0 == parts.0, "{name}: rays");
        assert_eq!(whole.1, parts.1, "{name}: classes");
        assert_eq!(whole.2, parts.2, "{name}: counts");
        assert_eq!(whole.3, parts.3, "{name}: fill");
        assert_eq!(whole.4, parts.4, "{name}: coverage and obstructions");
        for (count, of) in hidden.iter_mut().zip(&whole.4.1) {
            *count += of.pixels;
        }
        assert_eq!(whole.5, parts.5, "{name}: errors");
        assert!(whole.1.contains(&PixelClass::Filled), "{name}");
        lost += whole.3.lost.rim + whole.3.lost.content;
    }
    assert!(lost > 0 && hidden.iter().all(|count| *count > 100), "{lost} {hidden:?}");
}

/// Of the rays of a ridge that is a valley many are shadowed, of a bulging mirror few are in doubt.
#[test]
fn no_answer_depends_on_when_the_grid_is_made() {
    let valley = "layout.conquistador = { fill_frame = true, ridge = \"valley\" }";
    let (design, scene) = part_of(&profile(&[("layout.strip = {}", valley)]), [161, 203]);
    for (part, shadow) in
        [((design, scene), true), (part("conquistador", "facet_px = 5", [161, 203]), false)]
    {
        let (design, scene) = part;
        let (searched, _) = found(&design, &scene, usize::MAX);
        for (closed, strip_pixels) in [(false, usize::MAX), (true, usize::MAX), (true, 1)] {
            let bare = Scene::for_cameras(scene.mesh().clone(), closed);
            let (first, _) = found(&design, &bare, strip_pixels);
            assert!(first == searched, "first, {closed}, {strip_pixels}");
            let (again, _) = found(&design, &bare, strip_pixels);
            assert!(again == searched, "again, {closed}, {strip_pixels}");
        }
        let shadowed = |pixel: &&PixelTrace| matches!(pixel.outcome, Outcome::Shadowed(_));
        assert_eq!(searched.0.iter().filter(shadowed).count() > 100, shadow);
        assert!(searched.2.followed > 0);
    }
}
