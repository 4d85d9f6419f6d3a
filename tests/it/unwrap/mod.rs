//! Photos through mirrors, unwrapped: against the direct projection of the same world, against rays
//! traced on vectors, and as files.

mod files;
mod pictures;
mod video;

use crate::support::builds::{SMALL, edited, parsed};
use crate::support::{self, shipped_text};
use morion::internals::design::Design;
use morion::internals::geom::{DVec2, DVec3};
use morion::internals::num::{atan2, cos, degrees, sin, wrap_turn};
use morion::internals::optics::{StripLaw, reflect};
use morion::internals::profile::Profile;
use morion::internals::raster::Raster;
use morion::internals::trace::{Outcome, Scene};
use morion::internals::unwrap::{
    DirectionPicture, ImagingSystem, InverseMap, Panorama, RemapTable, crop_panels,
};
use std::f64::consts::{PI, TAU};

/// Waves of the test world's colours around the horizon.
const WAVES: f64 = 6.0;

/// An equirectangular world whose colours tell where they are: red and green the azimuth, blue the
/// elevation.
fn world() -> Raster {
    let (width, height) = (720, 360);
    let colour = |k: usize| {
        let a = TAU * (((k % width) as f64 + 0.5) / width as f64 - 0.5);
        let e = PI * (0.5 - ((k / width) as f64 + 0.5) / height as f64);
        [0.5 + 0.4 * sin(WAVES * a), 0.5 + 0.4 * cos(WAVES * a), 0.5 + 0.3 * e].map(|x| x as f32)
    };
    Raster { width, height, rgb: (0..width * height).map(colour).collect() }
}

fn seen(world: &Raster, azimuth: f64, elevation: f64) -> [f32; 3] {
    let x = (azimuth / TAU + 0.5) * world.width as f64;
    world.sample(x, (0.5 - elevation / PI) * world.height as f64, true)
}

fn angles(d: DVec3) -> [f64; 2] {
    [atan2(d.x, d.y), atan2(d.z, d.truncate().length())]
}

/// Azimuth (up to a wave) and elevation of a colour.
fn place(colour: [f32; 3]) -> [f64; 2] {
    let [r, g, b] = colour.map(f64::from);
    [atan2(r - 0.5, g - 0.5) / WAVES, (b - 0.5) / 0.3]
}

/// How far apart two colours are in the panorama, pixels.
fn apart(panorama: &Panorama, a: [f32; 3], b: [f32; 3]) -> f64 {
    let ([a, up_a], [b, up_b]) = (place(a), place(b));
    let across = wrap_turn((a - b) * WAVES) / WAVES;
    let z = |e: f64| panorama.law.image_of_degrees(degrees(e));
    DVec2::new(across, z(up_a) - z(up_b)).length() / panorama.per_px
}

/// Where the mirror's point over image point `q` is and which way its ray leaves, by vectors.
fn traced(design: &Design, q: DVec2) -> Option<(DVec3, DVec3)> {
    let Design { mirror, camera, .. } = design;
    let at = mirror
        .intersect_camera_ray(&camera.chart, q)
        .filter(|at| mirror.full_outline().contains(*at))?;
    let point = mirror.row(at.y).at(at.x);
    let place = mirror.position(at, &point);
    let ray = camera.ray(q, place.z + 1.0);
    Some((place, reflect(ray.direction, mirror.normal(at, &point))))
}

/// The photo of `world`, `scale` pixels to one of the sensor, 2 x 2 samples each.
fn photo(design: &Design, world: &Raster, scale: usize) -> Raster {
    let view = design.view.as_ref().unwrap();
    let [width, height] = design.camera.pixels.map(|n| n as usize * scale);
    let pixel = |k: usize| {
        let mut sum = [0.0; 3];
        for (dx, dy) in [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)] {
            let (x, y) = ((k % width) as f64 + dx, (k / width) as f64 + dy);
            let q = design.camera.image_point(x / scale as f64, y / scale as f64);
            let Some((at, direction)) = traced(design, q) else { continue };
            let [azimuth, elevation] = angles(view.direction_from_origin(at, direction));
            let light = seen(world, azimuth, elevation);
            sum = [0, 1, 2].map(|c| sum[c] + 0.25 * light[c]);
        }
        sum
    };
    Raster { width, height, rgb: (0..width * height).map(pixel).collect() }
}

/// The direct projection of `world`.
fn direct(world: &Raster, panorama: &Panorama) -> Raster {
    let [width, height] = panorama.size;
    let pixel = |k: usize| {
        let (x, y) = ((k % width) as f64 + 0.5, (k / width) as f64 + 0.5);
        let z = panorama.top - y * panorama.per_px;
        let elevation = match panorama.law {
            StripLaw::Cylindrical => atan2(z, 1.0),
            StripLaw::Equirectangular => z,
            _ => {
                atan2(0.5 * (morion::internals::num::exp(z) - morion::internals::num::exp(-z)), 1.0)
            }
        };
        seen(world, panorama.left + x * panorama.per_px, elevation)
    };
    Raster { width, height, rgb: (0..width * height).map(pixel).collect() }
}

fn optics(design: &Design) -> ImagingSystem<'_> {
    let view = design.view.as_ref().unwrap();
    ImagingSystem { mirror: &design.mirror, camera: &design.camera, view }
}

/// A shipped profile with half as many pixels along each side, and edits.
fn half(name: &str, edits: &[(&str, &str)]) -> Profile {
    let text = edited(shipped_text(name), edits)
        .replace("[640, 480]", "[320, 240]")
        .replace("[480, 480]", "[240, 240]")
        .replace("focal_px = 800", "focal_px = 400");
    Profile { name: name.into(), ..parsed(&text) }
}

const NEAR: (&str, &str) =
    ("[projection.cylindrical] ", "[projection.cylindrical]\ntarget_radius_mm = 200 ");

/// Mirrors of every kind, and the design's own error in pixels or more.
fn mirrors() -> Vec<(Profile, f64)> {
    let valley = ("ridge = \"crest\"", "ridge = \"valley\"");
    let near_ring = ("# target_radius_mm = 500", "target_radius_mm = 500");
    let pinhole = "camera.pinhole = { pixels = [320, 240], focal_px = 800, distance_mm = 150 }";
    let given = "camera.pinhole = { pixels = [240, 240], focal_px = 400, distance_mm = 100 }
projection.tangent-proportional.outer_polar_deg = 105
layout.disc = {}
part = { width_mm = 60, base_mm = 5 }
mirror.polynomial = { radius_mm = -32, conic = -1, terms = [[3, 0, 1e-5]] }
mesh.chord_um = 20
export.formats = [\"stl\"]
";
    let bands = "camera.pinhole = { pixels = [240, 240], focal_px = 400, distance_mm = 100 }
projection.table.polar_deg = [[0, 0], [0.35, 50], [0.6, 68], [0.8, 84], [1, 100]]
layout.disc = {}
method.vector-field.degree = 40
part = { width_mm = 60, base_mm = 5 }
mesh.chord_um = 20
export.formats = [\"stl\"]
";
    let pinhole = support::profile(&[
        ("camera.orthographic.pixels = [640, 480]", pinhole),
        ("azimuth_deg = [-180, 180]", "azimuth_deg = [-90, 150]"),
    ]);
    vec![
        (half("conquistador", &[]), 0.5),
        (half("conquistador", &[valley]), 0.5),
        (half("conquistador", &[NEAR]), 0.5),
        (half("conquistador", &[("panel = \"refit\" ", "panel = \"section\" ")]), 0.5),
        (half("panoramic", &[]), 0.3),
        (pinhole, 0.3),
        (half("conformal", &[]), 0.0),
        (half("parabolic", &[]), 0.0),
        (half("hyperbolic", &[]), 0.0),
        (half("cylinder", &[near_ring]), 0.0),
        (parsed(given), 0.0),
        (parsed(bands), 0.0),
    ]
}

/// Whether all that the interpolation takes of the photo at `place` is on the mirror, and in a ring
/// not so near the axis that a photo's pixel is many of the panorama's.
fn inside(design: &Design, [x, y]: [f32; 2]) -> bool {
    let on = |dx: f64, dy: f64| {
        let q = design.camera.image_point(f64::from(x) + dx, f64::from(y) + dy);
        let bounds = design.mirror.full_outline().bounds();
        let round = matches!(design.mirror.outline, morion::internals::geom::Outline::Ring { .. });
        design.mirror.full_outline().contains(q) && (!round || q.length() > 0.3 * bounds.max.x)
    };
    let [width, height] = design.camera.pixels.map(|n| n as f32);
    let frame = |a: f32, most: f32| (0.0..=most).contains(&a);
    frame(x, width)
        && frame(y, height)
        && [(-2.5, -2.5), (2.5, -2.5), (-2.5, 2.5), (2.5, 2.5)].iter().all(|(dx, dy)| on(*dx, *dy))
}

#[test]
#[ignore = "long: .ci/nightly"]
fn a_world_seen_through_the_mirror_and_unwrapped_is_its_direct_projection() {
    let world = world();
    for (profile, error_px) in mirrors() {
        let design = support::designed(&profile);
        let photo = photo(&design, &world, 1);
        let size = [photo.width, photo.height];
        let panorama = Panorama::new(&optics(&design), size, None, None).unwrap();
        let map = RemapTable::new(&optics(&design), &panorama, size).unwrap();
        let (found, exact) = (map.paint(&photo), direct(&world, &panorama));
        let off: Vec<f64> = (0..map.places.len())
            .filter(|k| inside(&design, map.places[*k]))
            .map(|k| apart(&panorama, found.rgb[k], exact.rgb[k]))
            .collect();
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        let worst = off.iter().copied().fold(0.0, f64::max);
        println!("{}: {:?} mean {mean:.4} worst {worst:.4} px", profile.name, panorama.size);
        assert!(off.len() > map.places.len() / 2, "{}: {} pixels", profile.name, off.len());
        assert!(mean <= 0.02 && worst <= 0.3, "{}: {mean} {worst}", profile.name);

        // The crop_panels alone have the design's own error, which the remap took away.
        let Ok((found, panorama)) = crop_panels(&optics(&design), &photo) else { continue };
        assert_eq!([found.width, found.height], panorama.size);
        let exact = direct(&world, &panorama);
        let off: Vec<f64> = (found.rgb.iter().zip(&exact.rgb))
            .filter(|(light, _)| light[2] > 0.0)
            .map(|(a, b)| apart(&panorama, *a, *b))
            .collect();
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        println!("  cuts: mean {mean:.4} px; removed {:?}", map.distortion_px.unwrap());
        let rms = (off.iter().map(|x| x * x).sum::<f64>() / off.len() as f64).sqrt();
        let design_rms = design.facts.pixel_error_px.unwrap().rms;
        assert!((rms - design_rms).abs() <= 0.1 * design_rms + 0.1, "{}: {rms}", profile.name);
        assert!(mean >= error_px, "{}: {mean}", profile.name);
    }
}

#[test]
fn the_map_is_the_inverse_of_the_ray_trace_and_misses_nothing() {
    for (profile, _) in mirrors() {
        let design = support::designed(&profile);
        let view = design.view.as_ref().unwrap();
        let sensor = design.camera.pixels.map(|n| n as usize);
        let panorama = Panorama::new(&optics(&design), sensor, None, None).unwrap();
        let map = RemapTable::new(&optics(&design), &panorama, sensor).unwrap();
        let [width, height] = map.size;
        let z = |e: f64| panorama.law.image_of_degrees(degrees(e));
        // Where in the panorama the ray of a place belongs, pixels.
        let belongs = |x: f64, y: f64| {
            let (at, direction) = traced(&design, design.camera.image_point(x, y))?;
            let [azimuth, elevation] = angles(view.direction_from_origin(at, direction));
            let middle = panorama.left + 0.5 * width as f64 * panorama.per_px;
            let across = wrap_turn(azimuth - middle) / panorama.per_px + 0.5 * width as f64;
            Some([across, (panorama.top - z(elevation)) / panorama.per_px])
        };
        let turn = TAU / panorama.per_px;
        for (k, [x, y]) in map.places.iter().enumerate().step_by(5).filter(|(_, p)| !p[0].is_nan())
        {
            let Some([across, down]) = belongs(f64::from(*x), f64::from(*y)) else { continue };
            let wanted = [(k % width) as f64 + 0.5, (k / width) as f64 + 0.5];
            let mut off = DVec2::new(across - wanted[0], down - wanted[1]);
            off.x -= turn * (off.x / turn).round();
            // In pixels of the photo: near the axis a panorama has many to one.
            let share = match design.mirror.outline {
                morion::internals::geom::Outline::Rect(_) => 1.0,
                morion::internals::geom::Outline::Ring { outer, .. } => {
                    design.camera.image_point(f64::from(*x), f64::from(*y)).length() / outer
                }
            };
            off.x *= share;
            assert!(off.length() < 2e-4, "{} {k}: {off}", profile.name);
        }
        let mut missed = 0;
        for k in (0..sensor[0] * sensor[1]).step_by(3) {
            let place = [(k % sensor[0]) as f32 + 0.5, (k / sensor[0]) as f32 + 0.5];
            if !inside(&design, place) {
                continue;
            }
            let [x, y] = place.map(f64::from);
            let Some([across, down]) = belongs(x, y) else { continue };
            let (column, row) = (across.floor(), down.floor());
            let within =
                (0.0..width as f64).contains(&column) && (0.0..height as f64).contains(&row);
            missed += usize::from(
                within && map.places[row as usize * width + column as usize][0].is_nan(),
            );
        }
        // Only at the frame's edge, where the centre of the panorama's pixel is just beyond it.
        assert!(missed < 200, "{}: {missed}", profile.name);
    }
}

#[test]
fn facets_move_content_by_no_more_than_their_bound() {
    let profile = parsed(&SMALL.replace("facet_px = 3", "facet_px = 0.5"));
    let design = support::designed(&profile);
    let face = support::meshed(&profile, &design).unwrap();
    let bound = face.bound.facet_mm / design.camera.pixel_mm;
    assert!(bound <= 0.5, "{bound}");
    let view = design.view.as_ref().unwrap();
    let scene = Scene::new(face.mesh.into_panels());
    let panorama = Panorama::new(&optics(&design), [160, 120], None, None).unwrap();
    let mut search = InverseMap::new(optics(&design)).search();
    let (mut worst, mut count) = (0.0_f64, 0);
    for k in 0..320 * 60 {
        let sigma = panorama.sigma((k % 320) as f64 + 0.5, (k / 320) as f64 + 0.5);
        let Some(found) = search.find(sigma) else { continue };
        let ray = design.camera.ray(found.image, 100.0);
        let end = scene.trace_primary(&ray);
        if end.outcome == Outcome::Missed {
            continue;
        }
        assert_eq!(end.outcome, Outcome::Hit);
        let content = view.image_of(end.hit_point(&ray), end.direction, found.image);
        worst = worst
            .max(view.projection.image_distance(content, found.intended) / design.camera.pixel_mm);
        count += 1;
    }
    println!("{count} places, worst {worst:.3} of {bound:.3} px");
    assert!(count > 18_000, "{count}");
    assert!(worst <= bound && worst > 0.1 * bound, "{worst}");
}
