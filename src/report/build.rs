//! Answers of a build and of a verification.

use super::answer::{Answer, AnswerRows, Head, ToRows};
use super::fact_rows::{PlainPicture, TracesWithFrame};
use super::page::{Page, escaped};
use super::sharpness::PlainSharpness;
use crate::profile::AcceptanceLimits;
use crate::results::{BuildReport, FileFacts, TraceFacts, VerifyReport};
use crate::trace::FrameFill;

impl Answer for BuildReport {
    fn head(&self) -> Head<'_> {
        Head::judged(&self.profile, self.verdict, &self.reasons).with_warnings(&self.warnings)
    }

    fn rows(&self) -> AnswerRows {
        let Self { layout, design, form, mesh, solid, files, step, sag, .. } = self;
        let Self { trace, frame, sharpness, accepted, .. } = self;
        let mut rows = AnswerRows::of(&[layout, &plain_picture(trace, frame, accepted)]);
        sharpness.as_ref().map(PlainSharpness).add_to(&mut rows);
        files.add_to(&mut rows);
        let trace = &TracesWithFrame { traces: trace, has_frame: frame.is_some() };
        rows.details(|rows| {
            rows.append(AnswerRows::of(&[
                design, form, mesh, solid, step, sag, trace, frame, sharpness, accepted,
            ]));
        });
        rows
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

fn plain_picture<'a>(
    traces: &'a [TraceFacts],
    frame: &'a Option<FrameFill>,
    accepted: &'a Option<AcceptanceLimits>,
) -> PlainPicture<'a> {
    PlainPicture { traces, frame: frame.as_ref(), accepted: accepted.as_ref() }
}

impl Answer for VerifyReport {
    fn head(&self) -> Head<'_> {
        Head::judged(&self.profile, self.verdict, &self.reasons).with_warnings(&self.warnings)
    }

    fn rows(&self) -> AnswerRows {
        let Self { layout, design, form, files, units, alignment, form_error_um, .. } = self;
        let Self { trace, frame, sharpness, accepted, .. } = self;
        let mut rows = AnswerRows::of(&[layout, files, units, alignment, form_error_um]);
        plain_picture(trace, frame, accepted).add_to(&mut rows);
        sharpness.as_ref().map(PlainSharpness).add_to(&mut rows);
        let trace = &TracesWithFrame { traces: trace, has_frame: frame.is_some() };
        rows.details(|rows| {
            let parts: [&dyn ToRows; 6] = [design, form, trace, frame, sharpness, accepted];
            rows.append(AnswerRows::of(&parts));
        });
        rows
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
