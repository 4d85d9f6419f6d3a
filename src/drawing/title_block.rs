//! The title block (ISO 7200), and the frame (ISO 5457).

use super::dimension::{FAINT, NARROW, WIDE};
use super::paper::{Area, PaperLayout};
use crate::profile::{DrawingSpec, TitleBlock, ViewArrangement};
use crate::results::DrawingFacts;
use crate::sheet::{Sheet, TextAlign};

/// Height of a caption's letters, mm.
const CAPTION: f64 = 1.7;
/// Height of a field's letters, at most and at least, mm.
const FIELD: f64 = 3.2;
const LEAST: f64 = 1.2;

/// A field: its caption and what stands in it.
type Field<'a> = (&'a str, FieldContent);

/// What stands in a field.
enum FieldContent {
    Text(String),
    /// The symbol of an arrangement of views.
    Views(ViewArrangement),
}

/// Draws the paper's frame and the title block.
pub(super) fn draw_title(
    sheet: &mut Sheet,
    layout: &PaperLayout,
    facts: &DrawingFacts,
    spec: &DrawingSpec,
    profile: [&str; 2],
) {
    let Area { left, low, right, high } = layout.frame;
    sheet.frame([left, low], [right, high], 0.7);
    centre_marks(sheet, layout);
    let block = layout.title;
    sheet.frame([block.left, block.low], [block.right, block.high], WIDE.width_mm);
    let mut top = block.high;
    for (height, fields) in rows(facts, spec, profile) {
        let mut x = block.left;
        for (share, field) in fields {
            let cell =
                Area { left: x, low: top - height, right: x + share * block.width(), high: top };
            draw_field(sheet, &cell, &field);
            x = cell.right;
        }
        top -= height;
    }
}

/// The rows of fields, each with its height, mm, and the share of the width that each field takes. The profile is its name and
/// its SHA-256.
fn rows<'a>(
    facts: &DrawingFacts,
    spec: &DrawingSpec,
    [profile, sha256]: [&str; 2],
) -> [(f64, Vec<(f64, Field<'a>)>); 4] {
    let TitleBlock { owner, number, revision, title, creator, approver, date } = spec.title.clone();
    let title = if title.is_empty() { profile.to_owned() } else { title };
    let short = sha256.get(..16).unwrap_or(sha256);
    let text = FieldContent::Text;
    [
        (
            9.0,
            vec![
                (0.5, ("Material", text(spec.material.clone()))),
                (0.5, ("Document type", text("Part drawing of a mirror".into()))),
            ],
        ),
        (
            9.0,
            vec![
                (0.35, ("Creator", text(creator))),
                (0.35, ("Approval person", text(approver))),
                (0.3, ("Date of issue", text(date))),
            ],
        ),
        (
            16.0,
            vec![
                (0.32, ("Legal owner", text(owner))),
                (0.44, ("Title", text(title))),
                (0.24, ("Identification number", text(number))),
            ],
        ),
        (
            14.0,
            vec![
                (0.14, ("Scale", text(facts.scale.clone()))),
                (0.16, ("Projection", FieldContent::Views(spec.arrangement))),
                (0.1, ("Paper", text(facts.paper.clone()))),
                (0.26, (PROFILE, text(format!("{profile} {short}")))),
                (0.1, ("Rev.", text(revision))),
                (0.1, ("Sheet", text("1/1".into()))),
                (0.14, ("Unit", text("mm".into()))),
            ],
        ),
    ]
}

/// Caption of the profile that the figures are of.
const PROFILE: &str = "Profile, SHA-256";

/// A cell with its caption in the upper corner and the text at the foot, smaller where it is long.
fn draw_field(sheet: &mut Sheet, cell: &Area, (caption, content): &Field) {
    sheet.frame([cell.left, cell.low], [cell.right, cell.high], NARROW.width_mm);
    let inside = cell.left + 1.0;
    sheet.text([inside, cell.high - CAPTION - 0.4], CAPTION, caption, TextAlign::Left);
    let text = match content {
        FieldContent::Text(text) => text,
        FieldContent::Views(arrangement) => return draw_symbol(sheet, cell, *arrangement),
    };
    let wide = Sheet::width_of(text, 1.0);
    let size = if wide > 0.0 { ((cell.width() - 2.0) / wide).clamp(LEAST, FIELD) } else { FIELD };
    sheet.text([inside, cell.low + 1.4], size, text, TextAlign::Left);
}

/// The symbol of the arrangement of views (ISO 5456-2): a cone's end, from the side and from its small end.
fn draw_symbol(sheet: &mut Sheet, cell: &Area, arrangement: ViewArrangement) {
    let [middle, _] = cell.middle();
    let (y, large, small) = (cell.low + 5.6, 3.0, 1.5);
    // The view from the left, where the small end is, stands to the right in the first angle.
    let (cone, rings) = match arrangement {
        ViewArrangement::FirstAngle => (middle - 5.0, middle + 6.0),
        ViewArrangement::ThirdAngle => (middle + 5.0, middle - 6.0),
    };
    let side = [
        [cone - 3.5, y - small],
        [cone + 3.5, y - large],
        [cone + 3.5, y + large],
        [cone - 3.5, y + small],
        [cone - 3.5, y - small],
    ];
    sheet.strokes(side.to_vec(), NARROW);
    sheet.circle([rings, y], large, NARROW);
    sheet.circle([rings, y], small, NARROW);
    sheet.strokes(vec![[middle - 10.0, y], [middle + 10.0, y]], FAINT);
}

/// Marks in the middle of the paper's sides.
fn centre_marks(sheet: &mut Sheet, layout: &PaperLayout) {
    let [width, height] = layout.size_mm;
    let Area { left, low, right, high } = layout.frame;
    let (x, y) = (0.5 * width, 0.5 * height);
    for (from, to) in [
        ([left - 5.0, y], [left, y]),
        ([right + 5.0, y], [right, y]),
        ([x, low - 5.0], [x, low]),
        ([x, high + 5.0], [x, high]),
    ] {
        sheet.strokes(vec![from, to], NARROW);
    }
}
