//! The font of sheets: DejaVu Sans, cut down to Latin 1.

use std::sync::LazyLock;
use ttf_parser::Face;

/// Letters of Latin 1 as TrueType, made of DejaVu Sans by fontTools' `pyftsubset`: licence beside it.
pub(super) const FILE: &[u8] = include_bytes!("font/DejaVuSans-latin1.ttf");
/// First and last character that the font is asked for.
pub(super) const FIRST: u8 = 32;
pub(super) const LAST: u8 = 255;

/// Figures of the font, in thousandths of the size of its letters.
pub(super) struct FontFigures {
    /// Widths of the characters from the first to the last; 0 of those that there are not.
    pub widths: Vec<f32>,
    pub ascent: f32,
    pub descent: f32,
    pub cap_height: f32,
    pub bounds: [f32; 4],
}

pub(super) static FIGURES: LazyLock<FontFigures> = LazyLock::new(|| {
    // (The file is a part of this program.)
    let face = Face::parse(FILE, 0).expect("the font that is built in");
    let scale = 1000.0 / f32::from(face.units_per_em());
    let width = |character: u8| {
        let glyph = face.glyph_index(char::from(character));
        let advance = glyph.and_then(|glyph| face.glyph_hor_advance(glyph));
        advance.map_or(0.0, |advance| f32::from(advance) * scale)
    };
    // (This font does not tell how high its capital letters are.)
    let capital = face.glyph_index('H').and_then(|glyph| face.glyph_bounding_box(glyph));
    let bounds = face.global_bounding_box();
    let ends = [bounds.x_min, bounds.y_min, bounds.x_max, bounds.y_max];
    FontFigures {
        widths: (FIRST..=LAST).map(width).collect(),
        ascent: f32::from(face.ascender()) * scale,
        descent: f32::from(face.descender()) * scale,
        cap_height: capital.map_or(0.0, |bounds| f32::from(bounds.y_max)) * scale,
        bounds: ends.map(|end| f32::from(end) * scale),
    }
});

/// Whether sheets have a letter for every character of `text`: those of Latin 1.
#[must_use]
pub fn is_printable(text: &str) -> bool {
    text.chars().all(|c| u8::try_from(u32::from(c)).is_ok_and(is_letter))
}

fn is_letter(byte: u8) -> bool {
    matches!(byte, 32..=126 | 160..=255)
}

/// Text in the font's encoding, Latin 1 in which 0x80 to 0x9f are nothing; what it has not is a question mark.
pub(super) fn encoded(text: &str) -> Vec<u8> {
    let byte = |c: char| u8::try_from(u32::from(c)).ok().filter(|b| is_letter(*b)).unwrap_or(b'?');
    text.chars().map(byte).collect()
}

/// Height of capital letters, in the size of letters.
pub(super) fn capital_height() -> f64 {
    f64::from(FIGURES.cap_height) / 1000.0
}

/// Width, mm, of a line of text with letters of this size.
pub(super) fn text_width_mm(text: &str, size_mm: f64) -> f64 {
    let width = |byte: u8| f64::from(FIGURES.widths[usize::from(byte - FIRST)]);
    encoded(text).into_iter().map(width).sum::<f64>() * size_mm / 1000.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_letter_of_latin_1_has_a_width_and_others_are_question_marks() {
        assert_eq!(encoded("\u{b1}0.5 \u{b5}m\u{2300}\n"), b"\xb10.5 \xb5m??");
        for byte in (32..=126).chain(160..=255) {
            assert!(FIGURES.widths[usize::from(byte - FIRST)] > 0.0, "{byte}");
        }
        // DejaVu's digits are 1303 of 2048 wide.
        let wide = text_width_mm("0123456789", 3.0);
        assert!((wide - 30.0 * 1303.0 / 2048.0).abs() < 1e-4, "{wide}");
    }
}
