//! Profiles that are valid, profiles at the edge of it, and text that is no profile at all.

use crate::support::least::{strip_of, with};
use crate::support::shipped_text;
use morion::internals::geom::{ScanPath, ScanPattern};
use morion::internals::optics::{CameraModel, Mount, StripLaw, Target};
use morion::internals::profile::{
    AcceptanceSpec, DrawingSpec, FileFormat, Layout, LensSpec, MeshFormat, MeshGoal, Method,
    MethodKind, PanelSource, PaperSize, PartSpec, Profile, ProgramSpec, ProjectionSpec, Ridge,
    SagTable, ShapeSpec, StepProtocol, StripLawSpec, StripSpec, Tolerance, shipped,
};
use proptest::prelude::*;

#[test]
fn the_shipped_conquistador_is_the_papers() {
    let text = shipped_text("conquistador");
    let profile = Profile::parse("c", "c.toml", text.as_bytes()).expect("valid");
    assert_eq!(
        profile,
        Profile {
            name: "c".into(),
            named: "c".into(),
            heights: None,
            form_map: None,
            sha256: profile.sha256.clone(),
            files: Vec::new(),
            summary: "Panoramic mirror folded to fill a 640 x 480 frame".into(),
            camera: CameraModel::Orthographic { pixels: [640, 480] },
            mount: Mount::default(),
            camera_body: None,
            obstacles: vec![],
            camera_file: None,
            lens: LensSpec { aperture: None, focal_mm: None, wavelength_nm: 550.0 },
            projection: Some(ProjectionSpec::Strip(StripSpec {
                law: StripLawSpec::Named(StripLaw::Cylindrical),
                azimuth_deg: [-180.0, 180.0],
                elevation_deg: [-30.0, 30.0],
                target: Target::Infinity,
            })),
            layout: Layout::Conquistador {
                panel: PanelSource::Refit,
                ridge: Ridge::Crest,
                fill_frame: true,
            },
            shape: ShapeSpec::Designed(Method {
                kind: MethodKind::VectorField,
                degree: 12,
                minimax: false,
            }),
            part: PartSpec {
                width_mm: 60.0,
                base_mm: 5.0,
                border: None,
                holes: vec![],
                forming: None,
                shell: None
            },
            step: StepProtocol::Ap214,
            drawing: DrawingSpec::default(),
            program: ProgramSpec::default(),
            mesh: MeshGoal::limits(Some(2.0), Some(1.0)),
            formats: [MeshFormat::Stl, MeshFormat::Obj].map(FileFormat::Mesh).to_vec(),
            sag: SagTable::default(),
            accept: AcceptanceSpec {
                blur_p95_px: None,
                pixel_error_rms_px: Some(2.0),
                pixel_error_max_px: Some(7.0),
                frame_filled: Some(0.999),
            },
            tolerance: Tolerance::default(),
        }
    );
}

#[test]
fn a_sag_table_has_a_path_and_spacings_or_usual_ones() {
    let table = |text: &str| {
        let export = format!("export.formats = [\"stl\", \"csv\"]\n{text}");
        with(&[("export.formats = [\"stl\"]\n", &export)]).map(|profile| profile.sag)
    };
    let spacing_mm = |table: &SagTable| {
        let ScanPath { pitch_mm, step_mm, .. } = table.scan(60.0);
        [pitch_mm, step_mm]
    };
    let usual = table("").unwrap();
    assert_eq!(usual, SagTable::default());
    assert_eq!(spacing_mm(&usual), [0.3, 0.3]);
    let spiral = table("export.sag = { path = \"spiral\", pitch_mm = 0.02 }").unwrap();
    assert_eq!(spiral.path, ScanPattern::Spiral);
    assert_eq!(spacing_mm(&spiral), [0.02, 0.3]);
    for (text, words) in [
        ("export.sag.path = \"spirale\"", "did you mean \"spiral\"?"),
        ("export.sag.step_mm = 0", "export.sag.step_mm must be a number from 0.001 to 1000000"),
        ("export.sag.pitch = 0.1", "did you mean pitch_mm?"),
        ("export.sag = \"raster\"", "export.sag must be a table"),
        (
            "export.sag = { pitch_mm = 0.01, step_mm = 0.005 }",
            "least.toml:8:43: export.sag must ask for at most 2e7 points, found about 7e7",
        ),
    ] {
        let complaints = table(text).unwrap_err();
        assert!(complaints.contains(words), "{complaints}");
        assert_eq!(
            complaints.lines().filter(|line| !line.starts_with(' ')).count(),
            1,
            "{complaints}"
        );
    }
}

#[test]
fn a_step_file_has_a_schema() {
    let step = |text: &str| {
        let export = format!("export.formats = [\"step\"]\n{text}");
        with(&[("export.formats = [\"stl\"]\n", &export)]).map(|profile| profile.step)
    };
    assert_eq!(step("").unwrap(), StepProtocol::Ap214);
    assert_eq!(step("export.step.schema = \"ap214\"").unwrap(), StepProtocol::Ap214);
    assert_eq!(step("export.step.schema = \"ap242\"").unwrap(), StepProtocol::Ap242);
    for (text, words) in [
        ("export.step.schema = \"ap-242\"", "did you mean \"ap242\"?"),
        ("export.step.schema = 242", "export.step.schema must be \"ap214\" or \"ap242\""),
        ("export.step.scheme = \"ap242\"", "did you mean schema?"),
    ] {
        let complaints = step(text).unwrap_err();
        assert!(complaints.contains(words), "{complaints}");
    }
}

#[test]
fn a_drawing_says_what_its_font_has_letters_for() {
    let drawing = |text: &str| {
        let export = format!("export.formats = [\"stl\"]\n{text}\n");
        with(&[("export.formats = [\"stl\"]\n", &export)]).map(|profile| profile.drawing)
    };
    assert_eq!(drawing("").unwrap(), DrawingSpec::default());
    let said =
        drawing("drawing = { paper = \"A4\", owner = \" \u{c6}rø \", date = 2026-11-27 }").unwrap();
    assert_eq!(
        (said.paper, &*said.title.owner, &*said.title.date),
        (PaperSize::A4, "\u{c6}r\u{f8}", "2026-11-27")
    );
    assert_eq!(drawing("drawing.date = \"2026-11-27\"").unwrap().title.date, "2026-11-27");
    let long = format!("drawing.title = \"{}\"", "x".repeat(61));
    for (text, words) in [
        ("drawing.paper = \"a4\"", "drawing.paper must be \"A3\" or \"A4\""),
        ("drawing.projection = \"first\"", "did you mean \"first-angle\"?"),
        (
            "drawing.owner = \"\u{65e5}\u{672c}\"",
            "found '\u{65e5}', which the drawing's font has not",
        ),
        ("drawing.title = \"two\\nlines\"", "found '\\n', which the drawing's font has not"),
        (&long, "found 61 characters"),
        ("drawing.date = \"27.11.2026\"", "drawing.date must be a date as year-month-day"),
        ("drawing.date = 2026-11-27T10:00:00", "as in date = 2026-11-27"),
        ("drawing.number = 4711", "drawing.number must be text of at most 60 characters"),
        ("drawing.colour = \"red\"", "drawing must hold only"),
    ] {
        let complaints = drawing(text).unwrap_err();
        assert!(complaints.contains(words), "{text}: {complaints}");
    }
}

#[test]
fn defaults_and_other_ways_to_write_toml() {
    let profile = with(&[]).expect("valid");
    assert_eq!(profile.summary, "");
    assert_eq!(profile.accept, AcceptanceSpec::default());
    assert_eq!(profile.mesh.facet_px(), None);
    assert_eq!(
        profile.layout,
        Layout::Conquistador { panel: PanelSource::Refit, ridge: Ridge::Crest, fill_frame: false }
    );
    let strip = with(&[("layout.conquistador", "layout.strip")]).expect("valid");
    assert_eq!(strip.layout, Layout::Strip { fill_frame: false });
    let valley = "layout.conquistador = { ridge = \"valley\", panel = \"section\" }";
    let valley = with(&[("layout.conquistador = {}", valley)]).expect("valid");
    assert_eq!(
        valley.layout,
        Layout::Conquistador {
            panel: PanelSource::Section,
            ridge: Ridge::Valley,
            fill_frame: false,
        }
    );
    let mercator = with(&[("cylindrical", "mercator"), ("[640", "[0x2_80")]).expect("valid");
    assert_eq!(strip_of(&mercator).law, StripLawSpec::Named(StripLaw::Mercator));
    assert_eq!(mercator.camera, CameraModel::Orthographic { pixels: [640, 480] });
}

#[test]
fn limits_are_where_they_are_said_to_be() {
    let strip = ("layout.conquistador", "layout.strip");
    for (old, inside, outside) in [
        ("[640, 480]", "[1, 32767]", "[1, 32768]"),
        ("[-180, 180]", "[-360, 0]", "[-360.001, -1]"),
        ("[-180, 180]", "[0, 360]", "[-0.001, 360]"),
        ("[-30, 30]", "[-89.999, 89.999]", "[-90, 89]"),
        ("degree = 12", "degree = 1", "degree = 0"),
        ("degree = 12", "degree = 40", "degree = 41"),
        ("width_mm = 60", "width_mm = 1e-3", "width_mm = 0.999e-3"),
        ("width_mm = 60", "width_mm = 1e6", "width_mm = 1000001"),
        ("base_mm = 5", "base_mm = 0.001", "base_mm = -0.0"),
        ("chord_um = 2", "chord_um = 1e-4", "chord_um = 0.99e-4"),
        ("chord_um = 2", "facet_px = 1e-3", "facet_px = 0"),
        ("chord_um = 2", "facet_px = 1000", "facet_px = 1000.1"),
        ("chord_um = 2", "max_triangles = 100", "max_triangles = 99"),
        ("chord_um = 2", "max_triangles = 4e7", "max_triangles = 40_000_001"),
        (
            "\"stl\"]",
            "\"stl\"]\naccept = { frame_filled = 1, pixel_error_rms_px = 0 }",
            "\"stl\"]\naccept.frame_filled = 1.0001",
        ),
    ] {
        if let Err(complaints) = with(&[strip, (old, inside)]) {
            panic!("{inside}: {complaints}");
        }
        assert!(with(&[strip, (old, outside)]).is_err(), "{outside}");
    }
}

#[test]
fn the_hash_is_of_the_bytes() {
    let text = shipped()[0].text;
    let hash = |text: &str| Profile::parse("p", "p.toml", text.as_bytes()).expect("valid").sha256;
    assert_eq!(hash(text).len(), 64);
    assert_ne!(hash(text), hash(&format!("{text}\n")));
    assert_ne!(hash(text), hash(&text.replace('\n', "\r\n")));
    // SHA-256 of this very text, by another program.
    assert_eq!(
        with(&[]).expect("valid").sha256,
        "5d3ca418c56b4d2330511dbf3057523715d608c39eba8c28f6085009c79eb517"
    );
}

/// Nesting of every kind, within the limit of size, on a small stack.
#[test]
fn nesting_never_exhausts_the_stack() {
    let deep = |unit: &str, tail: &str| {
        let mut text = unit.repeat((65_000 - tail.len()) / unit.len());
        text.push_str(tail);
        text
    };
    let keys = deep("a.", "b = 1");
    let half = |open: &str, close: &str| {
        let n = 60_000 / (open.len() + close.len());
        format!("{}1{}", open.repeat(n), close.repeat(n))
    };
    let dotted = format!("{{{}a=", "a.".repeat(70));
    let product = format!("x = {}1{}", dotted.repeat(75), "}".repeat(75));
    let texts = [
        keys.clone(),
        format!("[{keys}"),
        deep("[", ""),
        deep("x = [", ""),
        deep("x = [}", ""),
        deep("x = {]", ""),
        deep("a = {", ""),
        deep("[a.", ""),
        deep("[[a]]\n", ""),
        deep("a . ", "b = 1"),
        deep("\"\".", "b = 1"),
        deep("'='.", "b = 1"),
        deep("\"#\\\"\".", "b = 1"),
        deep("'''\n'''.", "b = 1"),
        format!("x = {}", half("[", "]")),
        format!("x = {}", half("{a=", "}")),
        format!("x = {}", half("{a.b.c.d.e.f.g.h=\n", "}")),
        format!("x = {}", half("[}", "{]")),
        product,
    ];
    let small = std::thread::Builder::new().stack_size(256 * 1024);
    let thread = small.spawn(move || {
        for text in texts {
            let start: String = text.chars().take(20).collect();
            let complaints = Profile::parse("deep", "deep.toml", text.as_bytes());
            let complaints = complaints.expect_err("no profile");
            assert!((1..=21).contains(&complaints.0.len()), "{start}");
        }
    });
    assert!(thread.expect("a thread").join().is_ok());
}

/// Text made of the pieces that TOML is made of.
fn soup() -> impl Strategy<Value = String> {
    let piece = prop::sample::select(vec![
        "[",
        "]",
        "[[",
        "]]",
        "{",
        "}",
        "=",
        ",",
        ".",
        "\n",
        "\r\n",
        "\r",
        "\"",
        "'",
        "\"\"\"",
        "'''",
        "\\",
        "#",
        " ",
        "\t",
        "camera",
        "orthographic",
        "pixels",
        "mesh",
        "chord_um",
        "layout",
        "strip",
        "projection",
        "table",
        "elevation_deg",
        "mirror",
        "polynomial",
        "radius_mm",
        "terms",
        "[[0,1]]",
        "[[0,1,2]]",
        "summary",
        "1",
        "-1",
        "0x",
        "1e",
        "nan",
        "inf",
        "true",
        "1979-05-27",
        "é",
        "\u{feff}",
        "\0",
        "\u{1b}",
        "_",
    ]);
    prop::collection::vec(piece, 0..60).prop_map(|pieces| pieces.concat())
}

/// Complaints must be there, in order and inside the text.
fn check_complaints(text: &[u8]) -> Result<(), TestCaseError> {
    if let Err(complaints) = Profile::parse("soup", "soup.toml", text) {
        prop_assert!(!complaints.0.is_empty());
        let places: Vec<_> = complaints.0.iter().map(|c| (c.line, c.column)).collect();
        prop_assert!(places.is_sorted());
        let text = String::from_utf8_lossy(text);
        let lines: Vec<&str> = text.split('\n').collect();
        for ((line, column), complaint) in places.iter().zip(&complaints.0) {
            prop_assert!((1..=lines.len()).contains(line));
            prop_assert!((1..=lines[line - 1].chars().count() + 1).contains(column));
            let raw = complaint.to_string().contains('\u{1b}');
            prop_assert!(!raw, "an escape character reaches the terminal");
        }
    }
    Ok(())
}

/// A ring under a pinhole, a strip by a table and a given mirror.
const OTHERS: [&str; 3] = [
    "[camera.pinhole]\npixels = [640, 480]\nhfov_deg = 40\ndistance_mm = 200\n\
     [projection.cylinder]\ninner_polar_deg = 20\nouter_polar_deg = 120\n\
     target_radius_mm = 500\n[layout.annulus]\ninner_width_mm = 20\n\
     [method.distribution]\ndegree = 12\nminimax = true\n[part]\nwidth_mm = 60\n\
     base_mm = 5\n[mesh]\nfacet_px = 1\n[export]\nformats = [\"obj\"]\n",
    "[camera.orthographic]\npixels = [640, 480]\n[projection.table]\n\
     azimuth_deg = [-90, 90]\nelevation_deg = [[0, 40], [100, 20], [200, 5]]\n\
     target_plane_mm = 500\n[layout.strip]\nfill_frame = false\n\
     [method.fixed-surface]\ndegree = 12\n[part]\nwidth_mm = 60\n\
     base_mm = 5\n[mesh]\nfacet_px = 1\n[export]\nformats = [\"obj\"]\n",
    "[camera.pinhole]\npixels = [640, 480]\nfocal_px = 800\ndistance_mm = 200\n\
     [mirror.polynomial]\nradius_mm = -80\nconic = -0.5\n\
     terms = [[2, 0, 1e-3], [0, 4, 1e-6]]\n[part]\nwidth_mm = 60\nheight_mm = 40\n\
     base_mm = 5\n[mesh]\nchord_um = 2\n[export]\nformats = [\"obj\"]\n",
];

#[test]
fn the_texts_to_damage_are_whole() {
    for text in OTHERS {
        if let Err(complaints) = Profile::parse("o", "o.toml", text.as_bytes()) {
            panic!("{complaints}");
        }
    }
}

proptest! {
    #[test]
    fn no_text_is_too_strange(text in soup()) {
        check_complaints(text.as_bytes())?;
    }

    #[test]
    fn no_bytes_are_too_strange(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        check_complaints(&bytes)?;
    }

    /// A valid profile with a piece cut out or something strange put in.
    #[test]
    fn no_damage_is_too_strange(
        which in 0..6_usize,
        at in 0..1500_usize,
        cut in 0..40_usize,
        put in soup(),
    ) {
        let whole = shipped().get(which).map_or_else(|| OTHERS[which - 3], |s| s.text);
        let mut text = whole.as_bytes().to_vec();
        let at = at.min(text.len());
        let end = (at + cut).min(text.len());
        text.splice(at..end, put.bytes());
        check_complaints(&text)?;
    }
}
