//! AP242: datum features and the mirror's profile tolerance stand in the file, and the shape is that of AP214.

use super::reading::{File, Value};
use super::{Case, all, fitted, label, panels, written};
use crate::support::builds::{SMALL, edited, files, folder, parsed};
use crate::support::share;
use morion::internals::export::step::{Pmi, StepSchema, write_step};
use morion::internals::geom::{Contour, DatumScheme, Outline};
use morion::internals::pipeline::{Silent, build};
use morion::internals::results::BuildReport;

/// The file of a case in AP242.
fn in_ap242(case: &Case, pmi: Pmi) -> Vec<u8> {
    let (schema, mut bytes) = (StepSchema::Ap242(pmi), Vec::new());
    let (fit, name) = (fitted(case), label(&case.name));
    write_step(&mut bytes, &fit, case.features(), &schema, &name).unwrap();
    bytes
}

/// Datum features of a case.
fn datums(case: &Case) -> DatumScheme {
    let walls = match case.mirror.outline {
        Outline::Ring { outer, .. } => Some(Contour::Circle { radius_mm: outer }),
        Outline::Rect(rect) => {
            let half = 0.5 * rect.size();
            case.mirror.chart.is_plan().then_some(Contour::Rect { half, corner_mm: 0.0 })
        }
    };
    DatumScheme::new(case.stock.as_ref(), walls)
}

/// The name of the face that a feature of the shape is said to be.
fn face_of(file: &File, feature: u32) -> String {
    const USAGE: &str = "GEOMETRIC_ITEM_SPECIFIC_USAGE";
    let mut found = file.all(USAGE);
    found.retain(|&usage| file.get(usage, USAGE)[2].id() == feature);
    let [usage] = found[..] else { panic!("{found:?}") };
    let face = file.get(usage, USAGE)[4].id();
    let Value::Text(name) = &file.get(face, "ADVANCED_FACE")[0] else { panic!("no name") };
    // (Words on a hole come after its number.)
    name.split(' ').next().unwrap().to_owned()
}

/// Letters of the datums and names of their faces, and the features that the tolerance is of.
fn told(file: &File) -> (Vec<(String, String)>, usize) {
    let datum = |feature: u32| {
        let Value::Text(letter) = &file.get(feature, "DATUM_FEATURE")[0] else { panic!() };
        (letter.clone(), face_of(file, feature))
    };
    let features = file.all("SHAPE_ASPECT");
    assert!(features.iter().all(|&feature| face_of(file, feature) == "OPTICAL"));
    (file.all("DATUM_FEATURE").into_iter().map(datum).collect(), features.len())
}

#[test]
#[ignore = "long: .ci/nightly"]
fn every_datum_feature_is_a_face_of_its_kind_and_the_tolerance_is_of_the_whole_mirror() {
    for case in share(2, 0, all()) {
        let scheme = datums(&case);
        let pmi = Pmi { datums: scheme.clone(), profile_mm: Some(0.02) };
        let file = File::parse(&in_ap242(&case, pmi));
        let wanted = |(letter, feature): (char, _)| {
            let outer = if case.stock.is_some() { "SIDE" } else { "WALL" };
            let face = match format!("{feature}").as_str() {
                "base" => "BASE".to_owned(),
                hole if hole.starts_with("hole ") => hole.to_uppercase().replace(' ', "_"),
                _ => outer.to_owned(),
            };
            (letter.to_string(), face)
        };
        let wanted: Vec<_> = scheme.lettered().map(wanted).collect();
        assert_eq!(told(&file), (wanted, panels(&case.mirror)), "{}", case.name);
        let referred = file.all("DATUM_REFERENCE_COMPARTMENT").len();
        assert_eq!(referred, scheme.lettered().count(), "{}", case.name);
        let groups = file.all("COMPOSITE_GROUP_SHAPE_ASPECT").len();
        assert_eq!(groups, usize::from(panels(&case.mirror) > 1), "{}", case.name);
    }
}

#[test]
#[ignore = "long: .ci/nightly"]
fn the_shape_is_that_of_ap214() {
    for case in all().into_iter().take(4) {
        let plain = String::from_utf8(written(&case, &fitted(&case))).unwrap();
        let text = in_ap242(&case, Pmi { datums: datums(&case), profile_mm: None });
        let text = String::from_utf8(text).unwrap();
        assert!(text.contains("FILE_SCHEMA(('AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF {"));
        assert!(!text.contains("TOLERANCE("));
        let shape = |text: &str| -> String {
            let lines = text.lines().skip_while(|line| !line.starts_with("#3="));
            lines.take_while(|line| !line.contains("=DATUM") && *line != "ENDSEC;").collect()
        };
        assert!(shape(&plain).len() > 1000 && shape(&plain) == shape(&text), "{}", case.name);
    }
}

/// A build of the small conquistador, its STEP in AP242.
fn built(edits: &[(&str, &str)]) -> (File, BuildReport) {
    let ap242 = ("[\"stl\", \"obj\"]", "[\"step\"]\nstep.schema = \"ap242\"");
    let (profile, folder) = (parsed(&edited(SMALL, &[&[ap242], edits].concat())), folder());
    let report = build(&profile, folder.path(), &Silent).unwrap();
    let bytes = files(&folder.path().join("small")).remove("mirror.step").unwrap();
    (File::parse(&bytes), report)
}

/// The tolerance of a file, mm: it is the only length with a unit.
fn width_mm(file: &File) -> f64 {
    let lengths = file.all("LENGTH_MEASURE_WITH_UNIT");
    let [length] = lengths[..] else { panic!("{lengths:?}") };
    let Value::Typed(measure, value) = &file.get(length, "LENGTH_MEASURE_WITH_UNIT")[0] else {
        panic!("no measure")
    };
    assert_eq!(measure, "LENGTH_MEASURE");
    value[0].number()
}

#[test]
fn the_report_has_what_the_file_says_and_stricter_limits_leave_less() {
    let (file, report) = built(&[]);
    let pmi = report.step.unwrap().pmi.unwrap();
    assert_eq!(pmi.datums, ["A base", "B side towards -Y", "C side towards -X"]);
    let mm = pmi.surface_profile_mm.unwrap();
    assert_eq!(width_mm(&file), mm);
    assert!(pmi.limited_by.unwrap().starts_with("legendre_"));
    let stricter = ("pixel_error_max_px = 5", "pixel_error_max_px = 3");
    let (_, report) = built(&[stricter]);
    assert!(report.step.unwrap().pmi.unwrap().surface_profile_mm.unwrap() < 0.8 * mm);
    // A design over its limits leaves nothing.
    let (file, report) = built(&[("pixel_error_rms_px = 2", "pixel_error_rms_px = 0.1")]);
    let pmi = report.step.unwrap().pmi.unwrap();
    assert_eq!((pmi.surface_profile_mm, pmi.limited_by), (None, None));
    assert_eq!(file.all("DATUM").len(), 3);
    assert!(file.all("LENGTH_MEASURE_WITH_UNIT").is_empty());
}
