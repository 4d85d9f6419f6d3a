//! A replayed trial as JSON and as text, and its pose as JSON.

use super::answer::{Answer, AnswerRows, Head, json_text};
use crate::num::stats::Summary;
use crate::results::{PoseFile, ReplayFile, ReplayReport, digits, displacement};
use crate::tolerance::{Displacement, Witnessed};

impl PoseFile {
    /// `pose.json`.
    #[must_use]
    pub fn json(&self) -> String {
        json_text(self)
    }
}

impl Answer for ReplayReport {
    fn head(&self) -> Head<'_> {
        Head::judged(&self.profile, self.verdict, &self.reasons)
    }

    fn rows(&self) -> AnswerRows {
        let Self { trial, seed, samples, .. } = self;
        let mut rows = AnswerRows::default();
        rows.terminal("replay", format!("trial {trial} of seed {seed}, {samples} pixels"));
        let errors: Vec<String> =
            self.errors.iter().map(|e| format!("{} {}", e.source, digits(e.value))).collect();
        for (k, line) in errors.chunks(4).enumerate() {
            rows.terminal(if k == 0 { "errors" } else { "" }, line.join(", "));
        }
        rows.terminal("trial", figures(&self.repeated));
        let without = match self.without.as_slice() {
            [] => String::new(),
            keys => format!("; without {}", keys.join(", ")),
        };
        rows.terminal("surface", format!("{}{without}", figures(&self.smooth)));
        self.files.iter().for_each(|file| file.add_to(&mut rows));
        rows
    }
}

impl ReplayFile {
    fn add_to(&self, rows: &mut AnswerRows) {
        let Self { file, triangles, off_surface_mm, witnessed, .. } = self;
        let Witnessed { rays, hit, shadowed, beyond, displacement, facet_error_px, .. } = witnessed;
        let facets = facet_error_px.map_or("no".into(), |Summary { rms, max, .. }| {
            format!("{} rms, {} max", digits(rms), digits(max))
        });
        let shown = figures(displacement);
        rows.remark(format!("{:8} {shown}; facet error {facets} px", file.name));
        let off = digits(1e3 * off_surface_mm);
        rows.terminal(
            "",
            format!(
                "{triangles} triangles, {hit} of {rays} rays hit ({shadowed} shadowed), {beyond} led over the \
                 rim; vertices within {off} um of the made surface"
            ),
        );
    }
}

/// Displacements as made and after adjustment.
fn figures(of: &Displacement) -> String {
    let Displacement { as_made, adjusted } = of;
    let [a, b, c, d] =
        [as_made.rms_px, as_made.p95_px, adjusted.rms_px, adjusted.p95_px].map(displacement);
    format!("as made {a} rms, {b} p95; adjusted {c} rms, {d} p95 px")
}
