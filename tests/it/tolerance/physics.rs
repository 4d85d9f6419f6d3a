//! The perturbed system against closed forms, central differences and rays traced by hand.

use super::{engine, fixed, spec, usual, with_map};
use crate::support::{designed, profile, shipped};
use morion::internals::design::Design;
use morion::internals::geom::{BicubicSpline, DVec2, DVec3, GridAxis};
use morion::internals::machining::{BallRaster, SurfaceAnalysis};
use morion::internals::num::random::RandomStream;
use morion::internals::num::{cos, radians, sin};
use morion::internals::optics::reflect;
use morion::internals::tolerance::{
    Compensator, Engine, Perturbation, Process, ProcessPreset, ToleranceSpec, ripple_slope,
};

const STREAM: RandomStream = RandomStream { seed: 5, trial: 2 };

fn designs() -> Vec<(&'static str, Design)> {
    let names = ["conquistador", "conformal", "hyperbolic", "conical", "plane"];
    names.map(|name| (name, designed(&shipped(name)))).into()
}

fn precise() -> Process {
    Process::of(ProcessPreset::PrecisionCnc)
}

/// Displacement of `values`, made and by first derivatives.
fn both(engine: &Engine, values: &[(Perturbation, f64)]) -> [Vec<f64>; 2] {
    let made = engine.make(values, STREAM);
    let full = engine.displacements(std::slice::from_ref(&made)).remove(0);
    [full, engine.linear_displacement(&made)]
}

fn length(field: &[f64]) -> f64 {
    field.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[test]
fn derivatives_agree_with_central_differences() {
    for (name, design) in designs() {
        let mut sources = usual(&design, precise());
        sources.push(fixed(Perturbation::Coma, 500.0));
        let engine = engine(&design, spec(sources.clone(), &[]));
        for source in sources {
            // Facets are drawn, and displace by what is drawn; tracks have a test of their own.
            if source.kind == Perturbation::Facets {
                let [full, linear] = both(&engine, &[(Perturbation::Facets, 0.5)]);
                assert!(full == linear && length(&full) > 0.0);
                continue;
            }
            if source.kind == Perturbation::Stepover {
                continue;
            }
            // By Richardson, of eighth order.
            let h = if source.kind == Perturbation::Waviness { 2e-2 } else { 5e-2 } * source.limit;
            let difference = |h: f64| -> Vec<f64> {
                let [up, _] = both(&engine, &[(source.kind, h)]);
                let [down, _] = both(&engine, &[(source.kind, -h)]);
                up.iter().zip(&down).map(|(a, b)| (a - b) / (2.0 * h)).collect()
            };
            let mut rows: Vec<Vec<f64>> =
                [8.0, 4.0, 2.0, 1.0].map(|times| difference(times * h)).into();
            for power in [4.0, 16.0, 64.0] {
                let finer = |pair: &[Vec<f64>]| -> Vec<f64> {
                    let all = pair[0].iter().zip(&pair[1]);
                    all.map(|(coarse, fine)| (power * fine - coarse) / (power - 1.0)).collect()
                };
                rows = rows.windows(2).map(finer).collect();
            }
            let [_, linear] = both(&engine, &[(source.kind, h)]);
            let exact: Vec<f64> = linear.iter().map(|x| x / h).collect();
            let off: Vec<f64> = exact.iter().zip(&rows[0]).map(|(a, b)| a - b).collect();
            // What is symmetric about the axis does not feel being turned; 1e-11 px are rounding.
            assert!(
                length(&off) <= 1e-9 * length(&exact) + 1e-11 / h,
                "{name} {:?}: {:e}",
                source.kind,
                length(&off) / length(&exact)
            );
        }
    }
}

/// The finer the tracks, the nearer the full trace is to the derivative by their slope: what remains
/// is of second order.
#[test]
fn fine_tracks_displace_by_the_derivative() {
    for (name, design) in designs() {
        let asked = spec(vec![fixed(Perturbation::Stepover, 0.02)], &[]);
        let engine = engine(&design, asked).pointwise();
        let remains = [1e-2, 1e-3, 1e-4].map(|stepover| {
            let [full, linear] = both(&engine, &[(Perturbation::Stepover, stepover)]);
            let off: Vec<f64> = full.iter().zip(&linear).map(|(a, b)| a - b).collect();
            assert!(length(&linear) > 0.0);
            length(&off) / length(&linear)
        });
        assert!(remains[0] < 0.1 && remains[2] < 1e-3, "{name}: {remains:?}");
        assert!(remains.windows(2).all(|pair| pair[1] < 0.2 * pair[0]), "{name}: {remains:?}");
    }
}

/// Every error at once, by rays and vectors: the mirror is moved, not the ray, and its surface is
/// evaluated in full.
#[test]
fn a_perturbed_picture_is_that_of_rays_traced_by_hand() {
    for (name, design) in designs() {
        let engine = engine(&design, spec(usual(&design, precise()), &[]));
        let telecentric = design.camera.chart.vergence == 0.0;
        let values = [
            (Perturbation::DecentreX, 40.0),
            (Perturbation::DecentreY, -30.0),
            (Perturbation::Despace, 60.0),
            (Perturbation::TiltX, 0.8),
            (Perturbation::TiltY, -0.5),
            (Perturbation::Clocking, 1.1),
            (Perturbation::Scale, 150.0),
            (Perturbation::Magnification, -400.0),
            (Perturbation::PrincipalX, 0.7),
            (Perturbation::PrincipalY, -0.4),
            (Perturbation::Distortion, 300.0),
            (Perturbation::Coma, 600.0),
            (Perturbation::Telecentricity, if telecentric { 0.9 } else { 0.0 }),
        ];
        let [found, _] = both(&engine, &values);
        let Design { mirror, camera, .. } = &design;
        let view = design.view.as_ref().unwrap();
        let turned = |v: DVec3| {
            let about = |v: DVec3, axis: DVec3, mrad: f64| {
                let a = 1e-3 * mrad;
                v * cos(a) + axis.cross(v) * sin(a) + axis * axis.dot(v) * (1.0 - cos(a))
            };
            about(about(about(v, DVec3::X, 0.8), DVec3::Y, -0.5), DVec3::Z, 1.1)
        };
        let world = |p: DVec3| turned(p * 1.00015) + DVec3::new(0.04, -0.03, 0.06);
        let half_width = 0.5 * camera.pixel_mm * f64::from(camera.pixels[0]);
        for (k, (point, content)) in engine.places().enumerate() {
            let far = point.length_squared() / (half_width * half_width);
            let (x, y) = (point.x, point.y);
            let coma = DVec2::new(3.0 * x * x + y * y, 2.0 * x * y) * (2e-4 / half_width);
            let q =
                point * (1.0 - 4e-4 + 3e-4 * far) + coma + DVec2::new(0.7, -0.4) * camera.pixel_mm;
            let mut ray = camera.ray(q, camera.chart.plane_mm);
            if telecentric {
                ray.direction = (point * 9e-4 / half_width).extend(-1.0).normalize();
            }
            // Chart coordinates of the mirror's point on the ray: Newton by differences.
            let mut at = mirror.intersect_camera_ray(&camera.chart, point).unwrap();
            let surface = |at: DVec2| world(mirror.position(at, &mirror.row(at.y).at(at.x)));
            let across = [ray.direction.any_orthonormal_vector()];
            let across = [across[0], ray.direction.cross(across[0])];
            let off = |at: DVec2| {
                let way = surface(at) - ray.origin;
                DVec2::new(way.dot(across[0]), way.dot(across[1]))
            };
            for _ in 0..12 {
                let (h, f) = (1e-5, off(at));
                let [dx, dy] =
                    [DVec2::X, DVec2::Y].map(|e| (off(at + e * h) - off(at - e * h)) / (2.0 * h));
                let det = dx.x * dy.y - dx.y * dy.x;
                at -= DVec2::new(f.x * dy.y - f.y * dy.x, f.y * dx.x - f.x * dx.y) / det;
            }
            let normal = turned(mirror.normal(at, &mirror.row(at.y).at(at.x)));
            let hit = surface(at);
            let seen = view.image_of(hit, reflect(ray.direction, normal), point);
            let exact = (seen - content) / camera.pixel_mm;
            let found = DVec2::new(found[2 * k], found[2 * k + 1]);
            assert!((found - exact).length() < 1e-8, "{name} {point}: {found} {exact}");
        }
    }
}

/// What a pixel sees through a lens with coma, another sees through one without, of a sensor shifted by
/// p (3 x^2 + y^2, 2 x y); by first derivatives too.
#[test]
fn coma_displaces_each_pixel_as_a_shift_of_the_sensor_by_its_closed_form() {
    for (name, design) in designs() {
        let engine = engine(&design, spec(vec![fixed(Perturbation::Coma, 800.0)], &[]));
        let pixel = design.camera.pixel_mm;
        let half_width = 0.5 * pixel * f64::from(design.camera.pixels[0]);
        let [full, linear] = both(&engine, &[(Perturbation::Coma, 800.0)]);
        let [full_x, linear_x] = both(&engine, &[(Perturbation::PrincipalX, 1.0)]);
        let [_, linear_y] = both(&engine, &[(Perturbation::PrincipalY, 1.0)]);
        assert!(length(&full) > 0.0 && length(&full_x) > 0.0);
        for (k, (point, _)) in engine.places().enumerate().step_by(10) {
            let (x, y) = (point.x, point.y);
            let p = 8e-4 / (3.0 * half_width);
            let [shift_x, shift_y] =
                [p * (3.0 * x * x + y * y), p * 2.0 * x * y].map(|mm| mm / pixel);
            let shift = [(Perturbation::PrincipalX, shift_x), (Perturbation::PrincipalY, shift_y)];
            let [shifted, _] = both(&engine, &shift);
            for i in [2 * k, 2 * k + 1] {
                assert!((full[i] - shifted[i]).abs() < 1e-9, "{name} {point}");
                let by_shift = linear_x[i] * shift_x + linear_y[i] * shift_y;
                assert!((linear[i] - by_shift).abs() < 1e-10, "{name} {point}");
            }
        }
    }
}

/// A flat mirror that shows a strip through a telecentric camera: tilting it about X by a turns
/// what each pixel sees by 2a in elevation at azimuth 0.
#[test]
fn a_tilt_turns_the_ray_twice() {
    // Z = -Y at 45 degrees looks along Y towards the horizon.
    let given = profile(&[
        ("method.vector-field.degree = 12", "mirror.polynomial.terms = [[0, 1, -1.0]]"),
        ("azimuth_deg = [-180, 180]", "azimuth_deg = [-10, 10]"),
        ("width_mm = 60", "width_mm = 6"),
        ("projection.cylindrical", "projection.mercator"),
    ]);
    let design = designed(&given);
    let engine = engine(&design, spec(vec![fixed(Perturbation::TiltX, 1.0)], &[]));
    // A radian of azimuth is 6 mm / 20 degrees; mercator's z is the isometric latitude.
    let scale = 6.0 / radians(20.0) / design.camera.pixel_mm;
    for mrad in [0.3, 1.0, 5.0, -20.0] {
        let [found, _] = both(&engine, &[(Perturbation::TiltX, mrad)]);
        let angle = 2e-3 * mrad;
        // tan e = sinh z.
        let exact = scale * morion::internals::num::asinh(morion::internals::num::tan(angle));
        for d in found.chunks_exact(2) {
            assert!(d[0].abs() < 1e-7 * scale, "{d:?}");
            assert!((d[1].abs() / exact.abs() - 1.0).abs() < 1e-8, "{mrad}: {d:?} {exact}");
        }
    }
}

/// Ripples and tracks turn rays by twice their slope: on a flat mirror at 45 degrees the
/// displacement is 2 / (1 + 1) times the slope along Y in radians of elevation.
#[test]
fn textures_displace_by_their_rms_slope() {
    let given = profile(&[
        ("method.vector-field.degree = 12", "mirror.polynomial.terms = [[0, 1, -1.0]]"),
        ("azimuth_deg = [-180, 180]", "azimuth_deg = [-10, 10]"),
        ("width_mm = 60", "width_mm = 6"),
        ("projection.cylindrical", "projection.mercator"),
    ]);
    let design = designed(&given);
    let texture = precise().texture;
    let scale = 6.0 / radians(20.0) / design.camera.pixel_mm;
    let rms = |kind: Perturbation, limit: f64| {
        let engine = engine(&design, spec(vec![fixed(kind, limit)], &[])).pointwise();
        let made: Vec<_> = (0..300)
            .map(|trial| engine.make(&[(kind, limit)], RandomStream { seed: 1, trial }))
            .collect();
        let all = engine.displacements(&made).concat();
        let rms = (all.iter().map(|x| x * x).sum::<f64>() / (0.5 * all.len() as f64)).sqrt();
        let predicted = engine.variance(&fixed(kind, limit)).sqrt();
        (rms / scale, predicted / scale)
    };
    let (ripple, predicted) = rms(Perturbation::Waviness, 0.1);
    let exact = ripple_slope(0.1e-3, texture.waviness_period_mm);
    assert!((predicted / exact - 1.0).abs() < 0.01, "{predicted} {exact}");
    assert!((ripple / exact - 1.0).abs() < 0.06, "{ripple} {exact}");
    let (tracks, predicted) = rms(Perturbation::Stepover, 0.02);
    // On ground that slopes by 45 degrees across the tracks these are sqrt 2 times as far apart, and
    // their slope against it is 2 times as much along Z.
    let exact = 8f64.sqrt() * 0.02 / (12.0f64.sqrt() * texture.ball_radius_mm);
    assert!((predicted / exact - 1.0).abs() < 1e-4, "{predicted} {exact}");
    assert!((tracks / exact - 1.0).abs() < 0.06, "{tracks} {exact}");
    // An isotropic slope: both directions turn the ray alike.
    let (random, predicted) = rms(Perturbation::Slope, 0.2);
    assert!((predicted / 0.2e-3 - 1.0).abs() < 1e-3, "{predicted}");
    assert!((random / 0.2e-3 - 1.0).abs() < 0.06, "{random}");
}

/// Tool tracks move the picture as machining foresees, on slopes and on curved ground.
#[test]
fn tracks_displace_as_scallops_do() {
    for name in ["conquistador", "panoramic", "hyperbolic", "plane"] {
        let design = designed(&shipped(name));
        let texture = precise().texture;
        let stepover_mm = 0.02;
        let source = fixed(Perturbation::Stepover, stepover_mm);
        let asked = ToleranceSpec { samples: 2000, ..spec(vec![source], &[]) };
        let found = engine(&design, asked).pointwise().variance(&source).sqrt();
        let survey = SurfaceAnalysis::new(&design.mirror, &design.camera, design.view.as_ref());
        // Tracks that follow each other along Y run along X.
        let raster = BallRaster { ball_mm: texture.ball_radius_mm, stepover_mm, angle: 0.0 };
        let foreseen = survey.figures(&raster).unwrap().unwrap().pixel_error_px.unwrap().rms;
        // (The samples stay away from the rim, where scallops do most.)
        assert!((0.9..1.02).contains(&(found / foreseen)), "{name}: {found} {foreseen}");
    }
}

/// Where the picture is what the projection asks for, a shift and a larger picture are just that.
#[test]
fn adjustments_undo_what_they_can() {
    let design = designed(&shipped("conformal"));
    let all = [Compensator::Shift, Compensator::Rotation, Compensator::Magnification];
    let engine = engine(&design, spec(usual(&design, precise()), &all));
    for (kind, limit, exact) in [
        (Perturbation::PrincipalX, 1.0, [-1.0, 0.0, 0.0, 0.0]),
        (Perturbation::PrincipalY, 1.0, [0.0, -1.0, 0.0, 0.0]),
        (Perturbation::Magnification, 500.0, [0.0, 0.0, 0.0, -500.0]),
    ] {
        let [displacement, _] = both(&engine, &[(kind, limit)]);
        let (before, after, steps) = engine.compensate(displacement);
        assert!(after.rms_px < 1e-6 * before.rms_px, "{kind:?} {before:?} {after:?}");
        for (step, exact) in steps.iter().zip(exact) {
            assert!((step - exact).abs() < 1e-6 * limit, "{kind:?} {steps:?}");
        }
    }
}

/// A map of a tilted plane is a tilt; one of a Legendre term is that form error.
#[test]
fn a_measured_map_acts_as_what_it_holds() {
    let design = designed(&shipped("conquistador"));
    let knots = |reach: f64| GridAxis { first_mm: -reach, step_mm: reach / 20.0, count: 41 };
    let (x, y) = (knots(32.0), knots(24.0));
    let heights: Vec<f64> = (0..41 * 41)
        .map(|k| {
            let u = (x.at(k % 41)) / 30.0;
            1e-3 * (1.5 * u * u - 0.5) / 1.5
        })
        .collect();
    let map = BicubicSpline::new(x, y, &heights).unwrap();
    let sources = vec![fixed(Perturbation::Map, 1.0), fixed(Perturbation::Legendre20, 1.0)];
    let engine = engine(&design, with_map(spec(sources.clone(), &[]), map));
    let [mapped, by_map] = both(&engine, &[(Perturbation::Map, 1.0)]);
    let [term, by_term] = both(&engine, &[(Perturbation::Legendre20, 1.0)]);
    let off = |a: &[f64], b: &[f64]| {
        length(&a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<f64>>()) / length(b)
    };
    assert!(off(&mapped, &term) < 1e-9, "{}", off(&mapped, &term));
    assert!(off(&by_map, &by_term) < 1e-9, "{}", off(&by_map, &by_term));
    let [a, b] = [0, 1].map(|k| engine.mean_square(&sources[k]));
    assert!((a / b - 1.0).abs() < 1e-9);
}
