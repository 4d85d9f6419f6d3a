//! Tables and notes of a drawing.

use super::dimension::{NARROW, SMALL, mm};
use super::paper::Area;
use crate::profile::DrawingSpec;
use crate::results::{DrawingFacts, DrawnFeature};
use crate::sheet::{Sheet, TextAlign};

/// Height of a row, and room beside a cell's text, mm.
const ROW: f64 = 4.2;
const BESIDE: f64 = 1.1;

/// A table from its upper left corner, its first row a head, in small letters or, where it would be wider than `room`, in smaller
/// ones; where it ends to the right and below.
fn table(sheet: &mut Sheet, [left, top]: [f64; 2], rows: &[Vec<String>], room: f64) -> [f64; 2] {
    let widths = widths(rows);
    let shrunk = (room / widths.iter().sum::<f64>()).min(1.0);
    let mut edges = vec![left];
    widths.iter().for_each(|width| edges.push(edges[edges.len() - 1] + shrunk * width));
    let end = [edges[widths.len()], top - ROW * rows.len() as f64];
    for (k, row) in rows.iter().enumerate() {
        let base = top - ROW * (k as f64 + 1.0) + 0.5 * (ROW - 0.73 * SMALL);
        for (cell, edge) in row.iter().zip(&edges[1..]) {
            sheet.text([edge - shrunk * BESIDE, base], shrunk * SMALL, cell, TextAlign::Right);
        }
        if k > 0 {
            let y = top - ROW * k as f64;
            sheet.strokes(vec![[left, y], [end[0], y]], NARROW);
        }
    }
    for edge in &edges {
        sheet.strokes(vec![[*edge, top], [*edge, end[1]]], NARROW);
    }
    sheet.frame([left, end[1]], [end[0], top], NARROW.width_mm);
    end
}

/// A table's title; the height below it.
fn title(sheet: &mut Sheet, [left, top]: [f64; 2], text: &str) -> f64 {
    sheet.text([left, top - SMALL], SMALL, text, TextAlign::Left);
    top - SMALL - 1.6
}

/// The sag table's excerpt: heights of the mirror over a grid; where it ends below.
fn sag(sheet: &mut Sheet, facts: &DrawingFacts, at: [f64; 2], room: f64) -> f64 {
    let top = title(sheet, at, "Sag table (excerpt): Z of the mirror over X and Y, mm");
    let axis = |k: usize| {
        let mut all: Vec<f64> = facts.sag_mm.iter().map(|place| place[k]).collect();
        all.sort_by(f64::total_cmp);
        all.dedup();
        all
    };
    let (xs, ys) = (axis(0), axis(1));
    let head = std::iter::once("Y \\ X".to_owned()).chain(xs.iter().map(|x| mm(*x))).collect();
    let mut rows: Vec<Vec<String>> = vec![head];
    for y in ys.iter().rev() {
        let cell = |x: &f64| {
            let found = facts.sag_mm.iter().find(|place| place[0] == *x && place[1] == *y);
            found.map_or("-".to_owned(), |place| format!("{:.4}", place[2]))
        };
        rows.push(std::iter::once(mm(*y)).chain(xs.iter().map(cell)).collect());
    }
    table(sheet, [at[0], top], &rows, room)[1]
}

/// Tables of the mirror's heights and of the part's holes and marks.
pub(super) fn draw_tables(sheet: &mut Sheet, facts: &DrawingFacts, area: &Area) {
    let below = sag(sheet, facts, [area.left, area.high], area.width()) - 3.0;
    if facts.features.is_empty() {
        return;
    }
    let words = match facts.shell_mm {
        Some(_) => "Holes (H), marks (M) and drains (D), mm",
        None => "Holes (H) and marks (M), mm",
    };
    let top = title(sheet, [area.left, below], words);
    let fitting = (((top - area.low) / ROW).floor() as usize).saturating_sub(1).max(1);
    let row = |feature: &DrawnFeature| {
        let [x, y] = feature.at_mm.map(mm);
        let DrawnFeature { name, diameter_mm, what, .. } = feature;
        vec![name.clone(), x, y, format!("\u{d8}{}", mm(*diameter_mm)), what.clone()]
    };
    let (mut left, mut told) = (area.left, 0);
    for some in facts.features.chunks(fitting) {
        let head = ["No.", "X", "Y", "\u{d8}", ""].map(str::to_owned).to_vec();
        let rows: Vec<Vec<String>> = std::iter::once(head).chain(some.iter().map(row)).collect();
        if told > 0 && left + widths(&rows).iter().sum::<f64>() > area.right {
            break;
        }
        left = table(sheet, [left, top], &rows, area.right - left)[0] + 3.0;
        told += some.len();
    }
    if told < facts.features.len() {
        let rest = format!("and {} more: drawing.json", facts.features.len() - told);
        sheet.text([area.left + 50.0, top + 1.6], SMALL, &rest, TextAlign::Left);
    }
}

/// Widths of the columns of a table in small letters, mm.
fn widths(rows: &[Vec<String>]) -> Vec<f64> {
    let column = |k: usize| {
        let cells = rows.iter().filter_map(|row| row.get(k));
        cells.map(|cell| Sheet::width_of(cell, SMALL)).fold(0.0, f64::max) + 2.0 * BESIDE
    };
    (0..rows.first().map_or(0, Vec::len)).map(column).collect()
}

/// What is asked of the mirror's surface, by the numbers of ISO 10110.
pub(super) fn draw_surface(
    sheet: &mut Sheet,
    facts: &DrawingFacts,
    (spec, letters): (&DrawingSpec, &[char]),
    area: &Area,
) {
    let dash = |text: &str| if text.is_empty() { "-".to_owned() } else { text.to_owned() };
    let letters = letters.iter().map(char::to_string).collect::<Vec<_>>().join(", ");
    let form = facts.pmi.surface_profile_mm.map_or("-".to_owned(), |zone| {
        format!("-({}) mm: profile within {} mm to {letters}", mm(zone), mm(zone))
    });
    let slope = facts.slope_error_mrad.map_or("-".to_owned(), |mrad| {
        format!("{} mrad RMS, angle of the normals, form included", mm(mrad))
    });
    let sphere = match facts.sphere_radius_mm {
        Some(radius) => {
            let side = if radius < 0.0 { "CX" } else { "CC" };
            format!("R {} {side}, ", mm(radius.abs()))
        }
        None => "plane, ".to_owned(),
    };
    let departs = format!("{sphere}departure {} mm", mm(facts.sphere_departure_mm));
    let rows = [
        (
            "GS",
            "general surface (ISO 10110-19): STEP model and sag table of the profile".to_owned(),
        ),
        ("sphere", format!("best fit {departs}")),
        ("3/", form),
        ("slope", slope),
        ("4/", format!("centred by datum features {letters}")),
        ("5/", dash(&spec.imperfections)),
        ("texture", dash(&spec.texture)),
        ("coating", dash(&spec.coating)),
    ];
    let mut y = title(sheet, [area.left, area.high], "Mirror, ISO 10110") - SMALL;
    for (name, text) in rows {
        sheet.text([area.left, y], SMALL, name, TextAlign::Left);
        let left = area.left + 14.0;
        y = sheet.paragraph([left, y], area.right - left, SMALL, &text) - 0.7;
    }
}

/// What a reader has to know beside the views.
pub(super) fn draw_notes(sheet: &mut Sheet, facts: &DrawingFacts, spec: &DrawingSpec, area: &Area) {
    let mut notes = vec![
        "Dimensions in mm. X right in the picture, Y up in it, Z towards the camera's side; origin on the base."
            .to_owned(),
        format!("Camera: {}.", facts.camera),
        format!("Datum features: {}.", facts.pmi.datums.join(", ")),
        "Mirror: do not round or break its edges.".to_owned(),
        format!(
            "Crosses in the plan: {} places to measure, as of the inspection's plan.",
            facts.inspection_points
        ),
    ];
    if let Some(shell_mm) = facts.shell_mm {
        notes.push(format!(
            "Hollow: base, walls and mirror {} mm or more around the cavity.",
            mm(shell_mm)
        ));
    }
    if !spec.general_tolerance.is_empty() {
        notes.push(format!("Sizes without a tolerance: {}.", spec.general_tolerance));
    }
    let mut y = area.high - SMALL;
    for note in notes {
        y = sheet.paragraph([area.left, y], area.width(), SMALL, &note) - 0.2;
    }
}
