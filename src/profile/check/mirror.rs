//! Entries of the mirror's shape: a method, or the mirror itself.

use toml::de::DeValue;

use super::super::reader::Need::{Optional, Required};
use super::super::reader::{ProfileReader, Section};
use super::super::values::{Located, RowsFormat, flag, number, rows, within};
use super::super::{Conic, Method, MethodKind, Monomial, Polynomial, ShapeSpec};
use super::{SIGNED, is_signed, only};

const MAX_DEGREE: usize = 40;
/// Number of terms up to the highest degree.
const MOST_TERMS: usize = (MAX_DEGREE + 1) * (MAX_DEGREE + 2) / 2;

/// A shape, and where its conic stands.
pub(super) struct ShapeEntry {
    /// Its table.
    pub(super) path: String,
    /// The mirror is given and not designed.
    pub(super) is_given: bool,
    pub(super) conic: Option<Located<Conic>>,
    pub(super) shape: Option<ShapeSpec>,
}

/// The shape, designed or given.
pub(super) fn read(reader: &mut ProfileReader, root: &Section) -> Option<ShapeEntry> {
    let designed = root.has("method");
    let given = root.has("mirror");
    let mut read = Vec::new();
    if designed || !given {
        let hint = "vector-field fits the mirror's gradient; [mirror.polynomial] gives a mirror \
                    instead";
        for (name, section) in reader.alternatives(root, "method", hint) {
            read.push(method(reader, name, &section));
        }
    }
    if given {
        let hint = "a polynomial has radius_mm or terms or both, a grid has a file of heights";
        for (name, section) in reader.alternatives(root, "mirror", hint) {
            if designed && read.iter().all(|found| found.path.starts_with("method")) {
                let message = "mirror must be left out with [method], found both".to_owned();
                let hint = "a method designs the mirror, [mirror] gives it; remove one of them";
                reader.complain(section.at, message, hint);
            }
            read.push(match name {
                "grid" => grid(reader, &section),
                _ => polynomial(reader, &section),
            });
        }
    }
    only(read)
}

fn method(reader: &mut ProfileReader, name: &str, section: &Section) -> ShapeEntry {
    let must = "a whole number from 1 to 40";
    let hint = "the degree of the mirror's polynomial; 12 suits a panorama";
    let degree = number(reader, section, "degree", Required, must, hint, |f| {
        f.fract() == 0.0 && (1.0..=MAX_DEGREE as f64).contains(&f)
    });
    let minimax = flag(reader, section, "minimax").is_some_and(|flag| flag.value);
    let kind = match name {
        "fixed-surface" => MethodKind::FixedSurface,
        "distribution" => MethodKind::Distribution,
        _ => MethodKind::VectorField,
    };
    let method = degree.map(|degree| Method { kind, degree: degree.value as usize, minimax });
    let shape = method.map(ShapeSpec::Designed);
    ShapeEntry { path: section.path.clone(), is_given: false, conic: None, shape }
}

fn polynomial(reader: &mut ProfileReader, section: &Section) -> ShapeEntry {
    if !section.has("radius_mm") && !section.has("terms") {
        let message = format!("{} must hold radius_mm, terms or both, found neither", section.path);
        let hint = "radius_mm = -50 is a dome; terms = [[2, 0, -0.01]] is -0.01 X^2";
        reader.missing(section, message, hint);
    }
    let hint = "the radius of curvature in the middle; below 0 the mirror is a dome, convex \
                towards the camera";
    let radius = number(reader, section, "radius_mm", Optional, SIGNED, hint, is_signed);
    let must = "a number from -1000000 to 1000000";
    let hint = "0 is a sphere, -1 a paraboloid";
    let conic = number(reader, section, "conic", Optional, must, hint, |f| f.abs() <= 1e6);
    if let Some(conic) = conic
        && !section.has("radius_mm")
    {
        let path = section.path_of("conic");
        let message = format!("{path} must go with a radius_mm, found {} alone", conic.value);
        reader.complain(conic.at, message, "radius_mm = -50 is a dome of that radius");
    }
    let terms = terms(reader, section);
    let conic = radius.map(|radius| {
        let k = conic.map_or(0.0, |conic| conic.value);
        Located { value: Conic { radius_mm: radius.value, conic: k }, at: radius.at }
    });
    let polynomial = Polynomial { conic: conic.map(|conic| conic.value), terms };
    let shape = Some(ShapeSpec::Polynomial(polynomial));
    ShapeEntry { path: section.path.clone(), is_given: true, conic, shape }
}

fn terms(reader: &mut ProfileReader, section: &Section) -> Vec<Monomial> {
    let list = RowsFormat {
        key: "terms",
        need: Optional,
        entry: "[i, j, c]",
        count: [1, MOST_TERMS],
        hint: "[2, 0, -0.01] is the term -0.01 X^2 Y^0, in millimetres",
    };
    let path = section.path_of(list.key);
    let mut terms: Vec<Monomial> = Vec::new();
    for entry in rows::<3>(reader, section, &list).map_or_else(Vec::new, |rows| rows.value) {
        let exponents = format!("the exponents in {path}");
        let must = "whole numbers from 0 to 40";
        let whole = |f: f64| f.fract() == 0.0 && (0.0..=MAX_DEGREE as f64).contains(&f);
        let [i, j, c] = entry.value;
        let i = within(reader, &exponents, i, must, list.hint, whole);
        let j = within(reader, &exponents, j, must, list.hint, whole);
        let coefficients = format!("the coefficients in {path}");
        let c = within(reader, &coefficients, c, "numbers", list.hint, |_| true);
        let (Some(i), Some(j), Some(c)) = (i, j, c) else { return terms };
        let (i, j) = (i as usize, j as usize);
        if i + j > MAX_DEGREE {
            let message = format!("{path} must have i + j at most {MAX_DEGREE}, found {i} + {j}");
            reader.complain(entry.at, message, list.hint);
        }
        if terms.iter().any(|term| (term.i, term.j) == (i, j)) {
            let message = format!("{path} must give each term once, found [{i}, {j}] again");
            reader.complain(entry.at, message, "add the two coefficients up");
        }
        terms.push(Monomial { i, j, c });
    }
    terms
}

fn grid(reader: &mut ProfileReader, section: &Section) -> ShapeEntry {
    let must = "the name of a file";
    let hint = "a table of heights beside the profile, as in file = \"sag.csv\"";
    let value = reader.value(section, "file", Required, must, hint);
    let mut shape = None;
    if let Some(value) = value {
        match value.get_ref() {
            DeValue::String(file) if !file.trim().is_empty() => {
                shape = Some(ShapeSpec::Grid { file: file.to_string() });
            }
            _ => {
                let path = section.path_of("file");
                let message = format!("{path} must be {must}, found {}", reader.quote_type(value));
                reader.complain(value.span().start, message, hint);
            }
        }
    }
    ShapeEntry { path: section.path.clone(), is_given: true, conic: None, shape }
}
