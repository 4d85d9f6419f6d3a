//! Faces of a STEP file say what they are of, by their names and by their colours.

use super::reading::{File, Value};
use super::{Case, cases, fitted, panels, side_faces, written};
use std::collections::BTreeSet;

/// The name of a face.
fn text(file: &File, face: u32) -> String {
    let Value::Text(name) = &file.get(face, "ADVANCED_FACE")[0] else { panic!("no name") };
    name.clone()
}

/// Every face says what it is of and has the colour of its kind; holes and marks are counted.
pub fn check(case: &Case, file: &File) {
    let name = |face: u32| text(file, face);
    let mut told: Vec<String> = file.all("ADVANCED_FACE").into_iter().map(name).collect();
    told.sort();
    let count = |name: &str| told.iter().filter(|told| *told == name).count();
    let own = panels(&case.mirror);
    assert_eq!((count("OPTICAL"), count("BASE")), (own, 1), "{}: {told:?}", case.name);
    let stock = case.stock.as_ref();
    assert_eq!(count("RIM"), usize::from(stock.is_some()), "{}: {told:?}", case.name);
    let sides = stock.map_or(0, side_faces);
    let chamfers = stock.map_or(0, |stock| 2 * usize::from(stock.edge_chamfer_mm > 0.0) * sides);
    assert_eq!((count("SIDE"), count("CHAMFER")), (sides, chamfers), "{}: {told:?}", case.name);
    let numbered = |what: &str| {
        let number = |told: &String| told.strip_prefix(what)?.split(' ').next()?.parse().ok();
        let mut found: Vec<usize> = told.iter().filter_map(number).collect();
        found.sort_unstable();
        found.dedup();
        found
    };
    let holes = case.features().holes().count();
    assert_eq!(numbered("HOLE_"), (1..=holes).collect::<Vec<_>>(), "{}", case.name);
    let marks = stock.map_or(0, |stock| stock.marks.len());
    assert_eq!(numbered("MARK_"), (1..=marks).collect::<Vec<_>>(), "{}", case.name);
    assert!(told.iter().all(|name| !name.is_empty()));
    let (mut coloured, mut colours) = (Vec::new(), BTreeSet::new());
    for item in file.all("STYLED_ITEM") {
        let item = file.get(item, "STYLED_ITEM");
        let (name, style) = (name(item[2].id()), item[1].list()[0].id());
        assert_eq!(colour(file, style), colour_of(&name), "{}: {name}", case.name);
        colours.insert(style);
        coloured.push(name);
    }
    coloured.sort();
    assert_eq!(coloured, told, "{}", case.name);
    // A style for each colour.
    assert_eq!(colours.len(), file.all("COLOUR_RGB").len(), "{}", case.name);
}

/// Red, green and blue of a style of surfaces.
fn colour(file: &File, style: u32) -> [f64; 3] {
    let first = |id: u32, keyword: &str, k: usize| file.get(id, keyword)[k].list()[0].id();
    let usage = first(style, "PRESENTATION_STYLE_ASSIGNMENT", 0);
    let side = file.get(usage, "SURFACE_STYLE_USAGE")[1].id();
    let area = first(side, "SURFACE_SIDE_STYLE", 1);
    let fill = file.get(area, "SURFACE_STYLE_FILL_AREA")[0].id();
    let fill = first(fill, "FILL_AREA_STYLE", 1);
    let rgb = file.get(file.get(fill, "FILL_AREA_STYLE_COLOUR")[1].id(), "COLOUR_RGB");
    [1, 2, 3].map(|k| rgb[k].number())
}

/// The colour that docs/files.md gives a face of this name.
fn colour_of(name: &str) -> [f64; 3] {
    let (kind, words) = name.split_once(' ').unwrap_or((name, ""));
    match kind {
        "OPTICAL" => [0.55, 0.75, 0.95],
        "BASE" => [0.5, 0.75, 0.5],
        "CHAMFER" => [0.6, 0.65, 0.65],
        "LAND" | "WALL" | "RIM" | "SIDE" => [0.8, 0.8, 0.8],
        hole if hole.starts_with("HOLE_") => match words {
            thread if thread.starts_with('M') => [0.95, 0.6, 0.25],
            dowel if dowel.contains(" H7 ") => [0.85, 0.3, 0.3],
            _ => [0.9, 0.85, 0.4],
        },
        mark if mark.starts_with("MARK_") => [0.7, 0.5, 0.8],
        _ => panic!("{name}"),
    }
}

/// A plain through hole has its number alone; any other the words of the drawing too.
#[test]
fn holes_have_the_words_of_the_drawing_in_their_names() {
    let cases = cases();
    let case = cases.iter().find(|case| case.name == "conquistador-stock-drilled").unwrap();
    let file = File::parse(&written(case, &fitted(case)));
    let mut told: Vec<String> =
        file.all("ADVANCED_FACE").into_iter().map(|f| text(&file, f)).collect();
    told.retain(|name| name.starts_with("HOLE_"));
    told.dedup();
    assert_eq!(
        told,
        [
            "HOLE_1 diameter 4.2, through, for a screw M4, counterbore 7, 2.2 deep",
            "HOLE_2 diameter 3.2, through, chamfer 0.4 x 45 deg",
            "HOLE_3 M2 x 0.4 - 6H, 1.4 deep, pilot 1.6, 3 deep",
            "HOLE_4 diameter 5, 2 deep, flat",
            "HOLE_5 diameter 2 H7 (+0.010/0), 2.5 deep, chamfer 0.2 x 45 deg",
            "HOLE_6 diameter 1.5, 2.4 deep, counterbore 4, 1.2 deep, chamfer 0.3 x 45 deg",
        ]
    );
    let plain = cases.iter().find(|case| case.name == "conformal-stock").unwrap();
    let bytes = String::from_utf8(written(plain, &fitted(plain))).unwrap();
    assert_eq!(bytes.matches("ADVANCED_FACE('HOLE_1',").count(), 1);
    assert_eq!(bytes.matches("ADVANCED_FACE('HOLE_2',").count(), 1);
}
