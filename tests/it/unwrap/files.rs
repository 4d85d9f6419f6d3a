//! The command: its files, its figures and its refusals.

use crate::support::builds::{files, folder, morion, told};
use crate::support::refused;
use morion::internals::raster::Raster;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// A small conquistador, and a ring, whose designs take a moment.
const FOLDED: &str = "camera.orthographic.pixels = [160, 120]
projection.cylindrical = { azimuth_deg = [-180, 180], elevation_deg = [-30, 30] }
layout.conquistador.fill_frame = true
method.vector-field.degree = 8
part = { width_mm = 15, base_mm = 2 }
mesh.chord_um = 20
export.formats = [\"stl\"]
";
const GIVEN: &str = "camera.orthographic.pixels = [160, 120]
mirror.polynomial = { radius_mm = 20 }
part = { width_mm = 15, height_mm = 10, base_mm = 2 }
mesh.chord_um = 20
export.formats = [\"stl\"]
";

/// A smooth picture without symmetry.
pub(super) fn picture(width: usize, height: usize) -> Raster {
    let pixel = |k: usize| {
        let (x, y) = ((k % width) as f32 / width as f32, (k / width) as f32 / height as f32);
        [0.1 + 0.8 * x, 0.1 + 0.8 * y, 0.9 - 0.8 * x * y]
    };
    Raster { width, height, rgb: (0..width * height).map(pixel).collect() }
}

pub(super) fn home() -> tempfile::TempDir {
    let home = folder();
    let save = |name: &str, bytes: &[u8]| std::fs::write(home.path().join(name), bytes).unwrap();
    save("folded.toml", FOLDED.as_bytes());
    save("given.toml", GIVEN.as_bytes());
    save("photo.png", &picture(160, 120).to_png().unwrap());
    home
}

/// Runs `morion unwrap` with `arguments`; its report.
#[track_caller]
pub(super) fn unwrapped(home: &Path, arguments: &str) -> Value {
    let all: Vec<&str> =
        ["unwrap", "--format", "json", "-q"].into_iter().chain(arguments.split(' ')).collect();
    let (code, out, err) = told(&morion(home, &all));
    assert_eq!((code, &*err), (0, ""), "{arguments}");
    serde_json::from_str(&out).unwrap()
}

pub(super) fn read(home: &Path, name: &str) -> Vec<u8> {
    std::fs::read(home.join("out/folded").join(name)).unwrap()
}

/// Shape and numbers of a .npy file, read by its definition.
pub(super) fn npy(bytes: &[u8]) -> ([usize; 3], Vec<[f32; 2]>) {
    assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
    let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    assert_eq!((10 + length) % 64, 0);
    let header = std::str::from_utf8(&bytes[10..10 + length]).unwrap();
    assert!(
        header.starts_with("{'descr': '<f4', 'fortran_order': False, ") && header.ends_with('\n')
    );
    let shape = header.split(['(', ')']).nth(1).unwrap();
    let shape: Vec<usize> = shape.split(", ").map(|n| n.parse().unwrap()).collect();
    let numbers = bytes[10 + length..]
        .chunks_exact(8)
        .map(|pair| [0, 4].map(|k| f32::from_le_bytes(pair[k..k + 4].try_into().unwrap())));
    (shape.try_into().unwrap(), numbers.collect())
}

#[test]
fn the_maps_hold_the_photos_columns_and_rows_and_give_the_same_panorama() {
    let home = home();
    let home = home.path();
    let report = unwrapped(home, "photo.png --profile folded.toml --map npy");
    unwrapped(home, "photo.png --profile folded.toml --map exr");
    let names: Vec<String> = files(&home.join("out/folded")).into_keys().collect();
    assert_eq!(names, ["photo-map.exr", "photo-map.npy", "photo-unwrapped.png"]);
    let (shape, places) = npy(&read(home, "photo-map.npy"));
    assert_eq!(shape, [60, 320, 2]);
    assert_eq!(places.len(), 60 * 320);

    let seen = places.iter().filter(|place| **place != [-1.0; 2]).count();
    let share = seen as f64 / places.len() as f64;
    assert_eq!(report["map"]["seen"], share);
    assert!(share > 0.97 && share < 1.0, "{share}");
    assert!(places.iter().all(|p| *p == [-1.0; 2] || (-0.5..159.5).contains(&p[0])));
    // The halves: upright, and the lower one turned by half a turn.
    let at = |x: usize, y: usize| places[y * 320 + x];
    let near = |found: [f32; 2], x: f32, y: f32| {
        assert!((found[0] - x).abs() < 1.0 && (found[1] - y).abs() < 1.0, "{found:?} {x} {y}");
    };
    near(at(80, 30), 80.0, 30.0);
    near(at(40, 10), 40.0, 10.0);
    near(at(160 + 80, 30), 79.0, 89.0);
    near(at(160 + 40, 10), 119.0, 109.0);

    let photo = Raster::decode(&std::fs::read(home.join("photo.png")).unwrap()).unwrap();
    let panorama = Raster::decode(&read(home, "photo-unwrapped.png")).unwrap();
    assert_eq!([panorama.width, panorama.height], [320, 60]);
    for (place, light) in places.iter().zip(&panorama.rgb) {
        // Away from the ridge, over which OpenCV would look.
        if (place[1] - 59.5).abs() < 3.0 {
            continue;
        }
        let [x, y] = place.map(|x| f64::from(x) + 0.5);
        let wanted = if place[0] == -1.0 { [0.0; 3] } else { photo.sample(x, y, false) };
        let off = (0..3).map(|c| (wanted[c] - light[c]).abs()).fold(0.0, f32::max);
        assert!(off < 0.005, "{place:?}: {wanted:?} {light:?}");
    }

    let exr = exr::prelude::read_all_flat_layers_from_file(home.join("out/folded/photo-map.exr"));
    let layer = &exr.unwrap().layer_data[0];
    assert_eq!(layer.size, (320, 60).into());
    for (name, index) in [("R", 0), ("G", 1)] {
        let mut channels = layer.channel_data.list.iter();
        let channel = channels.find(|channel| channel.name.to_string() == name).unwrap();
        assert!(channel.sample_data.values_as_f32().eq(places.iter().map(|place| place[index])));
    }
}

#[test]
fn cuts_are_the_photos_own_pixels() {
    let home = home();
    let home = home.path();
    let report = unwrapped(home, "photo.png --profile folded.toml --cuts");
    assert_eq!(report["panorama"]["way"], "cuts");
    assert!(report.get("map").is_none());
    let photo = Raster::decode(&std::fs::read(home.join("photo.png")).unwrap()).unwrap();
    let cut = Raster::decode(&read(home, "photo-unwrapped.png")).unwrap();
    assert_eq!([cut.width, cut.height], [320, 60]);
    for (k, light) in cut.rgb.iter().enumerate() {
        let (x, y) = (k % 320, k / 320);
        let from = if x < 160 { [x, y] } else { [319 - x, 119 - y] };
        assert_eq!(*light, photo.rgb[from[1] * 160 + from[0]], "{x} {y}");
    }
}

#[test]
fn photos_of_any_resolution_and_panoramas_of_any_width() {
    let home = home();
    let home = home.path();
    std::fs::write(home.join("large.png"), picture(480, 360).to_png().unwrap()).unwrap();
    let range = |report: &Value| report["panorama"]["azimuth_deg"].clone();
    let one = unwrapped(home, "photo.png --profile folded.toml --map npy");
    let three = unwrapped(home, "large.png --profile folded.toml --map npy");
    assert_eq!(three["photo"]["pixels_per_sensor_pixel"], 3.0);
    assert_eq!(three["panorama"]["pixels"], serde_json::json!([960, 180]));
    assert_eq!(range(&one), range(&three));
    let (_, small) = npy(&read(home, "photo-map.npy"));
    let (_, large) = npy(&read(home, "large-map.npy"));
    for y in 0..60 {
        for x in 0..320 {
            // The middle one of three by three pixels has the same centre.
            let (a, b) = (small[y * 320 + x], large[(3 * y + 1) * 960 + 3 * x + 1]);
            if a == [-1.0; 2] {
                assert_eq!(b, a, "{x} {y}");
                continue;
            }
            for c in 0..2 {
                assert!((3.0 * (a[c] + 0.5) - (b[c] + 0.5)).abs() < 1e-3, "{x} {y}: {a:?} {b:?}");
            }
        }
    }
    // A narrower panorama of the larger photo is the smaller photo's, averaged.
    let narrow = unwrapped(home, "large.png --profile folded.toml --width 320");
    assert_eq!(narrow["panorama"]["pixels"], serde_json::json!([320, 60]));
    let [narrow, small] = ["large", "photo"]
        .map(|name| Raster::decode(&read(home, &format!("{name}-unwrapped.png"))).unwrap());
    for (a, b) in narrow.rgb.iter().zip(&small.rgb) {
        assert!((0..3).all(|c| (a[c] - b[c]).abs() < 0.02), "{a:?} {b:?}");
    }
    // Equal elevations in equal steps.
    let even = unwrapped(home, "photo.png --profile folded.toml --projection equirectangular");
    let elevation =
        |report: &Value, k: usize| report["panorama"]["elevation_deg"][k].as_f64().unwrap();
    assert!((elevation(&even, 1) - elevation(&one, 1)).abs() < 0.6);
    let rows = even["panorama"]["pixels"][1].as_f64().unwrap();
    let per_row = (elevation(&even, 1) - elevation(&even, 0)) / rows;
    assert!((per_row - 360.0 / 320.0).abs() < 1e-9, "{per_row}");
}

#[test]
fn a_round_mirror_unrolls_at_the_scale_of_its_rim() {
    let home = home();
    let home = home.path();
    std::fs::write(home.join("round.png"), picture(480, 480).to_png().unwrap()).unwrap();
    let report = unwrapped(home, "round.png --profile parabolic");
    assert_eq!(report["panorama"]["projection"], "equirectangular");
    let width = (std::f64::consts::PI * 480.0).round();
    assert_eq!(report["panorama"]["pixels"][0], width as u64);
    // Laws that reach the pole at infinity stop before.
    let report =
        unwrapped(home, "round.png --profile parabolic --projection cylindrical --width 700");
    let top = report["panorama"]["elevation_deg"][1].as_f64().unwrap();
    assert!((top - 75.0).abs() < 0.1, "{top}");
}

#[test]
fn the_number_of_threads_does_not_show() {
    let home = home();
    let home = home.path();
    let run = |threads: &str| -> BTreeMap<String, Vec<u8>> {
        let all = format!("photo.png --profile folded.toml --map exr --threads {threads}");
        unwrapped(home, &all);
        files(&home.join("out/folded"))
    };
    let (one, three) = (run("1"), run("3"));
    assert!(one == three);
}

/// Expects exit 2, nothing on stdout, and one message that holds all of `words`.
#[track_caller]
fn unable(home: &Path, arguments: &str, words: &[&str]) {
    let all: Vec<&str> = ["unwrap", "-q"].into_iter().chain(arguments.split(' ')).collect();
    refused(home, &all, words);
}

#[test]
fn what_cannot_be_unwrapped_is_refused_with_a_remedy_and_nothing_is_written() {
    let home = home();
    let home = home.path();
    let save = |name: &str, bytes: &[u8]| std::fs::write(home.join(name), bytes).unwrap();
    let png = picture(160, 120).to_png().unwrap();
    save("cut.png", &png[..png.len() / 2]);
    save("text.png", b"no picture at all");
    save("wide.png", &picture(160, 100).to_png().unwrap());
    save("square.png", &picture(60, 60).to_png().unwrap());
    let at = "--profile folded.toml";
    unable(home, &format!("cut.png {at}"), &["cut.png: the PNG picture is cut off"]);
    unable(home, &format!("text.png {at}"), &["text.png: this is no PNG, JPEG or EXR"]);
    unable(home, &format!("none.png {at}"), &["cannot read none.png"]);
    unable(home, &format!(". {at}"), &["./cut.png: the PNG picture is cut off"]);
    unable(home, &format!("wide.png {at}"), &["160 x 100", "160 x 120", "crop it"]);
    unable(home, "photo.png --profile given.toml", &["given has no [projection]"]);
    unable(home, "square.png --profile parabolic --cuts", &["round", "leave --cuts out"]);
    unable(home, &format!("photo.png {at} --width 65536"), &["65536 x", "--width"]);
    unable(home, &format!("photo.png {at} --width 0"), &["--width"]);
    unable(home, &format!("photo.png {at} --cuts --map npy"), &["--cuts", "--map"]);
    unable(home, "photo.png", &["--profile"]);
    assert!(!home.join("out").exists());
    save("out", b"mine");
    unable(home, &format!("photo.png {at}"), &["cannot create the folder out/folded"]);
    std::fs::remove_file(home.join("out")).unwrap();
    // A folder in the place of the second file: the first one stays away too.
    std::fs::create_dir_all(home.join("out/folded/photo-map.npy")).unwrap();
    unable(home, &format!("photo.png {at} --map npy"), &["cannot write", "photo-map.npy"]);
    assert_eq!(std::fs::read_dir(home.join("out/folded")).unwrap().count(), 1);
}

#[test]
fn the_summary_can_be_read() {
    let home = home();
    let (code, out, err) =
        told(&morion(home.path(), &["unwrap", "photo.png", "--profile", "folded.toml"]));
    assert_eq!(code, 0, "{err}");
    for words in [
        "folded  (",
        "  photo    photo.png: 160 x 120 pixels, as the sensor",
        "  panorama 320 x 60 pixels, cylindrical, by remap; azimuth -90.00 to 270.00 deg",
        " % of the panorama is seen; distortion removed ",
        "  file     photo-unwrapped.png",
    ] {
        assert!(out.contains(words), "no {words:?} in {out}");
    }
    let stages: Vec<&str> = err.lines().map(|line| line.split(' ').next().unwrap()).collect();
    assert_eq!(stages, ["read", "design", "picture", "write"], "{err}");
}
