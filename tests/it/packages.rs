//! 3MF packages that other readers refuse, and parts of the wrong size.

use crate::support::builds::{SMALL, edited, folder, morion, save, told};
use crate::support::package::{TYPES, package};
use serde_json::Value;
use std::path::Path;

/// The exit code and the reasons of verifying a file against the small profile.
fn verified(home: &Path, name: &str, more: &[&str]) -> (i32, Vec<String>) {
    let arguments = ["verify", name, "--profile", "small.toml", "--quiet", "--format", "json"];
    let (code, out, err) = told(&morion(home, &[&arguments[..], more].concat()));
    let report: Value = serde_json::from_str(&out).unwrap_or_else(|_| panic!("{out}{err}"));
    (code, serde_json::from_value(report["reasons"].clone()).unwrap())
}

/// The model of the small profile's 3MF.
fn built(home: &Path) -> String {
    save(home, &edited(SMALL, &[("\"obj\"", "\"3mf\"")]));
    assert_eq!(told(&morion(home, &["build", "small.toml", "--quiet"])).0, 0);
    let file = std::fs::File::open(home.join("out/small/mirror.3mf")).unwrap();
    let mut zip = zip::ZipArchive::new(file).unwrap();
    std::io::read_to_string(zip.by_name("3D/3dmodel.model").unwrap()).unwrap()
}

#[test]
fn packages_without_content_types_or_with_a_dtd_are_no_3mf() {
    let folder = folder();
    let home = folder.path();
    let model = built(home);
    let path = home.join("odd.3mf");
    package(&path, Some(TYPES), &[&model]);
    assert_eq!(verified(home, "odd.3mf", &[]), (0, Vec::new()));
    let by_name =
        TYPES.replace("Default Extension=\"model\"", "Override PartName=\"/3D/3dmodel.model\"");
    package(&path, Some(&by_name), &[&model]);
    assert_eq!(verified(home, "odd.3mf", &[]).0, 0);

    let document = model.replacen("<model", "<!DOCTYPE model [<!ENTITY a \"b\">]>\n<model", 1);
    for (types, model, words) in [
        (None, &model, "[Content_Types].xml: "),
        (
            Some(TYPES.replace("\"model\"", "\"stl\"")),
            &model,
            "it must say that 3D/3dmodel.model is",
        ),
        (Some(TYPES.replace("3dmodel+xml", "stl")), &model, "it must say that 3D/3dmodel.model is"),
        (Some(TYPES.replace("\"rels\"", "\"r\"")), &model, "it must say that _rels/.rels is"),
        (Some(TYPES.to_owned()), &document, "it has a document type (DTD), which 3MF forbids"),
    ] {
        package(&path, types.as_deref(), &[model]);
        let (code, reasons) = verified(home, "odd.3mf", &[]);
        assert_eq!((code, reasons.len()), (1, 1), "{words}: {reasons:?}");
        assert!(reasons[0].contains(words), "{words}: {reasons:?}");
    }
}

#[test]
fn a_part_of_the_wrong_size_is_told_so_first() {
    let folder = folder();
    let home = folder.path();
    let model = built(home);
    for (unit, words) in [
        ("inch", "the part is 25.4 times too large: is the unit inch?"),
        ("centimeter", "the part is 10 times too large: is the unit centimetre?"),
        ("micron", "the part is 1000 times too small: is the unit metre?"),
    ] {
        let other = model.replace("unit=\"millimeter\"", &format!("unit=\"{unit}\""));
        package(&home.join("other.3mf"), Some(TYPES), &[&other]);
        let (code, reasons) = verified(home, "other.3mf", &[]);
        assert_eq!(code, 1, "{unit}");
        assert_eq!(reasons[0], format!("other.3mf: {words}"), "{unit}: {reasons:?}");
    }
    std::fs::copy(home.join("out/small/mirror.stl"), home.join("right.stl")).unwrap();
    let (code, reasons) = verified(home, "right.stl", &["--units", "in"]);
    assert_eq!(
        (code, &*reasons[0]),
        (1, "right.stl: the part is 25.4 times too large: is the unit inch?")
    );
    assert_eq!(verified(home, "right.stl", &[]), (0, Vec::new()));
}
