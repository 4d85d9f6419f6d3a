//! Closed forms, round trips, and lenses that fold over.

use super::radial_map::solved;
use super::*;
use crate::num::sample::Draws;
use crate::num::{Interval, acos, atan, cos, exp, hypot, log};
use std::f64::consts::{FRAC_PI_2, PI};

fn radial(k1: f64) -> Distortion {
    let radial = [k1, 0.0, 0.0, 0.0, 0.0, 0.0];
    Distortion::BrownConrady { radial, tangential: [0.0; 2], prism: [0.0; 4] }
}

/// Root of r (1 + k1 r^2) = d on the branch of 0, by Cardano's formula; k1 < 0 in the case of three roots.
fn cardano(k1: f64, d: f64) -> f64 {
    // r^3 + p r + q = 0.
    let (p, q) = (1.0 / k1, -d / k1);
    if k1 > 0.0 {
        let root = f64::sqrt(0.25 * q * q + p * p * p / 27.0);
        let cube = |x: f64| x.signum() * exp(log(x.abs()) / 3.0);
        return cube(-0.5 * q + root) + cube(-0.5 * q - root);
    }
    let m = 2.0 * f64::sqrt(-p / 3.0);
    let angle = acos(3.0 * q / (p * m)) / 3.0;
    m * cos(angle - 2.0 * PI / 3.0)
}

fn radius([x, y]: [f64; 2]) -> f64 {
    hypot(x, y)
}

fn at(radius: f64, turn: f64) -> [f64; 2] {
    [radius * cos(turn), radius * crate::num::sin(turn)]
}

/// Random coefficients of all terms, as large as those of lenses of 60 to 150 degrees.
fn lenses() -> Vec<Distortion> {
    let mut draws = Draws::new(7);
    let mut sized = |size: f64| draws.inside([-size, size]);
    let brown = |sized: &mut dyn FnMut(f64) -> f64| Distortion::BrownConrady {
        radial: [0.4, 0.2, 0.1, 0.2, 0.1, 0.02].map(&mut *sized),
        tangential: [0.01; 2].map(&mut *sized),
        prism: [0.01; 4].map(&mut *sized),
    };
    let fisheye = |sized: &mut dyn FnMut(f64) -> f64| Distortion::KannalaBrandt {
        radial: [0.1, 0.03, 0.01, 0.003].map(&mut *sized),
    };
    (0..200).map(|k| if k % 2 == 0 { brown(&mut sized) } else { fisheye(&mut sized) }).collect()
}

#[test]
fn one_radial_coefficient_is_inverted_as_by_cardano() {
    for k1 in [-0.4, -0.1, -0.01, 0.02, 0.5, 3.0] {
        let lens = radial(k1);
        // Up to a fold, if there is one.
        let most = if k1 < 0.0 { 2.0 / 3.0 * f64::sqrt(-1.0 / (3.0 * k1)) } else { 4.0 };
        for k in 1..100 {
            let d = 0.01 * f64::from(k) * most;
            let found = lens.undistorted(at(d, 0.1 * f64::from(k))).unwrap();
            let exact = cardano(k1, d);
            // Near the fold, rounding is divided by the slope.
            let slope = 1.0 + 3.0 * k1 * exact * exact;
            assert!(
                (radius(found) - exact).abs() < 1e-14 * (1.0 + exact) / slope.min(1.0),
                "{k1} {d}"
            );
        }
    }
}

#[test]
fn a_fisheye_without_coefficients_shows_angles() {
    let lens = Distortion::KannalaBrandt { radial: [0.0; 4] };
    for k in 0..80 {
        let (r, turn) = (0.2 * f64::from(k), f64::from(k));
        assert!((radius(lens.distorted(at(r, turn))) - atan(r)).abs() < 1e-15 * (1.0 + r));
        let found = lens.undistorted(at(atan(r), turn)).unwrap();
        assert!((radius(found) - r).abs() < 1e-15 * (1.0 + r * r) * 4.0, "{r}");
    }
    let fault = lens.undistorted(at(1.56, 1.0)).unwrap_err();
    assert!(
        matches!(fault, DistortionFault::Aside { angle_deg } if (angle_deg - 89.38).abs() < 0.01)
    );
}

#[test]
fn without_distortion_points_stay() {
    let p = [0.7, -1.3];
    assert_eq!(Distortion::None.distorted(p), p);
    assert_eq!(Distortion::None.undistorted(p), Ok(p));
    assert!((crate::num::tan(MOST_ANGLE) / MOST_TANGENT - 1.0).abs() < 1e-14);
    assert!(matches!(
        Distortion::None.undistorted([60.0, 0.0]),
        Err(DistortionFault::Aside { .. })
    ));
}

#[test]
fn undistorted_points_are_distorted_to_where_they_came_from() {
    let (mut done, mut folded) = (0, 0);
    for lens in lenses() {
        for k in 0..200 {
            let p = at(0.006 * f64::from(k), 0.7 * f64::from(k));
            let Ok(q) = lens.undistorted(p) else {
                folded += 1;
                continue;
            };
            let back = lens.distorted(q);
            assert!(radius([back[0] - p[0], back[1] - p[1]]) < 1e-14, "{lens:?} {p:?} {back:?}");
            done += 1;
        }
    }
    assert!(done > 30_000 && folded > 100, "{done} and {folded}");
}

/// In steps of a thousandth the branch cannot be lost.
#[test]
fn the_branch_is_that_of_the_centre() {
    let mut folded = 0;
    for lens in lenses() {
        let map = lens.map();
        for k in 0..12 {
            let p = at(1.5, 0.5 * f64::from(k));
            let mut slow = Lift::new(&map, p);
            let arrived =
                (1..=1000).all(|k| slow.advance(f64::from(k) / 1000.0) && slow.determinant() > 0.0);
            let mut quick = Lift::new(&map, p);
            assert_eq!(quick.advance(1.0), arrived, "{lens:?} {p:?}");
            folded += usize::from(!arrived);
            let off = [0, 1].map(|k| quick.at[k] - slow.at[k]);
            // Where it folds, each stops within its least step before that.
            let near = if arrived { 1e-12 } else { 1e-3 };
            assert!(radius(off) < near, "{lens:?} {p:?} {off:?}");
        }
    }
    assert!(folded > 50, "{folded}");
}

#[test]
fn a_fold_is_met_where_it_is() {
    let lens = radial(-0.3);
    let r = f64::sqrt(1.0 / 0.9);
    let fold = 2.0 / 3.0 * r;
    assert_eq!(lens.undistorted(at(fold * (1.0 + 1e-6), 1.0)), Err(DistortionFault::Folded));
    assert!(lens.undistorted(at(fold * (1.0 - 1e-6), 1.0)).is_ok());
    // The determinant by tan t is (1 + 3 k1 r^2) (1 + k1 r^2), that of tan t by t is (1 + r^2) r / atan r.
    let determinant =
        |u: f64| (1.0 - 0.9 * u) * (1.0 - 0.3 * u) * (1.0 + u) * f64::sqrt(u) / atan(f64::sqrt(u));
    let (mut u, mut step) = (1.0, 0.25);
    for _ in 0..60 {
        u += if determinant(u) > LEAST_DETERMINANT { step } else { -step };
        step *= 0.5;
    }
    let edge = f64::sqrt(u) * (1.0 - 0.3 * u);
    let (share, fault) = lens.first_fault(at(2.0, 1.0)).unwrap();
    assert_eq!(fault, DistortionFault::Folded);
    assert!((2.0 * share - edge).abs() < 1e-6, "{share} {edge}");
    assert!(edge > fold * (1.0 - 1e-4) && edge < fold);
    assert_eq!(lens.first_fault(at(0.99 * edge, 2.0)), None);
}

#[test]
fn a_fisheye_folds_where_its_polynomial_turns() {
    let lens = Distortion::KannalaBrandt { radial: [-0.2, 0.0, 0.0, 0.0] };
    // t (1 - 0.2 t^2) turns at t^2 = 1 / 0.6.
    let t = f64::sqrt(1.0 / 0.6);
    assert!(t < FRAC_PI_2);
    let top = 2.0 / 3.0 * t;
    assert!(lens.undistorted(at(top * (1.0 - 1e-6), 0.3)).is_ok());
    assert_eq!(lens.undistorted(at(top * (1.0 + 1e-6), 0.3)), Err(DistortionFault::Folded));
}

/// A range of undistorted points has all their images in its own.
#[test]
fn intervals_hold_the_images_of_their_points() {
    let mut draws = Draws::new(3);
    for lens in lenses() {
        let sides = [0, 1].map(|_| {
            let low = draws.inside([-0.4, 0.3]);
            Interval::new(low, low + 0.1)
        });
        let image = lens.distorted(sides);
        for _ in 0..20 {
            let q = sides.map(|side| draws.inside([side.lo, side.hi]));
            for (range, found) in image.iter().zip(lens.distorted(q)) {
                assert!((range.lo..=range.hi).contains(&found));
            }
        }
    }
}

/// Such a lens has a ratio that falls as atan r / r: its picture is that of angles.
#[test]
fn a_wide_lens_of_the_rational_model_is_no_fold() {
    let radial = [0.31, 0.021, 0.0013, 0.66, 0.11, 0.006];
    let lens = Distortion::BrownConrady { radial, tangential: [0.0; 2], prism: [0.0; 4] };
    let r = crate::num::tan(75.0_f64.to_radians());
    assert_eq!(lens.first_fault(lens.distorted(at(r, 0.3))), None);
}

/// Rectangles of distorted points, about the centre and beside it, for each lens: the last ones reach over folds.
fn rectangles() -> impl Iterator<Item = (Distortion, [[f64; 2]; 2])> {
    let around =
        |half: f64| [[[-half, -0.7 * half], [half, 0.8 * half]], [[0.1, half], [half, 0.2]]];
    lenses().into_iter().flat_map(move |lens| {
        [0.3, 0.6, 1.2].into_iter().flat_map(around).map(move |corners| (lens, corners))
    })
}

/// Random points of a rectangle.
fn points_of([a, b]: [[f64; 2]; 2], count: usize) -> impl Iterator<Item = [f64; 2]> {
    let mut draws = Draws::new(11);
    (0..count).map(move |_| [0, 1].map(|k| draws.inside([a[k].min(b[k]), a[k].max(b[k])])))
}

#[test]
#[ignore = "long: .ci/nightly"]
fn a_table_of_the_inverse_is_the_inverse_to_rounding() {
    let (mut followed, mut refined, mut none) = (0, 0, 0);
    for (lens, corners) in rectangles() {
        let table = InverseTable::new(&lens, corners, [40, 30]);
        for p in points_of(corners, 200) {
            let Ok(q) = lens.undistorted(p) else {
                assert!(table.undistorted(p).is_err(), "{lens:?} {p:?}");
                none += 1;
                continue;
            };
            let found = table.undistorted(p).unwrap();
            let Some(w) = table.refined(p) else {
                assert_eq!(found, q);
                followed += 1;
                continue;
            };
            refined += 1;
            // Rounding of the image, through the inverse Jacobian of the model and the tangent of an angle.
            let map = lens.map();
            let jacobian = map.jacobian(w);
            let inverse = [[1.0, 0.0], [0.0, 1.0]].map(|unit| radius(solved(jacobian, unit)));
            let is_angle = matches!(lens, Distortion::KannalaBrandt { .. });
            let stretch = if is_angle { 1.0 + q[0] * q[0] + q[1] * q[1] } else { 1.0 };
            let scale = radius(q) + (inverse[0] + inverse[1]) * radius(p) * stretch;
            let off = radius([found[0] - q[0], found[1] - q[1]]) / scale;
            assert!(off < 1e-15, "{lens:?} {p:?} {off:e}");
        }
    }
    println!("{refined} refined, {followed} followed, {none} without a ray");
    assert!(refined > 100_000 && none > 1000, "{refined}, {followed}, {none}");
    assert!(followed < refined / 10, "{refined}, {followed}, {none}");
}

/// What is beyond the rectangle, and at its corners.
#[test]
fn a_table_of_the_inverse_answers_beyond_its_rectangle_too() {
    let lens = radial(-0.3);
    let corners = [[-0.3, 0.2], [0.4, -0.25]];
    let table = InverseTable::new(&lens, corners, [1, 5]);
    for p in [[0.5, 0.0], [-0.31, 0.0], [0.0, 0.21], [0.0, -0.26]] {
        assert!(table.refined(p).is_none());
        assert_eq!(table.undistorted(p), lens.undistorted(p));
    }
    for p in [corners[0], corners[1], [-0.3, -0.25], [0.4, 0.2], [0.0; 2]] {
        let [found, exact] = [table.undistorted(p), lens.undistorted(p)].map(Result::unwrap);
        assert!(radius([found[0] - exact[0], found[1] - exact[1]]) < 2e-16, "{p:?}");
    }
    assert_eq!(table.undistorted([f64::NAN, 0.0]), lens.undistorted([f64::NAN, 0.0]));
}
