//! Answers of a build and of a verification.

use super::answer::{Answer, AnswerRows, Head};
use super::fact_rows::TracesWithFrame;
use super::facts::{
    FileFacts, MeshFacts, ProfileId, SagFacts, SolidFacts, StepFacts, TraceFacts, Verdict,
};
use super::measured::{AlignmentFacts, UnitFacts};
use super::page::{Page, escaped};
use super::reason::Reason;
use super::sharpness::SharpnessFacts;
use crate::align::FormError;
use crate::design::{DesignFacts, Mounting};
use crate::mirror::Form;
use crate::profile::AcceptanceLimits;
use crate::trace::FrameFill;
use serde::{Deserialize, Serialize};

/// Results of a build, in the shape of `report.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BuildReport {
    /// Version of these keys.
    pub schema: u32,
    /// Profile that was built.
    pub profile: ProfileId,
    /// Places of camera and target in the part's frame, and the size of the part; absent from reports
    /// of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layout: Option<Mounting>,
    /// Figures of the design.
    pub design: DesignFacts,
    /// The sphere and the plane nearest to the mirror.
    pub form: Form,
    /// Figures of the mesh; absent where none could be made.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<MeshFacts>,
    /// The solid that was made; absent where there is no mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solid: Option<SolidFacts>,
    /// The files written.
    pub files: Vec<FileFacts>,
    /// Figures of the witness, for each mesh file that could be read.
    pub trace: Vec<TraceFacts>,
    /// Figures of the sag table that was read back; absent when none was written or it is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sag: Option<SagFacts>,
    /// Error of the STEP file's splines; absent when none was written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step: Option<StepFacts>,
    /// The frame as the first mesh file shows it; absent when none could be read.
    pub frame: Option<FrameFill>,
    /// Sharpness of the picture through a lens; absent where no pixel has a spot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sharpness: Option<SharpnessFacts>,
    /// The limits that the picture is held to; absent without a projection.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accepted: Option<AcceptanceLimits>,
    /// Pass or fail.
    pub verdict: Verdict,
    /// Reasons of a fail, each with figures; empty for a pass.
    pub reasons: Vec<Reason>,
    /// Nuisances to come, and what to do about them; no part of the verdict.
    pub warnings: Vec<String>,
}

/// Results of the verification of a file of unknown making, in the shape of `report.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VerifyReport {
    /// Version of these keys.
    pub schema: u32,
    /// Profile that the file is held against.
    pub profile: ProfileId,
    /// Places of camera and target in the part's frame, and the size of the part.
    pub layout: Mounting,
    /// Figures of the design.
    pub design: DesignFacts,
    /// The sphere and the plane nearest to the mirror.
    pub form: Form,
    /// The file: the only one.
    pub files: Vec<FileFacts>,
    /// Figures of the witness; empty where the file could not be read.
    pub trace: Vec<TraceFacts>,
    /// The unit of its coordinates; absent where the file could not be read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub units: Option<UnitFacts>,
    /// Pose that brings a measured part into the part frame; absent when that was not asked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alignment: Option<AlignmentFacts>,
    /// Distance of a measured part from its design along its normal, um; positive where there is too
    /// much material.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub form_error_um: Option<FormError>,
    /// The frame as the file shows it; absent where it could not be read.
    pub frame: Option<FrameFill>,
    /// Sharpness of the picture through a lens; absent where no pixel has a spot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sharpness: Option<SharpnessFacts>,
    /// The limits that the picture is held to; absent without a projection, and of measured parts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accepted: Option<AcceptanceLimits>,
    /// Pass or fail.
    pub verdict: Verdict,
    /// Reasons of a fail, each with figures; empty for a pass.
    pub reasons: Vec<Reason>,
    /// Nuisances to come, and what to do about them; no part of the verdict.
    pub warnings: Vec<String>,
}

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
