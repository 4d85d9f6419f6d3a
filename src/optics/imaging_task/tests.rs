use super::*;
use crate::num::{atan2, cos, radians, sin, wrap_turn};
use crate::optics::{
    RadialLawKind, ReflectedRay, RimConditions, ShownContent, Strip, StripLaw, reflect,
};

fn strip(law: StripLaw) -> Projection {
    Projection::Strip(Strip { law, scale_mm: 19.0, azimuth: 0.0, z: -0.589 })
}

fn ring() -> Projection {
    let rims =
        RimConditions { radius: [6.0, 31.0], psi: [50.0, 120.0].map(radians), vergence: 0.004 };
    Projection::Radial { law: rims.law(RadialLawKind::Equiangular), radius: rims.radius }
}

fn views() -> Vec<ImagingTask> {
    let targets = [Target::Infinity, Target::Cylinder { radius_mm: 70.0 }];
    let mut views = Vec::new();
    for target in targets {
        for law in [
            StripLaw::Cylindrical,
            StripLaw::Mercator,
            StripLaw::Equirectangular,
            StripLaw::EqualArea,
        ] {
            let fold = Some(Fold::Above);
            views.push(ImagingTask {
                projection: strip(law),
                target: target.clone(),
                origin_mm: 8.0,
                fold,
                picture: PictureMap::default(),
            });
        }
        views.push(ImagingTask {
            projection: ring(),
            target,
            origin_mm: 8.0,
            fold: None,
            picture: PictureMap::default(),
        });
    }
    let target = Target::Plane { height_mm: -300.0 };
    let rims =
        RimConditions { radius: [6.0, 31.0], psi: [110.0, 140.0].map(radians), vergence: 0.0 };
    let projection =
        Projection::Radial { law: rims.law(RadialLawKind::Cylinder), radius: rims.radius };
    views.push(ImagingTask {
        projection,
        target,
        origin_mm: 8.0,
        fold: None,
        picture: PictureMap::default(),
    });
    views
}

fn charts() -> [Chart; 2] {
    [0.0, 0.004].map(|vergence| Chart::on_axis(vergence, 10.0))
}

fn points() -> impl Iterator<Item = DVec2> {
    (0..100).map(|k| DVec2::new(f64::from(k % 10) * 4.1 - 20.0, f64::from(k / 10) * 1.1 + 6.5))
}

/// Of rays near and far from what is wanted, on both panels, some of which are found side by side and some alone.
#[test]
fn content_beside_what_is_wanted_is_where_it_is_found_alone() {
    for view in views() {
        for side in [1.0, -1.0] {
            let images = points().map(|q| q * DVec2::new(1.0, side));
            let rays: Vec<(ReflectedRay, ShownContent)> = images
                .enumerate()
                .map(|(k, near)| {
                    let at = DVec3::new(0.3 * near.x, 0.2 * near.y, 4.0);
                    let wanted = view.wanted((near, view.turn(near.x)), view.rise(near.y));
                    let off = if k < 40 { 1e-6 } else { [1e-9, 1e-4, 1e-2, 0.1][k % 4] };
                    let along = view.direction_to(&wanted, at) + DVec3::new(off, -off, 0.3 * off);
                    let (direction, turn) = (along.normalize(), view.turn(near.x));
                    (ReflectedRay { at, direction, near, turn }, wanted)
                })
                .collect();
            let first: &[(ReflectedRay, ShownContent); 4] = rays.first_chunk().unwrap();
            let mut shown = first.map(|(ray, _)| view.shown(ray.at, ray.direction, ray.near));
            let is_short =
                matches!(&view.projection, Projection::Strip(strip) if strip.law.has_steps());
            assert_eq!(view.place_beside(&mut shown, first), is_short);
            for count in [100, 97, 1] {
                let beside = view.shown_beside(&rays[..count]);
                for ((ray, _), beside) in rays.iter().zip(&beside) {
                    let alone = view.image_of(ray.at, ray.direction, ray.near);
                    assert!((beside.image - alone).length() < 2e-13, "{alone} {beside:?}");
                }
                assert_eq!(beside.len(), count);
            }
        }
    }
}

#[test]
fn a_mirror_along_the_field_shows_what_is_wanted() {
    for view in views() {
        for chart in charts() {
            for q in points() {
                let f = 0.03 * q.x;
                let at = chart.point(q, f);
                let s = view.field(&chart, q.to_array(), f);
                let p = chart.slope(q.to_array(), s);
                // By vectors.
                let normal = DVec3::new(-p[0], -p[1], 1.0);
                let seen = reflect(chart.ray(q, 99.0).direction, normal);
                assert!((seen - view.direction_of(q, at)).length() < 1e-13, "{view:?} {q}");
                let content =
                    view.image_of_seen(&chart, at.to_array(), p, q + DVec2::new(1.5, 0.0));
                assert!((DVec2::from_array(content) - q).length() < 1e-11, "{view:?} {q}");
                assert!((view.image_of(at, seen, q) - q).length() < 1e-11, "{view:?} {q}");
            }
        }
    }
}

#[test]
fn curl_is_that_of_w_itself() {
    for view in views() {
        for chart in charts() {
            let w = |r: DVec3| {
                let (q, _) = chart.coordinates(r);
                view.direction_of(q, r) - chart.ray(q, 99.0).direction
            };
            for q in points().step_by(7) {
                let f = 0.03 * q.x;
                let r = chart.point(q, f);
                let h = 1e-4;
                let d = |e: DVec3| (w(r + e * h) - w(r - e * h)) / (2.0 * h);
                let (dx, dy, dz) = (d(DVec3::X), d(DVec3::Y), d(DVec3::Z));
                let curl = DVec3::new(dy.z - dz.y, dz.x - dx.z, dx.y - dy.x);
                let exact = w(r).dot(curl) / w(r).length_squared();
                let found = view.curl(&chart, q, f);
                assert!((found - exact).abs() < 1e-8, "{view:?} {q}: {found} {exact}");
            }
        }
    }
}

#[test]
fn curl_vanishes_where_a_mirror_exists() {
    let chart = Chart::on_axis(0.0, 0.0);
    let exact = |projection, target| ImagingTask {
        projection,
        target,
        origin_mm: 3.0,
        fold: None,
        picture: PictureMap::default(),
    };
    let cylinder = Target::Cylinder { radius_mm: 70.0 };
    for q in points() {
        let mercator = exact(strip(StripLaw::Mercator), Target::Infinity);
        assert!(mercator.curl(&chart, q, 0.0).abs() < 1e-16);
        for target in [Target::Infinity, cylinder.clone()] {
            for chart in charts() {
                assert!(exact(ring(), target.clone()).curl(&chart, q, 1.0).abs() < 1e-16);
            }
        }
    }
    let q = DVec2::new(12.0, 9.0);
    assert!(exact(strip(StripLaw::Cylindrical), cylinder).curl(&chart, q, 0.0).abs() > 1e-5);
}

/// Under parallel rays and far away, with azimuth a and elevation e, it is sin a (e' - cos e) / 2.
#[test]
fn bounds_of_the_curl_hold_its_closed_form_and_are_near_it() {
    let chart = Chart::on_axis(0.0, 0.0);
    for scale_mm in [1e-4, 0.3, 19.0, 1e6] {
        for law in [
            StripLaw::Cylindrical,
            StripLaw::Mercator,
            StripLaw::Equirectangular,
            StripLaw::EqualArea,
        ] {
            let strip = Strip { law: law.clone(), scale_mm, azimuth: 0.1, z: 0.0 };
            let projection = Projection::Strip(strip);
            let view = ImagingTask {
                projection,
                target: Target::Infinity,
                origin_mm: 0.0,
                fold: None,
                picture: PictureMap::default(),
            };
            for k in 0..400 {
                let (x, z) = (f64::from(k % 20) * 0.3 - 3.0, f64::from(k / 20) * 0.05 - 0.5);
                let q = DVec2::new(x, z) * scale_mm;
                // cos e and de/dz, z being what the law makes of it.
                let z = q.y / scale_mm;
                let (c, slope) = match law {
                    StripLaw::Cylindrical => (1.0 / (1.0 + z * z).sqrt(), 1.0 / (1.0 + z * z)),
                    StripLaw::Mercator => (0.0, 0.0),
                    StripLaw::Equirectangular => (cos(z), 1.0),
                    _ => ((1.0 - z * z).sqrt(), 1.0 / (1.0 - z * z).sqrt()),
                };
                let exact = 0.5 * sin(q.x / scale_mm + 0.1) * (slope - c) / scale_mm;
                let CurlBounds { range, condition } = view.curl_bounds(&chart, q, 0.0);
                let ulp = f64::EPSILON * condition;
                let room = Interval::new(range.lo - 2.0 * ulp, range.hi + 2.0 * ulp);
                assert!(room.contains(exact), "{law:?} {q}: {exact:e} {range:?}");
                assert!(range.contains(exact) || law != StripLaw::Mercator, "{q}: {range:?}");
                assert!(range.contains(view.curl(&chart, q, 0.0)), "{law:?} {q}: {range:?}");
                assert!(range.width() < 100.0 * ulp, "{law:?} {q}: {range:?} {ulp:e}");
            }
        }
    }
}

#[test]
fn bounds_of_the_curl_tell_exact_mirrors_from_others() {
    let mut most = 0.0f64;
    for target in [Target::Infinity, Target::Cylinder { radius_mm: 70.0 }] {
        for chart in charts() {
            for q in points() {
                let mut of = |projection| {
                    let view = ImagingTask {
                        projection,
                        target: target.clone(),
                        origin_mm: 3.0,
                        fold: None,
                        picture: PictureMap::default(),
                    };
                    let CurlBounds { range, condition } = view.curl_bounds(&chart, q, 1.0);
                    let ulps = range.width() / (f64::EPSILON * condition);
                    most = most.max(ulps);
                    assert!(ulps < 1e4, "{view:?} {q}: {ulps}");
                    range
                };
                assert!(of(ring()).contains(0.0), "{target:?} {chart:?} {q}");
                let turned = q.x.abs() > 1.0;
                let other = of(strip(StripLaw::Cylindrical));
                assert!(!turned || !other.contains(0.0), "{target:?} {chart:?} {q} {other:?}");
            }
        }
    }
    println!("{most:.0} roundings at most");
}

#[test]
fn the_folded_half_sees_the_other_half_turn_upside_down() {
    let view = &views()[0];
    let (above, below) = (DVec2::new(-7.0, 20.0), DVec2::new(-7.0, -20.0));
    let angle = |d: DVec3| atan2(d.x, d.y);
    let [up, down] = [above, below].map(|q| view.direction_of(q, DVec3::ZERO));
    assert!((wrap_turn(angle(up) + angle(down) - radians(180.0))).abs() < 1e-12);
    assert_eq!(up.z, down.z);
}
