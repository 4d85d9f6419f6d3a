//! What `morion render` shows, against closed forms of where it belongs.

use crate::support::builds::{SMALL, edited, files, folder, morion, save, told};
use crate::support::{designed, refused, shipped};
use morion::internals::geom::{DVec2, DVec3};
use morion::internals::num::{asinh, radians, tan};
use morion::internals::raster::{Raster, srgb};
use std::f64::consts::PI;
use std::path::Path;

/// An exact mirror: half a turn in each half of the frame, mercator.
const EXACT: (&str, &str) = ("[projection.cylindrical]", "[projection.mercator]");

/// Renders, and reads the picture and the number of rays.
#[track_caller]
fn rendered(folder: &Path, profile: &str, arguments: &[&str]) -> (Raster, u64) {
    let head = ["render", profile, "--format", "json", "--quiet", "--scene"];
    let (code, out, err) = told(&morion(folder, &[&head[..], arguments].concat()));
    assert_eq!((code, &*err), (0, ""), "{arguments:?}");
    let said: serde_json::Value = serde_json::from_str(&out).unwrap();
    let bytes = std::fs::read(folder.join(said["file"].as_str().unwrap())).unwrap();
    let picture = Raster::decode(&bytes).unwrap();
    assert_eq!(said["pixels"], serde_json::json!([picture.width, picture.height]));
    (picture, said["rays"].as_u64().unwrap())
}

fn at(picture: &Raster, x: usize, y: usize) -> [f32; 3] {
    picture.rgb[y * picture.width + x]
}

fn bright(picture: &Raster, x: usize, y: usize) -> f64 {
    at(picture, x, y).iter().map(|c| f64::from(*c)).sum()
}

/// The middle of the dark line that crosses a row of samples, counted from its middle one.
fn darkest(row: &[f64]) -> f64 {
    let n = row.len() as f64 - 1.0;
    let (first, last) = (row[0], row[row.len() - 1]);
    let ink = |k: usize| (first + (last - first) * k as f64 / n - row[k]).max(0.0);
    let [sum, moment] = (0..row.len()).fold([0.0, 0.0], |[sum, moment], k| {
        [sum + ink(k), moment + ink(k) * (k as f64 - 0.5 * n)]
    });
    assert!(sum > 0.1, "no line in {row:?}");
    moment / sum
}

#[test]
fn the_grid_in_an_exact_mirror_is_straight_and_where_it_belongs() {
    let folder = folder();
    let (picture, _) = rendered(folder.path(), "conformal", &["grid", "--smooth"]);
    let per_rad = 640.0 / PI;
    // The ridge in the middle shows z = -3 pi / 16.
    let row = |elevation: f64| 240.0 - (asinh(tan(radians(elevation))) + 3.0 * PI / 16.0) * per_rad;
    let column = |azimuth: f64| 320.0 + radians(azimuth) * per_rad;
    let mut lines = 0;
    for azimuth in [-75, -60, -45, -30, 30, 45, 60, 75].map(f64::from) {
        for y in (row(27.0) as usize..row(18.0) as usize).step_by(3) {
            let middle = column(azimuth);
            let first = middle as usize - 3;
            let samples: Vec<f64> = (0..7).map(|k| bright(&picture, first + k, y)).collect();
            let found = first as f64 + 3.5 + darkest(&samples);
            assert!((found - middle).abs() < 0.1, "meridian {azimuth} at {y}: {found} {middle}");
            lines += 1;
        }
    }
    for elevation in [-15.0, 15.0] {
        for azimuth in [-82, -67, -52, -37, 38, 53, 68, 82].map(f64::from) {
            let (x, middle) = (column(azimuth) as usize, row(elevation));
            let first = middle as usize - 3;
            let samples: Vec<f64> = (0..7).map(|k| bright(&picture, x, first + k)).collect();
            let found = first as f64 + 3.5 + darkest(&samples);
            assert!((found - middle).abs() < 0.1, "circle {elevation} at {x}: {found} {middle}");
            lines += 1;
        }
    }
    assert!(lines > 80, "{lines}");
}

/// A telecentric camera sees in a paraboloid what is in line with its focus: the pixel of a place in
/// the picture of `parabolic` with the camera upside down.
struct Paraboloid {
    focus: DVec3,
    /// Half its parameter: image radius over tan(psi / 2), mm.
    h: f64,
    pixel_mm: f64,
    height_mm: f64,
}

impl Paraboloid {
    fn shipped() -> Self {
        let design = designed(&shipped("parabolic"));
        let h = 30.0 / tan(radians(50.0));
        let top = design.mirror.position(DVec2::ZERO, &design.mirror.surface.at(DVec2::ZERO));
        let height_mm = design.camera.chart.plane_mm;
        Self { focus: top - DVec3::Z * (0.5 * h), h, pixel_mm: 60.0 / 480.0, height_mm }
    }

    fn pixel(&self, place: DVec3) -> DVec2 {
        let way = (place - self.focus).normalize();
        // tan(psi / 2) outwards.
        let q = way.truncate() / (1.0 + way.z) * self.h;
        DVec2::new(240.0 - q.x / self.pixel_mm, 240.0 + q.y / self.pixel_mm)
    }
}

#[test]
fn edges_of_the_chessboards_squares_are_where_the_paraboloid_puts_them() {
    let folder = folder();
    let square = 50.0;
    let arguments = ["chessboard", "--smooth", "--square-mm", "50"];
    let (picture, rays) = rendered(folder.path(), "parabolic", &arguments);
    // Only edges are sampled again.
    let again = rays - 480 * 480;
    assert!(again > 0 && again % 16 == 0 && again < 16 * 480 * 480 / 4, "{again}");
    let paraboloid = Paraboloid::shipped();
    // Up is -Z, the board 1.5 squares below the mirror; White, at the picture's foot before the
    // camera is turned, has the file a on its left.
    let board = |x: f64, y: f64| {
        let z = paraboloid.height_mm + 1.5 * square;
        paraboloid.pixel(DVec3::new(-x * square, y * square, z))
    };
    let mut places = 0;
    // Lines between files and between ranks, seen crossing rows and columns of the picture.
    for line in -3..=3 {
        let line = f64::from(line);
        for k in -19..=19 {
            let along = 0.1 * f64::from(k) + 0.003;
            // Clear of the corners, of the hole and of the pieces' shadows.
            if (along - along.round()).abs() < 0.25 || DVec2::new(line, along).length() < 0.9 {
                continue;
            }
            for of_files in [true, false] {
                if !of_files && line.abs() > 1.5 {
                    continue;
                }
                let point = |s: f64| if of_files { board(line, s) } else { board(s, line) };
                let (here, ahead) = (point(along), point(along + 1e-4));
                let way = ahead - here;
                let by_row = way.y.abs() > way.x.abs();
                let turn = |p: DVec2| if by_row { p } else { DVec2::new(p.y, p.x) };
                let (here, way) = (turn(here), turn(way));
                let row = here.y.floor();
                let exact = here.x + way.x / way.y * (row + 0.5 - here.y);
                let first = exact.floor() as usize - 4;
                let sample = |k: usize| {
                    let (x, y) = (first + k, row as usize);
                    if by_row { bright(&picture, x, y) } else { bright(&picture, y, x) }
                };
                let (left, right) = (sample(0), sample(8));
                let share = |k: usize| (sample(k) - right) / (left - right);
                let found = first as f64 + (0..9).map(share).sum::<f64>();
                assert!((left - right).abs() > 0.3, "no edge at {line} {along}: {left} {right}");
                assert!((found - exact).abs() < 0.1, "{line} {along}: {found} {exact}");
                places += 1;
            }
        }
    }
    assert!(places > 150, "{places}");
    // And the squares have their colours: a1 is dark.
    for (x, y) in [(-1.5, -1.5), (-1.5, -0.5), (1.5, 0.5), (1.5, 1.5), (-2.5, 0.5), (2.5, 0.5)] {
        let p = board(x, y);
        let dark = (x + y + 7.0_f64) as i64 % 2 == 0;
        let seen = bright(&picture, p.x as usize, p.y as usize);
        assert_eq!(seen < 0.6, dark, "{x} {y}: {seen}");
    }
}

/// A panorama of `width` columns whose codes are those of `code` in azimuth and elevation, degrees.
fn panorama(width: usize, code: impl Fn(f64, f64) -> [f64; 3]) -> Vec<u8> {
    let height = width / 2;
    let light = |k: usize| {
        let [x, y] = [k % width, k / width].map(|n| n as f64 + 0.5);
        let per_deg = width as f64 / 360.0;
        code(x / per_deg - 180.0, 90.0 - y / per_deg).map(|code| srgb::decode(code.round() as u8))
    };
    let rgb = (0..width * height).map(light).collect();
    Raster { width, height, rgb }.to_png().unwrap()
}

/// From 0 to 255 and back in `period`.
fn wave(x: f64, period: f64) -> f64 {
    510.0 * (x / period - (x / period).round()).abs()
}

#[test]
fn a_panorama_is_seen_at_its_pixels_and_in_one_colour_without_edges() {
    let folder = folder();
    let code = |a: f64, e: f64| [30.0 + wave(a, 360.0) * 0.8, 128.0 + e, 200.0 - e];
    std::fs::write(folder.path().join("ramp.png"), panorama(720, code)).unwrap();
    let (picture, _) = rendered(folder.path(), "conformal", &["ramp.png", "--smooth"]);
    for x in (8..640).step_by(39) {
        for y in (4..480).step_by(23) {
            // The lower half is the upper one turned about the ridge.
            let upper = y < 240;
            let (q, up) = if upper {
                (x as f64 + 0.5, 239.5 - y as f64)
            } else {
                (x as f64 + 0.5, y as f64 - 239.5)
            };
            let azimuth = (q - 320.0) / 640.0 * 180.0;
            let z = (up / 640.0 - 3.0 / 16.0) * PI;
            let elevation = morion::internals::num::degrees(morion::internals::num::atan(
                morion::internals::num::sinh(z),
            ));
            let azimuth = if upper { azimuth } else { 180.0 - azimuth };
            let azimuth = if azimuth > 180.0 { azimuth - 360.0 } else { azimuth };
            let found = at(&picture, x, y).map(|light| f64::from(srgb::encode(light)));
            let exact = code(azimuth, elevation);
            for c in 0..3 {
                assert!((found[c] - exact[c]).abs() < 1.6, "{x} {y}: {found:?} {exact:?}");
            }
        }
    }
    std::fs::write(folder.path().join("plain.png"), panorama(4, |_, _| [90.0; 3])).unwrap();
    let (picture, rays) = rendered(folder.path(), "conformal", &["plain.png", "--smooth"]);
    assert_eq!(rays, 640 * 480);
    assert!(picture.rgb.iter().all(|light| light.map(srgb::encode) == [90; 3]));
}

#[test]
fn the_mesh_shows_what_the_designed_mirror_shows_within_its_tolerance() {
    let folder = folder();
    let code = |a: f64, e: f64| [wave(a, 40.0), wave(e, 40.0), 99.0];
    std::fs::write(folder.path().join("waves.png"), panorama(1440, code)).unwrap();
    let orthographic = "[camera.orthographic]\npixels = [160, 120]";
    let pinhole = "[camera.pinhole]\npixels = [160, 120]\ndistance_mm = 300\nfocal_px = 3200";
    for camera in [orthographic, pinhole] {
        let finer = ("facet_px = 3", "facet_px = 0.5");
        let strip = (
            "[layout.conquistador]\npanel = \"refit\"\nridge = \"crest\"\nfill_frame = true",
            "[layout.strip]",
        );
        let frame = ("frame_filled = 0.99\n", "");
        let edits = [(orthographic, camera), EXACT, finer, strip, frame];
        save(folder.path(), &edited(SMALL, &edits));
        let [(mesh, _), (smooth, _)] = [&["waves.png"][..], &["waves.png", "--smooth"]]
            .map(|arguments| rendered(folder.path(), "small.toml", arguments));
        // Degrees a pixel, and codes a degree.
        let steepest = 0.5 * (360.0 / 160.0) * (510.0 / 40.0);
        let (mut worst, mut compared) = (0.0_f64, 0);
        for y in 46..74 {
            for x in 1..159 {
                let [a, b] = [&mesh, &smooth].map(|p| at(p, x, y).map(srgb::encode));
                for c in 0..2 {
                    worst = worst.max(f64::from(a[c].abs_diff(b[c])));
                }
                compared += 1;
            }
        }
        // Beside the peaks, where a pixel is sampled again for one of them, they differ a little more.
        assert!(worst > 0.0 && worst < steepest + 6.0, "{camera}: {worst} {steepest}");
        assert!(compared > 4000);
    }
}

#[test]
fn a_room_has_its_colours_in_their_directions() {
    let folder = folder();
    // Walls of a cube of 2 units around the mirror: front (+Y), right (+X), back and left.
    let room = "mtllib room.mtl
v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1
usemtl front\nf 4 3 7 8\nusemtl right\nf 3 2 6 7\nusemtl back\nf 2 1 5 6\nusemtl left\nf 1 4 8 5\n";
    let materials = "newmtl front\nKd 0.9 0.1 0.1\nnewmtl right\nKd 0.1 0.9 0.1
newmtl back\nKd 0.1 0.1 0.9\nnewmtl left\nKd 0.9 0.9 0.1\n";
    std::fs::create_dir(folder.path().join("models")).unwrap();
    std::fs::write(folder.path().join("models/room.obj"), room).unwrap();
    std::fs::write(folder.path().join("models/room.mtl"), materials).unwrap();
    let arguments = ["models/room.obj", "--smooth", "--unit-mm", "1e5"];
    let (picture, _) = rendered(folder.path(), "conformal", &arguments);
    assert!(folder.path().join("out/conformal/render-room-obj.png").exists());
    for (azimuth, expected) in [
        (0.0, [9.0, 1.0, 1.0]),
        (-40.0, [9.0, 1.0, 1.0]),
        (44.8, [9.0, 1.0, 1.0]),
        (45.2, [1.0, 9.0, 1.0]),
        (80.0, [1.0, 9.0, 1.0]),
        (-44.8, [9.0, 1.0, 1.0]),
        (-45.2, [9.0, 9.0, 1.0]),
    ] {
        let x = (320.0 + azimuth / 180.0 * 640.0) as usize;
        let light = at(&picture, x, 118).map(f64::from);
        let least = light.iter().copied().fold(f64::INFINITY, f64::min);
        for c in 0..3 {
            let ratio = light[c] / least;
            assert!((ratio - expected[c]).abs() < 0.5, "{azimuth}: {light:?}");
        }
    }
    // The other half turn is below: the back is in the middle.
    let [r, _, b] = at(&picture, 320, 361);
    assert!(b > 5.0 * r);
}

#[test]
#[ignore = "long: .ci/nightly"]
fn the_count_of_threads_does_not_show() {
    let folder = folder();
    save(folder.path(), SMALL);
    for scene in ["chessboard", "views", "cylinder"] {
        let [one, two, seven] = ["1", "2", "7"].map(|threads| {
            let arguments =
                ["render", "small.toml", "--scene", scene, "--threads", threads, "--out", threads];
            assert_eq!(told(&morion(folder.path(), &arguments)).0, 0);
            files(&folder.path().join(threads).join("small"))
        });
        assert!(one == two && two == seven, "{scene}");
        assert!(one.contains_key(&format!("render-{scene}.png")));
    }
}

#[test]
fn the_front_view_has_the_parts_proportions() {
    let folder = folder();
    save(folder.path(), SMALL);
    let (picture, _) = rendered(folder.path(), "small.toml", &["views"]);
    let part = |x: usize, y: usize| at(&picture, x, y) != [1.0; 3];
    let across = (0..480).filter(|&x| part(x, 180)).count() as f64;
    let down = (0..360).filter(|&y| part(240, y)).count() as f64;
    // 160 x 120 pixels are filled.
    assert!((across / down - 4.0 / 3.0).abs() < 0.01, "{across} {down}");
}

#[test]
fn what_cannot_be_rendered_is_told_and_nothing_is_written() {
    let folder = folder();
    let home = folder.path();
    let put = |name: &str, bytes: &[u8]| std::fs::write(home.join(name), bytes).unwrap();
    put("high.png", &Raster::new(9, 9, [0.5; 3]).to_png().unwrap());
    put("text.png", b"no picture");
    put("bare.obj", b"v 0 0 0\n");
    put("lost.obj", b"mtllib gone.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    put("dull.obj", b"mtllib dull.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n");
    put("dull.mtl", b"newmtl a\nKd 1 0\n");
    std::fs::create_dir(home.join("folder")).unwrap();
    let before = std::fs::read_dir(home).unwrap().count();
    for (arguments, words) in [
        (
            &["chesboard"][..],
            &[
                "chesboard: no such file",
                "grid, chessboard, errors, views and cylinder",
                "did you mean chessboard?",
            ][..],
        ),
        (&["gone.png"], &["gone.png: no such file"]),
        (&["folder"], &["cannot read folder"]),
        (&["high.png"], &["high.png", "9 x 9", "at most half as high"]),
        (&["text.png"], &["text.png", "no PNG, JPEG or EXR"]),
        (&["bare.obj"], &["bare.obj", "no facets"]),
        (&["lost.obj"], &["lost.obj", "cannot read gone.mtl"]),
        (&["dull.obj"], &["dull.mtl: line 2: Kd must be one or three numbers"]),
        (&["grid", "--square-mm", "50"], &["--square-mm is for the chessboard"]),
        (&["views", "--unit-mm", "2"], &["--unit-mm is for OBJ models"]),
        (&["cylinder"], &["--smooth is for what the camera sees"]),
        (&["chessboard", "--square-mm", "0"], &["--square-mm", "millimetres from 1e-6"]),
        (&["chessboard", "--square-mm", "nan"], &["--square-mm", "millimetres from 1e-6"]),
    ] {
        let all = [&["render", "conformal", "--smooth", "--scene"], arguments].concat();
        refused(home, &all, words);
    }
    assert_eq!(std::fs::read_dir(home).unwrap().count(), before);
    let (code, _, err) = told(&morion(home, &["render", "conformal"]));
    assert_eq!((code, err.contains("--scene")), (2, true));
}

#[test]
fn the_summary_names_file_size_and_what_was_traced() {
    let folder = folder();
    save(folder.path(), SMALL);
    let (code, out, err) =
        told(&morion(folder.path(), &["render", "small.toml", "--scene", "grid"]));
    assert_eq!(code, 0);
    assert!(out.contains("the mesh written as stl and read back"), "{out}");
    assert!(out.contains("render-grid.png  160 x 120 pixels, "), "{out}");
    let stages: Vec<&str> = err.lines().map(|line| line.split(' ').next().unwrap()).collect();
    assert_eq!(stages, ["design", "mesh", "solid", "write", "read", "trace", "picture", "write"]);
}
