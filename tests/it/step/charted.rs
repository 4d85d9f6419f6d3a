//! All rays of a camera at once against a body of curved faces: what the search finds ray by ray.

use super::strangers::body;
use super::{all, fitted, written};
use crate::support::share;
use morion::internals::brep::{Body, ChartedBody};
use morion::internals::geom::{Chart, DVec2, DVec3};

/// Columns and rows of a picture, and how much larger than the body it is.
const PIXELS: [usize; 2] = [75, 52];
const ROOM: f64 = 1.06;

/// Largest distance between both answers, mm, and angle between normals.
const OFF_MM: f64 = 1e-9;
const OFF_NORMAL: f64 = 1e-8;

/// Cameras above a body: parallel rays and a pinhole, upright and leaning.
fn charts(body: &Body) -> [Chart; 4] {
    let [lo, hi] = body.bounds();
    let size = (hi - lo).max_element();
    let plane_mm = 0.3 * lo.z + 0.7 * hi.z;
    let near = 1.0 / (2.3 * size);
    [
        (0.0, DVec2::ZERO),
        (0.0, DVec2::new(0.4, -0.25)),
        (near, DVec2::ZERO),
        (near, DVec2::new(-0.2, 0.3)),
    ]
    .map(|(vergence, lean)| Chart { vergence, plane_mm, lean })
}

/// Rows of chart coordinates over a body.
fn rows(body: &Body, chart: &Chart) -> (Vec<Vec<DVec2>>, f64) {
    let [lo, hi] = body.bounds();
    let corner = |k: usize| {
        let pick = |axis: usize| if k >> axis & 1 == 0 { lo[axis] } else { hi[axis] };
        chart.coordinates(DVec3::from_array([0, 1, 2].map(pick))).0
    };
    let corners: Vec<DVec2> = (0..8).map(corner).collect();
    let lo = corners.iter().fold(DVec2::INFINITY, |least, &q| least.min(q));
    let hi = corners.iter().fold(DVec2::NEG_INFINITY, |most, &q| most.max(q));
    let (middle, size) = (0.5 * (lo + hi), ROOM * (hi - lo));
    let share = |k: usize, count: usize| (k as f64 + 0.43) / count as f64 - 0.5;
    let at = |column: usize, row: usize| {
        middle + size * DVec2::new(share(column, PIXELS[0]), share(row, PIXELS[1]))
    };
    let row = |row: usize| (0..PIXELS[0]).map(|column| at(column, row)).collect();
    ((0..PIXELS[1]).map(row).collect(), size.x / PIXELS[0] as f64)
}

/// Number of rays that meet the body, all as the search finds them.
fn compare(name: &str, body: &Body) -> usize {
    let top_mm = 2.0 * body.bounds()[1].z + 10.0;
    let (mut met, mut slipped) = (0, 0);
    for (number, chart) in charts(body).iter().enumerate() {
        let (rows, pixel_mm) = rows(body, chart);
        let charted = ChartedBody::new(body, chart, top_mm, pixel_mm).unwrap();
        let mut found = vec![None; PIXELS[0] * PIXELS[1]];
        for first in (0..rows.len()).step_by(16) {
            let end = (first + 16).min(rows.len());
            let band: Vec<&[DVec2]> = rows[first..end].iter().map(|row| &row[..]).collect();
            charted.meet(&band, |[row, column], _, hit| {
                let place = &mut found[(first + row) * PIXELS[0] + column];
                assert!(place.replace(hit).is_none(), "{name} {number}: twice");
            });
        }
        for (k, found) in found.iter().enumerate() {
            let ray = chart.ray(rows[k / PIXELS[0]][k % PIXELS[0]], top_mm);
            let wanted = body.nearest_hit(&ray, 0.0, f64::INFINITY);
            let (Some(found), Some(wanted)) = (found, wanted) else {
                // Where a ray slips in along an edge, by rounding, the search finds the back of a face.
                let is_back = wanted.is_some_and(|hit| hit.normal.dot(ray.direction) > 0.0);
                slipped += usize::from(found.is_none() && is_back);
                let is_same = found.is_none() && (wanted.is_none() || is_back);
                assert!(is_same, "{name} {number} {k}: {found:?} {wanted:?}");
                continue;
            };
            let off = (found.t - wanted.t).abs();
            let turned = found.normal.normalize().distance(wanted.normal);
            assert!(off <= OFF_MM, "{name} {number} {k}: {found:?} {wanted:?}");
            let is_same = found.face == wanted.face && turned <= OFF_NORMAL;
            assert!(is_same, "{name} {number} {k}: {turned:e} {found:?} {wanted:?}");
            met += 1;
        }
    }
    assert!(slipped < 4, "{name}: {slipped}");
    met
}

#[test]
#[ignore = "long: .ci/nightly"]
fn rays_of_a_camera_meet_mirrors_where_each_ray_does() {
    for case in share(14, 1, all()) {
        let body = Body::read(&written(&case, &fitted(&case))).unwrap();
        let met = compare(&case.name, &body);
        assert!(met > 5_000, "{}: {met}", case.name);
    }
}

#[test]
fn rays_of_a_camera_meet_bodies_of_other_programs_where_each_ray_does() {
    let names = [
        "box",
        "drilled",
        "dimpled",
        "nurbs",
        "countersunk",
        "rounded",
        "nurbs-rounded",
        "cylinder",
        "elliptic",
        "oblique",
        "cone",
        "pointed",
        "sphere",
        "torus",
        "nurbs-torus",
        "extruded",
        "turned",
        "sector",
    ];
    for name in share(5, 0, names) {
        let met = compare(name, &body(name));
        assert!(met > 1_500, "{name}: {met}");
    }
}
