//! The drawing of a part that a shop signs: views with dimensions, datum features and tolerances, tables and a title block.
//! Its figures are those of [`DrawingFacts`]; its lines are those of the part's mesh.

mod dimension;
mod lines;
mod paper;
mod part_edges;
mod tables;
mod title_block;
mod views;

pub use paper::DrawingScale;

use crate::geom::{DVec2, DatumScheme};
use crate::profile::{Profile, ViewArrangement};
use crate::render::{AxialPlane, PartSection};
use crate::results::DrawingFacts;
use crate::sheet::Sheet;
use crate::solid::Solid;
use paper::PaperLayout;
use part_edges::PartEdges;
use views::ViewPainter;

/// The lines of a part: what a drawing shows of it beside its figures.
#[derive(Debug, Clone)]
pub struct DrawnPart {
    solid: Solid,
    /// Datum features.
    datums: DatumScheme,
    /// Sections through Y = 0 and X = 0.
    sections: [PartSection; 2],
    /// Circles in the plan, each with its centre and radius, mm.
    circles: Vec<(DVec2, f64)>,
    /// Places to measure, in the plan, mm.
    inspected: Vec<DVec2>,
}

impl DrawnPart {
    /// The lines of a closed part with these datum features, those circles in its plan and those places to measure, mm.
    #[must_use]
    pub fn new(
        solid: Solid,
        datums: DatumScheme,
        circles: Vec<(DVec2, f64)>,
        inspected: Vec<DVec2>,
    ) -> Self {
        let sections =
            [AxialPlane::Y0, AxialPlane::X0].map(|plane| PartSection::new(solid.mesh(), plane));
        Self { solid, datums, sections, circles, inspected }
    }
}

/// The scale of the drawing of a part of this size, mm, as `profile` asks for it.
#[must_use]
pub fn scale(profile: &Profile, size_mm: [f64; 3]) -> DrawingScale {
    layout(profile, size_mm, [0.0; 2]).scale
}

/// The layout of a part of this size whose least X and Y these are, mm.
fn layout(profile: &Profile, size_mm: [f64; 3], least_mm: [f64; 2]) -> PaperLayout {
    PaperLayout::new(profile.drawing.paper, profile.drawing.arrangement, size_mm, least_mm)
}

/// The drawing of a part.
#[must_use]
pub fn drawn(profile: &Profile, facts: &DrawingFacts, part: &DrawnPart) -> Sheet {
    let (layout, spec) = (layout(profile, facts.size_mm, facts.least_mm), &profile.drawing);
    let mut sheet = Sheet::new(layout.size_mm);
    title_block::draw_title(&mut sheet, &layout, facts, spec, [&profile.name, &profile.sha256]);
    tables::draw_tables(&mut sheet, facts, &layout.tables);
    let letters: Vec<char> = part.datums.lettered().map(|(letter, _)| letter).collect();
    tables::draw_surface(&mut sheet, facts, (spec, &letters), &layout.surface);
    tables::draw_notes(&mut sheet, facts, spec, &layout.notes);
    let arrangement: ViewArrangement = spec.arrangement;
    let edges = PartEdges::new(&part.solid);
    ViewPainter { part, facts, layout: &layout, arrangement, edges }.draw(&mut sheet);
    sheet
}
