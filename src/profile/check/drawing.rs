//! What a drawing of the part says beside its figures.

use super::super::drawing::{DrawingSpec, PaperSize, TitleBlock, ViewArrangement};
use super::super::reader::Need::Optional;
use super::super::reader::{ProfileReader, Section};
use super::super::values::word;
use crate::sheet::is_printable;
use toml::de::DeValue;

/// `[drawing]`; the defaults where there is none.
pub(super) fn read(reader: &mut ProfileReader, root: &Section) -> DrawingSpec {
    let Some(section) = reader.section(root, "drawing", Optional) else {
        return DrawingSpec::default();
    };
    let papers = [("A3", PaperSize::A3), ("A4", PaperSize::A4)];
    let hint = "A3 lies, A4 stands";
    let paper = word(reader, &section, "paper", &papers, hint).unwrap_or_default();
    let arrangements = [
        ("first-angle", ViewArrangement::FirstAngle),
        ("third-angle", ViewArrangement::ThirdAngle),
    ];
    let hint = "first-angle is usual in Europe, third-angle in the USA";
    let arrangement = word(reader, &section, "projection", &arrangements, hint).unwrap_or_default();
    let mut said = |key, hint| text(reader, &section, key, hint).unwrap_or_default();
    let title = TitleBlock {
        owner: said("owner", "who owns the drawing, in quotes"),
        number: said("number", "the drawing's number, as in number = \"4711-02\""),
        revision: said("revision", "the state of the drawing, as in revision = \"B\""),
        title: said("title", "what the part is called, in quotes"),
        creator: said("creator", "who made the drawing, in quotes"),
        approver: said("approver", "who approved it, in quotes"),
        date: String::new(),
    };
    let material = said("material", "as in material = \"EN AW-6061 T6\"");
    let coating = said("coating", "as in coating = \"protected aluminium, R > 88 %\"");
    let imperfections =
        said("imperfections", "what follows 5/ on the drawing, as in imperfections = \"3x0.25\"");
    let texture = said("texture", "as in texture = \"Rq 5 nm\"");
    let general_tolerance = said("general_tolerance", "as in general_tolerance = \"ISO 2768-m\"");
    let title = TitleBlock { date: date(reader, &section).unwrap_or_default(), ..title };
    DrawingSpec {
        paper,
        arrangement,
        title,
        material,
        coating,
        imperfections,
        texture,
        general_tolerance,
    }
}

/// A text that the drawing's font has letters for.
fn text(reader: &mut ProfileReader, section: &Section, key: &str, hint: &str) -> Option<String> {
    let most = DrawingSpec::MOST_CHARACTERS;
    let must = format!("text of at most {most} characters in Latin letters");
    let value = reader.value(section, key, Optional, &must, hint)?;
    let found = match value.get_ref() {
        DeValue::String(text) if text.chars().count() > most => {
            format!("{} characters", text.chars().count())
        }
        DeValue::String(text) => match text.chars().find(|c| !is_printable(&c.to_string())) {
            None => return Some(text.trim().to_owned()),
            Some(c) => format!("{c:?}, which the drawing's font has not"),
        },
        _ => reader.quote_type(value),
    };
    let path = section.path_of(key);
    reader.complain(value.span().start, format!("{path} must be {must}, found {found}"), hint);
    None
}

/// A date, in quotes or as TOML has it.
fn date(reader: &mut ProfileReader, section: &Section) -> Option<String> {
    let must = "a date as year-month-day";
    let hint = "as in date = 2026-11-27";
    let value = reader.value(section, "date", Optional, must, hint)?;
    let found = match value.get_ref() {
        DeValue::String(text) => text.parse().ok(),
        DeValue::Datetime(date) => Some(*date),
        _ => None,
    };
    let only_a_date = |date: &toml::value::Datetime| date.date.is_some() && date.time.is_none();
    if let Some(date) = found.filter(only_a_date) {
        return Some(date.to_string());
    }
    let (path, found) = (section.path_of("date"), reader.quote_type(value));
    reader.complain(value.span().start, format!("{path} must be {must}, found {found}"), hint);
    None
}
