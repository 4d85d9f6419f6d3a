use super::*;
use crate::num::sample::Draws;
use crate::num::{Interval, Jet2, cos, hypot, log, sin};
use crate::optics::{Strip, StripLaw};

const FRAME: Rect = Rect { min: DVec2::new(-30.0, -10.0), max: DVec2::new(30.0, 12.0) };

#[test]
fn the_middle_of_a_symmetric_map_is_found() {
    let symmetric = |q: DVec2| DVec3::new(0.02 * q.x, 0.02 * (q.y - 1.0), 1.0).normalize();
    let map = map(&samples([120, 44], symmetric));
    for near in [DVec2::ZERO, DVec2::new(0.0, 1.0), DVec2::new(1e-17, 1.0 + 1e-16), DVec2::ONE] {
        let found = DVec2::from_array(map.image_of([0.0; 2], near));
        assert!((found - DVec2::Y).length() < 1e-13, "{near} {found}");
    }
}

#[test]
fn a_map_is_symmetric_where_reflecting_the_picture_reflects_the_world() {
    let frame = Rect { min: DVec2::new(-30.0, -10.0), max: DVec2::new(30.0, 10.0) };
    let symmetric = |off: DVec2, higher: f64| {
        // (Samples are over FRAME, which is 1 mm higher in the middle.)
        let all = samples([12, 8], |q| (0.02 * (q - DVec2::Y - off)).extend(1.0).normalize());
        let frame = Rect { max: frame.max + DVec2::new(0.0, higher), ..frame };
        let map = SampledMap::new(&all, frame, frame);
        [0, 1].map(|axis| map.is_symmetric(axis))
    };
    assert_eq!(symmetric(DVec2::ZERO, 0.0), [true; 2]);
    assert_eq!(symmetric(DVec2::new(0.1, 0.0), 0.0), [false, true]);
    assert_eq!(symmetric(DVec2::new(0.0, 0.1), 0.0), [true, false]);
    assert_eq!(symmetric(DVec2::ZERO, 0.1), [true, false]);
}

/// Samples of the directions of `f` over the frame.
fn samples([columns, rows]: [usize; 2], f: impl Fn(DVec2) -> DVec3) -> DirectionSamples {
    let cell = FRAME.size() / DVec2::new(columns as f64, rows as f64);
    let at = |k: usize| {
        let (column, row) = ((k % columns) as f64 + 0.5, (k / columns) as f64 + 0.5);
        DVec2::new(FRAME.min.x + column * cell.x, FRAME.max.y - row * cell.y)
    };
    DirectionSamples { columns, rows, directions: (0..columns * rows).map(|k| f(at(k))).collect() }
}

fn strip() -> Strip {
    let law = StripLaw::Cylindrical;
    Strip { law, scale_mm: 60.0 / std::f64::consts::TAU, azimuth: 0.0, z: 0.0 }
}

fn panorama(q: DVec2) -> DVec3 {
    stereographic::direction(strip().direction_of(q.to_array()))
}

fn map(samples: &DirectionSamples) -> SampledMap {
    SampledMap::new(samples, FRAME, FRAME)
}

fn inside(r: &mut Draws) -> DVec2 {
    DVec2::new(r.inside([FRAME.min.x, FRAME.max.x]), r.inside([FRAME.min.y, FRAME.max.y]))
}

#[test]
fn a_sampled_panorama_is_the_panorama_to_the_fourth_order() {
    let error = |n: usize| {
        let (map, mut r) = (map(&samples([3 * n, n], panorama)), Draws::new(1));
        let off = (0..400).map(|_| {
            let q = inside(&mut r);
            let [a, b] = map.direction_of(q.to_array());
            let [c, d] = strip().direction_of(q.to_array());
            hypot(a - c, b - d)
        });
        (off.fold(0.0, f64::max), map.interpolation_error())
    };
    let ((coarse, told), (fine, _)) = (error(40), error(80));
    let order = log(coarse / fine) / log(2.0);
    assert!((3.5..5.5).contains(&order), "{order}");
    assert!(fine < 2e-6, "{fine}");
    // What it says of itself is of the same size.
    assert!((0.3..10.0).contains(&(told / coarse)), "{told:e} {coarse:e}");
}

#[test]
fn image_points_are_found_again_from_pixels_away() {
    let (map, mut r) = (map(&samples([120, 40], panorama)), Draws::new(2));
    for _ in 0..500 {
        let q = inside(&mut r);
        let near = q + DVec2::new(r.inside([-3.0, 3.0]), r.inside([-2.0, 2.0]));
        let back = DVec2::from_array(map.image_of(map.direction_of(q.to_array()), near));
        assert!((back - q).length() < 1e-12, "{q} {back}");
        // From anywhere it finds a place that shows the same: azimuths a turn apart do.
        let seen = map.direction_of(q.to_array());
        let from = inside(&mut r);
        let image = map.image_of(seen, from);
        let back = map.direction_of(image);
        assert!(
            hypot(back[0] - seen[0], back[1] - seen[1]) < 1e-12,
            "{q} {from} {image:?} {back:?} {seen:?}"
        );
    }
}

#[test]
fn bounds_hold_both_ways() {
    let (map, mut r) = (map(&samples([120, 40], panorama)), Draws::new(3));
    let parts = |j: Jet2<f64>| {
        let ([x, y], [xx, xy, yy]) = (j.gradient, j.hessian);
        [j.value, x, y, xx, xy, yy]
    };
    let ranges = |j: Jet2<Interval>| {
        let ([x, y], [xx, xy, yy]) = (j.gradient, j.hessian);
        [j.value, x, y, xx, xy, yy]
    };
    let mut finite = 0;
    for round in 0..300 {
        // Up to many patches wide, and beyond the frame.
        let size = [0.01, 0.3, 1.0, 6.0][round % 4];
        let lo = inside(&mut r) - DVec2::splat(0.3);
        let [x, y] = [lo.x, lo.y].map(|lo| Interval::new(lo, lo + r.inside([0.0, size])));
        let there = map.direction_of([Jet2::variable_x(x), Jet2::variable_y(y)]);
        let near = DVec2::new(x.mid(), y.mid());
        let back = map.image_of(there, near);
        finite += usize::from(back[0].value.is_finite());
        for _ in 0..8 {
            let q = [r.inside([x.lo, x.hi]), r.inside([y.lo, y.hi])];
            let found = map.direction_of([Jet2::variable_x(q[0]), Jet2::variable_y(q[1])]);
            let undone = map.image_of(found, near);
            for (bounds, found) in
                there.into_iter().chain(back).zip(found.into_iter().chain(undone))
            {
                for (bound, found) in ranges(bounds).into_iter().zip(parts(found)) {
                    assert!(bound.contains(found), "{bound:?} {found} {x:?} {y:?}");
                }
            }
        }
    }
    // Of boxes that are not many patches wide, nor beyond the knots, the way back is proven.
    assert!(finite > 180, "{finite}");
}

#[test]
fn gaps_want_nothing_and_change_nothing_around_them() {
    let all = samples([120, 40], panorama);
    let mut some = all.clone();
    for (k, direction) in some.directions.iter_mut().enumerate() {
        let (column, row) = (k % 120, k / 120);
        if column > 100 || (50..60).contains(&column) && (10..30).contains(&row) {
            *direction = DVec3::NAN;
        }
    }
    let (whole, gapped) = (map(&all), map(&some));
    assert!(whole.gaps.is_none());
    let cell = FRAME.size() / DVec2::new(120.0, 40.0);
    let at = |column: f64, row: f64| {
        DVec2::new(FRAME.min.x + column * cell.x, FRAME.max.y - row * cell.y)
    };
    for (column, row, wanted) in
        [(20.0, 5.0, true), (54.0, 20.0, false), (54.0, 5.0, true), (110.0, 5.0, false)]
    {
        assert_eq!(gapped.wants(at(column, row)), wanted, "{column} {row}");
    }
    // Two samples away from a gap it is the same within a thousandth of a sample's step.
    let step = cell.x * whole.radians_per_mm();
    for row in 1..39 {
        for column in [48.0, 62.0, 97.5] {
            let q = at(column, f64::from(row)).to_array();
            let ([a, b], [c, d]) = (whole.direction_of(q), gapped.direction_of(q));
            assert!(hypot(a - c, b - d) < 1e-3 * step, "{column} {row}");
        }
    }
}

#[test]
fn what_is_no_picture_is_refused() {
    let good = samples([12, 10], panorama);
    let found = |directions: Vec<DVec3>| DirectionSamples::new(12, directions).unwrap_err();
    let with = |k: usize, direction: DVec3| {
        let mut directions = good.directions.clone();
        directions[k] = direction;
        found(directions)
    };
    assert_eq!(DirectionSamples::new(12, good.directions.clone()), Ok(good.clone()));
    let (row, column) = (3, 6);
    let k = 2 * 12 + 5;
    let length = 57.3;
    assert_eq!(with(k, DVec3::X * length), MapFault::Length { row, column, length });
    let partial = DVec3::new(0.0, f64::NAN, 1.0);
    assert_eq!(with(k, partial), MapFault::Partial { row, column });
    assert_eq!(with(k, DVec3::NEG_Z), MapFault::Down { row, column });
    assert_eq!(found(vec![DVec3::Z; 12]), MapFault::TooFew { columns: 12, rows: 1 });
    assert_eq!(found(vec![DVec3::NAN; 120]), MapFault::Empty);
    // The left half reflected.
    let folded = samples([12, 10], |q| panorama(DVec2::new(q.x.abs(), q.y)));
    assert!(matches!(found(folded.directions), MapFault::Folds { .. }));
    // One direction for all.
    let constant = vec![DVec3::new(sin(0.3), 0.0, cos(0.3)); 120];
    assert_eq!(found(constant), MapFault::Folds { row: 1, column: 1 });
}
