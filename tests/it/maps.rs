//! Pictures given as data: the same mirrors as by their laws, gaps, and what is refused.

use morion::internals::design::{Design, design};
use morion::internals::geom::DVec2;
use morion::internals::optics::stereographic;
use morion::internals::profile::{Profile, shipped};
use std::fmt::Write;

/// Unit directions, row by row from the upper left, of a picture of so many columns and rows that covers the frame of
/// `design`.
fn directions(design: &Design, [columns, rows]: [usize; 2]) -> Vec<[f64; 3]> {
    let view = design.view.as_ref().unwrap();
    let frame = design.camera.frame();
    let cell = frame.size() / DVec2::new(columns as f64, rows as f64);
    let direction = |k: usize| {
        let at = DVec2::new((k % columns) as f64 + 0.5, (k / columns) as f64 + 0.5) * cell;
        let image = DVec2::new(frame.min.x + at.x, frame.max.y - at.y);
        let sigma = view.projection.direction_of(image.to_array());
        stereographic::direction(sigma).to_array()
    };
    (0..columns * rows).map(direction).collect()
}

fn npy(columns: usize, vectors: &[[f64; 3]]) -> Vec<u8> {
    let shape = format!("({}, {columns}, 3)", vectors.len() / columns);
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(vectors.iter().flatten().flat_map(|x| x.to_le_bytes()));
    bytes
}

/// The text of a shipped profile, another picture in the place of its own.
fn with_projection(text: &str, projection: &str) -> String {
    let mut out = String::new();
    let mut is_projection = false;
    for line in text.lines() {
        if line.starts_with('[') {
            is_projection = line.starts_with("[projection");
        }
        if !is_projection {
            writeln!(out, "{line}").unwrap();
        }
    }
    format!("{out}\n[projection.map]\n{projection}\n")
}

fn parsed(text: &str, file: &[u8]) -> Result<Profile, String> {
    let read = |_: &str, _| Ok(file.to_vec());
    Profile::parse_with("m", "m.toml", text.as_bytes(), &read).map_err(|found| found.to_string())
}

/// Largest difference of height over the part, mm.
fn apart(a: &Design, b: &Design) -> f64 {
    let area = a.mirror.outline.bounds();
    let height = |design: &Design, q: DVec2| {
        let mirror = &design.mirror;
        mirror.position(q, &mirror.at(q)).z
    };
    let places = (0..41 * 41).map(|k| {
        let share = DVec2::new(f64::from(k % 41), f64::from(k / 41)) / 40.0;
        area.min + share * area.size()
    });
    places.fold(0.0, |most, q| f64::max(most, (height(a, q) - height(b, q)).abs()))
}

/// A fisheye view behind a lens.
const LENS: &str =
    "camera.calibrated = { pixels = [640, 480], focal_px = [820, 818], principal_px = [331, 229], \
                    distortion = [-0.21, 0.05, 0.001, -0.0006], distance_mm = 150 }
[projection.fisheye]
hfov_deg = 70
law = \"equisolid\"
[layout.rectangle]
[method.vector-field]
degree = 12
[part]
width_mm = 100
base_mm = 5
[mesh]
facet_px = 1
[export]
formats = [\"stl\"]
";

/// The text of a shipped profile whose mirror ends before the frame: beyond it a law goes on, and a map need not.
fn narrow(name: &str) -> String {
    let text = shipped().iter().find(|profile| profile.name == name).unwrap().text;
    let line = text.lines().find(|line| line.starts_with("width_mm")).unwrap();
    text.replace(line, "width_mm = 40")
}

/// Views far away and of a near plane, behind a lens and not, on a mount and not: mirrors through maps are the same.
#[test]
fn a_law_through_a_map_is_itself() {
    for (name, text, target) in [
        ("driver", narrow("driver"), ""),
        ("floor", narrow("floor"), "target_plane_mm = 1050"),
        ("lens", LENS.to_owned(), ""),
    ] {
        let own = design(&Profile::parse(name, name, text.as_bytes()).unwrap()).unwrap();
        let size = own.camera.pixels.map(|n| n as usize);
        let file = npy(size[0], &directions(&own, size));
        let text = with_projection(&text, &format!("file = \"w.npy\"\n{target}"));
        let profile = parsed(&text, &file).unwrap_or_else(|error| panic!("{error}\n{text}"));
        let by_map = design(&profile).unwrap();
        let off = apart(&own, &by_map);
        println!(
            "{name}: {off:e} mm, {:?} {:?}",
            by_map.facts.pixel_error_px, own.facts.pixel_error_px
        );
        assert!(off < 1e-9, "{name}: {off:e}");
    }
}
