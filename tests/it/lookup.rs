//! Look-up tables: from pixels to directions and a floor, and back, in each of their files.

use crate::support::builds::{SMALL, folder, morion, parsed, told};
use crate::support::{designed, shipped};
use morion::internals::lookup::{Direction, FloorPlane};
use morion::internals::num::{cos, radians, sin, tan};
use morion::internals::pipeline::{Command, Error, OutputFile, Silent, TableOptions};
use morion::internals::profile::Profile;
use morion::internals::results::TableReport;
use std::io::Write;
use std::path::Path;
use std::process::Stdio;

fn made(profile: &Profile, options: &TableOptions) -> (TableReport, Vec<OutputFile>) {
    options.in_memory(profile, &Silent).unwrap_or_else(|error| panic!("{error}"))
}

fn bytes<'f>(files: &'f [OutputFile], name: &str) -> &'f [u8] {
    &files.iter().find(|file| file.name == name).unwrap_or_else(|| panic!("no {name}")).bytes
}

/// Shape and numbers of an array of NumPy in single precision.
fn array(bytes: &[u8]) -> (Vec<usize>, Vec<f32>) {
    assert!(bytes.starts_with(b"\x93NUMPY\x01\x00"));
    let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let header = std::str::from_utf8(&bytes[10..10 + length]).unwrap();
    assert!(header.contains("'<f4'") && (10 + length) % 64 == 0, "{header}");
    let shape = header.split_once('(').unwrap().1.split_once(')').unwrap().0;
    let shape = shape.split(',').map(|n| n.trim().parse().unwrap()).collect();
    let (numbers, rest) = bytes[10 + length..].as_chunks();
    assert!(rest.is_empty());
    (shape, numbers.iter().map(|four| f32::from_le_bytes(*four)).collect())
}

/// The numbers of each node of `table.npy`.
fn nodes(files: &[OutputFile]) -> Vec<Vec<f64>> {
    let (shape, numbers) = array(bytes(files, "table.npy"));
    numbers.chunks(shape[2]).map(|node| node.iter().map(|&x| f64::from(x)).collect()).collect()
}

/// Every ray of a mirror with a single viewpoint passes through it: the floor is where the direction from there meets it.
#[test]
#[ignore = "long: .ci/nightly"]
fn a_single_viewpoint_says_where_the_floor_is() {
    for (name, polar_deg) in [("hyperbolic", 110.0), ("parabolic", 100.0)] {
        let profile = shipped(name);
        // The rim, 30 mm from the axis at the base's 5 mm, is seen from there under the polar angle of the rim.
        let viewpoint_mm = 5.0 - 30.0 / tan(radians(polar_deg));
        for floor_mm in [-150.0, 400.0] {
            let options = TableOptions {
                floor_mm: Some(floor_mm),
                range_mm: Some(2000.0),
                ..TableOptions::default()
            };
            let (report, files) = made(&profile, &options);
            let mut met = 0;
            for node in nodes(&files).into_iter().filter(|node| !node[4].is_nan()) {
                let [azimuth, elevation] = [radians(node[0]), radians(node[1])];
                let way = (floor_mm - viewpoint_mm) * tan(std::f64::consts::FRAC_PI_2 - elevation);
                let [x, y] = [way * sin(azimuth), way * cos(azimuth)];
                // (Angles are in single precision.)
                let slack = 1e-4 * (1.0 + (x * x + y * y) / floor_mm.abs());
                let off = ((x - node[4]).abs()).max((y - node[5]).abs());
                assert!(off < slack, "{name}: {off} {node:?}");
                met += 1;
            }
            assert!(met > 500, "{name} {floor_mm}: {met}");
            let floor = report.floor.unwrap();
            assert!(
                floor.field.off_px.unwrap().max <= 0.25 && floor.field.told > 0.85,
                "{floor:?}"
            );
        }
    }
}

/// The sensor's shift by the pixels of a block is the shift of the table by a node, and so is that of a part under parallel rays, whose
/// floor is shifted with it.
#[test]
#[ignore = "long: .ci/nightly"]
fn a_mounted_part_is_seen_where_it_is() {
    let profile = parsed(SMALL);
    let pixel_mm = designed(&profile).camera.pixel_mm;
    let folder = folder();
    let path = folder.path().join("pose.json");
    let table = |pose: Option<&str>| {
        if let Some(text) = pose {
            std::fs::write(&path, text).unwrap();
        }
        let pose = pose.map(|_| path.as_path());
        let options = TableOptions { floor_mm: Some(-40.0), pose, ..TableOptions::default() };
        nodes(&made(&profile, &options).1)
    };
    let designed = table(None);
    let sensor = table(Some(r#"{"camera": {"principal_x_px": 4}}"#));
    let moved_um = 4e3 * pixel_mm;
    let part =
        table(Some(&format!(r#"{{"part": {{"decentre_x_um": {moved_um}}}, "note": "measured"}}"#)));
    let columns = 160 / 4;
    let mut compared = 0;
    for k in (0..designed.len()).filter(|k| (1..columns - 1).contains(&(k % columns))) {
        let pairs =
            [(&sensor[k], &designed[k + 1], 0.0), (&part[k], &designed[k - 1], 1e-3 * moved_um)];
        for (found, exact, moved_mm) in pairs {
            if found[4].is_nan() || exact[4].is_nan() {
                continue;
            }
            compared += 1;
            let turned = (found[0] - exact[0]).abs();
            assert!(turned.min(360.0 - turned) < 1e-4 && (found[1] - exact[1]).abs() < 1e-4);
            assert!((found[4] - exact[4] - moved_mm).abs() < 1e-3, "{found:?} {exact:?}");
            assert!((found[5] - exact[5]).abs() < 1e-3);
            // A part whose mounting is known differs from others by its form alone.
            assert!(found[2] < exact[2] && found[3] < exact[3], "{found:?} {exact:?}");
        }
    }
    assert!(compared > 500, "{compared}");
}

/// Compiles a header with a program that reads places and prints what they show.
fn compiled(folder: &Path, header: &[u8]) -> std::path::PathBuf {
    std::fs::write(folder.join("table.h"), header).unwrap();
    let program = "#include \"table.h\"
#include <stdio.h>
int main(void) {
  float x, y, a = 0, e = 0, p = 0, q = 0;
  while (scanf(\"%f %f\", &x, &y) == 2) {
    int look = morion_look(x, y, &a, &e), floor = morion_floor(x, y, &p, &q);
    printf(\"%d %.7g %.7g %d %.7g %.7g\\n\", look, a, e, floor, p, q);
  }
  return 0;
}
";
    std::fs::write(folder.join("main.c"), program).unwrap();
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".into());
    let mut command = std::process::Command::new(compiler);
    command.args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-O1", "main.c", "-lm", "-o", "main"]);
    let done = command.current_dir(folder).output().expect("a C compiler");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    folder.join("main")
}

/// What a compiled header says of places.
fn said(program: &Path, places: &[[f64; 2]]) -> Vec<[f64; 6]> {
    let mut child = std::process::Command::new(program)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = child.stdin.take().unwrap();
    let lines: String = places.iter().map(|[x, y]| format!("{x} {y}\n")).collect();
    let writer = std::thread::spawn(move || input.write_all(lines.as_bytes()).unwrap());
    let out = child.wait_with_output().unwrap();
    writer.join().unwrap();
    let line = |line: &str| {
        let numbers: Vec<f64> = line.split(' ').map(|n| n.parse().unwrap()).collect();
        <[f64; 6]>::try_from(numbers).unwrap()
    };
    String::from_utf8(out.stdout).unwrap().lines().map(line).collect()
}

/// Unit vector of two angles, rad.
fn vector([azimuth, elevation]: [f64; 2]) -> [f64; 3] {
    [cos(elevation) * sin(azimuth), cos(elevation) * cos(azimuth), sin(elevation)]
}

fn apart<const N: usize>(a: [f64; N], b: [f64; N]) -> f64 {
    (0..N).map(|k| (a[k] - b[k]) * (a[k] - b[k])).sum::<f64>().sqrt()
}

/// How far what is told of a pixel is off, px, by the differences of its neighbours' figures; none where those do not tell, at rims and
/// ridges.
fn off_px<const N: usize>(
    told: [f64; N],
    (k, width): (usize, usize),
    of: impl Fn(usize) -> [f64; N],
) -> Option<f64> {
    let here = of(k);
    let along = |step: usize| {
        let [before, after] = [of(k - step), of(k + step)];
        let ways = [apart(here, before), apart(after, here)];
        let is_smooth = ways[0] < 1.5 * ways[1] && ways[1] < 1.5 * ways[0];
        is_smooth.then(|| -> [f64; N] { std::array::from_fn(|i| 0.5 * (after[i] - before[i])) })
    };
    let dot = |a: &[f64; N], b: &[f64; N]| (0..N).map(|i| a[i] * b[i]).sum::<f64>();
    let (x, y) = (along(1)?, along(width)?);
    let off: [f64; N] = std::array::from_fn(|i| told[i] - here[i]);
    // Least squares of off = a x + b y.
    let [xx, xy, yy, p, q] = [dot(&x, &x), dot(&x, &y), dot(&y, &y), dot(&x, &off), dot(&y, &off)];
    let area = xx * yy - xy * xy;
    let [a, b] = [(p * yy - q * xy) / area, (q * xx - p * xy) / area];
    Some((a * a + b * b).sqrt())
}

/// Header against a table with a node in each pixel: of 320 x 240 pixels its tables take at most 40 kB, and what it tells of the middle of
/// a pixel is off by no more than a quarter of a pixel, in directions and on the floor. (Differences of neighbours stand for derivatives:
/// a tenth is theirs.)
#[test]
#[ignore = "long: .ci/nightly"]
fn the_header_for_c_is_off_by_a_quarter_of_a_pixel_at_most() {
    let soccer = shipped("soccer");
    let folded = parsed(SMALL);
    for (profile, floor_mm, told) in [(&soccer, 204.0, 0.9), (&folded, -40.0, 0.9)] {
        let options = TableOptions { floor_mm: Some(floor_mm), ..TableOptions::default() };
        let (report, files) = made(profile, &options);
        assert!(report.header_bytes <= 40_000, "{}", report.header_bytes);
        let directions = report.directions;
        assert!(directions.off_px.unwrap().max <= 0.25 && directions.told > told, "{directions:?}");
        let folder = folder();
        let program = compiled(folder.path(), bytes(&files, "table.h"));
        let exact = nodes(&made(profile, &TableOptions { every: 1, ..options }).1);
        let [width, height] = report.frame_px;
        let place = |k: usize| [(k % width) as f64 + 0.5, (k / width) as f64 + 0.5];
        let places: Vec<[f64; 2]> = (0..width * height).map(place).collect();
        let look = |k: usize| vector([0, 1].map(|i| radians(exact[k][i])));
        let floor = |k: usize| [exact[k][4], exact[k][5]];
        let (mut compared, mut looked) = ([0; 2], 0);
        for (k, said) in said(&program, &places).into_iter().enumerate() {
            let (x, y) = (k % width, k / width);
            if !(1..width - 1).contains(&x) || !(1..height - 1).contains(&y) {
                continue;
            }
            looked += usize::from(said[0] == 1.0);
            let directed = off_px(vector([said[1], said[2]]), (k, width), look);
            if let Some(off) = directed.filter(|_| said[0] == 1.0) {
                assert!(off <= 0.275, "{x} {y}: {off}");
                compared[0] += 1;
            }
            let placed = off_px([said[4], said[5]], (k, width), floor);
            if let Some(off) = placed.filter(|_| said[3] == 1.0) {
                assert!(off <= 0.275, "{x} {y}: {off}");
                compared[1] += 1;
            }
        }
        let seen = exact.iter().filter(|node| !node[0].is_nan()).count();
        assert!(looked as f64 > told * 0.97 * seen as f64, "{looked} of {seen}");
        assert!(
            compared[0] as f64 > 0.85 * seen as f64 && compared[1] > 2000,
            "{compared:?} of {seen}"
        );
    }
}

/// The ways back lead to places that look where they should, within a twentieth of a pixel of the picture; both forms of a map agree.
#[test]
fn maps_lead_back_to_where_pixels_look() {
    for (profile, floor_mm) in [(shipped("soccer"), 204.0), (parsed(SMALL), -40.0)] {
        let options = TableOptions {
            floor_mm: Some(floor_mm),
            deg_per_px: 1.0,
            mm_per_px: Some(floor_mm.abs() / 20.0),
            ..TableOptions::default()
        };
        let (report, files) = made(&profile, &options);
        let design = designed(&profile);
        // (A little wider than the plan.)
        let plane = FloorPlane { z_mm: floor_mm, range_mm: 6.0 * floor_mm.abs() };
        for (name, facts) in [("panorama", report.panorama), ("floor", report.floor.unwrap().plan)]
        {
            let (shape, numbers) = array(bytes(&files, &format!("{name}-map.npy")));
            let [width, height] = facts.pixels;
            assert_eq!(shape, [height, width, 2]);
            let top = facts.corner[1] / facts.per_px;
            let pictures = ["x", "y"].map(|axis| bytes(&files, &format!("{name}-{axis}.pgm")));
            let (mut seen, mut worst) = (0, 0.0f64);
            for k in 0..width * height {
                let place = [0, 1].map(|i| f64::from(numbers[2 * k + i]) + 0.5);
                let pixel = pictures.map(|picture| {
                    let at = picture.len() - 2 * (width * height - k);
                    usize::from(u16::from_be_bytes([picture[at], picture[at + 1]]))
                });
                if numbers[2 * k] < 0.0 && numbers[2 * k + 1] < 0.0 && place == [-0.5; 2] {
                    assert_eq!(pixel, [65_535; 2]);
                    continue;
                }
                seen += 1;
                assert!(
                    (0..2).all(|i| (place[i] - 0.5 - pixel[i] as f64).abs() < 0.501),
                    "{place:?} {pixel:?}"
                );
                let point = design.camera.image_point(place[0], place[1]);
                let ray = traced(&design, point);
                let (x, y) = ((k % width) as f64 + 0.5, (k / width) as f64 + 0.5);
                let off = if name == "floor" {
                    let [fx, fy] = plane.meets(&ray).unwrap();
                    let middle = 0.5 * width as f64;
                    apart([middle + fx / facts.per_px, middle - fy / facts.per_px], [x, y])
                } else {
                    let Direction { azimuth_deg, elevation_deg } = Direction::of(&ray);
                    let turned = (azimuth_deg + 180.0) / facts.per_px - x;
                    let turn = 360.0 / facts.per_px;
                    let turned = turned - turn * (turned / turn).round();
                    // Near the pole columns are narrow.
                    let narrow = cos(radians(elevation_deg));
                    apart([narrow * turned, top - elevation_deg / facts.per_px], [0.0, y])
                };
                worst = worst.max(off);
            }
            assert!(worst < 0.05, "{name}: {worst}");
            assert!(seen as f64 > 0.3 * (width * height) as f64, "{name}: {seen}");
            assert!((facts.seen - seen as f64 / (width * height) as f64).abs() < 1e-12);
        }
    }
}

/// The ray that leaves the designed mirror towards what an image point shows.
fn traced(
    design: &morion::internals::design::Design,
    point: morion::internals::geom::DVec2,
) -> morion::internals::geom::Ray {
    let on_chart = design.camera.picture.chart_point(point);
    let place = design.mirror.intersect_camera_ray(&design.camera.chart, on_chart).unwrap();
    let surface = design.mirror.local_surface(place);
    let ray = design.camera.ray(point, surface.at.z + 10.0);
    let direction = morion::internals::optics::reflect(ray.direction, surface.normal());
    morion::internals::geom::Ray { origin: surface.at, direction }
}

#[test]
fn bad_options_and_poses_are_refused_by_name() {
    let profile = parsed(SMALL);
    let refused = |options: &TableOptions| match options.in_memory(&profile, &Silent) {
        Err(error @ (Error::Option { .. } | Error::Pose { .. } | Error::File(_))) => {
            error.to_string()
        }
        Err(error) => panic!("{error}"),
        Ok(_) => panic!("it is made"),
    };
    let usual = TableOptions::default();
    let said = refused(&TableOptions { every: 0, ..usual });
    assert!(said.contains("--every must be a whole number from 1 to 60"), "{said}");
    let near = TableOptions { floor_mm: Some(-40.0), range_mm: Some(10.0), ..usual };
    let said = refused(&near);
    assert!(said.contains("--range-mm must be more than") && said.contains("found 10"), "{said}");
    let said = refused(&TableOptions { floor_mm: Some(0.0), ..usual });
    assert!(said.contains("--floor-mm must be finite, and not 0"), "{said}");
    let said = refused(&TableOptions { floor_mm: Some(100.0), mm_per_px: Some(1e-4), ..usual });
    assert!(said.contains("--mm-per-px"), "{said}");
    let folder = folder();
    let path = folder.path().join("pose.json");
    let pose = |text: &str| {
        std::fs::write(&path, text).unwrap();
        refused(&TableOptions { pose: Some(&path), ..usual })
    };
    let said = pose(r#"{"part": {"tilt_mrad": 2}}"#);
    assert!(
        said.contains("part.tilt_mrad is none of its keys") && said.contains("tilt_x_mrad"),
        "{said}"
    );
    let said = pose("{\"part\":\n {\"tilt_x_mrad\": \"two\"}}");
    assert!(said.contains("line 2"), "{said}");
    let said = refused(&TableOptions { pose: Some(Path::new("nowhere.json")), ..usual });
    assert!(said.contains("nowhere.json"), "{said}");
}

/// A replayed trial's own pose is taken, and what the program prints and writes is the same.
#[test]
fn the_pose_of_a_replayed_trial_is_taken() {
    let folder = folder();
    std::fs::write(folder.path().join("small.toml"), SMALL).unwrap();
    let run = |arguments: &[&str]| {
        let (code, out, err) = told(&morion(folder.path(), arguments));
        assert!(code < 2, "{arguments:?}: {err}");
        out
    };
    run(&["tolerance", "small.toml", "--replay", "3", "--without", "stepover_mm", "--quiet"]);
    let pose = "out/small/replay-3/pose.json";
    let out = run(&["table", "small.toml", "--floor-mm", "-40", "--pose", pose, "--quiet"]);
    assert!(out.contains("as mounted by out/small/replay-3/pose.json"), "{out}");
    let table = std::fs::read_to_string(folder.path().join("out/small/table/table.csv")).unwrap();
    let first = table.lines().next().unwrap();
    assert_eq!(
        first,
        "x_px,y_px,azimuth_deg,elevation_deg,azimuth_sd_deg,elevation_sd_deg,floor_x_mm,floor_y_mm,floor_x_sd_mm,floor_y_sd_mm"
    );
    assert!(table.lines().count() > 1000);
}
