//! Targets of triangles: against the surfaces that they are tessellations of, and what is refused.

use crate::support::builds::{folder, morion, told};
use morion::internals::design::{Design, design};
use morion::internals::geom::{DVec2, DVec3, TriMesh};
use morion::internals::num::{cos, sin};
use morion::internals::profile::{NamedFiles, Profile};
use std::f64::consts::{PI, TAU};

/// A view of a pinhole camera with 24 degrees across 160 x 120 pixels, 150 mm away.
fn view(rest: &str, method: &str) -> String {
    format!(
        "camera.pinhole = {{ pixels = [160, 120], hfov_deg = 24, distance_mm = 150 }}\n{rest}\n\
         layout.rectangle = {{}}\nmethod.{method}\npart = {{ width_mm = 66, base_mm = 5 }}\n\
         mesh.chord_um = 5\nexport.formats = [\"stl\"]\naccept.pixel_error_max_px = 30\n"
    )
}

fn parsed(text: &str, mesh: &TriMesh) -> Result<Profile, String> {
    let read = |_: &str| Ok(mesh.clone());
    let files = NamedFiles { mesh: &read, ..NamedFiles::NONE };
    Profile::parse_with("t", "t.toml", text.as_bytes(), files).map_err(|found| found.to_string())
}

fn designed(text: &str, mesh: &TriMesh) -> Result<Design, String> {
    design(&parsed(text, mesh)?).map_err(|error| error.to_string())
}

/// A surface over n x n squares of two parameters, each cut in two.
fn surface(n: u32, place: impl Fn(f64, f64) -> DVec3) -> TriMesh {
    let side = n + 1;
    let at = |k: u32| place(f64::from(k % side) / f64::from(n), f64::from(k / side) / f64::from(n));
    let square = |k: u32| {
        let corner = k / n * side + k % n;
        let [a, b, c, d] = [corner, corner + 1, corner + side, corner + side + 1];
        [[a, b, d], [a, d, c]]
    };
    TriMesh {
        vertices: (0..side * side).map(at).collect(),
        triangles: (0..n * n).flat_map(square).collect(),
    }
}

/// Part of the plane through (0, 30, 400) with the normal (0.3, -0.2, 1).
fn wall(n: u32) -> TriMesh {
    surface(n, |u, v| {
        let [x, y] = [u, v].map(|t| 3000.0 * (t - 0.5));
        DVec3::new(x, y, 400.0 - 0.3 * x + 0.2 * (y - 30.0))
    })
}

/// Half of a sphere of 400 mm about (20, -35, 90), on the camera's side.
fn dome(n: u32) -> TriMesh {
    surface(n, |u, v| {
        let [azimuth, polar] = [TAU * u, 0.7 * PI * v];
        let out = DVec3::new(sin(polar) * cos(azimuth), sin(polar) * sin(azimuth), cos(polar));
        DVec3::new(20.0, -35.0, 90.0) + 400.0 * out
    })
}

/// Largest difference of height, mm.
fn apart(a: &Design, b: &Design) -> f64 {
    let area = a.mirror.outline.bounds();
    let difference = |k: i32| {
        let q = area.min + DVec2::new(f64::from(k % 21), f64::from(k / 21)) / 20.0 * area.size();
        (a.mirror.at(q).f - b.mirror.at(q).f).abs()
    };
    (0..21 * 21).map(difference).fold(0.0, f64::max)
}

const PICTURE: &str = "projection.perspective.hfov_deg = 40\n";
const SPHERE: &str = "target.sphere = { centre_mm = [20, -35, 90], radius_mm = 400";
const MESH: &str = "target.mesh = { file = \"t.obj\"";

#[test]
fn a_wall_of_triangles_is_the_plane() {
    let plane = "target.plane = { point_mm = [0, 30, 400], normal = [0.3, -0.2, 1]";
    for method in ["vector-field.degree = 10", "fixed-surface.degree = 8"] {
        for viewpoint in ["", ", viewpoint_mm = [12, -40, 60]"] {
            let [own, facets] = [plane, MESH].map(|target| {
                let rest = format!("{PICTURE}{target}{viewpoint} }}");
                designed(&view(&rest, method), &wall(7)).unwrap_or_else(|e| panic!("{e}\n{rest}"))
            });
            let off = apart(&own, &facets);
            assert!(off < 1e-9, "{method}{viewpoint}: {off:e} mm");
            let errors = [&own, &facets].map(|d| d.facts.pixel_error_px.unwrap().rms);
            assert!((errors[0] - errors[1]).abs() < 1e-8, "{errors:?}");
        }
    }
}

/// Chords of arcs are off by the square of their length.
#[test]
fn a_finely_tessellated_sphere_is_the_sphere_to_second_order() {
    for viewpoint in ["", ", viewpoint_mm = [30, -20, 200]"] {
        let text = |target: &str| {
            let rest = format!("{PICTURE}{target}{viewpoint} }}");
            view(&rest, "vector-field.degree = 8")
        };
        let own = designed(&text(SPHERE), &wall(1)).unwrap();
        let off = [40, 80, 160, 320].map(|n| {
            let facets = designed(&text(MESH), &dome(n)).unwrap();
            let errors = [&own, &facets].map(|d| d.facts.pixel_error_px.unwrap().rms);
            println!("{viewpoint} {n}: {errors:?}, least {:?}", facets.facts.least_error);
            apart(&own, &facets)
        });
        println!("{viewpoint}: {off:?}");
        assert!(off[0] / off[3] > 32.0, "three doublings are worth 64: {off:?}");
        assert!(off[3] < 1e-4, "{off:?}");
    }
}

#[test]
fn units_are_those_of_the_file() {
    let scaled = |unit: f64| {
        let mut mesh = dome(60);
        mesh.vertices.iter_mut().for_each(|v| *v /= unit);
        let text =
            view(&format!("{PICTURE}{MESH}, unit_mm = {unit} }}"), "vector-field.degree = 8");
        designed(&text, &mesh).unwrap()
    };
    assert!(apart(&scaled(1.0), &scaled(1000.0)) < 1e-9);
}

#[test]
fn what_a_mesh_cannot_show_is_refused_with_its_pixel() {
    let text = view(&format!("{PICTURE}{MESH} }}"), "vector-field.degree = 8");
    let refused = |mesh: &TriMesh, text: &str, words: &[&str]| {
        let error = designed(text, mesh).err().unwrap_or_else(|| panic!("{words:?}\n{text}"));
        println!("{error}");
        for word in words {
            assert!(error.contains(word), "{word}: {error}");
        }
    };
    // A wall with a hole in its middle.
    let mut holed = wall(31);
    let is_far = |t: &[u32; 3]| (holed.vertices[t[0] as usize].truncate().length()) > 110.0;
    holed.triangles = holed.triangles.iter().copied().filter(is_far).collect();
    refused(&holed, &text, &["pixel (", "has no facet", "% of the frame's pixels miss it"]);
    // A post before the wall.
    let mut post = wall(3);
    let first = post.vertices.len() as u32;
    post.vertices
        .extend([(-4.0, -500.0), (4.0, -500.0), (0.0, 500.0)].map(|(x, y)| DVec3::new(x, y, 80.0)));
    post.triangles.push([first, first + 1, first + 2]);
    let strict = text.replace("pixel_error_max_px = 30", "pixel_error_max_px = 2");
    refused(&post, &strict, &["jumps in depth beside pixel (", "pixel_error_max_px = 2"]);
    // Something that goes through the mirror.
    let mut pierced = wall(3);
    let first = pierced.vertices.len() as u32;
    pierced.vertices.extend([
        DVec3::new(20.0, -10.0, -50.0),
        DVec3::new(24.0, 10.0, -50.0),
        DVec3::new(22.0, 0.0, 30.0),
    ]);
    pierced.triangles.push([first, first + 1, first + 2]);
    refused(&pierced, &text, &["reaches through the target surface"]);
    let parted = format!("{PICTURE}{MESH}, viewpoint_mm = [0, 0, 900] }}");
    refused(
        &wall(3),
        &view(&parted, "vector-field.degree = 8"),
        &["t.toml:3:15: target.mesh must be in sight", "the surface between them"],
    );
}

/// Faults of the file and of keys that do not go with it are told at their places, and nothing is written.
#[test]
fn faults_of_the_file_have_their_places() {
    let folder = folder();
    let text = view(&format!("{PICTURE}{MESH} }}"), "vector-field.degree = 8");
    let check = |obj: Option<&str>, text: &str| {
        if let Some(obj) = obj {
            std::fs::write(folder.path().join("t.obj"), obj).unwrap();
        }
        std::fs::write(folder.path().join("p.toml"), text).unwrap();
        let (code, out, err) = told(&morion(folder.path(), &["check", "p.toml"]));
        assert_eq!((code, out.as_str()), (2, ""), "{err}");
        err
    };
    let missing = check(None, &text);
    assert!(missing.contains("p.toml:3:24: target.mesh.file: cannot read t.obj"), "{missing}");
    let empty = check(Some("v 0 0 400\nv 1 0 400\nv 0 1 400\n"), &text);
    assert!(
        empty.contains("p.toml:3:24: target.mesh.file: t.obj: the file holds no facets"),
        "{empty}"
    );
    let wall = "v -9000 -9000 400\nv 9000 -9000 400\nv 0 9000 400\nf 1 2 3\n";
    let facet = check(Some(wall), &text.replace("chord_um = 5", "facet_px = 1"));
    let words =
        "p.toml:7:17: mesh must hold chord_um alone with [target.mesh], found mesh.facet_px";
    assert!(facet.contains(words), "{facet}");
    let most = check(None, &text.replace("chord_um = 5", "max_triangles = 5000"));
    assert!(most.contains("found mesh.max_triangles"), "{most}");
    let best = "projection.best = { azimuth_deg = [-20, 20], elevation_deg = [60, 80] }\n";
    let best = text.replace(PICTURE, best).replace("rectangle", "strip");
    let best = check(None, &best);
    assert!(best.contains("projection must be a law of known height with [target.mesh]"), "{best}");
}
