//! A drawing in words.

use super::answer::{Answer, AnswerRows, Head, ToRows};
use super::fact_rows::pmi_sentence;
use crate::results::{DrawingFacts, DrawingReport, digits};

impl Answer for DrawingReport {
    fn head(&self) -> Head<'_> {
        Head::of(&self.profile)
    }

    fn rows(&self) -> AnswerRows {
        let mut rows = AnswerRows::default();
        let [x, y, z] = self.drawing.size_mm;
        rows.add("part", format!("{x:.2} x {y:.2} x {z:.2} mm"));
        self.drawing.add_to(&mut rows);
        self.files.add_to(&mut rows);
        rows
    }
}

impl ToRows for DrawingFacts {
    fn add_to(&self, rows: &mut AnswerRows) {
        let Self { paper, projection, scale, pmi, .. } = self;
        let slope = self.slope_error_mrad.map_or(String::new(), |mrad| {
            format!("; its normals within {} mrad RMS, form included", digits(mrad))
        });
        let sentence =
            format!("{paper}, {projection}, scale {scale}; {}{slope}", pmi_sentence(pmi));
        rows.add("drawing", sentence);
    }
}
