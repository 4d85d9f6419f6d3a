//! A sheet of paper to print and sign: lines, circles and text, in millimetres from its lower left corner, as PDF with vector
//! text in a font that the file holds, and as DXF.

mod dxf;
mod font;
mod pdf;

pub use font::is_printable;

use font::text_width_mm;

/// Width and height of A4 upright, mm.
pub const A4_MM: [f64; 2] = [210.0, 297.0];
/// Width and height of A3 lying, mm.
pub const A3_MM: [f64; 2] = [420.0, 297.0];

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

/// How a line is broken (ISO 128-2).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dashes {
    /// Not at all.
    Continuous,
    /// Dashes: a hidden edge.
    Dashed,
    /// Long dashes and dots: an axis.
    Chain,
}

/// A pen: what a line looks like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pen {
    /// Width of the line, mm.
    pub width_mm: f64,
    /// Its colour.
    pub colour: SheetColour,
    /// How it is broken.
    pub dashes: Dashes,
}

impl Pen {
    /// A black line.
    #[must_use]
    pub const fn black(width_mm: f64) -> Self {
        Self { width_mm, colour: SheetColour::Black, dashes: Dashes::Continuous }
    }

    /// The same line in another colour.
    #[must_use]
    pub const fn coloured(self, colour: SheetColour) -> Self {
        Self { colour, ..self }
    }

    /// A black line that is broken.
    #[must_use]
    pub const fn broken(width_mm: f64, dashes: Dashes) -> Self {
        Self { dashes, ..Self::black(width_mm) }
    }
}

/// Where text stands from its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TextAlign {
    /// It begins there.
    Left,
    /// Its middle is there.
    Centre,
    /// It ends there.
    Right,
}

/// The way in which a line of text runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TextWay {
    /// To the right.
    Across,
    /// Upwards.
    Up,
}

/// A line of text.
#[derive(Debug, Clone, PartialEq)]
struct TextLine {
    at: [f64; 2],
    size_mm: f64,
    text: String,
    align: TextAlign,
    way: TextWay,
}

impl TextLine {
    /// Where its first letter stands.
    fn start(&self) -> [f64; 2] {
        let share = match self.align {
            TextAlign::Left => 0.0,
            TextAlign::Centre => 0.5,
            TextAlign::Right => 1.0,
        };
        let back = share * text_width_mm(&self.text, self.size_mm);
        let [x, y] = self.at;
        match self.way {
            TextWay::Across => [x - back, y],
            TextWay::Up => [x, y - back],
        }
    }
}

/// Something on a sheet.
#[derive(Debug, Clone, PartialEq)]
enum SheetMark {
    /// Straight strokes from place to place.
    Strokes { places: Vec<[f64; 2]>, pen: Pen },
    /// A filled triangle.
    Triangle { corners: [[f64; 2]; 3], colour: SheetColour },
    /// A circle.
    Circle { centre: [f64; 2], radius_mm: f64, pen: Pen },
    /// A filled circle.
    Disc { centre: [f64; 2], radius_mm: f64, colour: SheetColour },
    /// A line of text, whose letters stand on `at`.
    Text(TextLine),
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

    /// Its width and height, mm.
    #[must_use]
    pub fn size_mm(&self) -> [f64; 2] {
        self.size_mm
    }

    /// Draws straight strokes through these places.
    pub fn strokes(&mut self, places: Vec<[f64; 2]>, pen: Pen) {
        self.marks.push(SheetMark::Strokes { places, pen });
    }

    /// Draws a level line.
    pub fn rule(&mut self, y: f64, [from, to]: [f64; 2], width_mm: f64) {
        self.strokes(vec![[from, y], [to, y]], Pen::black(width_mm));
    }

    /// Draws a rectangle from its lower left to its upper right corner.
    pub fn frame(&mut self, [left, low]: [f64; 2], [right, high]: [f64; 2], width_mm: f64) {
        let places = vec![[left, low], [right, low], [right, high], [left, high], [left, low]];
        self.strokes(places, Pen::black(width_mm));
    }

    /// Fills a triangle.
    pub fn triangle(&mut self, corners: [[f64; 2]; 3], colour: SheetColour) {
        self.marks.push(SheetMark::Triangle { corners, colour });
    }

    /// Draws a circle.
    pub fn circle(&mut self, centre: [f64; 2], radius_mm: f64, pen: Pen) {
        self.marks.push(SheetMark::Circle { centre, radius_mm, pen });
    }

    /// Fills a circle.
    pub fn disc(&mut self, centre: [f64; 2], radius_mm: f64, colour: SheetColour) {
        self.marks.push(SheetMark::Disc { centre, radius_mm, colour });
    }

    /// Writes a line of text with letters of this size.
    pub fn text(&mut self, at: [f64; 2], size_mm: f64, text: &str, align: TextAlign) {
        self.text_along(TextWay::Across, at, size_mm, text, align);
    }

    /// Writes a line of text that runs in this way.
    pub fn text_along(
        &mut self,
        way: TextWay,
        at: [f64; 2],
        size_mm: f64,
        text: &str,
        align: TextAlign,
    ) {
        let text = text.to_owned();
        self.marks.push(SheetMark::Text(TextLine { at, size_mm, text, align, way }));
    }

    /// Width of a line of text, mm.
    #[must_use]
    pub fn width_of(text: &str, size_mm: f64) -> f64 {
        text_width_mm(text, size_mm)
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

    /// The sheet as DXF of release 12, every length times `scale`: of a drawing at 1:2 with a scale of 2 its views have
    /// the part's size. The same bytes for the same sheet.
    #[must_use]
    pub fn dxf(&self, scale: f64) -> Vec<u8> {
        dxf::written(self, scale)
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
            sheet.circle([50.0, 50.0], 10.0, Pen::black(0.2).coloured(SheetColour::Blue));
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
