//! The solid angle of a pixel.

use crate::support::{designed, profile, rims, shipped, shipped_but};
use morion::internals::design::Design;
use morion::internals::geom::DVec2;
use morion::internals::num::{cos, radians, sin, tan, tanh};
use morion::internals::optics::Projection;
use morion::internals::pencil::map_pencils;
use std::f64::consts::{PI, TAU};

/// Solid angle of every pixel, sr, and the pixels' image points.
fn pixels(design: &Design) -> Vec<(DVec2, f64)> {
    let Design { mirror, camera, view, .. } = design;
    let [width, height] = camera.pixels;
    let area = camera.pixel_mm * camera.pixel_mm;
    let found = map_pencils(mirror, camera, view.as_ref(), [0..width, 0..height], |pencil| {
        pencil.solid_angle() * area
    });
    let point = |k: usize| {
        let (x, y) = (k as u32 % width, k as u32 / width);
        camera.image_point(f64::from(x) + 0.5, f64::from(y) + 0.5)
    };
    let pixels = found.into_iter().enumerate();
    pixels.filter_map(|(k, sr)| Some((point(k), sr?))).collect()
}

/// Every pixel against `exact`, sr per mm^2 at a radius.
#[track_caller]
fn agree(design: &Design, tolerance: f64, exact: impl Fn(f64) -> f64) {
    let area = design.camera.pixel_mm * design.camera.pixel_mm;
    let pixels = pixels(design);
    assert!(pixels.len() > 1000);
    let off = |(q, sr): &(DVec2, f64)| (sr / (exact(q.length()) * area) - 1.0).abs();
    let worst = pixels.iter().map(off).fold(0.0, f64::max);
    assert!(worst < tolerance, "{worst:e}");
}

#[test]
fn a_paraboloid_has_the_density_of_the_stereographic_projection() {
    let design = designed(&shipped_but("parabolic", &[("[480, 480]", "[96, 96]")]));
    let rate = tan(radians(50.0)) / rims(&design)[1];
    agree(&design, 1e-9, |r| {
        let scale = 2.0 * rate / (1.0 + rate * rate * r * r);
        scale * scale
    });
}

#[test]
fn the_equi_areal_mirror_is_uniform() {
    let design = designed(&shipped_but("equi-areal", &[("[480, 480]", "[96, 96]")]));
    let outer = rims(&design)[1];
    let exact = TAU * (1.0 - cos(radians(110.0))) / (PI * outer * outer);
    agree(&design, 1e-7, |_| exact);
}

#[test]
fn a_target_nearby_is_seen_from_its_origin() {
    // cot psi = cot psi0 - rate (r - r0) from the target's origin, wherever the mirror's point is.
    for target in ["", "\ntarget_radius_mm = 300"] {
        let text = format!("outer_polar_deg = 120{target} #");
        let edits = [("[480, 480]", "[96, 96]"), ("focal_px = 800", "focal_px = 160")];
        let edits = [&edits[..], &[("outer_polar_deg = 120", &*text)]].concat();
        let design = designed(&shipped_but("cylinder", &edits));
        let [inner, outer] = rims(&design);
        let cot = |deg: f64| 1.0 / tan(radians(deg));
        let rate = (cot(60.0) - cot(120.0)) / (outer - inner);
        agree(&design, 1e-6, |r| {
            let cot = cot(60.0) - rate * (r - inner);
            let sine = 1.0 / (1.0 + cot * cot).sqrt();
            sine * sine * sine * rate / r
        });
    }
}

#[test]
fn an_exact_panorama_sums_to_the_zone_that_its_rows_show() {
    let off = |width: u32| {
        let sensor = format!("[{width}, {}]", width * 3 / 4);
        let profile = profile(&[("[640, 480]", &*sensor), ("cylindrical", "mercator")]);
        let design = designed(&profile);
        let view = design.view.as_ref().unwrap();
        let Projection::Strip(strip) = &view.projection else { panic!("a strip") };
        let pixels = pixels(&design);
        assert_eq!(pixels.len() % width as usize, 0);
        let rows = pixels.iter().map(|(q, _)| q.y);
        let (low, high) = rows.fold((f64::MAX, f64::MIN), |(a, b), y| (a.min(y), b.max(y)));
        // tan(elevation) = sinh z: its sine is tanh z.
        let z = |y: f64| strip.z + y / strip.scale_mm;
        let half = 0.5 * design.camera.pixel_mm;
        let exact = TAU * (tanh(z(high + half)) - tanh(z(low - half)));
        assert!((exact - 2.0 * TAU * sin(radians(30.0))).abs() < 0.05 * exact);
        pixels.iter().map(|p| p.1).sum::<f64>() / exact - 1.0
    };
    // The midpoint rule: fourfold pixels, a sixteenth of the error.
    let [coarse, fine] = [80, 320].map(off);
    assert!(coarse.abs() < 1e-3 && (14.0..18.0).contains(&(coarse / fine)), "{coarse:e} {fine:e}");
}

#[test]
fn the_conquistador_shows_the_zone_of_its_frame() {
    // The paper's folded mirror: tan(elevation) up to 3 pi / 16, all around; the projection is met
    // to some pixels.
    let design = designed(&shipped("conquistador"));
    let z = 3.0 * PI / 16.0;
    let exact = 2.0 * TAU * z / (1.0 + z * z).sqrt();
    let found: f64 = pixels(&design).iter().map(|p| p.1).sum();
    assert!((found / exact - 1.0).abs() < 0.02, "{found} {exact}");
}
