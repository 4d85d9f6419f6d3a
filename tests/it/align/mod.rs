//! Parts that others measured or changed are found, whatever their pose, and judged by what they do.

mod copies;
mod files;

use crate::support::draws::Draws;
use crate::support::{share, times};
use copies::{Part, decimated, holed, moved, noisy, shipped_like, spiked};
use morion::internals::align::{AlignError, Alignment, Pose, align};
use morion::internals::geom::{DVec3, TriMesh};

/// What is left of `pose` after `found` has undone it, in mm on the mirror and in radians; turns about
/// the axis count only where the mirror shows them.
fn left(part: &Part, pose: &Pose, found: &Alignment) -> [f64; 2] {
    let both = pose.then(&found.pose);
    let mut turn = both.rotation_vector();
    if part.round() {
        turn.z = 0.0;
    }
    // The corners of a box around the mirror, with the same turn.
    let rest = Pose::about(DVec3::ZERO, both.shift, turn);
    let half = 0.5 * part.width();
    let corners =
        [DVec3::splat(half), DVec3::new(half, -half, 0.0), DVec3::new(-half, -half, half)];
    let off = corners.map(|corner| (rest.apply(corner) - corner).length());
    [off.into_iter().fold(0.0, f64::max), turn.length()]
}

#[track_caller]
fn aligned(part: &Part, mesh: &TriMesh, what: &str) -> Alignment {
    align(&part.design.mirror, mesh).unwrap_or_else(|e| panic!("{}, {what}: {e}", part.name))
}

#[test]
#[ignore = "long: .ci/nightly"]
fn every_pose_in_range_is_found_to_a_nanometre() {
    let mut draws = Draws::new(1);
    let mut tried = 0;
    for part in shipped_like() {
        let stocked = Part::stocked(part.name).solid;
        let meshes = [&part.solid, &part.face(), &part.scan(80), &stocked];
        for (k, mesh) in meshes.into_iter().enumerate() {
            for attempt in share(2, 1, 0..4) {
                // At the end of the range, and anywhere in it.
                let share = if attempt < 2 { 1.0 } else { draws.unit() };
                let pose = draws.pose(20.0 * share, 0.2 * share, part.width());
                let found = aligned(&part, &moved(mesh, &pose), &format!("mesh {k}"));
                let [off, turn] = left(&part, &pose, &found);
                let what = format!("{} {k} {attempt}: {off:e} mm, {turn:e} rad", part.name);
                assert!(off <= 1e-6 && turn <= 1e-7, "{what}");
                assert!(found.rms_mm < 1e-6 && found.covered > 0.85, "{what}: {found:?}");
                assert!(found.outliers < 0.02 && !found.turned_over, "{what}: {found:?}");
                tried += 1;
            }
        }
    }
    assert!(tried >= times(30, 60), "{tried}");
}

#[test]
fn what_a_round_mirror_does_not_show_is_said_and_left_alone() {
    let mut draws = Draws::new(2);
    for part in shipped_like() {
        // A tilt and a shift, without a turn about the axis.
        let tilt = DVec3::new(0.2, -0.1, 0.0);
        let to = draws.way() * 5.0;
        let pose = Pose::about(DVec3::ZERO, to, tilt);
        let found = aligned(&part, &moved(&part.solid, &pose), "tilted");
        if !part.round() {
            assert!(found.free.is_empty(), "{}: {:?}", part.name, found.free);
            continue;
        }
        let [free] = found.free[..] else { panic!("{}: {:?}", part.name, found.free) };
        let through = free.through_mm.expect("a turn");
        assert!((free.direction - DVec3::Z).length() < 1e-9, "{free:?}");
        assert!(through.truncate().length() < 1e-9, "{free:?}");
        // Left as it was, up to what a tilt and back again cannot tell.
        let twist = pose.then(&found.pose).rotation_vector().z;
        assert!(twist.abs() < 0.05, "{}: {twist}", part.name);
    }
}

#[test]
fn noise_moves_the_pose_by_no_more_than_its_share() {
    let part = Part::conquistador();
    let sigma = 0.02;
    for steps in [40, 80] {
        let clean = part.scan(steps);
        let count = clean.vertices.len() as f64;
        let (mut squares, mut scales, tries) = (0.0, 0.0, 24);
        for seed in 0..tries {
            let mut draws = Draws::new(100 + seed);
            let pose = draws.pose(15.0, 0.15, part.width());
            let mut mesh = moved(&clean, &pose);
            noisy(&mut mesh, sigma, &mut draws);
            let found = aligned(&part, &mesh, "noisy");
            let both = pose.then(&found.pose);
            let mirror = &part.design.mirror;
            let off = |v: &DVec3| {
                let q = mirror.chart.coordinates(*v).0;
                let normal = mirror.normal(q, &mirror.row(q.y).at(q.x)).normalize();
                let d = normal.dot(both.apply(*v) - *v);
                d * d
            };
            squares += clean.vertices.iter().map(off).sum::<f64>() / count;
            scales += found.rms_mm / sigma;
        }
        // Least squares with six unknowns puts 6 sigma^2 / N into the mean square of what it fits;
        // weights by area and against outliers cost some of it.
        let ratio = squares / tries as f64 / (6.0 * sigma * sigma / count);
        assert!((0.75..1.8).contains(&ratio), "{steps}: {ratio}");
        let scale = scales / tries as f64;
        assert!((0.8..1.05).contains(&scale), "{steps}: {scale}");
    }
}

#[test]
#[ignore = "long: .ci/nightly"]
fn one_vertex_in_twenty_may_be_anywhere() {
    let (sigma, tries) = (0.005, 6);
    for part in shipped_like() {
        // What is left after noise alone, and after the same noise and spikes, in units of the noise's share
        // in the worst direction of the six.
        let mut squares = [0.0; 2];
        for seed in 0..tries {
            let mut draws = Draws::new(10 + seed);
            let pose = draws.pose(20.0, 0.2, part.width());
            let mut mesh = moved(&part.scan(70), &pose);
            noisy(&mut mesh, sigma, &mut draws);
            let count = mesh.vertices.len() as f64;
            let left = |found: &Alignment| {
                let [off, _] = left(&part, &pose, found);
                let share = off / (sigma / count.sqrt() * found.condition);
                share * share
            };
            squares[0] += left(&aligned(&part, &mesh, "noisy"));
            let spikes = spiked(&mut mesh, 6.0, &mut draws);
            assert!((0.03..0.07).contains(&(spikes as f64 / count)));
            let found = aligned(&part, &mesh, "spiked");
            squares[1] += left(&found);
            assert!((0.8..1.1).contains(&(found.rms_mm / sigma)), "{found:?}");
            assert!((0.02..0.4).contains(&found.outliers), "{found:?}");
        }
        let [noise, both] = squares.map(|square| (square / tries as f64).sqrt());
        assert!(noise < 6.0 && both < 1.4 * noise, "{}: {noise} {both}", part.name);
    }
}

#[test]
fn holes_thinning_and_the_wrong_side_do_not_matter() {
    let mut draws = Draws::new(5);
    for part in shipped_like() {
        let whole = part.scan(80);
        let part_of = |mesh: &TriMesh| mesh.triangles.len() as f64 / whole.triangles.len() as f64;
        let with_holes = holed(&whole, 6, 0.1 * part.width(), &mut draws);
        let few = decimated(&whole, 2.5);
        assert!(part_of(&with_holes) < 0.9 && part_of(&few) < 0.3, "{}", part.name);
        let mut wrong_side = holed(&part.solid, 2, 4.0, &mut draws);
        wrong_side.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        let side = 0.1 * part.width();
        let corner = copies::kept(&whole, |t| {
            let place = whole.corners(t)[0];
            place.x < side || place.y < 0.0
        });
        for (what, mesh) in [
            ("holed", &with_holes),
            ("thin", &few),
            ("corner missing", &corner),
            ("turned", &wrong_side),
        ] {
            let pose = draws.pose(20.0, 0.2, part.width());
            let mut mesh = moved(mesh, &pose);
            let found = aligned(&part, &mesh, what);
            let [off, turn] = left(&part, &pose, &found);
            assert!(off <= 1e-6 && turn <= 1e-7, "{} {what}: {off:e} {turn:e}", part.name);
            assert_eq!(found.turned_over, what == "turned");
            if what == "holed" {
                let lost = 1.0 - found.covered / aligned(&part, &whole, "whole").covered;
                let exact = 1.0 - part_of(&with_holes);
                assert!((lost - exact).abs() < 0.3 * exact, "{}: {lost} {exact}", part.name);
            }
            found.apply(&mut mesh);
            let up = (0..mesh.triangles.len()).map(|t| mesh.area_vector(t).z);
            let highest = mesh.vertices.iter().map(|v| v.z).fold(f64::NEG_INFINITY, f64::max);
            assert!(highest > 5.0 && up.clone().filter(|z| *z > 0.0).count() * 3 > up.count());
        }
    }
}

#[test]
fn what_cannot_be_aligned_is_refused_with_a_remedy() {
    let part = Part::conquistador();
    let mirror = &part.design.mirror;
    let scan = part.scan(80);
    let near = |t: usize| scan.corners(t).iter().all(|v| (v.truncate().x - 8.0).abs() < 3.0);
    let strip = copies::kept(&scan, near);
    let few = copies::kept(&scan, |t| t % 400 == 7);
    let mut dome = scan.clone();
    for v in &mut dome.vertices {
        let r2 = v.truncate().length_squared();
        v.z = 12.0 - r2 * r2 * 2e-5 + 6.0 * morion::internals::num::sin(0.4 * v.x + 0.7 * v.y);
    }
    for (mesh, wanted) in [(&strip, "covers"), (&few, "cover"), (&dome, "does not look like")] {
        let error = align(mirror, mesh).unwrap_err();
        let text = error.to_string();
        assert!(text.contains(wanted) && text.contains("units"), "{text}");
    }
    let nothing = align(mirror, &TriMesh::default()).unwrap_err();
    assert_eq!(nothing, AlignError::Few { found: 0 });
}
