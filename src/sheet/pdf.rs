//! A sheet as a PDF of one page.

use super::font::{FIGURES, FILE, FIRST, LAST, encoded};
use super::{Dashes, Pen, Sheet, SheetColour, SheetMark, TextLine, TextWay};
use pdf_writer::types::FontFlags;
use pdf_writer::{Content, Finish, Name, Pdf, Rect, Ref, Str, TextStr};

/// Points of PDF to a millimetre.
const POINTS: f64 = 72.0 / 25.4;
/// Distance of a circle's control points from the ends of a quarter, in its radius: off by 0.03 % at most.
const QUARTER: f64 = 0.552_284_749_830_793;
/// Dashes and gaps of a hidden edge and of an axis, in the line's width (ISO 128-2).
const DASHED: [f64; 2] = [12.0, 3.0];
const CHAIN: [f64; 4] = [24.0, 3.0, 0.5, 3.0];
/// The font's name in the page and in itself; six letters before it tell that it is a part of a font.
const FONT: Name = Name(b"F1");
const BASE_FONT: Name = Name(b"MORION+DejaVuSans");
/// Width of its upright stems, thousandths: of DejaVu Sans.
const STEM_V: f32 = 80.0;

/// Numbers of the file's objects.
const CATALOG: Ref = Ref::new(1);
const PAGES: Ref = Ref::new(2);
const PAGE: Ref = Ref::new(3);
const CONTENT: Ref = Ref::new(4);
const FONT_DICT: Ref = Ref::new(5);
const DESCRIPTOR: Ref = Ref::new(6);
const FONT_FILE: Ref = Ref::new(7);
const INFO: Ref = Ref::new(8);

pub(super) fn written(sheet: &Sheet, title: &str) -> Vec<u8> {
    let mut pdf = Pdf::new();
    pdf.catalog(CATALOG).pages(PAGES);
    pdf.pages(PAGES).kids([PAGE]).count(1);
    let mut page = pdf.page(PAGE);
    let [width, height] = sheet.size_mm.map(points);
    page.parent(PAGES).media_box(Rect::new(0.0, 0.0, width, height)).contents(CONTENT);
    page.resources().fonts().pair(FONT, FONT_DICT);
    page.finish();
    let mut content = Content::new();
    sheet.marks.iter().for_each(|mark| draw(&mut content, mark));
    pdf.stream(CONTENT, &content.finish());
    write_font(&mut pdf);
    pdf.document_info(INFO)
        .title(TextStr(title))
        .producer(TextStr(concat!("Morion ", env!("CARGO_PKG_VERSION"))));
    pdf.finish()
}

/// The font, and its file as a whole.
fn write_font(pdf: &mut Pdf) {
    let figures = &*FIGURES;
    let mut font = pdf.indirect(FONT_DICT).dict();
    font.pair(Name(b"Type"), Name(b"Font"));
    font.pair(Name(b"Subtype"), Name(b"TrueType"));
    font.pair(Name(b"BaseFont"), BASE_FONT);
    font.pair(Name(b"FirstChar"), i32::from(FIRST));
    font.pair(Name(b"LastChar"), i32::from(LAST));
    font.insert(Name(b"Widths")).array().items(figures.widths.iter().copied());
    font.pair(Name(b"FontDescriptor"), DESCRIPTOR);
    font.pair(Name(b"Encoding"), Name(b"WinAnsiEncoding"));
    font.finish();
    let [left, low, right, high] = figures.bounds;
    pdf.font_descriptor(DESCRIPTOR)
        .name(BASE_FONT)
        .flags(FontFlags::NON_SYMBOLIC)
        .bbox(Rect::new(left, low, right, high))
        .italic_angle(0.0)
        .ascent(figures.ascent)
        .descent(figures.descent)
        .cap_height(figures.cap_height)
        .stem_v(STEM_V)
        .font_file2(FONT_FILE);
    let length = i32::try_from(FILE.len()).unwrap_or(i32::MAX);
    pdf.stream(FONT_FILE, FILE).pair(Name(b"Length1"), length);
}

/// A length in points, to a ten-thousandth: no digits that nobody prints.
fn points(mm: f64) -> f32 {
    ((mm * POINTS * 1e4).round() / 1e4) as f32
}

fn draw(content: &mut Content, mark: &SheetMark) {
    match mark {
        SheetMark::Strokes { places, pen } => {
            take(content, pen);
            trace_lines(content, places);
            content.stroke();
        }
        SheetMark::Triangle { corners, colour } => {
            fill_with(content, *colour);
            trace_lines(content, corners);
            content.close_path().fill_nonzero();
        }
        SheetMark::Circle { centre, radius_mm, pen } => {
            take(content, pen);
            trace_circle(content, *centre, *radius_mm);
            content.stroke();
        }
        SheetMark::Disc { centre, radius_mm, colour } => {
            fill_with(content, *colour);
            trace_circle(content, *centre, *radius_mm);
            content.fill_nonzero();
        }
        SheetMark::Text(line) => write_text(content, line),
    }
}

/// Takes a pen for the lines that follow.
fn take(content: &mut Content, pen: &Pen) {
    let [r, g, b] = rgb(pen.colour);
    content.set_stroke_rgb(r, g, b).set_line_width(points(pen.width_mm));
    let dashes: &[f64] = match pen.dashes {
        Dashes::Continuous => &[],
        Dashes::Dashed => &DASHED,
        Dashes::Chain => &CHAIN,
    };
    content.set_dash_pattern(dashes.iter().map(|share| points(share * pen.width_mm)), 0.0);
}

fn fill_with(content: &mut Content, colour: SheetColour) {
    let [r, g, b] = rgb(colour);
    content.set_fill_rgb(r, g, b);
}

fn trace_lines(content: &mut Content, places: &[[f64; 2]]) {
    for (k, place) in places.iter().enumerate() {
        let [x, y] = place.map(points);
        if k == 0 {
            content.move_to(x, y)
        } else {
            content.line_to(x, y)
        };
    }
}

fn write_text(content: &mut Content, line: &TextLine) {
    fill_with(content, SheetColour::Black);
    let [x, y] = line.start().map(points);
    content.begin_text().set_font(FONT, points(line.size_mm));
    match line.way {
        TextWay::Across => content.next_line(x, y),
        TextWay::Up => content.set_text_matrix([0.0, 1.0, -1.0, 0.0, x, y]),
    };
    content.show(Str(&encoded(&line.text))).end_text();
}

/// Four quarters of a circle as cubic curves.
fn trace_circle(content: &mut Content, [x, y]: [f64; 2], radius: f64) {
    let at = |u: f64, v: f64| [points(x + radius * u), points(y + radius * v)];
    let [from_x, from_y] = at(1.0, 0.0);
    content.move_to(from_x, from_y);
    let mut way = [1.0, 0.0];
    for _ in 0..4 {
        let next = [-way[1], way[0]];
        let [a, b] = at(way[0] + QUARTER * next[0], way[1] + QUARTER * next[1]);
        let [c, d] = at(next[0] + QUARTER * way[0], next[1] + QUARTER * way[1]);
        let [e, f] = at(next[0], next[1]);
        content.cubic_to(a, b, c, d, e, f);
        way = next;
    }
    content.close_path();
}

/// Red, green and blue.
fn rgb(colour: SheetColour) -> [f32; 3] {
    match colour {
        SheetColour::Black => [0.0; 3],
        SheetColour::Grey => [0.6; 3],
        SheetColour::Red => [0.75, 0.1, 0.1],
        SheetColour::Blue => [0.1, 0.25, 0.75],
    }
}
