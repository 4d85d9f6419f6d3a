//! 3MF: what is written, what is read, and what a stranger's file may look like.

use crate::support::altered_files::{FileRewriter, flipped};
use crate::support::builds::{SMALL, folder, morion, parsed, save, told};
use crate::support::package::TYPES;
use crate::support::small_but;
use morion::internals::export::{ReadError, read_3mf, read_stl};
use morion::internals::geom::{DVec3, TriMesh};
use morion::internals::pipeline::{Silent, build, verify};
use morion::internals::results::Verdict;
use std::fmt::Write as _;
use std::io::{Cursor, Read, Write as _};
use zip::write::SimpleFileOptions;

const RELATIONS: &str = "_rels/.rels";
const MODEL: &str = "3D/3dmodel.model";
const CONTENT: (&str, &str) = ("[Content_Types].xml", TYPES);

fn three_formats() -> String {
    small_but("[\"stl\", \"obj\"]", "[\"stl\", \"3mf\", \"obj\"]")
}

/// The text of a part of a package.
fn part(package: &[u8], name: &str) -> String {
    let mut zip = zip::ZipArchive::new(Cursor::new(package)).unwrap();
    let mut text = String::new();
    zip.by_name(name).unwrap().read_to_string(&mut text).unwrap();
    text
}

/// A package of these parts.
fn package(parts: &[(&str, &str)]) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, text) in parts {
        zip.start_file(*name, SimpleFileOptions::default()).unwrap();
        zip.write_all(text.as_bytes()).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// A package with this model, under a name of its own.
fn of_model(model: &str) -> Vec<u8> {
    let relations = "<Relationships><Relationship Id=\"thumb\" Target=\"/a.png\" Type=\"image\"/>\
        <Relationship Target=\"/parts/one.model\" Id=\"r\" \
        Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>";
    package(&[CONTENT, ("parts/one.model", model), (RELATIONS, relations)])
}

/// The mesh as an object of a model.
fn object(id: u32, mesh: &TriMesh, scale: f64) -> String {
    let mut text = format!("<object id='{id}'><mesh><vertices>");
    for v in &mesh.vertices {
        let [x, y, z] = (*v * scale).to_array();
        write!(text, "<vertex z='{z}' y=' {y:e} ' x=\"{x}\"></vertex>").unwrap();
    }
    text += "</vertices>\n<triangles>";
    for [a, b, c] in &mesh.triangles {
        write!(text, "<triangle v1='{a}' v2='{b}' v3='{c}' pid='7' p1='0'/>").unwrap();
    }
    text + "</triangles></mesh></object>"
}

fn tetrahedron() -> TriMesh {
    TriMesh {
        vertices: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
        triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    }
}

fn volume(mesh: &TriMesh) -> f64 {
    let six = |t: usize| {
        let [a, b, c] = mesh.corners(t);
        a.cross(b).dot(c)
    };
    (0..mesh.triangles.len()).map(six).sum::<f64>() / 6.0
}

#[test]
fn a_3mf_is_the_stl_in_a_third_of_its_bytes() {
    let folder = folder();
    let report = build(&parsed(&three_formats()), folder.path(), &Silent).unwrap();
    assert_eq!(report.verdict, Verdict::Pass, "{:?}", report.reasons);
    let names: Vec<&str> = report.trace.iter().map(|trace| &*trace.file).collect();
    assert_eq!(names, ["mirror.stl", "mirror.3mf", "mirror.obj"]);
    let read = |name: &str| std::fs::read(folder.path().join("small").join(name)).unwrap();
    let (stl, packed) = (read("mirror.stl"), read("mirror.3mf"));
    assert!(packed.len() as f64 <= 0.3 * stl.len() as f64, "{} {}", packed.len(), stl.len());
    let [a, b] = [read_stl(&stl).unwrap().mesh, read_3mf(&packed).unwrap().mesh];
    assert_eq!(a, b);
    // The rays of both see the same.
    assert_eq!(report.trace[0].errors, report.trace[1].errors);
    // The text is the shortest that reads back to the same single, and names nothing -0.
    let model = part(&packed, MODEL);
    for line in model.lines().filter(|line| line.starts_with("<vertex ")) {
        for number in line.split('"').skip(1).step_by(2) {
            let value: f32 = number.parse().unwrap();
            assert_eq!(value.to_string(), number);
            assert_ne!(value.to_bits(), (-0.0f32).to_bits());
        }
    }
}

#[test]
fn a_3mf_says_who_made_it_for_what() {
    let folder = folder();
    let report = build(&parsed(&three_formats()), folder.path(), &Silent).unwrap();
    let packed = std::fs::read(folder.path().join("small/mirror.3mf")).unwrap();
    let model = part(&packed, MODEL);
    assert!(model.contains("<model unit=\"millimeter\""));
    for words in [
        "<metadata name=\"Title\">small</metadata>",
        "<metadata name=\"Application\">Morion</metadata>",
        &*report.profile.sha256,
        "; millimetres; chord um 20:",
        " facet px 3:",
    ] {
        assert!(model.contains(words), "no {words}");
    }
}

#[test]
fn names_cannot_become_markup() {
    let folder = folder();
    let mut profile = parsed(&three_formats());
    profile.name = "a&b <c> \"d\" \u{e9}".into();
    build(&profile, folder.path(), &Silent).unwrap();
    let packed = std::fs::read(folder.path().join(&profile.name).join("mirror.3mf")).unwrap();
    let model = part(&packed, MODEL);
    assert!(model.contains("<metadata name=\"Title\">a&amp;b &lt;c&gt; \"d\" ?</metadata>"));
    assert!(read_3mf(&packed).is_ok());
}

/// Strangers use other units, orders, quotes, names, transforms and components.
#[test]
fn a_3mf_of_another_making_is_read_and_verified() {
    let folder = folder();
    let home = folder.path();
    save(home, SMALL);
    assert_eq!(told(&morion(home, &["build", "small.toml", "--quiet"])).0, 0);
    let stl = std::fs::read(home.join("out/small/mirror.stl")).unwrap();
    let mesh = read_stl(&stl).unwrap().mesh;
    // Half as large in inches, lying on its side and to the left, in an object within an object;
    // another one is not on the build plate.
    let model = format!(
        "<?xml version='1.0'?>\n<!-- elsewhere -->\n<m:model xmlns:m='x' unit='inch'><m:resources>{}{}\
         <m:object id='9'><m:components>\
         <m:component objectid='4' transform='2 0 0 0 2 0 0 0 2 0 0 0'/></m:components></m:object>\
         </m:resources><m:build>\
         <m:item objectid='9' transform='0 0 1 1 0 0 0 1 0 0 0 0'/></m:build></m:model>",
        object(4, &turned(&mesh), 0.5 / 25.4),
        object(5, &tetrahedron(), 1.0),
    );
    let path = home.join("theirs.3MF");
    std::fs::write(&path, of_model(&model)).unwrap();
    let report = verify(&parsed(SMALL), &path, &Silent).unwrap();
    assert_eq!(report.verdict, Verdict::Pass, "{:?}", report.reasons);
    assert_eq!(report.files[0].format, "3mf");
}

/// What the transform of the test above turns back: (x, y, z) to (y, z, x).
fn turned(mesh: &TriMesh) -> TriMesh {
    let vertices = mesh.vertices.iter().map(|v| DVec3::new(v.z, v.x, v.y));
    // Row vectors: (x, y, z) M = (y, z, x) for the matrix with rows (0 0 1), (1 0 0), (0 1 0).
    TriMesh { vertices: vertices.collect(), triangles: mesh.triangles.clone() }
}

#[test]
fn transforms_and_units_place_every_item() {
    let model = format!(
        "<model unit='centimeter'><resources>{}</resources><build>\
         <item objectid='1' transform='1 0 0 0 1 0 0 0 1 5 0 0'/>\
         <item objectid='1' transform='-1 0 0 0 1 0 0 0 1 0 0 0'/></build></model>",
        object(1, &tetrahedron(), 1.0)
    );
    let mesh = read_3mf(&of_model(&model)).unwrap().mesh;
    assert_eq!(mesh.triangles.len(), 8);
    // A reflection does not turn it inside out.
    assert!((volume(&mesh) - 2.0 * 1000.0 / 6.0).abs() < 1e-9, "{}", volume(&mesh));
    let (lo, hi) = mesh.bounds().unwrap();
    assert_eq!((lo, hi), (DVec3::new(-10.0, 0.0, 0.0), DVec3::new(60.0, 10.0, 10.0)));
}

#[test]
fn what_is_no_3mf_says_why() {
    let whole = object(1, &tetrahedron(), 1.0);
    let item = "<build><item objectid='1'/></build>";
    let of = |inner: &str| of_model(&format!("<model>{inner}</model>"));
    let doubling: String = (2..40)
        .map(|k| {
            let component = format!("<component objectid='{}'/>", k - 1);
            format!("<object id='{k}'><components>{component}{component}</components></object>")
        })
        .collect();
    let deep = of(&format!("{whole}{doubling}<build><item objectid='16'/></build>"));
    assert_eq!(read_3mf(&deep).unwrap().mesh.triangles.len(), 4 << 15);
    for (bytes, why) in [
        (b"solid".to_vec(), "the archive: "),
        (package(&[("a", "b")]), "[Content_Types].xml: "),
        (package(&[CONTENT, ("a", "b")]), "_rels/.rels: "),
        (package(&[CONTENT, (RELATIONS, "<Relationships/>")]), "it leads to no model"),
        (of(&whole), "the file holds no facets"),
        (of(&format!("{whole}<build><item objectid='2'/></build>")), "known objects"),
        (of(&format!("{whole}{item}").replace("v3='1'", "v3='4'")), "facet 0 has vertex 4 of 4"),
        (of(&format!("{whole}{item}").replace("v3='1'", "v3='-1'")), "must have a number v3"),
        (of(&format!("{whole}{item}").replace("x=\"0\"", "")), "must have a number x"),
        (of(&format!("{whole}{item}").replace("x=\"1\"", "x='inf'")), "not a finite number"),
        (of(&format!("{whole}{whole}{item}")), "object 1 is there twice"),
        (of("<vertex x='0' y='0' z='0'/>"), "it must stand in an object"),
        (of(&format!("{whole}<build><item objectid='1' transform='1 2'/></build>")), "twelve"),
        (of(&format!("{whole}<build><item objectid='1' p:path='/b'/></build>")), "other parts"),
        (of(&format!("{whole}{doubling}<build><item objectid='39'/></build>")), "nested deeper"),
        (
            of(&format!("<metadata>{}</metadata>{whole}{item}", " ".repeat(2 << 20))),
            "is longer than",
        ),
        (
            of(&format!("{whole}<build>{}</build>", "<item objectid='1'/>".repeat(100_000))),
            "more than 100000 objects and places of them",
        ),
        (of_model("<model unit='cubit'/>"), "unknown unit cubit"),
        (of_model(&format!("<model>{whole}{item}")), "it ends inside 1 elements"),
        (of_model(&format!("<model>{whole}{item}</mode>")), "parts/one.model, byte "),
    ] {
        match read_3mf(&bytes) {
            Err(
                error @ (ReadError::ThreeMf(_) | ReadError::Empty | ReadError::NotFinite { .. }),
            ) => {
                let said = error.to_string();
                assert!(said.contains(why), "{said}, not {why}");
            }
            other => panic!("{other:?}, not {why}"),
        }
    }
}

#[test]
fn a_damaged_3mf_fails_and_is_named() {
    let only = parsed(&small_but("[\"stl\", \"obj\"]", "[\"3mf\"]"));
    for percent in [5, 40, 90] {
        let folder = folder();
        let report =
            build(&only, folder.path(), &FileRewriter(|bytes| flipped(bytes, percent, 0x10)))
                .unwrap();
        assert_eq!(report.verdict, Verdict::Fail);
        assert!(report.reasons.iter().all(|reason| reason.to_string().starts_with("mirror.3mf: ")));
        // Every part of a package has a check sum.
        let broken =
            report.reasons.iter().any(|reason| reason.to_string().contains("not a readable 3MF"));
        assert!(broken, "{:?}", report.reasons);
    }
}

#[test]
fn nothing_is_removed_where_not_all_can_be() {
    let folder = folder();
    let with = |formats: &str| parsed(&small_but("[\"stl\", \"obj\"]", formats));
    build(&with("[\"obj\"]"), folder.path(), &Silent).unwrap();
    let home = folder.path().join("small");
    std::fs::create_dir(home.join("mirror.step")).unwrap();
    let before = std::fs::read(home.join("report.json")).unwrap();
    let error = build(&with("[\"stl\"]"), folder.path(), &Silent).unwrap_err().to_string();
    assert!(error.contains("mirror.step"), "{error}");
    assert!(home.join("mirror.obj").exists() && !home.join("mirror.stl").exists());
    assert_eq!(std::fs::read(home.join("report.json")).unwrap(), before);
}
