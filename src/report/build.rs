//! Answers of a build and of a verification.

use super::answer::{Answer, AnswerRows, Head};
use super::fact_rows::TracesWithFrame;
use super::page::{Page, escaped};
use crate::results::{BuildReport, FileFacts, VerifyReport};

impl Answer for BuildReport {
    fn head(&self) -> Head<'_> {
        Head::judged(&self.profile, self.verdict, &self.reasons).with_warnings(&self.warnings)
    }

    fn rows(&self) -> AnswerRows {
        let Self { layout, design, form, mesh, solid, files, step, sag, .. } = self;
        let Self { trace, frame, sharpness, accepted, .. } = self;
        let trace = &TracesWithFrame { traces: trace, has_frame: frame.is_some() };
        AnswerRows::of(&[
            layout, design, form, mesh, solid, files, step, sag, trace, frame, sharpness, accepted,
        ])
    }
}

impl BuildReport {
    /// `report.json`.
    #[must_use]
    pub fn json(&self) -> String {
        Answer::json(self)
    }

    /// A readable summary: a line a fact, the reasons, and the verdict last. Plain text, in which what
    /// would steer a terminal is written out.
    #[must_use]
    pub fn text(&self) -> String {
        Answer::text(self)
    }

    /// `report.html`: a page that needs nothing but `picture` (a file name) beside it.
    #[must_use]
    pub fn html(&self, summary: &str, picture: &str) -> String {
        let mut page = Page::new(self, "");
        page.paragraph(summary);
        page.list(&self.head().reasons);
        page.list(&self.warnings);
        let alt = "What the camera sees of a world marked every 15 degrees";
        page.raw(&format!("<p><img src=\"{picture}\" alt=\"{alt}\"></p>"));
        let files: Vec<String> = self.files.iter().map(file_row).collect();
        page.facts(&self.page_rows(), &files.concat());
        page.finish()
    }

    /// Its facts in the order of the page.
    fn page_rows(&self) -> AnswerRows {
        let Self { layout, design, form, mesh, solid, step, sag, .. } = self;
        let Self { trace, frame, sharpness, accepted, .. } = self;
        let trace = &TracesWithFrame { traces: trace, has_frame: frame.is_some() };
        let mut rows = AnswerRows::default();
        rows.page("profile sha256", &self.profile.sha256);
        rows.append(AnswerRows::of(&[
            layout, design, form, step, sag, mesh, solid, trace, sharpness, accepted, frame,
        ]));
        rows
    }
}

/// A file with its hash, as a row of HTML.
fn file_row(FileFacts { name, bytes, sha256, .. }: &FileFacts) -> String {
    let name = escaped(name);
    format!("<tr><th>{name}</th><td>{bytes} bytes<br><code>sha256 {sha256}</code></td></tr>\n")
}

impl Answer for VerifyReport {
    fn head(&self) -> Head<'_> {
        Head::judged(&self.profile, self.verdict, &self.reasons).with_warnings(&self.warnings)
    }

    fn rows(&self) -> AnswerRows {
        let Self { layout, design, form, files, units, alignment, form_error_um, .. } = self;
        let Self { trace, frame, sharpness, accepted, .. } = self;
        let trace = &TracesWithFrame { traces: trace, has_frame: frame.is_some() };
        AnswerRows::of(&[
            layout,
            design,
            form,
            files,
            units,
            alignment,
            form_error_um,
            trace,
            frame,
            sharpness,
            accepted,
        ])
    }
}

impl VerifyReport {
    /// `report.json`.
    #[must_use]
    pub fn json(&self) -> String {
        Answer::json(self)
    }

    /// A readable summary: a line a fact, the reasons, and the verdict last. Plain text, in which what
    /// would steer a terminal is written out.
    #[must_use]
    pub fn text(&self) -> String {
        Answer::text(self)
    }
}
