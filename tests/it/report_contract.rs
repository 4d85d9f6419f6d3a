//! What other programs read: the keys of the reports, and every digit of the mesh files.

use crate::support::builds::{SMALL, edited, files, folder, morion, parsed, save, told};
use crate::support::{small_but, small_strip};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use morion::internals::design::{Design, design};
use morion::internals::export::{ImportedMesh, read_obj, read_stl};
use morion::internals::geom::{DVec2, DVec3, TriMesh, angle};
use morion::internals::pipeline::{Silent, build};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

/// A build with all that is known about it.
struct Built {
    design: Design,
    report: BuildReport,
    files: BTreeMap<String, Vec<u8>>,
}

fn built(text: &str) -> Built {
    let (profile, folder) = (parsed(text), folder());
    let report = build(&profile, folder.path(), &Silent).unwrap();
    let files = files(&folder.path().join("small"));
    Built { design: design(&profile).unwrap(), report, files }
}

impl Built {
    fn json(&self) -> Value {
        serde_json::from_slice(&self.files["report.json"]).unwrap()
    }

    fn stl(&self) -> ImportedMesh {
        read_stl(&self.files["mirror.stl"]).unwrap()
    }

    fn obj(&self) -> ImportedMesh {
        read_obj(&self.files["mirror.obj"]).unwrap()
    }

    /// Facets of the optical face, which come first, and of the designed panel, first of these.
    fn optical(&self) -> (usize, usize) {
        let optical = self.report.mesh.unwrap().optical_triangles;
        (optical, if self.design.mirror.folded { optical / 2 } else { optical })
    }
}

fn layouts() -> [String; 4] {
    [
        SMALL.into(),
        small_but("\"crest\"", "\"valley\""),
        small_but("\"refit\"", "\"section\""),
        small_strip(),
    ]
}

/// What a key holds.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Number,
    Count,
    Flag,
    Text,
    Texts,
    Sha256,
    CountPair,
    Range,
}

use Kind::{Count, CountPair, Flag, Number, Range, Sha256, Text, Texts};
use morion::internals::report::{Answer, TextLayout};
use morion::internals::results::{BuildReport, TraceFacts, Verdict};

const SPREAD: [(&str, Kind); 3] = [("rms", Number), ("p95", Number), ("max", Number)];

fn fits(value: &Value, kind: Kind) -> bool {
    let list =
        |fits: fn(&Value) -> bool| value.as_array().is_some_and(|values| values.iter().all(fits));
    let pair = value.as_array().is_some_and(|values| values.len() == 2);
    match kind {
        Number => value.as_f64().is_some_and(f64::is_finite),
        Count => value.is_u64(),
        Flag => value.is_boolean(),
        Text => value.as_str().is_some_and(|text| !text.is_empty()),
        Texts => list(Value::is_string),
        Sha256 => value.as_str().is_some_and(|text| {
            text.len() == 64 && text.bytes().all(|b| b"0123456789abcdef".contains(&b))
        }),
        CountPair => pair && list(Value::is_u64),
        Range => pair && value[0].as_f64() < value[1].as_f64() && list(Value::is_number),
    }
}

#[track_caller]
fn holds(value: &Value, keys: &[(&str, Kind)]) {
    for (path, kind) in keys {
        let found = path.split('.').fold(value, |value, key| &value[key]);
        assert!(fits(found, *kind), "{path} is {found}, no {kind:?}");
    }
}

#[track_caller]
fn holds_spread(value: &Value, path: &str) {
    let keys = SPREAD.map(|(key, kind)| (format!("{path}.{key}"), kind));
    keys.iter().for_each(|(key, kind)| holds(value, &[(key, *kind)]));
    let [rms, p95, max] = SPREAD.map(|(key, _)| {
        let path = format!("{path}.{key}");
        path.split('.').fold(value, |value, key| &value[key]).as_f64().unwrap()
    });
    assert!(0.0 <= rms && rms <= max && 0.0 <= p95 && p95 <= max, "{path}: {rms} {p95} {max}");
}

const SOLID: [(&str, Kind); 8] = [
    ("solid.closed", Flag),
    ("solid.oriented", Flag),
    ("solid.manifold", Flag),
    ("solid.components", Count),
    ("solid.euler", Count),
    ("solid.volume_mm3", Number),
    ("solid.volume_expected_mm3", Number),
    ("solid.reasons", Texts),
];

/// Whether null stands anywhere in `value`: that is how a number that is not finite is written.
fn has_null(value: &Value) -> bool {
    match value {
        Value::Null => true,
        Value::Array(values) => values.iter().any(has_null),
        Value::Object(values) => values.values().any(has_null),
        _ => false,
    }
}

#[test]
fn the_report_has_every_key_with_its_type() {
    let built = built(SMALL);
    let mut report = built.json();
    holds(
        &report,
        &[
            ("schema", Count),
            ("profile.name", Text),
            ("profile.sha256", Sha256),
            ("design.method", Text),
            ("design.degree", Count),
            ("design.unknowns", Count),
            ("design.gradient_residual", Number),
            ("design.curl.rms", Number),
            ("design.curl.max", Number),
            ("design.curl.condition", Number),
            ("design.curl.rounding", Number),
            ("design.least_error.pixel_rms_px", Number),
            ("design.least_error.ray_rms_deg", Number),
            ("unwanted.seen_twice", Number),
            ("unwanted.own_camera.off_deg", Number),
            ("form.sphere.radius_of_curvature_mm", Number),
            ("form.sphere.radius_mm", Number),
            ("form.sphere.pv_mm", Number),
            ("form.sphere.largest_mm", Number),
            ("form.sphere.normal_max_mrad", Number),
            ("form.plane.height_mm", Number),
            ("form.plane.sag_pv_mm", Number),
            ("form.plane.pv_mm", Number),
            ("form.plane.largest_mm", Number),
            ("form.plane.normal_max_mrad", Number),
            ("mesh.optical_triangles", Count),
            ("mesh.triangles", Count),
            ("mesh.vertices", Count),
            ("mesh.chord_um.limit", Number),
            ("mesh.chord_um.bound", Number),
            ("mesh.facet_px.limit", Number),
            ("mesh.facet_px.bound", Number),
            ("mesh.over_optimum.chord", Number),
            ("mesh.over_optimum.facet", Number),
            ("frame.pixels", CountPair),
            ("frame.filled", Number),
            ("frame.azimuth_deg", Range),
            ("frame.elevation_deg", Range),
            ("frame.gain_over_disc", Number),
            ("frame.lost.beyond", Count),
            ("frame.lost.rim", Count),
            ("frame.lost.ridge", Count),
            ("frame.lost.shadow", Count),
            ("frame.lost.content", Count),
            ("frame.lost.back_face", Count),
            ("frame.lost.missed", Count),
            ("verdict", Text),
            ("reasons", Texts),
            ("warnings", Texts),
        ],
    );
    holds(&report, &SOLID);
    holds_spread(&report, "design.ray_error_mrad");
    holds_spread(&report, "design.pixel_error_px");
    let [files, traces] = ["files", "trace"].map(|key| report[key].as_array().unwrap());
    assert_eq!((files.len(), traces.len()), (2, 2));
    for file in files {
        holds(file, &[("name", Text), ("format", Text), ("bytes", Count), ("sha256", Sha256)]);
    }
    for trace in traces {
        let counts = ["rays", "hit", "missed", "shadowed"].map(|key| (key, Count));
        holds(trace, &counts);
        holds(trace, &[("file", Text)]);
        holds(trace, &SOLID);
        for errors in ["ray_error_mrad", "pixel_error_px", "facet_error_px"] {
            holds_spread(trace, errors);
        }
    }
    // A telecentric camera has no pupil, and a world far away no origin.
    let layout = report.as_object_mut().unwrap().remove("layout").unwrap();
    let far: Vec<&str> = ["pupil_mm", "target_origin_mm", "size_mm", "mean_mm", "up"]
        .into_iter()
        .filter(|key| layout[key].is_null())
        .collect();
    assert_eq!(far, ["pupil_mm", "target_origin_mm"]);
    assert!(!has_null(&report));
    assert_eq!((&report["schema"], &report["profile"]["name"]), (&1.into(), &"small".into()));
    assert_eq!(report["frame"]["pixels"], serde_json::json!([160, 120]));
}

#[test]
fn the_report_describes_the_files_beside_it() {
    use sha2::{Digest, Sha256};
    let sha256 = |bytes: &[u8]| -> String {
        Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
    };
    let built = built(SMALL);
    let report = built.json();
    assert_eq!(report["profile"]["sha256"], sha256(SMALL.as_bytes()));
    for file in report["files"].as_array().unwrap() {
        let name = file["name"].as_str().unwrap();
        assert_eq!(file["bytes"], built.files[name].len());
        assert_eq!(file["sha256"], sha256(&built.files[name]));
        assert!(name.ends_with(file["format"].as_str().unwrap()));
    }
    let names = |key: &str, name: &str| -> Vec<String> {
        let entries = report[key].as_array().unwrap().iter();
        entries.map(|entry| entry[name].as_str().unwrap().into()).collect()
    };
    assert_eq!(names("files", "name"), ["mirror.stl", "mirror.obj"]);
    assert_eq!(names("trace", "file"), ["mirror.stl", "mirror.obj"]);
    let mesh = built.stl().mesh;
    assert_eq!(report["mesh"]["triangles"], mesh.triangles.len());
    assert_eq!(report["mesh"]["vertices"], mesh.vertices.len());
    for trace in report["trace"].as_array().unwrap() {
        let count = |key: &str| trace[key].as_u64().unwrap();
        let ends = ["hit", "missed", "shadowed", "back_face"].map(count);
        assert_eq!(count("rays"), ends.iter().sum::<u64>());
        assert_eq!(count("rays"), 160 * 120);
    }
}

#[test]
fn bounds_are_within_their_limits_and_the_witness_within_the_bounds() {
    for text in layouts() {
        let report = built(&text).report;
        let mesh = report.mesh.unwrap();
        for limited in [mesh.chord_um, mesh.facet_px] {
            assert!(limited.bound <= limited.limit.unwrap(), "{limited:?}");
        }
        for trace in &report.trace {
            let most = trace.errors.facet_error_px.unwrap().max;
            assert!(most <= mesh.facet_px.bound, "{most} px, {:?}", mesh.facet_px);
        }
        assert!(mesh.over_optimum.facet.unwrap() >= 1.0);
    }
}

#[test]
fn a_limit_that_is_not_asked_for_is_null() {
    let report = built(&small_but("chord_um = 20\n", "")).json();
    assert!(report["mesh"]["chord_um"].as_object().unwrap()["limit"].is_null());
    assert!(report["mesh"]["over_optimum"].as_object().unwrap()["chord"].is_null());
    assert!(fits(&report["mesh"]["chord_um"]["bound"], Number));
}

#[test]
fn verdict_reasons_exit_code_and_page_agree() {
    let strict = edited(SMALL, &[("max_px = 5", "max_px = 1"), ("rms_px = 2", "rms_px = 0.1")]);
    let folder = folder();
    for (text, code, verdict, reasons) in [(SMALL, 0, "pass", 0..1), (&strict, 1, "fail", 2..9)] {
        save(folder.path(), text);
        let arguments = ["build", "small.toml", "--quiet"];
        assert_eq!(told(&morion(folder.path(), &arguments)).0, code);
        let made = files(&folder.path().join("out/small"));
        let report: Value = serde_json::from_slice(&made["report.json"]).unwrap();
        assert_eq!(report["verdict"], verdict);
        let listed = report["reasons"].as_array().unwrap();
        assert!(reasons.contains(&listed.len()), "{listed:?}");
        let page = String::from_utf8(made["report.html"].clone()).unwrap();
        assert!(page.contains(&format!("<span class=\"{verdict}\">{verdict}</span>")));
        let preview =
            format!("data:image/png;base64,{}", BASE64_STANDARD.encode(&made["preview.png"]));
        assert!(page.contains(&preview));
        assert!(listed.iter().all(|reason| page.contains(reason.as_str().unwrap())));
    }
}

/// Every picture and script is in the page; what it links to are files of its own folder, or below it.
#[test]
fn the_page_needs_no_network_and_nothing_beside_it() {
    let page = String::from_utf8(built(SMALL).files["report.html"].clone()).unwrap();
    // The library that draws the part names addresses in its messages, and fetches none.
    let (before, library) = page.split_once("<script>/*! three.js").unwrap();
    let (_, after) = library.split_once("</script>").unwrap();
    for own in [before, after] {
        let sources: Vec<&str> = own.split("src=\"").skip(1).collect();
        assert!(sources.iter().all(|rest| rest.starts_with("data:image/png;base64,")));
        for rest in own.split("href=\"").skip(1) {
            let name = rest.split('"').next().unwrap();
            let is_below = !name.contains(':') && !name.starts_with('/') && !name.contains("..");
            assert!(is_below, "{name}");
        }
        assert!(!own.contains("http:") && !own.contains("https:") && !own.contains("@import"));
    }
    assert!(before.contains("<h2>Part</h2>") && before.contains("id=\"part-glb\""));
    assert_eq!([before, after].map(|own| own.matches("<img").count()), [1, 4]);
    for title in [
        "What the camera sees",
        "Side view",
        "Cross-sections",
        "Pixel error, px",
        "Curl of the wanted slopes, px",
        "Size of the spots, px",
        "Files",
    ] {
        assert!(after.contains(&format!("<h2>{title}</h2>")), "{title}");
    }
}

/// The page's part is the part: its coarse mesh fills the box that the report tells.
#[test]
fn the_pages_part_has_the_size_of_the_part() {
    let built = built(SMALL);
    let page = String::from_utf8(built.files["report.html"].clone()).unwrap();
    let (_, rest) = page.split_once("type=\"application/octet-stream\">").unwrap();
    let glb = BASE64_STANDARD.decode(rest.split_once('<').unwrap().0).unwrap();
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let json: Value = serde_json::from_slice(&glb[20..20 + length]).unwrap();
    let size = built.report.layout.unwrap().size_mm;
    let places = &json["accessors"][0];
    for axis in 0..3 {
        let [low, high] = ["min", "max"].map(|end| places[end][axis].as_f64().unwrap());
        assert!((high - low - size[axis]).abs() < 1e-2 * size[axis], "{axis}: {low} to {high}");
    }
}

#[test]
fn timings_name_each_stage_in_seconds() {
    let timings: Value = serde_json::from_slice(&built(SMALL).files["timings.json"]).unwrap();
    let seconds = timings["seconds"].as_object().unwrap();
    for stage in ["design", "mesh", "solid", "write", "read", "trace", "picture"] {
        assert!(seconds[stage].as_f64().is_some_and(|s| s >= 0.0), "{stage}");
    }
    let sum: f64 = seconds.values().map(|s| s.as_f64().unwrap()).sum();
    assert!(sum <= timings["total_s"].as_f64().unwrap());
}

#[test]
fn the_preview_is_as_large_as_the_frame_and_not_empty() {
    let bytes = &built(SMALL).files["preview.png"];
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!((info.width, info.height), (160, 120));
    let pixels = &pixels[..info.buffer_size()];
    let size = info.buffer_size() / (160 * 120);
    let colours: BTreeSet<&[u8]> = pixels.chunks(size).collect();
    assert!(colours.len() > 50, "{} colours", colours.len());
}

#[test]
fn both_files_say_who_made_them_for_what() {
    let built = built(SMALL);
    let stl = &built.files["mirror.stl"];
    let header = String::from_utf8(stl[..80].to_vec()).unwrap();
    let sha256 = &built.report.profile.sha256;
    let words = format!("Morion small {} mm telecentric camera; chord um 20:", &sha256[..8]);
    assert!(header.starts_with(&words), "{header}");
    assert!(!header.to_lowercase().starts_with("solid") && header.is_ascii());
    let count = u32::from_le_bytes(stl[80..84].try_into().unwrap()) as usize;
    assert_eq!((stl.len(), count), (84 + 50 * count, built.report.mesh.unwrap().triangles));

    let obj = String::from_utf8(built.files["mirror.obj"].clone()).unwrap();
    let comments: Vec<&str> = obj.lines().take_while(|line| line.starts_with('#')).collect();
    let comments = comments.join("\n");
    for word in ["Morion", "profile small", sha256, "millimetres", "chord um 20:", "facet px 3:"] {
        assert!(comments.contains(word), "no {word} in {comments}");
    }
    assert!(obj.ends_with('\n') && !obj.contains('\r'));
}

#[test]
fn no_coordinate_is_minus_zero() {
    for text in layouts() {
        let built = built(&text);
        for facet in built.files["mirror.stl"][84..].chunks(50) {
            for number in facet[..48].chunks(4) {
                assert_ne!(number, (-0.0f32).to_le_bytes(), "{facet:?}");
            }
        }
        let obj = std::str::from_utf8(&built.files["mirror.obj"]).unwrap();
        for line in obj.lines().filter(|line| line.starts_with('v')) {
            for number in line.split(' ').skip(1) {
                let value: f64 = number.parse().unwrap();
                assert_ne!(value.to_bits(), (-0.0f64).to_bits(), "{line}");
                assert_eq!(value.to_string(), number, "not the shortest form");
            }
        }
    }
}

#[test]
fn optical_facets_alone_have_normals() {
    for text in layouts() {
        let built = built(&text);
        let (optical, _) = built.optical();
        let obj = std::str::from_utf8(&built.files["mirror.obj"]).unwrap();
        let faces: Vec<&str> = obj.lines().filter_map(|line| line.strip_prefix("f ")).collect();
        assert_eq!(faces.len(), built.report.mesh.unwrap().triangles);
        for (t, face) in faces.iter().enumerate() {
            let corners: Vec<&str> = face.split(' ').collect();
            assert_eq!(corners.len(), 3);
            let number = |text: &str| text.bytes().all(|b| b.is_ascii_digit()) && !text.is_empty();
            let fits = |corner: &&str| match corner.split_once("//") {
                Some((vertex, normal)) => t < optical && number(vertex) && number(normal),
                None => t >= optical && number(corner),
            };
            assert!(corners.iter().all(fits), "facet {t} of {optical}: {face}");
        }
    }
}

#[test]
fn normals_of_the_obj_are_those_of_the_design() {
    for text in layouts() {
        let built = built(&text);
        let (optical, designed) = built.optical();
        let (obj, mirror) = (built.obj(), &built.design.mirror);
        let normals = obj.normals.unwrap();
        for (t, normals) in normals.iter().enumerate().take(optical) {
            for (v, normal) in obj.mesh.corners(t).into_iter().zip(normals) {
                // The reflected panel has the designed one's normal in the mirror, ridge included.
                let flip = DVec3::new(1.0, if t < designed { 1.0 } else { -1.0 }, 1.0);
                let q = DVec2::new(v.x, v.y * flip.y);
                let point = mirror.row(q.y).at(q.x);
                let wanted = mirror.normal(q, &point).normalize() * flip;
                assert!(angle(*normal, wanted) < 1e-7, "facet {t} at {v}: {normal}, not {wanted}");
            }
        }
    }
}

/// The vertices of the facets `range`.
fn vertices(mesh: &TriMesh, range: std::ops::Range<usize>) -> BTreeSet<u32> {
    mesh.triangles[range].iter().flatten().copied().collect()
}

fn bits(v: DVec3) -> [u64; 3] {
    v.to_array().map(f64::to_bits)
}

#[test]
fn vertices_of_the_obj_lie_on_the_design_to_the_last_bit() {
    for text in layouts() {
        let built = built(&edited(&text, &[("facet_px = 3", "facet_px = 2")]));
        let (mesh, mirror) = (built.obj().mesh, &built.design.mirror);
        let outline = mirror.full_outline();
        let optical = vertices(&mesh, 0..built.optical().0);
        assert!(optical.len() > 800);
        for v in optical.into_iter().map(|v| mesh.vertices[v as usize]) {
            let sag = mirror.position(v.truncate(), &mirror.row(v.y).at(v.x)).z;
            assert_eq!(v.z.to_bits(), sag.to_bits(), "{v}, sag {sag}");
            assert!(outline.contains(v.truncate()), "{v}");
        }
    }
}

#[test]
fn the_stl_is_the_obj_in_single_precision() {
    for text in layouts() {
        let built = built(&text);
        let (stl, obj) = (built.stl().mesh, built.obj().mesh);
        assert_eq!(stl.triangles.len(), obj.triangles.len());
        for t in 0..stl.triangles.len() {
            let rounded = obj.corners(t).map(|v| bits(v.as_vec3().as_dvec3()));
            assert_eq!(stl.corners(t).map(bits), rounded, "facet {t}");
        }
    }
}

#[test]
fn stl_normals_are_those_of_their_facets() {
    let built = built(SMALL);
    let mesh = built.stl().mesh;
    for (t, facet) in built.files["mirror.stl"][84..].chunks(50).enumerate() {
        let number = |k: usize| f32::from_le_bytes(facet[4 * k..][..4].try_into().unwrap());
        let normal = DVec3::from_array([0, 1, 2].map(|k| f64::from(number(k))));
        assert!(angle(normal, mesh.area_vector(t).normalize()) < 1e-6, "facet {t}: {normal}");
        assert_eq!(facet[48..], [0, 0]);
    }
}

#[test]
fn the_second_panel_is_the_first_in_the_mirror_and_shares_the_ridge() {
    for text in &layouts()[..3] {
        let built = built(text);
        let (optical, designed) = built.optical();
        for mesh in [built.stl().mesh, built.obj().mesh] {
            let image = |v: DVec3| bits(v * DVec3::new(1.0, -1.0, 1.0) + DVec3::ZERO);
            for t in 0..designed {
                let [a, b, c] = mesh.corners(t).map(image);
                assert_eq!(mesh.corners(designed + t).map(bits), [a, c, b], "facet {t}");
            }
            let [first, second] =
                [0..designed, designed..optical].map(|range| vertices(&mesh, range));
            let on_ridge = |v: &&u32| mesh.vertices[**v as usize].y == 0.0;
            let ridge: BTreeSet<u32> = first.iter().filter(on_ridge).copied().collect();
            assert!(ridge.len() > 10, "{} vertices on the ridge", ridge.len());
            assert_eq!(ridge, first.intersection(&second).copied().collect());
            assert_eq!(ridge, second.iter().filter(on_ridge).copied().collect());
            let ends = |v: &u32| mesh.vertices[*v as usize].x;
            let reach = ridge.iter().map(ends).fold(0.0, f64::max);
            assert_eq!(reach, built.design.mirror.outline.bounds().max.x);
        }
    }
}

#[test]
fn the_profile_allows_what_the_report_passes() {
    let built = built(SMALL);
    let accept = parsed(SMALL).accept;
    assert_eq!(built.report.verdict, Verdict::Pass);
    for trace in &built.report.trace {
        let errors = trace.errors.pixel_error_px.unwrap();
        assert!(errors.rms <= accept.pixel_error_rms_px.unwrap());
        assert!(errors.max <= accept.pixel_error_max_px.unwrap());
        assert_eq!(trace.hit, trace.rays);
        assert!(trace.solid.reasons.is_empty());
    }
    assert!(built.report.frame.unwrap().filled >= accept.frame_filled.unwrap());
}

/// Where only a sag table is asked for, a mesh is made to be traced, and thrown away.
#[test]
fn the_summary_names_no_file_that_is_not_there() {
    let folder = folder();
    let drawn = parsed(&small_but("formats = [\"stl\", \"obj\"]", "formats = [\"csv\"]"));
    let report = build(&drawn, folder.path(), &Silent).unwrap();
    assert!(!folder.path().join("small/mirror.obj").exists());
    let layout = TextLayout { details: true, ..TextLayout::default() };
    let shown = report.laid_out(&layout);
    assert!(!shown.contains("mirror.obj"), "{shown}");
    assert!(shown.contains("witness  a mesh that was not kept: "), "{shown}");
    let page = std::fs::read_to_string(folder.path().join("small/report.html")).unwrap();
    assert!(!page.contains("mirror.obj"));
    // Nor does the report itself, nor a reason.
    assert!(!report.json().contains("mirror.obj"), "{}", report.json());
}

/// Where only a STEP file is asked for, its curved faces are traced.
#[test]
fn no_triangles_are_made_where_only_a_step_file_is_asked_for() {
    let both = small_but("formats = [\"stl\", \"obj\"]", "formats = [\"step\", \"obj\"]");
    let both = built(&both);
    let alone = built(&small_but("formats = [\"stl\", \"obj\"]", "formats = [\"step\"]"));
    let report = alone.json();
    assert!(report.get("mesh").is_none() && report.get("solid").is_none(), "{report}");
    let names = |built: &Built| -> Vec<String> {
        built.report.trace.iter().map(|trace| trace.file.clone()).collect()
    };
    assert_eq!(names(&both), ["mirror.obj", "mirror.step"]);
    assert_eq!(names(&alone), ["mirror.step"]);
    // Beside a mesh or alone, the file shows the same.
    let ([step], [obj, beside]) = (&alone.report.trace[..], &both.report.trace[..]) else {
        panic!("{report}")
    };
    let hits = |trace: &TraceFacts| [trace.rays, trace.hit, trace.missed, trace.back_face];
    assert_eq!(hits(step), hits(beside));
    assert_eq!(hits(step), hits(obj));
    assert_eq!(step.errors, beside.errors);
    // Splines within 2 nm show the design, facets do not.
    let facet = |trace: &TraceFacts| trace.errors.facet_error_px.unwrap().max;
    assert!(facet(step) < 0.01 && facet(step) < 0.1 * facet(obj), "{step:?} {obj:?}");
    let solid = &step.solid;
    assert!(solid.check.is_solid() && solid.check.euler == 2, "{solid:?}");
    assert_eq!(alone.report.verdict, Verdict::Pass);
    assert!(alone.report.frame.is_some());
}

/// A STEP file that shows another picture does not pass.
#[test]
fn the_verdict_holds_the_step_file() {
    let limited = small_but("formats = [\"stl\", \"obj\"]", "formats = [\"step\"]")
        .replace("facet_px = 3", "facet_px = 0.001")
        .replace("pixels = [160, 120]", "pixels = [640, 480]");
    let report = built(&limited).report;
    let said = report.reasons.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ");
    assert!(said.contains("mirror.step: ") && said.contains("mesh.facet_px"), "{said}");
    assert_eq!(report.verdict, Verdict::Fail);
}
