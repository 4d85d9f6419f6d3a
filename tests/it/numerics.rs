//! Numerics of the design: existence, optima, extremes, scales.

use crate::support::oracle::{self, Strip, Wish, World, gauss_grid, pinhole, shrink};
use crate::support::{builds::parsed, share, shipped_text, times};
use morion::internals::design::Design;
use morion::internals::geom::{DVec2, Rect};
use morion::internals::mirror::{HeightField, Surface};
use morion::internals::num::{hypot, sin};
use std::f64::consts::PI;

const FAR: f64 = f64::INFINITY;

#[test]
fn curl_of_the_papers_law_has_its_closed_form() {
    let design = Wish::panoramic("cylindrical", 6).made();
    let (reach, mut square, mut max) = (1.0 / 3.0f64.sqrt(), 0.0, 0.0f64);
    let curl = |y: f64, z: f64| {
        let e = shrink(z);
        (sin(y) * (e - e / hypot(1.0, z)) / (1.0 + e * e)).abs()
    };
    let area = Rect { min: DVec2::new(-PI, -reach), max: DVec2::new(PI, reach) };
    for (p, weight) in gauss_grid(area, 60) {
        square += weight * curl(p.x, p.y) * curl(p.x, p.y);
    }
    for k in 0..=10_000 {
        max = max.max(curl(0.5 * PI, reach * (f64::from(k) / 5e3 - 1.0)));
    }
    let found = design.facts.curl.unwrap();
    println!("{found:?} {max} {}", square.sqrt());
    assert!((found.rms / square.sqrt() - 1.0).abs() < 1e-6, "{found:?} {}", square.sqrt());
    assert!((found.max / max - 1.0).abs() < 1e-3, "{found:?} {max}");
    // Under a pinhole nothing is exact, not even Mercator's law; under parallel rays that one is.
    let mercator = Wish::panoramic("mercator", 6);
    assert!(mercator.made().facts.curl.unwrap().max <= 1e-12);
    let near = Wish { camera: pinhole(200.0), ..mercator };
    assert!(near.made().facts.curl.unwrap().max > 1e-3);
}

/// What is measured of a law that has a mirror is rounding, and known to be no more than that; what
/// is measured of one that has none is far more.
#[test]
fn a_curl_of_nothing_is_told_from_rounding_at_every_size() {
    for width_mm in [1e-3, 0.37, 60.0, 1e3, 1e6] {
        let far = |law| Wish { width_mm, ..Wish::panoramic(law, 6) };
        let near = |wish: Wish| Wish { camera: pinhole(2.5 * width_mm), ..wish };
        let about = |wish: Wish| wish.before(&World::Cylinder(1.5 * width_mm).key());
        let round = || {
            let law = "[projection.equiangular]\nouter_polar_deg = 110";
            Wish { width_mm, ..Wish::round(oracle::ORTHOGRAPHIC, law, 0.0, 16) }
        };
        // A land has a micrometre at least.
        let ring = || {
            let (law, width_mm) =
                ("inner_polar_deg = 60\nouter_polar_deg = 120", width_mm.max(4e-3));
            let camera = pinhole(2.5 * width_mm);
            let law = format!("[projection.cylinder]\n{law}");
            let ring = Wish { width_mm, ..Wish::round(&camera, &law, 0.25 * width_mm, 16) };
            ring.before(&World::Cylinder(1.5 * width_mm).key())
        };
        let curl = |wish: Wish| wish.made().facts.curl.unwrap();
        for (what, wish) in [
            ("Mercator", far("mercator")),
            ("round", round()),
            ("round, pinhole", near(round())),
            ("ring, pinhole, near", ring()),
        ] {
            let found = curl(wish);
            println!("{width_mm} {what}: {found:?}");
            assert!(found.rms <= found.max && found.max <= found.rounding, "{what}: {found:?}");
            // No more than a few hundred roundings, nor times what they came to.
            let ulp = f64::EPSILON * found.condition;
            assert!(found.rounding < 2e3 * ulp && found.condition < 10.0, "{what}: {found:?}");
            assert!(found.rounding < 2e3 * found.max, "{what}: {found:?}");
        }
        for (what, wish) in [
            ("cylindrical", far("cylindrical")),
            ("equal area", far("equal-area")),
            ("Mercator, pinhole", near(far("mercator"))),
            ("Mercator, near", about(far("mercator"))),
        ] {
            let found = curl(wish);
            println!("{width_mm} {what}: {found:?}");
            assert!(found.max > 1e9 * found.rounding && found.rounding > 0.0, "{what}: {found:?}");
        }
    }
}

#[test]
#[ignore = "long: .ci/nightly"]
fn more_degrees_never_leave_more_and_the_problem_stays_well_conditioned() {
    for wish in [Wish::panoramic("cylindrical", 0), Wish::conquistador("cylindrical", 0)] {
        let mut last = f64::INFINITY;
        for degree in share(3, 0, [2, 3, 5, 8, 12, 16, 20, 24, 32, 40]) {
            let facts = Wish { degree, ..wish.clone() }.made().facts;
            let residual = facts.gradient_residual.unwrap();
            println!("{degree} {residual:e} {:?} {}", facts.condition, facts.steps);
            assert!(residual <= last * (1.0 + 1e-12), "{degree}: {residual:e} after {last:e}");
            assert!(facts.condition.unwrap() < 1e6, "{degree}: {:?}", facts.condition);
            assert_eq!(facts.steps, 1);
            last = residual;
        }
    }
}

fn extreme(law: &str, azimuth_deg: [f64; 2], elevation_deg: [f64; 2]) -> Strip<'_> {
    Strip { law, azimuth_deg, elevation_deg, distance: FAR, target: World::Far }
}

/// An answer whose reported errors are right, or a typed error; never a number that is none.
#[track_caller]
fn right_or_refused(strip: &Strip, degree: usize) -> bool {
    let what = format!(
        "{} {:?} {:?} {} {:?} degree {degree}",
        strip.law, strip.azimuth_deg, strip.elevation_deg, strip.distance, strip.target
    );
    let design = match strip.wish(degree).design() {
        Ok(design) => design,
        Err(error) => {
            println!("{what}: {error}");
            assert!(!error.to_string().is_empty());
            return false;
        }
    };
    let own = strip.errors(&design, 100);
    let facts = &design.facts;
    let (ray, pixel) = (facts.ray_error_mrad.unwrap(), facts.pixel_error_px.unwrap());
    let condition = facts.condition.unwrap();
    println!("{what}: {own:?} {ray:?} {pixel:?} {condition:.3e} {}", facts.steps);
    assert!(condition < 1e6, "{what}: condition {condition:e}");
    // The image of a pole is a line, for some laws infinitely far: where it may be seen, errors jump
    // from place to place.
    let [low, high] = strip.elevation_deg;
    let to_pole = 1e3 * oracle::rad(90.0 - high.max(-low));
    let mut pairs = vec![(ray.rms, own.ray_mrad[0])];
    if ray.max < 1e3 {
        pairs.push((ray.max, own.ray_mrad[1]));
    }
    if ray.max < 0.5 * to_pole {
        pairs.extend([(pixel.rms, own.pixel_px[0]), (pixel.max, own.pixel_px[1])]);
    }
    for (found, exact) in pairs {
        // To the sampling, and to the rounding of steep mirrors.
        let off = (found - exact).abs();
        assert!(off <= 0.02 * exact + 1e-8, "{what}: {found} for {exact}");
    }
    true
}

#[test]
#[ignore = "long: .ci/nightly"]
fn long_and_steep_strips_are_right_or_refused() {
    let laws = ["cylindrical", "mercator", "equirectangular", "equal-area"];
    for (k, law) in laws.into_iter().enumerate() {
        for degree in share(2, k, [4, 16]) {
            // About 1 : 100 and 100 : 1.
            assert!(right_or_refused(&extreme(law, [-180.0, 180.0], [-1.0, 2.6]), degree));
            assert!(right_or_refused(&extreme(law, [10.0, 11.0], [-45.0, 50.0]), degree));
            right_or_refused(&extreme(law, [-180.0, 180.0], [-89.0, 89.0]), degree);
            right_or_refused(&extreme(law, [-180.0, 180.0], [-89.9, 89.9]), degree);
            right_or_refused(&extreme(law, [-30.0, 50.0], [80.0, 89.9]), degree);
            right_or_refused(&extreme(law, [-30.0, 50.0], [-89.9, -80.0]), degree);
        }
    }
}

#[test]
#[ignore = "long: .ci/nightly"]
fn near_targets_are_right_or_refused() {
    let mut answers = 0;
    for (k, law) in ["cylindrical", "mercator"].into_iter().enumerate() {
        for distance in share(2, k, [FAR, 150.0]) {
            let strip = Strip { distance, ..extreme(law, [-180.0, 180.0], [-30.0, 30.0]) };
            for radius in [30.0001, 30.6, 31.0, 33.0, 40.0, 60.0, 1e3, 1e6, 1e9, 1e12] {
                let target = World::Cylinder(radius);
                answers += u32::from(right_or_refused(&Strip { target, ..strip }, 8));
            }
            let strip = Strip { elevation_deg: [10.0, 60.0], ..strip };
            for height in [0.001, 1.0, 10.0, 30.0, 1e3, 1e6, 1e12] {
                let target = World::Plane(height);
                right_or_refused(&Strip { target, ..strip }, 8);
            }
        }
    }
    assert!(answers >= times(10, 20) as u32, "{answers}");
}

#[test]
#[ignore = "long: .ci/nightly"]
fn near_targets_of_round_mirrors_are_met_or_refused() {
    // The least radius, for a rim of 30 mm, at which the exact mirror is surely found.
    for (camera, least) in [(oracle::ORTHOGRAPHIC.into(), 30.5), (pinhole(100.0), 35.0)] {
        for law in share(2, 0, ["cylinder", "equi-areal", "equiangular"]) {
            let law = format!("[projection.{law}]\ninner_polar_deg = 60\nouter_polar_deg = 120");
            let wish = Wish::round(&camera, &law, 16.0, 30);
            for radius in [30.0001, 30.01, 30.5, 31.0, 35.0, 50.0, 1e3, 1e6, 1e9, 1e12] {
                let near = wish.clone().before(&format!("target_radius_mm = {radius:?}"));
                match near.design() {
                    Ok(design) => {
                        let facts = design.facts;
                        println!("{law} {radius}: {:?} {}", facts.ray_error_mrad, facts.steps);
                        assert!(facts.ray_error_mrad.unwrap().max.is_finite());
                        let limit = if radius < least { f64::INFINITY } else { 1e-2 };
                        assert!(facts.ray_error_mrad.unwrap().max < limit);
                    }
                    Err(error) => {
                        println!("{law} {radius}: {error}");
                        assert!(radius < least, "{law} {radius}: {error}");
                    }
                }
            }
        }
        let law = "[projection.plane]\nouter_polar_deg = 50";
        for height in [0.001, 1.0, 5.0, 8.0, 10.0, 20.0, 100.0, 1e6, 1e12] {
            let wish = Wish::round(&camera, law, 0.0, 30);
            match wish.before(&format!("target_plane_mm = {height:?}")).design() {
                Ok(design) => {
                    let ray = design.facts.ray_error_mrad.unwrap();
                    println!("plane {height}: {ray:?} {}", design.facts.steps);
                    assert!(ray.max.is_finite() && (height < 20.0 || ray.max < 1e-3));
                }
                Err(error) => {
                    println!("plane {height}: {error}");
                    assert!(height < 15.0, "{height}: {error}");
                }
            }
        }
    }
}

/// Coefficients per width, and every dimensionless figure.
fn figures(design: &Design, width_mm: f64) -> Vec<f64> {
    let (facts, mut all) = (&design.facts, Vec::new());
    match &design.mirror.surface {
        Surface::Tensor(sheet) => {
            let (rows, columns) = sheet.series.shape();
            for k in 0..rows * columns {
                let c = sheet.series.coefficient(k / columns, k % columns);
                all.push(c * sheet.scale_mm / width_mm);
            }
        }
        Surface::Radial(round) => {
            all.extend((1..9).map(|k| {
                let r = round.radius[0] + (round.radius[1] - round.radius[0]) * f64::from(k) / 9.0;
                round.at(DVec2::X * r).f / width_mm
            }));
        }
        given => panic!("{given:?} is not designed"),
    }
    let (ray, pixel) = (facts.ray_error_mrad.unwrap(), facts.pixel_error_px.unwrap());
    all.extend([ray.rms * 1e-3, ray.p95 * 1e-3, ray.max * 1e-3]);
    all.extend([pixel.rms, pixel.p95, pixel.max]);
    all.extend([facts.curl.unwrap().max, facts.gradient_residual.unwrap()]);
    all
}

#[test]
fn size_does_not_matter() {
    let law = "[projection.cylinder]\ninner_polar_deg = 60\nouter_polar_deg = 120";
    // Lengths double by doubling, so that the rounding of the panel's corners scales too.
    for times in share(2, 1, [1.0 / 8192.0, 1.0 / 64.0, 2.0, 16384.0]) {
        let scaled = |camera: Option<f64>, radius: Option<f64>, times: f64, wish: &Wish| {
            let camera = camera.map_or(oracle::ORTHOGRAPHIC.into(), |d| pinhole(d * times));
            let target = radius.map_or(World::Far, |r| World::Cylinder(r * times)).key();
            let inner = format!("inner_width_mm = {:?}", 16.0 * times);
            let layout = wish.layout.replace("inner_width_mm = 16.0", &inner);
            Wish { camera, layout, width_mm: 60.0 * times, ..wish.clone() }.before(&target).made()
        };
        let cases = [
            (None, None, Wish::panoramic("cylindrical", 10)),
            (None, Some(200.0), Wish::conquistador("equal-area", 8)),
            (Some(150.0), None, Wish::panoramic("mercator", 8)),
            (None, None, Wish { method: "distribution", ..Wish::panoramic("cylindrical", 6) }),
            (Some(100.0), None, Wish::round("", law, 16.0, 16)),
            (Some(100.0), Some(90.0), Wish::round("", law, 16.0, 16)),
        ];
        for (k, (camera, radius, wish)) in cases.into_iter().enumerate() {
            let plain = figures(&scaled(camera, radius, 1.0, &wish), 60.0);
            let other = figures(&scaled(camera, radius, times, &wish), 60.0 * times);
            let off = plain.iter().zip(&other).map(|(a, b)| (a - b).abs() / (1.0 + a.abs()));
            let off = off.fold(0.0, f64::max);
            println!("{k} {times}: {off:e}");
            assert!(off < 1e-12, "{k} {times}: {off:e}\n{plain:?}\n{other:?}");
        }
    }
    // Any other size too, but for the corners' rounding to single precision.
    let plain = figures(&Wish::panoramic("cylindrical", 10).made(), 60.0);
    for width_mm in [1e-3, 0.37, 1e6] {
        let wish = Wish { width_mm, ..Wish::panoramic("cylindrical", 10) };
        let other = figures(&wish.made(), width_mm);
        for (k, (a, b)) in plain.iter().zip(&other).enumerate() {
            // The 95th percentiles jump from sample to sample.
            let limit = match k {
                0..=120 => 1e-12,
                122 | 125 => 1e-3,
                _ => 1e-6,
            };
            assert!((a - b).abs() < limit * (1.0 + a.abs()), "{width_mm}: {k} {a} {b}");
        }
    }
}

#[test]
fn more_degrees_never_leave_more_of_round_mirrors() {
    for name in oracle::round() {
        let text = shipped_text(name);
        let at = text.find("degree = ").unwrap();
        let mut last = f64::INFINITY;
        for degree in [1, 2, 3, 5, 8, 12, 20, 30, 40] {
            let text = format!("{}degree = {degree} #{}", &text[..at], &text[at + 9..]);
            let facts = match morion::internals::design::design(&parsed(&text)) {
                Ok(design) => design.facts,
                Err(error) => {
                    // Coarse mirrors see what this law shows nowhere: inside of the centre.
                    assert!(degree < 5 && name == "area-proportional", "{error}");
                    continue;
                }
            };
            let (residual, condition) =
                (facts.gradient_residual.unwrap(), facts.condition.unwrap());
            println!("{} {degree}: {residual:e} {condition}", name);
            // The inner rim's place moves a little with the answer.
            assert!(residual <= last * 1.05 + 1e-25, "{} {degree}: {residual:e}", name);
            assert!(condition < 1e3, "{} {degree}: {condition:e}", name);
            last = residual;
        }
    }
}
