//! What pixels see of textures and of facets: means over footprints, against many rays each.

use super::{engine, fixed, spec};
use crate::support::{designed, profile, share, shipped};
use morion::internals::design::Design;
use morion::internals::geom::{DVec2, Precision, Ray};
use morion::internals::mesh::{Limits, mesh};
use morion::internals::num::random::RandomStream;
use morion::internals::optics::reflect;
use morion::internals::profile::Profile;
use morion::internals::tolerance::{
    Engine, Perturbation, ToleranceSpec, facets_bound, facets_displace,
};
use morion::internals::trace::{Outcome, Scene};

/// Rays along each side of a pixel.
const SIDE: usize = 40;

/// Shifts over a pixel, px.
fn shifts() -> impl Iterator<Item = [f64; 2]> {
    let at = |k: usize| (k as f64 + 0.5) / SIDE as f64 - 0.5;
    (0..SIDE * SIDE).map(move |k| [at(k % SIDE), at(k / SIDE)])
}

fn square(field: &[f64]) -> f64 {
    field.iter().map(|x| x * x).sum::<f64>()
}

fn webcam() -> Profile {
    profile(&[
        (
            "camera.orthographic.pixels = [640, 480]",
            "camera.pinhole = { pixels = [640, 480], hfov_deg = 39, distance_mm = 150 }",
        ),
        ("width_mm = 60", "width_mm = 100"),
    ])
}

/// A texture alone, by the engine's means and by rays spread over each pixel: the principal point is
/// shifted by parts of a pixel.
fn means(engine: &Engine, value: (Perturbation, f64)) -> [Vec<f64>; 3] {
    let stream = RandomStream { seed: 5, trial: 2 };
    let of = |engine: &Engine, values: &[(Perturbation, f64)]| {
        engine.displacements(&[engine.make(values, stream)]).remove(0)
    };
    let points = engine.pointwise();
    let found = of(engine, &[value]);
    let mut mean = vec![0.0; found.len()];
    let mut squares = mean.clone();
    for [x, y] in shifts() {
        let shift = [(Perturbation::PrincipalX, x), (Perturbation::PrincipalY, y)];
        let [with, without] = [of(&points, &[value, shift[0], shift[1]]), of(&points, &shift)];
        for (k, (a, b)) in with.iter().zip(&without).enumerate() {
            let moved = (a - b) / (SIDE * SIDE) as f64;
            mean[k] += moved;
            squares[k] += moved * (a - b);
        }
    }
    let spread = squares.iter().zip(&mean).map(|(s, m)| s - m * m).collect();
    [found, mean, spread]
}

#[test]
#[ignore = "long: .ci/nightly"]
fn content_moves_by_the_mean_over_a_pixel_and_blurs_by_the_rest() {
    let designs = [designed(&shipped("conquistador")), designed(&webcam())];
    for (k, design) in designs.iter().enumerate() {
        for (kind, limit) in [
            (Perturbation::Stepover, 0.02),
            (Perturbation::Stepover, 0.07),
            (Perturbation::Stepover, 0.15),
            (Perturbation::Stepover, 0.3),
            (Perturbation::Waviness, 0.01),
            (Perturbation::Slope, 0.1),
        ] {
            let mut asked = spec(vec![fixed(kind, limit)], &[]);
            // Waves of a few pixels, and light that no height is too small for.
            asked.texture.waviness_period_mm = 0.17;
            asked.texture.slope_correlation_mm = 0.15;
            asked.texture.wavelength_nm = 1e-3;
            let engine = engine(design, asked);
            let [found, mean, spread] = means(&engine, (kind, limit));
            let off: Vec<f64> = found.iter().zip(&mean).map(|(a, b)| a - b).collect();
            let points: f64 = square(&mean) + spread.iter().sum::<f64>();
            // Sums of so few rays miss cusps by a few percent of what a point shows.
            let share = (square(&off) / points).sqrt();
            assert!(share < 0.06, "{k} {kind:?} {limit}: {share}");
            let blur = engine.blur_and_scatter(&fixed(kind, limit)).blur_px;
            let exact = (spread.iter().sum::<f64>() / engine.samples() as f64).sqrt();
            assert!((blur / exact - 1.0).abs() < 0.15, "{k} {kind:?} {limit}: {blur} {exact}");
            let predicted = engine.mean_square(&fixed(kind, limit));
            let moved = square(&found) / engine.samples() as f64;
            assert!(
                (predicted - moved).abs() < 0.35 * moved + 1e-3 * points / engine.samples() as f64,
                "{k} {kind:?} {limit}: {predicted} {moved}"
            );
        }
    }
}

/// RMS over pixels of the mean displacement that the facets of a mesh cause, of their points', and facets
/// a pixel.
fn by_facets(design: &Design, limit: f64) -> [f64; 3] {
    let Design { mirror, camera, .. } = design;
    let view = design.view.as_ref().unwrap();
    let pixel = camera.pixel_mm;
    let limits =
        Limits { chord_mm: None, facet_mm: Some(limit * pixel), precision: Precision::Double };
    let face = mesh(mirror, &camera.chart, Some(view), limits).unwrap().mesh;
    let facets = face.triangles.len() as f64;
    let area = mirror.full_outline().area() / (pixel * pixel);
    let scene = Scene::new(face.into_panels());
    let (mut sums, mut count) = ([0.0; 2], 0.0);
    let asked = ToleranceSpec { samples: 400, ..spec(vec![fixed(Perturbation::TiltX, 1.0)], &[]) };
    for (point, _) in engine(design, asked).places() {
        let shown = |shift: [f64; 2]| {
            let q = point + DVec2::from_array(shift) * pixel;
            let ray: Ray = camera.ray(q, camera.chart.plane_mm + 50.0);
            let end = scene.trace(&ray);
            (end.outcome != Outcome::Missed).then_some(())?;
            let at = end.hit_point(&ray);
            let place = mirror.intersect_camera_ray(&camera.chart, q)?;
            // Beyond the ridge it sees another panel.
            (mirror.reflects(place)
                == mirror.reflects(mirror.intersect_camera_ray(&camera.chart, point)?))
            .then_some(())?;
            let row = mirror.row(place.y).at(place.x);
            let smooth = reflect(ray.direction, mirror.normal(place, &row));
            Some(
                (view.image_of(at, end.direction, point) - view.image_of(at, smooth, point))
                    / pixel,
            )
        };
        let all: Option<Vec<DVec2>> = shifts().map(shown).collect();
        let Some(all) = all else { continue };
        let per = 1.0 / all.len() as f64;
        sums[0] += (per * all.iter().sum::<DVec2>()).length_squared();
        sums[1] += per * all.iter().map(|d| d.length_squared()).sum::<f64>();
        count += 1.0;
    }
    assert!(count > 300.0, "{count}");
    let [mean, points] = sums.map(|sum: f64| (sum / count).sqrt());
    [mean, points, facets / area]
}

/// Real meshes of three mirrors: points move by half the bound, pixels by far less where facets are finer.
#[test]
#[ignore = "long: .ci/nightly"]
fn facets_finer_than_pixels_average_out() {
    let designs =
        [designed(&shipped("conquistador")), designed(&shipped("parabolic")), designed(&webcam())];
    for design in &designs {
        for limit in share(4, 1, [0.5, 1.0, 2.0, 4.0]) {
            let [mean, points, density] = by_facets(design, limit);
            assert!((points / limit - 0.5).abs() < 0.12, "{limit}: {points}");
            assert!((facets_bound(density) / limit - 1.0).abs() < 0.25, "{limit}: {density}");
            let ratio = facets_displace(limit) / mean;
            assert!((0.7..2.0).contains(&ratio), "{limit}: {mean}, {ratio}");
        }
    }
}

/// Cusps of 2 nm displace by nothing and blur by nothing, though their slopes turn rays by pixels.
#[test]
fn cusps_far_below_the_wavelength_scatter_and_turn_no_rays() {
    let design = designed(&shipped("conical"));
    let mut asked = spec(vec![fixed(Perturbation::Stepover, 0.005)], &[]);
    asked.texture.ball_radius_mm = 1.0;
    let source = asked.sources[0];
    let engine = engine(&design, asked);
    let by_points = engine.pointwise().mean_square(&source).sqrt();
    let moved = engine.mean_square(&source).sqrt();
    let spread = engine.blur_and_scatter(&source);
    assert!(by_points > 0.5, "{by_points}");
    assert!(moved < 0.01 && spread.blur_px < 0.1, "{moved} {spread:?}");
    assert!(spread.scattered > 1e-5 && spread.scattered < 2e-3, "{spread:?}");
}

/// A print as it comes reflects upwards; sanded it does not.
#[test]
fn terraces_of_a_print_show_something_else() {
    let design = designed(&shipped("conquistador"));
    let engine = engine(&design, spec(vec![fixed(Perturbation::Layers, 50.0)], &[]));
    let stream = RandomStream { seed: 1, trial: 0 };
    let made = engine.make(&[(Perturbation::Layers, 50.0)], stream);
    let linear = engine.linear_displacement(&made);
    assert!(square(&linear).sqrt() > 100.0);
    let (before, ..) = engine.compensate(engine.displacements(&[made]).remove(0));
    assert!(!(before.rms_px < 100.0), "{before:?}");
    // Layers far below the wavelength do little.
    let fine = engine.mean_square(&fixed(Perturbation::Layers, 1e-4));
    assert!(fine.sqrt() < 0.1, "{fine}");
}
