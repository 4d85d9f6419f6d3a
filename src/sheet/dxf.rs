//! A sheet as DXF of release 12: the oldest that every reader knows. It has no date, no number drawn by chance and no
//! widths of lines: its layers tell what a line is for.

use super::font::{capital_height, encoded};
use super::{Dashes, Pen, Sheet, SheetColour, SheetMark, TextAlign, TextLine, TextWay};
use std::io::Write;

/// Layers with their colours (AutoCAD's index: 7 is black on white) and types of lines.
const LAYERS: [(&str, i32, &str); 7] = [
    ("OUTLINE", 7, "CONTINUOUS"),
    ("THIN", 8, "CONTINUOUS"),
    ("HIDDEN", 3, "HIDDEN"),
    ("AXIS", 5, "CENTER"),
    ("TEXT", 7, "CONTINUOUS"),
    ("FILLED", 7, "CONTINUOUS"),
    ("BEHIND", 9, "CONTINUOUS"),
];
/// Width from which a line is an outline, mm.
const WIDE_MM: f64 = 0.35;
/// Dashes and gaps of a hidden edge and of an axis on the sheet, mm; gaps are negative.
const DASHED_MM: [f64; 2] = [3.0, -1.0];
const CHAIN_MM: [f64; 4] = [6.0, -1.0, 0.5, -1.0];

pub(super) fn written(sheet: &Sheet, scale: f64) -> Vec<u8> {
    let mut out = GroupWriter { bytes: Vec::new(), scale };
    out.header(sheet.size_mm);
    out.tables();
    out.group(0, "SECTION");
    out.group(2, "ENTITIES");
    sheet.marks.iter().for_each(|mark| out.entity(mark));
    out.group(0, "ENDSEC");
    out.group(0, "EOF");
    out.bytes
}

/// Writes pairs of a group's code and its value, each on a line of its own.
struct GroupWriter {
    bytes: Vec<u8>,
    scale: f64,
}

impl GroupWriter {
    fn group(&mut self, code: u16, value: impl std::fmt::Display) {
        // Writing to memory cannot fail.
        let _ = writeln!(self.bytes, "{code:>3}\n{value}");
    }

    /// A length on the sheet, to a millionth of a millimetre.
    fn length(&mut self, code: u16, mm: f64) {
        let value = (mm * self.scale * 1e6).round() / 1e6 + 0.0;
        self.group(code, format_args!("{value:.6}"));
    }

    /// A place by its group's first code.
    fn place(&mut self, code: u16, [x, y]: [f64; 2]) {
        self.length(code, x);
        self.length(code + 10, y);
    }

    fn header(&mut self, size: [f64; 2]) {
        self.group(0, "SECTION");
        self.group(2, "HEADER");
        self.group(9, "$ACADVER");
        self.group(1, "AC1009");
        // The encoding of text: Latin 1 is a part of it.
        self.group(9, "$DWGCODEPAGE");
        self.group(3, "ANSI_1252");
        self.group(9, "$EXTMIN");
        self.place(10, [0.0; 2]);
        self.group(9, "$EXTMAX");
        self.place(10, size);
        self.group(9, "$MEASUREMENT");
        self.group(70, 1);
        self.group(0, "ENDSEC");
    }

    fn tables(&mut self) {
        self.group(0, "SECTION");
        self.group(2, "TABLES");
        self.table("LTYPE", 3);
        self.line_type("CONTINUOUS", "Solid line", &[]);
        self.line_type("HIDDEN", "Hidden __ __ __", &DASHED_MM);
        self.line_type("CENTER", "Axis ____ _ ____ _", &CHAIN_MM);
        self.group(0, "ENDTAB");
        self.table("LAYER", LAYERS.len());
        for (name, colour, line_type) in LAYERS {
            self.group(0, "LAYER");
            self.group(2, name);
            self.group(70, 0);
            self.group(62, colour);
            self.group(6, line_type);
        }
        self.group(0, "ENDTAB");
        self.table("STYLE", 1);
        self.group(0, "STYLE");
        self.group(2, "STANDARD");
        for (code, value) in [(70, "0"), (40, "0.0"), (41, "1.0"), (50, "0.0"), (71, "0")] {
            self.group(code, value);
        }
        self.group(42, "2.5");
        self.group(3, "DejaVuSans.ttf");
        self.group(4, "");
        self.group(0, "ENDTAB");
        self.group(0, "ENDSEC");
    }

    fn table(&mut self, name: &str, entries: usize) {
        self.group(0, "TABLE");
        self.group(2, name);
        self.group(70, entries);
    }

    fn line_type(&mut self, name: &str, words: &str, dashes: &[f64]) {
        self.group(0, "LTYPE");
        self.group(2, name);
        self.group(70, 0);
        self.group(3, words);
        self.group(72, 65);
        self.group(73, dashes.len());
        self.length(40, dashes.iter().map(|mm| mm.abs()).sum());
        dashes.iter().for_each(|mm| self.length(49, *mm));
    }

    fn begin(&mut self, kind: &str, layer: &str) {
        self.group(0, kind);
        self.group(8, layer);
    }

    fn entity(&mut self, mark: &SheetMark) {
        match mark {
            SheetMark::Strokes { places, pen } => match places[..] {
                [from, to] => {
                    self.begin("LINE", layer(pen));
                    self.place(10, from);
                    self.place(11, to);
                }
                _ => self.polyline(places, layer(pen)),
            },
            SheetMark::Triangle { corners: [a, b, c], .. } => {
                self.begin("SOLID", "FILLED");
                // (A triangle's last corner is there twice.)
                for (code, place) in [(10, a), (11, b), (12, c), (13, c)] {
                    self.place(code, *place);
                }
            }
            SheetMark::Circle { centre, radius_mm, pen } => {
                self.begin("CIRCLE", layer(pen));
                self.place(10, *centre);
                self.length(40, *radius_mm);
            }
            SheetMark::Disc { centre, radius_mm, .. } => self.disc(*centre, *radius_mm),
            SheetMark::Text(line) => self.text(line),
        }
    }

    fn polyline(&mut self, places: &[[f64; 2]], layer: &str) {
        let closed = places.len() > 2 && places.first() == places.last();
        let places = if closed { &places[1..] } else { places };
        self.begin("POLYLINE", layer);
        self.group(66, 1);
        self.place(10, [0.0; 2]);
        self.group(70, i32::from(closed));
        for place in places {
            self.begin("VERTEX", layer);
            self.place(10, *place);
        }
        self.begin("SEQEND", layer);
    }

    /// A filled circle: a ring of two half turns around nothing.
    fn disc(&mut self, [x, y]: [f64; 2], radius: f64) {
        self.begin("POLYLINE", "FILLED");
        self.group(66, 1);
        self.place(10, [0.0; 2]);
        self.group(70, 1);
        self.length(40, radius);
        self.length(41, radius);
        for side in [-0.5, 0.5] {
            self.begin("VERTEX", "FILLED");
            self.place(10, [x + side * radius, y]);
            self.group(42, "1.0");
        }
        self.begin("SEQEND", "FILLED");
    }

    fn text(&mut self, line: &TextLine) {
        self.begin("TEXT", "TEXT");
        self.place(10, line.start());
        // (DXF has the height of capital letters.)
        self.length(40, line.size_mm * capital_height());
        self.bytes.extend_from_slice(b"  1\n");
        self.bytes.extend(encoded(&line.text));
        self.bytes.push(b'\n');
        if line.way == TextWay::Up {
            self.group(50, "90.0");
        }
        let justified = match line.align {
            TextAlign::Left => return,
            TextAlign::Centre => 1,
            TextAlign::Right => 2,
        };
        self.group(72, justified);
        self.place(11, line.at);
    }
}

/// The layer of a pen's lines.
fn layer(pen: &Pen) -> &'static str {
    match (pen.dashes, pen.colour) {
        (Dashes::Chain, _) => "AXIS",
        (Dashes::Dashed, _) => "HIDDEN",
        (Dashes::Continuous, SheetColour::Grey) => "BEHIND",
        (Dashes::Continuous, _) if pen.width_mm >= WIDE_MM => "OUTLINE",
        (Dashes::Continuous, _) => "THIN",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// DejaVu's capital letters are 1493 of 2048 high.
    #[test]
    fn letters_are_as_high_as_those_of_the_pdf() {
        let mut sheet = Sheet::new([100.0, 50.0]);
        sheet.text([5.0, 6.0], 2.5, "H", TextAlign::Left);
        let text = String::from_utf8(sheet.dxf(1.0)).unwrap();
        let height: f64 =
            text.split_once("TEXT\n 10\n").unwrap().1.lines().nth(4).unwrap().parse().unwrap();
        assert!((height - 2.5 * 1493.0 / 2048.0).abs() < 1e-4, "{height}");
    }

    #[test]
    fn a_sheet_is_lines_of_groups_at_the_asked_scale() {
        let mut sheet = Sheet::new([100.0, 50.0]);
        sheet.strokes(vec![[1.0, 2.0], [3.0, 4.0]], Pen::black(0.5));
        sheet.strokes(
            vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 0.0]],
            Pen::broken(0.25, Dashes::Chain),
        );
        sheet.text([5.0, 6.0], 2.5, "\u{d8}3 \u{b1}0.1", TextAlign::Right);
        let bytes = sheet.dxf(2.0);
        assert_eq!(bytes, sheet.dxf(2.0));
        let lines: Vec<&[u8]> = bytes.split(|b| *b == b'\n').collect();
        assert!(lines.len() % 2 == 1 && lines.last().unwrap().is_empty());
        let holds = |text: &[u8]| bytes.windows(text.len()).any(|found| found == text);
        assert!(holds(b"LINE\n  8\nOUTLINE\n 10\n2.000000\n 20\n4.000000\n 11\n6.000000\n"));
        assert!(holds(b"  1\n\xd83 \xb10.1\n 72\n2\n 11\n10.000000\n"));
        // A closed line has each corner once.
        assert_eq!(lines.iter().filter(|line| **line == b"VERTEX").count(), 3);
        assert!(bytes.ends_with(b"  0\nEOF\n"));
    }
}
