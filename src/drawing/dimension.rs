//! Dimensions, leaders, datum features and tolerance frames (ISO 129-1, ISO 1101, ISO 5459).

use crate::sheet::{Dashes, Pen, Sheet, SheetColour, TextAlign, TextWay};

/// Lines of the part, and all others (ISO 128-2: twice as wide).
pub(super) const WIDE: Pen = Pen::black(0.5);
pub(super) const NARROW: Pen = Pen::black(0.2);
/// An axis, what is hidden, and what stands behind.
pub(super) const AXIS: Pen = Pen::broken(0.2, Dashes::Chain);
pub(super) const HIDDEN: Pen = Pen::broken(0.2, Dashes::Dashed);
pub(super) const FAINT: Pen = Pen::black(0.13).coloured(SheetColour::Grey);
/// Height of a drawing's letters, and of small ones, mm (ISO 3098).
pub(super) const TEXT: f64 = 3.0;
pub(super) const SMALL: f64 = 2.5;

/// Length and half the width of an arrow's head, mm.
const ARROW: [f64; 2] = [2.8, 0.45];
/// Gap between a line and its extension, and how far that goes past the dimension, mm.
const GAP: f64 = 0.8;
const PAST: f64 = 1.2;
/// Distance of a figure from its line, mm.
const OVER: f64 = 0.8;
/// Length of an outer arrow's line, mm.
const OUTSIDE: f64 = 6.0;
/// Side of a frame's cell, mm.
pub(super) const CELL: f64 = 6.0;

/// Millimetres to a thousandth, without zeros that say nothing.
pub(super) fn mm(value: f64) -> String {
    let text = format!("{:.3}", (value * 1e3).round() / 1e3 + 0.0);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// An arrow's head that points in a direction.
pub(super) fn arrow(sheet: &mut Sheet, tip: [f64; 2], [u, v]: [f64; 2]) {
    let [length, half] = ARROW;
    let back = [tip[0] - length * u, tip[1] - length * v];
    let side = |s: f64| [back[0] - s * half * v, back[1] + s * half * u];
    sheet.triangle([tip, side(1.0), side(-1.0)], SheetColour::Black);
}

/// A dimension between two X on the line at height `at`, of edges that end at height `from`.
pub(super) fn level(sheet: &mut Sheet, ends: [f64; 2], lines: [f64; 2], text: &str) {
    dimension(sheet, TextWay::Across, ends, lines, text);
}

/// A dimension between two Y on the line at `at`, of edges that end at `from`.
pub(super) fn upright(sheet: &mut Sheet, ends: [f64; 2], lines: [f64; 2], text: &str) {
    dimension(sheet, TextWay::Up, ends, lines, text);
}

/// A dimension in one way, whose figure is over its line, or beyond it where there is no room between its arrows.
fn dimension(
    sheet: &mut Sheet,
    way: TextWay,
    [low, high]: [f64; 2],
    [from, at]: [f64; 2],
    text: &str,
) {
    let place = |along: f64, across: f64| match way {
        TextWay::Across => [along, across],
        TextWay::Up => [across, along],
    };
    let away = (at - from).signum();
    for end in [low, high] {
        let line = [place(end, from + away * GAP), place(end, at + away * PAST)];
        sheet.strokes(line.to_vec(), NARROW);
    }
    let wide = Sheet::width_of(text, TEXT);
    let is_inside = high - low >= wide + 2.0 * ARROW[0] + 1.0;
    let (ends, middle) = if is_inside {
        ([low, high], 0.5 * (low + high))
    } else {
        ([low - OUTSIDE, high + OUTSIDE + wide], high + OUTSIDE + 0.5 * wide)
    };
    sheet.strokes(ends.map(|end| place(end, at)).to_vec(), NARROW);
    let outwards = if is_inside { 1.0 } else { -1.0 };
    arrow(sheet, place(low, at), place(-outwards, 0.0));
    arrow(sheet, place(high, at), place(outwards, 0.0));
    // Letters that run upwards stand to the left of their line.
    let over = match way {
        TextWay::Across => at + OVER,
        TextWay::Up => at - OVER,
    };
    sheet.text_along(way, place(middle, over), TEXT, text, TextAlign::Centre);
}

/// A leader from a place of the part to a text on a shelf that goes to the right.
pub(super) fn leader(sheet: &mut Sheet, tip: [f64; 2], knee: [f64; 2], text: &str) {
    let way = [tip[0] - knee[0], tip[1] - knee[1]];
    let length = (way[0] * way[0] + way[1] * way[1]).sqrt();
    let end = knee[0] + Sheet::width_of(text, TEXT) + 1.0;
    sheet.strokes(vec![tip, knee, [end, knee[1]]], NARROW);
    arrow(sheet, tip, way.map(|w| w / length));
    sheet.text([knee[0] + 0.5, knee[1] + OVER], TEXT, text, TextAlign::Left);
}

/// The symbol of a datum feature, whose triangle stands on a place; the letter is in the direction `away` of it.
pub(super) fn datum(sheet: &mut Sheet, at: [f64; 2], away: [f64; 2], letter: char) {
    let along = |d: f64| [at[0] + d * away[0], at[1] + d * away[1]];
    let base = [[-1.5, 0.0], [1.5, 0.0]].map(|[s, _]| [at[0] - s * away[1], at[1] + s * away[0]]);
    sheet.triangle([base[0], base[1], along(2.6)], SheetColour::Black);
    let (stem, half) = (along(5.0), 0.5 * CELL);
    sheet.strokes(vec![along(2.6), stem], NARROW);
    let middle = [stem[0] + half * away[0], stem[1] + half * away[1]];
    boxed(sheet, [middle[0] - half, middle[1] - half], &letter.to_string(), CELL);
}

/// A cell with text in its middle.
fn boxed(sheet: &mut Sheet, [left, low]: [f64; 2], text: &str, width: f64) {
    sheet.frame([left, low], [left + width, low + CELL], NARROW.width_mm);
    let base = low + 0.5 * (CELL - 0.73 * TEXT);
    sheet.text([left + 0.5 * width, base], TEXT, text, TextAlign::Centre);
}

/// A profile tolerance of a surface, mm, with respect to datums, from its lower left corner; where it ends.
pub(super) fn profile_tolerance(
    sheet: &mut Sheet,
    [left, low]: [f64; 2],
    value: &str,
    letters: &[char],
) -> f64 {
    sheet.frame([left, low], [left + CELL, low + CELL], NARROW.width_mm);
    // The symbol: half a circle, closed.
    let (middle, foot, radius) = (left + 0.5 * CELL, low + 0.33 * CELL, 0.33 * CELL);
    let on = |k: u32| {
        let angle = std::f64::consts::PI * f64::from(k) / 16.0;
        [middle + radius * crate::num::cos(angle), foot + radius * crate::num::sin(angle)]
    };
    let mut symbol: Vec<[f64; 2]> = (0..=16).map(on).collect();
    symbol.push(on(0));
    sheet.strokes(symbol, Pen::black(0.3));
    let wide = Sheet::width_of(value, TEXT) + 3.0;
    boxed(sheet, [left + CELL, low], value, wide);
    let mut end = left + CELL + wide;
    for letter in letters {
        boxed(sheet, [end, low], &letter.to_string(), CELL);
        end += CELL;
    }
    end
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_have_no_zeros_that_say_nothing() {
        let cases =
            [(60.0, "60"), (45.1234, "45.123"), (0.02, "0.02"), (-0.0001, "0"), (9.99995, "10")];
        for (value, text) in cases {
            assert_eq!(mm(value), text);
        }
    }
}
