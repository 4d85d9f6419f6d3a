//! The sag table, held against closed forms that are written down here, and the mirror's form.

use crate::support::altered_files::FileRewriter;
use crate::support::builds::{SMALL, edited, files, folder, parsed, save};
use crate::support::{shipped_text, small_but};
use morion::internals::geom::{DVec2, DVec3, Outline, angle};
use morion::internals::num::hypot;
use morion::internals::pipeline::{Silent, build, load};
use morion::internals::profile::Profile;
use morion::internals::results::{BuildReport, FileFault, Reason, Verdict};
use tempfile::TempDir;

const SPHERE: &str = "\
camera.orthographic.pixels = [96, 96]
mirror.polynomial = { radius_mm = -80, conic = 0 }
layout.disc = {}
part = { width_mm = 60, base_mm = 5 }
mesh.chord_um = 50
";

struct Made {
    folder: TempDir,
    report: BuildReport,
    /// The header's comments, and the rows.
    header: Vec<String>,
    rows: Vec<[f64; 6]>,
}

fn made(profile: &Profile) -> Made {
    let folder = folder();
    let report = build(profile, folder.path(), &Silent).unwrap();
    let text = std::fs::read_to_string(folder.path().join(&profile.name).join("sag.csv")).unwrap();
    assert!(text.ends_with('\n') && !text.contains('\r') && !text.contains("-0.000000000"));
    let (header, rest): (Vec<&str>, Vec<&str>) =
        text.lines().partition(|line| line.starts_with('#'));
    assert_eq!(rest[0], "X_mm,Y_mm,Z_mm,NX,NY,NZ");
    let row = |line: &&str| {
        let numbers: Vec<f64> = line.split(',').map(|number| number.parse().unwrap()).collect();
        assert!(
            line.split(',').all(|number| number.split_once('.').unwrap().1.len() == 9),
            "{line}"
        );
        <[f64; 6]>::try_from(numbers).unwrap()
    };
    let rows: Vec<[f64; 6]> = rest[1..].iter().map(row).collect();
    let facts = report.sag.unwrap();
    assert_eq!(facts.rows, rows.len());
    assert!(facts.height_error_mm < 6e-10 && facts.normal_error_rad < 1e-9, "{facts:?}");
    Made { folder, report, header: header.into_iter().map(Into::into).collect(), rows }
}

fn sphere(sag: &str) -> Profile {
    let text = format!("{SPHERE}export.formats = [\"stl\", \"csv\"]\n{sag}");
    parsed(&text)
}

/// Z and the normal of the given sphere: base under its lowest point, the rim.
fn on_sphere([x, y]: [f64; 2]) -> (f64, DVec3) {
    let drop = |r2: f64| r2 / (80.0 + f64::sqrt(6400.0 - r2));
    let r2 = x * x + y * y;
    let z = 5.0 + drop(900.0) - drop(r2);
    (z, DVec3::new(x, y, f64::sqrt(6400.0 - r2)) / 80.0)
}

#[track_caller]
fn lies_on_sphere(rows: &[[f64; 6]]) {
    for &[x, y, z, a, b, c] in rows {
        let (height, normal) = on_sphere([x, y]);
        assert!(hypot(x, y) <= 30.0 + 1e-9, "{x} {y} is beyond the rim");
        assert!((z - height).abs() < 1e-9, "({x}, {y}): {z} {height}");
        assert!((DVec3::new(a, b, c) - normal).length() < 1.5e-9, "({x}, {y})");
    }
}

#[test]
fn a_raster_of_a_sphere_is_even_and_meets_the_closed_form() {
    let made = made(&sphere("export.sag = { pitch_mm = 1.5, step_mm = 0.7 }"));
    assert_eq!(made.report.verdict, Verdict::Pass, "{:?}", made.report.reasons);
    lies_on_sphere(&made.rows);
    // 60 / 0.7 is no whole number: 86 steps, a little shorter.
    let (step, pitch) = (60.0 / 86.0, 1.5);
    let inside = |i: i32, j: i32| {
        let (x, y) = (-30.0 + step * f64::from(i), -30.0 + pitch * f64::from(j));
        (x * x + y * y <= 900.0 + 1e-9).then_some([x, y])
    };
    let wanted: Vec<[f64; 2]> =
        (0..=40).flat_map(|j| (0..=86).filter_map(move |i| inside(i, j))).collect();
    assert_eq!(made.rows.len(), wanted.len());
    for (row, wanted) in made.rows.iter().zip(wanted) {
        assert!((row[0] - wanted[0]).abs() < 1e-9 && (row[1] - wanted[1]).abs() < 1e-9);
    }
}

#[test]
fn a_spiral_runs_inwards_with_its_pitch_and_step() {
    let made = made(&sphere("export.sag = { path = \"spiral\", pitch_mm = 2, step_mm = 0.5 }"));
    lies_on_sphere(&made.rows);
    let at: Vec<DVec2> = made.rows.iter().map(|row| DVec2::new(row[0], row[1])).collect();
    assert_eq!((at[0], at[at.len() - 1]), (DVec2::new(30.0, 0.0), DVec2::ZERO));
    let mut turned = 0.0;
    for pair in at.windows(2) {
        let (before, after) = (pair[0].length(), pair[1].length());
        assert!(after < before);
        turned += pair[0].angle_to(pair[1]);
        // Archimedes: the radius falls by the pitch a turn.
        let radius = 30.0 - turned * 2.0 / (2.0 * std::f64::consts::PI);
        assert!(after == 0.0 || (after - radius).abs() < 1e-6, "{after} {radius}");
        // A chord is shorter than its arc, the more so near the axis.
        let step = (pair[1] - pair[0]).length();
        assert!(after < 10.0 || (step - 0.5).abs() < 1e-3, "{step}");
    }
    // Its length is about the disc's area over the pitch.
    let length = std::f64::consts::PI * 900.0 / 2.0;
    assert!((at.len() as f64 * 0.5 / length - 1.0).abs() < 0.02, "{}", at.len());
}

#[test]
fn the_header_says_what_the_table_is_of() {
    let made = made(&sphere(""));
    let header = made.header.join("\n");
    for words in [
        "Morion: profile small, sha256 ",
        &*made.report.profile.sha256,
        "millimetres",
        "chord um 50:",
        "X right in the picture, Y up in it, Z towards the camera",
        "raster: lines along X, pitch 0.3, step 0.3",
        "design: given",
        "best-fit sphere: radius of curvature -80.000000 (negative: a dome), sag departure 0.000000 PV",
    ] {
        assert!(header.contains(words), "no {words} in {header}");
    }
    assert_eq!(made.rows.len() / 1000, 31, "200 points across");
}

/// A cone's slope is the same everywhere, and the hyperboloid is written down by its foci.
#[test]
#[ignore = "long: .ci/nightly"]
fn tables_of_both_panels_and_of_pinhole_mirrors_lie_on_their_designs() {
    let sources = [
        (SMALL, [161, 121]),
        (shipped_text("hyperbolic"), [1, 1]),
        (shipped_text("conical"), [1, 1]),
    ];
    for (text, [columns, rows]) in sources {
        let text = text.replace("formats = [\"stl\", \"obj\"]", "formats = [\"csv\"]");
        let text = if rows > 1 {
            format!("{text}\n[export.sag]\npitch_mm = 0.0937501\nstep_mm = 0.0937501\n")
        } else {
            text.replace("chord_um = 2 ", "chord_um = 20 ")
                .replace("facet_px = 1 ", "facet_px = 9 ")
        };
        let profile = parsed(&text);
        let made = made(&profile);
        let mirror = morion::internals::design::design(&profile).unwrap().mirror;
        let outline = mirror.full_outline();
        for &[x, y, z, a, b, c] in &made.rows {
            // Back along the camera's ray, which the writer goes the other way.
            let (q, f) = mirror.chart.coordinates(DVec3::new(x, y, z));
            let point = mirror.row(q.y).at(q.x);
            assert!((point.f - f).abs() < 2e-9, "({x}, {y}, {z})");
            let normal = mirror.normal(q, &point).normalize();
            assert!(angle(normal, DVec3::new(a, b, c)) < 2e-9, "({x}, {y}, {z})");
            let slack = 1.0 - 1e-9;
            assert!(outline.contains(q * slack) || outline.contains(q / slack), "{q}");
        }
        if rows > 1 {
            assert_eq!(made.rows.len(), columns * rows);
            let Outline::Rect(rect) = outline else { panic!("no rectangle") };
            let corner = |row: &[f64; 6]| DVec2::new(row[0], row[1]);
            assert!((corner(&made.rows[0]) - rect.min).length() < 1e-9);
            assert!((corner(made.rows.last().unwrap()) - rect.max).length() < 1e-9);
            // The second panel is the first in the mirror.
            for j in 0..rows / 2 {
                for i in 0..columns {
                    let [x, y, z, a, b, c] = made.rows[j * columns + i];
                    let image = made.rows[(rows - 1 - j) * columns + i];
                    assert_eq!(image, [x, 0.0 - y, z, a, 0.0 - b, c]);
                }
            }
        }
    }
}

#[test]
fn a_table_alone_is_proven_by_a_mesh_that_does_not_stay() {
    let text = small_but("[\"stl\", \"obj\"]", "[\"csv\"]");
    let made = made(&parsed(&text));
    let report = &made.report;
    assert_eq!(report.verdict, Verdict::Pass, "{:?}", report.reasons);
    assert!(report.trace[0].hit > 19_000 && report.frame.as_ref().unwrap().filled > 0.99);
    let names: Vec<String> = files(&made.folder.path().join("small")).into_keys().collect();
    let pictures = ["curl.png", "design_error.png", "preview.png"];
    let pages = ["report.html", "report.json", "sag.csv", "timings.json"];
    assert_eq!(names, [&pictures[..], &pages].concat());
    let listed: Vec<&str> = report.files.iter().map(|file| &*file.name).collect();
    assert_eq!(listed, ["sag.csv"]);
}

/// By default a pitch is a share of the width, and a spiral runs out to the corners.
#[test]
fn a_table_of_too_many_places_is_refused() {
    let plate = |width: u32, height: u32, more: &str| {
        format!(
            "camera.orthographic.pixels = [96, 96]\nmirror.polynomial.terms = [[2, 0, 1e-3]]\n\
             part = {{ width_mm = {width}, height_mm = {height}, base_mm = 5 }}\n\
             mesh.chord_um = 50\nexport.formats = [\"csv\"]\n{more}"
        )
    };
    let folder = folder();
    let long = parsed(&plate(1, 4000, ""));
    let error = build(&long, folder.path(), &Silent).unwrap_err().to_string();
    assert!(error.contains("1.6e8 places, over 2e7; raise export.sag.pitch_mm"), "{error}");
    let spiral = "export.sag = { path = \"spiral\", pitch_mm = 0.1, step_mm = 0.1 }\n";
    let text = plate(1000, 1, spiral);
    let complaints = Profile::parse("p", "p.toml", text.as_bytes()).unwrap_err().to_string();
    assert!(complaints.contains("at most 2e7 points, found about 8e7"), "{complaints}");
}

/// A strip's table is a grid that can be given as a mirror.
#[test]
fn a_table_can_be_given_back_as_a_mirror() {
    let text = small_but("[\"stl\", \"obj\"]", "[\"stl\", \"csv\"]");
    let strip = edited(
        &text,
        &[
            (
                "[layout.conquistador]\npanel = \"refit\"\nridge = \"crest\"\nfill_frame = true\n",
                "[layout.strip]\n",
            ),
            ("frame_filled = 0.99\n", ""),
            ("[-180, 180]", "[-80, 80]"),
        ],
    );
    let first = made(&parsed(&strip));
    let folder = folder();
    let last = first.rows.last().unwrap();
    let given = format!(
        "camera.orthographic.pixels = [160, 120]\nmirror.grid.file = \"sag.csv\"\n\
         part = {{ width_mm = {}, height_mm = {}, base_mm = 2 }}\nmesh.chord_um = 20\n\
         export.formats = [\"stl\", \"csv\"]\n",
        2.0 * last[0] - 1e-8,
        2.0 * last[1] - 1e-8
    );
    let path = save(folder.path(), &given);
    std::fs::copy(first.folder.path().join("small/sag.csv"), folder.path().join("sag.csv"))
        .unwrap();
    let source = load(path.to_str().unwrap()).unwrap();
    let report = build(&source, &folder.path().join("out"), &Silent).unwrap();
    assert_eq!(report.verdict, Verdict::Pass, "{:?}", report.reasons);
    let [a, b] =
        [&first.report, &report].map(|report| report.form.sphere.radius_of_curvature_mm.unwrap());
    assert!((a / b - 1.0).abs() < 1e-6, "{a} {b}");
}

/// A table with another first digit after the point in its last row; other files as they are.
fn altered(mut bytes: Vec<u8>) -> Vec<u8> {
    if bytes.starts_with(b"# ") {
        let at = bytes.iter().rposition(|&b| b == b',').unwrap() + 4;
        bytes[at] = if bytes[at] == b'0' { b'1' } else { b'0' };
    }
    bytes
}

#[test]
fn a_table_that_is_not_the_design_any_more_fails() {
    let folder = folder();
    let report = build(&sphere(""), folder.path(), &FileRewriter(altered)).unwrap();
    assert_eq!(report.verdict, Verdict::Fail);
    let [altered, normal] = &report.reasons[..] else { panic!("{:?}", report.reasons) };
    assert_eq!(*altered, Reason::from(FileFault::Altered).of_file("sag.csv"));
    let normal = normal.to_string();
    assert!(
        normal.starts_with("sag.csv: a normal is ") && normal.contains(" rad off the design"),
        "{normal}"
    );
}

#[test]
fn a_given_sphere_departs_from_no_sphere_of_its_own_sign_and_a_paraboloid_does() {
    let of = |mirror: &str| {
        let text = format!("{}export.formats = [\"stl\"]\n", SPHERE.replace("conic = 0", mirror));
        build(&parsed(&text), folder().path(), &Silent).unwrap().form
    };
    let round = of("conic = 0").sphere;
    // The profile's sign.
    let given = -80.0;
    assert!((round.radius_of_curvature_mm.unwrap() / given - 1.0).abs() < 1e-9, "{round:?}");
    assert!(round.departure.sag_pv_mm.unwrap() < 1e-9 && round.departure.normal_max_mrad < 1e-6);
    let centre = DVec3::from_array(round.centre_mm.unwrap());
    assert!((centre - DVec3::Z * (on_sphere([0.0, 0.0]).0 - 80.0)).length() < 1e-7);
    // To second order a quarter of rim^4 / 8 R^3.
    let parabola = of("conic = -1").sphere.departure.sag_pv_mm.unwrap();
    let series = 0.25 * 810_000.0 / (8.0 * 512_000.0);
    assert!((parabola / series - 1.0).abs() < 0.25, "{parabola} {series}");
}
