//! Views in perspective, plans of a floor, and pictures of a part as it is mounted: their maps against rays traced on vectors.

use super::traced;
use crate::support::builds::{SMALL, folder, parsed};
use crate::support::{designed, shipped, shipped_but};
use morion::internals::design::Design;
use morion::internals::geom::{DVec2, DVec3};
use morion::internals::num::{cos, radians, sin, tan};
use morion::internals::pipeline::{
    Command, MapFormat, Silent, Unwrap, UnwrapOptions, UnwrapPicture, ViewAngles,
};
use morion::internals::profile::Profile;
use morion::internals::raster::Raster;
use morion::internals::report::Answer;
use morion::internals::results::UnwrapReport;
use std::path::{Path, PathBuf};

/// A map of a picture, by the places of the photo in px from its upper left corner.
struct FoundMap {
    report: UnwrapReport,
    size: [usize; 2],
    places: Vec<Option<DVec2>>,
}

/// A dark photo of a profile's frame.
fn photo(folder: &Path, profile: &Profile) -> PathBuf {
    let [width, height] = profile.camera.pixels().map(|pixels| pixels as usize);
    let dark = Raster { width, height, rgb: vec![[0.5; 3]; width * height] };
    let path = folder.join("photo.png");
    std::fs::write(&path, dark.to_png().unwrap()).unwrap();
    path
}

fn run(profile: &Profile, picture: UnwrapPicture, pose: Option<&str>) -> Result<FoundMap, String> {
    let folder = folder();
    let photo = photo(folder.path(), profile);
    let path = folder.path().join("pose.json");
    std::fs::write(&path, pose.unwrap_or_default()).unwrap();
    let pose = pose.map(|_| path.as_path());
    let options = UnwrapOptions::Remap { picture, map: Some(MapFormat::Npy), pose };
    let (report, files) = Unwrap { photo: &photo, options }
        .in_memory(profile, &Silent)
        .map_err(|error| error.to_string())?;
    let map = files.iter().find(|file| file.name.ends_with("map.npy")).unwrap();
    let ([height, width, _], places) = super::files::npy(&map.bytes);
    let place =
        |[x, y]: [f32; 2]| (x >= -0.5).then(|| DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
    let places = places.into_iter().map(|at| if at == [-1.0; 2] { None } else { place(at) });
    Ok(FoundMap { report, size: [width, height], places: places.collect() })
}

fn found(profile: &Profile, picture: UnwrapPicture, pose: Option<&str>) -> FoundMap {
    run(profile, picture, pose).unwrap_or_else(|error| panic!("{}: {error}", profile.name))
}

fn view(angles: [f64; 3], size: [usize; 2]) -> UnwrapPicture {
    let [azimuth_deg, elevation_deg, field_deg] = angles;
    let [width, height] = size.map(Some);
    let angles = ViewAngles { azimuth_deg, elevation_deg, field_deg };
    UnwrapPicture::View { angles, width, height }
}

fn ground(height_mm: f64, range_mm: f64, mm_per_px: f64) -> UnwrapPicture {
    let [range_mm, mm_per_px] = [range_mm, mm_per_px].map(Some);
    UnwrapPicture::Ground { height_mm, range_mm, mm_per_px }
}

/// Where in a picture that belongs, px, which a ray shows that leaves a place in a direction.
type Belongs = Box<dyn Fn(DVec3, DVec3) -> Option<DVec2>>;

/// A pinhole camera in `angles`, by vectors.
fn pinhole([azimuth, elevation, field]: [f64; 3], [width, height]: [usize; 2]) -> Belongs {
    let [a, e, field] = [azimuth, elevation, field].map(radians);
    let ahead = DVec3::new(cos(e) * sin(a), cos(e) * cos(a), sin(e));
    let right = ahead.cross(DVec3::Z).normalize();
    let up = right.cross(ahead);
    let focal = 0.5 * width as f64 / tan(0.5 * field);
    let middle = 0.5 * DVec2::new(width as f64, height as f64);
    Box::new(move |_, direction| {
        let depth = direction.dot(ahead);
        let on = DVec2::new(direction.dot(right), -direction.dot(up)) * focal / depth;
        (depth > 0.0).then_some(middle + on)
    })
}

/// A plan by where rays meet the floor.
fn plan(z_mm: f64, range_mm: f64, mm_per_px: f64) -> Belongs {
    Box::new(move |from, direction| {
        let way = (z_mm - from.z) / direction.z;
        let at = from + way * direction;
        let middle = (range_mm / mm_per_px).round();
        // Seen from the mirror, rows go down with Y along Z.
        let on = DVec2::new(middle + at.x / mm_per_px, middle + z_mm.signum() * at.y / mm_per_px);
        (way > 0.0 && at.truncate().length() < range_mm).then_some(on)
    })
}

/// The largest distance, px of the photo, between places of a map and where the picture's pixels are seen; and pixels of the photo that
/// show something of the picture which its map lacks.
fn held(design: &Design, map: &FoundMap, belongs: &Belongs) -> (f64, usize) {
    let of = |at: DVec2| {
        let (from, direction) = traced(design, design.camera.image_point(at.x, at.y))?;
        belongs(from, direction)
    };
    let [width, height] = map.size;
    /// Of a difference, px.
    const STEP: f64 = 0.03;
    let (mut worst, mut held) = (0.0f64, 0);
    for (k, at) in map.places.iter().enumerate() {
        let Some(at) = *at else { continue };
        let wanted = DVec2::new((k % width) as f64 + 0.5, (k / width) as f64 + 0.5);
        // By differences; none beside a rim or a ridge, where they jump.
        let beside = |way: DVec2| {
            let (from, here, to) = (of(at - STEP * way)?, of(at)?, of(at + STEP * way)?);
            let (before, after) = (here - from, to - here);
            let is_smooth = (after - before).length() < 0.1 * (before.length() + after.length());
            is_smooth.then(|| (before + after) / (2.0 * STEP))
        };
        let Some((x, y)) = beside(DVec2::X).zip(beside(DVec2::Y)) else { continue };
        held += 1;
        let off = of(at).unwrap() - wanted;
        let area = x.perp_dot(y);
        let in_photo = DVec2::new(off.perp_dot(y), x.perp_dot(off)) / area;
        worst = worst.max(in_photo.length());
    }
    assert!(10 * held >= 9 * map.places.iter().flatten().count(), "{held} places are held");
    let [columns, rows] = design.camera.pixels.map(|n| n as usize);
    let mut missed = 0;
    for k in 0..columns * rows {
        let at = DVec2::new((k % columns) as f64 + 0.5, (k / columns) as f64 + 0.5);
        let is_inside = |way: DVec2| of(at + way).is_some();
        let Some(on) =
            of(at).filter(|_| [DVec2::X, DVec2::Y].iter().all(|w| is_inside(*w) && is_inside(-*w)))
        else {
            continue;
        };
        let within =
            on.cmpge(DVec2::ONE).all() && on.x < width as f64 - 1.0 && on.y < height as f64 - 1.0;
        missed +=
            usize::from(within && map.places[on.y as usize * width + on.x as usize].is_none());
    }
    (worst, missed)
}

/// Unseen pixels of which all four neighbours are seen.
fn holes(map: &FoundMap) -> usize {
    let [width, height] = map.size;
    let is_hole = |k: &usize| {
        let (x, y) = (k % width, k / width);
        (1..width - 1).contains(&x)
            && (1..height - 1).contains(&y)
            && map.places[*k].is_none()
            && [k - 1, k + 1, k - width, k + width].iter().all(|k| map.places[*k].is_some())
    };
    (0..map.places.len()).filter(is_hole).count()
}

/// Mirrors of different kinds, a view of each, and a floor: Z, range and pixel.
fn cases() -> Vec<(Profile, [f64; 3], [f64; 3])> {
    let small = [("[480, 480]", "[240, 240]")];
    let hyperbolic = [small[0], ("focal_px = 800", "focal_px = 400")];
    vec![
        (parsed(SMALL), [30.0, 5.0, 80.0], [-40.0, 160.0, 1.0]),
        (parsed(SMALL), [-150.0, -10.0, 60.0], [60.0, 240.0, 2.0]),
        (shipped_but("hyperbolic", &hyperbolic), [200.0, 40.0, 90.0], [300.0, 900.0, 6.0]),
        (shipped_but("parabolic", &small), [0.0, 90.0, 100.0], [-150.0, 1500.0, 10.0]),
        (shipped("soccer"), [-70.0, 30.0, 70.0], [204.0, 800.0, 5.0]),
        (shipped("four-views"), [45.0, 0.0, 70.0], [150.0, 400.0, 2.0]),
    ]
}

/// Every place of a view's and of a plan's map shows what it should, and nothing that the photo shows is left out but at rims.
#[test]
#[ignore = "long: .ci/nightly"]
fn views_and_plans_hold_what_traced_rays_show() {
    for (profile, angles, [z_mm, range_mm, mm_per_px]) in cases() {
        let design = designed(&profile);
        let size = [160, 120];
        let floor = ground(z_mm, range_mm, mm_per_px);
        for (picture, belongs, name) in [
            (view(angles, size), pinhole(angles, size), "view"),
            (floor, plan(z_mm, range_mm, mm_per_px), "ground"),
        ] {
            let map = found(&profile, picture, None);
            let (worst, missed) = held(&design, &map, &belongs);
            let seen = map.places.iter().flatten().count();
            let share = seen as f64 / map.places.len() as f64;
            println!(
                "{} {name} {:?}: {share:.3} seen, worst {worst:.1e} px, {missed} missed, {} holes",
                profile.name,
                map.size,
                holes(&map)
            );
            assert!(share > 0.2, "{} {name}: {share}", profile.name);
            assert!((map.report.map.unwrap().seen - share).abs() < 1e-12);
            assert!(worst < 0.005, "{} {name}: {worst} px", profile.name);
            assert_eq!(holes(&map), 0, "{} {name}", profile.name);
            let [columns, rows] = design.camera.pixels;
            assert!(missed < (columns + rows) as usize, "{} {name}: {missed} missed", profile.name);
            if let Some(floor) = &map.report.ground {
                let way = if floor.row_mm < 0.0 { "Y up" } else { "Y down" };
                assert!(floor.row_mm * z_mm > 0.0 && map.report.text().contains(way));
            }
            // A floor 2 % farther and a field 2 % wider are told apart.
            let altered = match name {
                "view" => pinhole([angles[0], angles[1], 1.02 * angles[2]], size),
                _ => plan(1.02 * z_mm, range_mm, mm_per_px),
            };
            assert!(held(&design, &map, &altered).0 > 0.1, "{} {name}", profile.name);
        }
    }
}

/// A pose without errors is the designed mirror: rays that are traced through the sensor's pixels lead to the places that the inverse of
/// the designed mirror finds, and both see the same but at rims.
#[test]
#[ignore = "long: .ci/nightly"]
fn a_pose_without_errors_is_the_designed_mirror() {
    let none = r#"{"part": {"tilt_x_mrad": 0}, "camera": {}}"#;
    let panorama = UnwrapPicture::Panorama { projection: None, width: Some(300) };
    let near = shipped_but("robot-floor", &[("[1280, 960]", "[320, 240]")]);
    let all = cases().into_iter().map(|(profile, angles, _)| (profile, angles));
    let all = all.chain([(near, [10.0, 50.0, 60.0])]);
    for (profile, angles) in all.filter(|(profile, _)| profile.name != "four-views") {
        for (name, picture) in [("panorama", panorama), ("view", view(angles, [160, 120]))] {
            let [designed, mounted] = [None, Some(none)].map(|pose| found(&profile, picture, pose));
            assert_eq!(mounted.size, designed.size);
            let (mut worst, mut only) = (0.0f64, [0, 0]);
            for (a, b) in designed.places.iter().zip(&mounted.places) {
                match (a, b) {
                    (Some(a), Some(b)) => worst = worst.max(a.distance(*b)),
                    (Some(_), None) => only[0] += 1,
                    (None, Some(_)) => only[1] += 1,
                    (None, None) => {}
                }
            }
            let seen = designed.places.iter().flatten().count();
            println!(
                "{} {name}: {seen} seen, worst {worst:.1e} px, only one way {only:?}",
                profile.name
            );
            assert!(worst < 1e-3, "{} {name}: {worst}", profile.name);
            assert!(only[0] + only[1] <= designed.size[0] / 8, "{} {name}: {only:?}", profile.name);
            assert!(mounted.report.map.unwrap().distortion_px.is_none());
            assert!(designed.report.map.unwrap().distortion_px.is_some());
        }
    }
}

/// A sensor that is shifted has every place of a picture shifted; a part that is shifted under parallel rays shows what is far away at
/// places that are shifted with it, and a floor that is shifted against it.
#[test]
fn a_known_pose_moves_the_places() {
    let profile = parsed(SMALL);
    let pixel_mm = designed(&profile).camera.pixel_mm;
    let sensor = r#"{"camera": {"principal_x_px": 8}}"#.to_owned();
    let part = format!(r#"{{"part": {{"decentre_x_um": {}}}}}"#, 8e3 * pixel_mm);
    let panorama = UnwrapPicture::Panorama { projection: None, width: Some(320) };
    let pictures = [
        (panorama, 0),
        (view([20.0, 0.0, 60.0], [160, 120]), 0),
        // (Eight pixels of the photo are one of the plan.)
        (ground(-40.0, 1600.0 * pixel_mm, 8.0 * pixel_mm), 1),
    ];
    for (picture, floor_px) in pictures {
        let designed = found(&profile, picture, None);
        let width = designed.size[0];
        for (pose, way, by) in [(&sensor, -8.0, 0), (&part, 8.0, floor_px)] {
            let mounted = found(&profile, picture, Some(pose));
            let mut compared = 0;
            for (k, at) in designed.places.iter().enumerate() {
                // (At both ends of a turn a direction is seen twice.)
                let is_inside =
                    |at: &DVec2| (10.0..150.0).contains(&at.x) && k % width + by < width;
                let Some(at) = at.filter(is_inside) else { continue };
                let Some(found) = mounted.places[k + by] else { continue };
                compared += 1;
                let off = found.distance(at + way * DVec2::X);
                assert!(off < 1e-3, "{picture:?} {pose}: {at} {found}");
            }
            let seen = designed.places.iter().flatten().count();
            assert!(compared as f64 > 0.8 * seen as f64, "{compared} of {seen}");
        }
    }
}

#[test]
fn pictures_that_cannot_be_are_refused_by_their_option() {
    let profile = parsed(SMALL);
    let refused = |picture: UnwrapPicture| match run(&profile, picture, None) {
        Err(error) => error,
        Ok(_) => panic!("{picture:?} is made"),
    };
    let size = [160, 120];
    for (angles, words) in [
        (
            [0.0, 91.0, 60.0],
            "--view must be AZ,EL,FOV with an elevation from -90 to 90 degrees, found 91",
        ),
        ([0.0, f64::NAN, 60.0], "elevation"),
        ([400.0, 0.0, 60.0], "azimuth from -360 to 360"),
        ([0.0, 0.0, 0.0], "field of more than 0"),
        ([0.0, 0.0, 180.0], "less than 180 degrees, found 180"),
        ([0.0, 90.0, 20.0], "shows nothing of this view; the panorama, without --view"),
    ] {
        let said = refused(view(angles, size));
        assert!(said.contains(words), "{said}");
    }
    assert!(refused(view([0.0, 0.0, 60.0], [70_000, 10])).contains("70000 x 10"));
    for (picture, words) in [
        (ground(0.0, 100.0, 1.0), "--ground must be finite, and not 0"),
        (ground(-40.0, -1.0, 1.0), "--range-mm must be positive"),
        (ground(-40.0, 100.0, 0.0), "--mm-per-px must be positive"),
        (ground(-40.0, 100.0, 1e-4), "--mm-per-px must be such that"),
        (ground(-40.0, 10.0, 1.0), "nothing of the floor at Z = -40 mm is seen nearer"),
    ] {
        let said = refused(picture);
        assert!(said.contains(words), "{said}");
    }
}
