//! Look-up tables, in words.

use super::answer::{Answer, AnswerRows, Head, ToRows};
use crate::results::{FieldFacts, FloorFacts, PlaceMapFacts, TableReport, figures, three_digits};

impl Answer for TableReport {
    fn head(&self) -> Head<'_> {
        Head::of(&self.profile).with_warnings(&self.warnings)
    }

    fn rows(&self) -> AnswerRows {
        let mut rows = AnswerRows::default();
        let ([width, height], [columns, rows_of_nodes], every) =
            (self.frame_px, self.nodes, self.every);
        rows.add(
            "table",
            format!(
                "{columns} x {rows_of_nodes} nodes, one to {every} x {every} pixels of {width} x {height}; {} bytes in table.h",
                self.header_bytes
            ),
        );
        if let Some(pose) = &self.pose {
            rows.add("pose", format!("as mounted by {pose}"));
        }
        add_field(&mut rows, ("angles", "mrad"), &self.directions);
        if let Some(FloorFacts { z_mm, range_mm, field, plan }) = &self.floor {
            rows.add(
                "floor",
                format!(
                    "Z = {z_mm} mm in the part's frame, to {} mm from the axis",
                    three_digits(*range_mm)
                ),
            );
            add_field(&mut rows, ("", "mm"), field);
            add_map(&mut rows, ("plan", "mm"), plan);
        }
        add_map(&mut rows, ("panorama", "deg"), &self.panorama);
        self.files.add_to(&mut rows);
        rows
    }
}

fn add_field(rows: &mut AnswerRows, (label, unit): (&'static str, &str), field: &FieldFacts) {
    let FieldFacts { off_px, told, deviation } = field;
    let told = 100.0 * told;
    rows.add(
        label,
        format!(
            "{told:.1} % of the mirror's pixels told; between nodes off by {} px",
            figures(*off_px)
        ),
    );
    if deviation.is_some() {
        rows.add("", format!("parts differ by {} {unit}, one sigma", figures(*deviation)));
    }
}

fn add_map(rows: &mut AnswerRows, (label, unit): (&'static str, &str), map: &PlaceMapFacts) {
    let PlaceMapFacts { pixels: [width, height], per_px, corner, seen } = map;
    let [left, top] = corner.map(three_digits);
    let (per_px, seen) = (three_digits(*per_px), 100.0 * seen);
    rows.add(
        label,
        format!(
            "{width} x {height} pixels of {per_px} {unit}, from {left} and {top} {unit} at the upper left; the frame shows {seen:.1} %"
        ),
    );
}
