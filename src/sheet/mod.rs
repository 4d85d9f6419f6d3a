//! A sheet of paper to print and sign: lines, circles and text, in millimetres from its lower left corner, as PDF with vector
//! text in a font that the file holds.

mod font;
mod pdf;

use font::text_width_mm;

/// Width and height of A4 upright, mm.
pub const A4_MM: [f64; 2] = [210.0, 297.0];

/// A colour that prints dark enough.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SheetColour {
    /// Black.
    Black,
    /// Grey: for what stands behind.
    Grey,
    /// Red.
    Red,
    /// Blue.
    Blue,
}

/// Where text stands from its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TextAlign {
    /// To the right of it.
    Left,
    /// To the left of it.
    Right,
}

/// Something on a sheet.
#[derive(Debug, Clone, PartialEq)]
enum SheetMark {
    /// Straight strokes from place to place.
    Strokes { places: Vec<[f64; 2]>, width_mm: f64, colour: SheetColour },
    /// A circle, as a line or filled.
    Circle { centre: [f64; 2], radius_mm: f64, is_filled: bool, colour: SheetColour },
    /// A line of text, whose letters stand on `at`.
    Text { at: [f64; 2], size_mm: f64, text: String, colour: SheetColour },
}

/// A sheet with what is on it.
#[derive(Debug, Clone, PartialEq)]
pub struct Sheet {
    size_mm: [f64; 2],
    marks: Vec<SheetMark>,
}

/// Distance from line to line of text, in its size.
const LEADING: f64 = 1.35;

impl Sheet {
    /// An empty sheet.
    #[must_use]
    pub fn new(size_mm: [f64; 2]) -> Self {
        Self { size_mm, marks: Vec::new() }
    }

    /// Draws straight strokes through these places.
    pub fn strokes(&mut self, places: Vec<[f64; 2]>, width_mm: f64, colour: SheetColour) {
        self.marks.push(SheetMark::Strokes { places, width_mm, colour });
    }

    /// Draws a level line.
    pub fn rule(&mut self, y: f64, [from, to]: [f64; 2], width_mm: f64) {
        self.strokes(vec![[from, y], [to, y]], width_mm, SheetColour::Black);
    }

    /// Draws a circle.
    pub fn circle(
        &mut self,
        centre: [f64; 2],
        radius_mm: f64,
        is_filled: bool,
        colour: SheetColour,
    ) {
        self.marks.push(SheetMark::Circle { centre, radius_mm, is_filled, colour });
    }

    /// Writes a line of text with letters of this size.
    pub fn text(&mut self, [x, y]: [f64; 2], size_mm: f64, text: &str, align: TextAlign) {
        let width = text_width_mm(text, size_mm);
        let left = match align {
            TextAlign::Left => x,
            TextAlign::Right => x - width,
        };
        let (text, colour) = (text.to_owned(), SheetColour::Black);
        self.marks.push(SheetMark::Text { at: [left, y], size_mm, text, colour });
    }

    /// Writes text in lines no longer than `width_mm`, broken between words; the height of the line below.
    pub fn paragraph(&mut self, [x, y]: [f64; 2], width_mm: f64, size_mm: f64, text: &str) -> f64 {
        let mut y = y;
        for line in broken(text, width_mm, size_mm) {
            self.text([x, y], size_mm, &line, TextAlign::Left);
            y -= LEADING * size_mm;
        }
        y
    }

    /// The sheet as PDF, with a title; the same bytes for the same sheet, whenever it is made.
    #[must_use]
    pub fn pdf(&self, title: &str) -> Vec<u8> {
        pdf::written(self, title)
    }
}

/// Text in lines no longer than a width, broken between words; a longer word stands alone.
fn broken(text: &str, width_mm: f64, size_mm: f64) -> Vec<String> {
    let mut lines = Vec::new();
    let mut line = String::new();
    for word in text.split_whitespace() {
        let longer = if line.is_empty() { word.to_owned() } else { format!("{line} {word}") };
        if line.is_empty() || text_width_mm(&longer, size_mm) <= width_mm {
            line = longer;
        } else {
            lines.push(std::mem::replace(&mut line, word.to_owned()));
        }
    }
    lines.push(line);
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_broken_between_words_and_none_is_wider() {
        let text = "the mirror lies within 0.020 mm of the design, half of it to either side";
        let lines = broken(text, 40.0, 3.0);
        assert_eq!(lines.join(" "), text);
        assert!(lines.len() > 2 && lines.iter().all(|line| text_width_mm(line, 3.0) <= 40.0));
        assert_eq!(broken("legendre_20_um", 1.0, 3.0), ["legendre_20_um"]);
    }

    #[test]
    fn a_sheet_is_the_same_bytes_again_and_holds_its_font() {
        let sheet = || {
            let mut sheet = Sheet::new(A4_MM);
            sheet.text([20.0, 250.0], 4.0, "0.010 mm", TextAlign::Left);
            sheet.circle([50.0, 50.0], 10.0, false, SheetColour::Blue);
            sheet.rule(30.0, [20.0, 190.0], 0.3);
            sheet.pdf("A sheet")
        };
        let bytes = sheet();
        assert_eq!(bytes, sheet());
        assert!(bytes.starts_with(b"%PDF-1.7\n") && bytes.ends_with(b"%%EOF"), "{}", bytes.len());
        let holds = |word: &[u8]| bytes.windows(word.len()).any(|found| found == word);
        assert!(holds(b"(0.010 mm)") && holds(b"/FontFile2") && holds(b"/MediaBox [0 0 595"));
    }
}
