//! The inspection's sheet: a page to print and sign, on which every figure is one of `report.json`.

use crate::geom::DVec2;
use crate::results::{FileFacts, MeasuredForm, VerifyReport, coordinate, digits, error_px};
use crate::sheet::{A4_MM, Pen, Sheet, SheetColour, TextAlign};
use crate::tolerance_terms::ErrorSourceRow;

/// What the sheet's map shows: places in the plan, mm.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct InspectionMap {
    /// Rims of the mirror's panels.
    pub rims: Vec<Vec<DVec2>>,
    /// Points on the mirror that are no outliers, and how far the made surface is off there, um.
    pub points: Vec<(DVec2, f64)>,
}

/// Margins to the left and right, and where the text begins, mm.
const LEFT: f64 = 20.0;
const RIGHT: f64 = A4_MM[0] - 15.0;
const TOP: f64 = A4_MM[1] - 18.0;
/// Sizes of letters, mm.
const TITLE: f64 = 5.5;
const TEXT: f64 = 3.0;
const SMALL: f64 = 2.5;
/// Height of a line of the table, mm.
const ROW: f64 = 4.6;
/// Where columns of the table end, mm.
const COLUMNS: [f64; 3] = [LEFT + 70.0, LEFT + 105.0, LEFT + 140.0];
/// Place of the map, and of the lines to sign on, mm.
const MAP_HEIGHT: f64 = 92.0;
const FOOT: f64 = 24.0;
/// Pens of the mirror's rims, and of points where there is too little material.
const RIM: Pen = Pen::black(0.25).coloured(SheetColour::Grey);
const HOLLOW: Pen = Pen::black(0.2).coloured(SheetColour::Blue);
/// Largest and least radius of a point of the map, mm.
const DOTS: [f64; 2] = [2.6, 0.25];

/// The sheet of a measured part as PDF; none of a file whose form is not known.
#[must_use]
pub fn inspection_sheet(report: &VerifyReport, map: &InspectionMap) -> Option<Vec<u8>> {
    let form = report.measured_form.as_ref()?;
    let mut sheet = Sheet::new(A4_MM);
    let y = head(&mut sheet, report);
    let y = figures(&mut sheet, report, form, y);
    let y = terms(&mut sheet, form, y);
    draw_map(&mut sheet, map, y - 4.0);
    foot(&mut sheet);
    Some(sheet.pdf(&format!("Inspection of {}", report.profile.name)))
}

/// What was measured, and what it comes to.
fn head(sheet: &mut Sheet, report: &VerifyReport) -> f64 {
    sheet.text([LEFT, TOP], TITLE, "Inspection of a mirror", TextAlign::Left);
    let word = report.verdict.word().to_uppercase();
    sheet.text([RIGHT, TOP], TITLE, &word, TextAlign::Right);
    sheet.rule(TOP - 3.0, [LEFT, RIGHT], 0.5);
    let mut y = TOP - 9.0;
    let profile = &report.profile;
    let mut lines = vec![format!("profile {}, SHA-256 {}", profile.name, profile.sha256)];
    let file = |file: &FileFacts| format!("points {}, SHA-256 {}", file.name, file.sha256);
    lines.extend(report.files.iter().map(file));
    lines.push(format!("part {}", report.layout.size()));
    lines.extend(report.reasons.iter().map(|reason| format!("fails: {reason}")));
    for line in lines {
        y = sheet.paragraph([LEFT, y], RIGHT - LEFT, SMALL, &line);
    }
    y - 2.0
}

/// The figures that are judged.
fn figures(sheet: &mut Sheet, report: &VerifyReport, form: &MeasuredForm, y: f64) -> f64 {
    let mut lines = Vec::new();
    let probe = form
        .probe_mm
        .map_or(String::new(), |mm| format!(", centres of a ball of {} mm radius", digits(mm)));
    lines.push(format!("{} of {} points on the mirror{probe}", form.used, form.points));
    if let Some(pose) = &report.alignment {
        let place = |v: [f64; 3]| v.map(|x| coordinate(x, 4)).join(", ");
        lines.push(format!(
            "best pose: turned by ({}) deg, then shifted by ({}) mm",
            place(pose.turn_deg),
            place(pose.shift_mm)
        ));
    }
    if let Some(errors) = form.pixel_error_px {
        let allowed = report.accepted.map_or(String::new(), |limits| {
            let [rms, max] = [limits.pixel_error_rms_px, limits.pixel_error_max_px];
            format!("; allowed {} and {}", rms.value, max.value)
        });
        let [rms, max] = [errors.rms, errors.max].map(error_px);
        lines.push(format!("picture with this form off by {rms} px RMS, {max} at most{allowed}"));
    }
    if let Some(error) = &report.form_error_um {
        let inner = &error.without_outliers;
        let [pv, rms] = [inner.pv, inner.rms].map(digits);
        lines.push(format!(
            "departure from the design {pv} um from peak to valley, {rms} um RMS without outliers"
        ));
    }
    if let (Some(mm), Some(outside)) = (form.surface_profile_mm, form.outside) {
        lines.push(format!("profile tolerance {} mm: {outside} points outside", digits(mm)));
    }
    let mut y = y;
    for line in lines {
        y = sheet.paragraph([LEFT, y], RIGHT - LEFT, TEXT, &line);
    }
    y - 2.0
}

/// The table of the form's terms.
fn terms(sheet: &mut Sheet, form: &MeasuredForm, y: f64) -> f64 {
    let row = |sheet: &mut Sheet, y: f64, cells: [&str; 3]| {
        sheet.text([LEFT, y], TEXT, cells[0], TextAlign::Left);
        for (cell, end) in cells[1..].iter().zip(&COLUMNS[1..]) {
            sheet.text([*end, y], TEXT, cell, TextAlign::Right);
        }
    };
    row(sheet, y, ["form error beyond the best pose", "PV, um", "standard uncertainty"]);
    sheet.rule(y - 1.4, [LEFT, COLUMNS[2]], 0.25);
    let mut y = y - ROW - 0.6;
    for term in &form.terms {
        let [um, uncertainty] = [term.pv_um, term.uncertainty_um].map(|um| coordinate(um, 3));
        row(sheet, y, [&described(&term.term), &um, &uncertainty]);
        y -= ROW;
    }
    let rest = form.rest_um.map_or("too few points".to_owned(), |um| format!("{um:.3}"));
    row(sheet, y, ["the rest: finer form, texture, noise (RMS)", &rest, ""]);
    y - ROW
}

/// A term in words, by the key of its error source.
fn described(key: &str) -> String {
    let source = ErrorSourceRow::TABLE.iter().find(|row| row.perturbation.key() == key);
    let what = source.map_or_else(|| key.to_owned(), |row| row.what.concat());
    let what = what.trim().trim_start_matches("Form error: ").trim_end_matches('.');
    let what = what.trim_start_matches("the ");
    what.split_at_checked(1).map_or_else(String::new, |(first, rest)| first.to_uppercase() + rest)
}

/// The points in the plan: the larger, the further off; filled where there is too much material.
fn draw_map(sheet: &mut Sheet, map: &InspectionMap, top: f64) {
    let places = || map.rims.iter().flatten().copied().chain(map.points.iter().map(|p| p.0));
    let low = places().fold(DVec2::INFINITY, DVec2::min);
    let high = places().fold(DVec2::NEG_INFINITY, DVec2::max);
    let size = high - low;
    if !(size.is_finite() && size.min_element() > 0.0) {
        return;
    }
    let height = MAP_HEIGHT.min(top - FOOT - 14.0);
    let scale = ((RIGHT - LEFT) / size.x).min(height / size.y);
    let middle = 0.5 * (low + high);
    let at = |p: DVec2| {
        let q = (p - middle) * scale;
        [0.5 * (LEFT + RIGHT) + q.x, top - 0.5 * height + q.y]
    };
    for rim in &map.rims {
        sheet.strokes(rim.iter().map(|&p| at(p)).collect(), RIM);
    }
    let most = map.points.iter().map(|p| p.1.abs()).fold(0.0, f64::max);
    for &(place, um) in &map.points {
        let share = if most > 0.0 { um.abs() / most } else { 0.0 };
        let radius = DOTS[1] + (DOTS[0] - DOTS[1]) * share;
        if um > 0.0 {
            sheet.disc(at(place), radius, SheetColour::Red);
        } else {
            sheet.circle(at(place), radius, HOLLOW);
        }
    }
    let caption = format!(
        "Plan, Y upwards: filled where there is too much material, hollow where there is too little; the largest {} um.",
        digits(most)
    );
    sheet.text([LEFT, top - height - 5.0], SMALL, &caption, TextAlign::Left);
}

/// Where it is signed.
fn foot(sheet: &mut Sheet) {
    let third = (RIGHT - LEFT) / 3.0;
    for (k, word) in ["machine and temperature", "inspected by", "date"].into_iter().enumerate() {
        let from = LEFT + third * k as f64;
        sheet.rule(FOOT, [from, from + third - 6.0], 0.25);
        sheet.text([from, FOOT - 4.0], SMALL, word, TextAlign::Left);
    }
}
