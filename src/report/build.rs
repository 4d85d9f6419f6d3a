//! Answers of a build and of a verification.

use super::answer::{Answer, AnswerRows, Head, ToRows};
use super::build_figures::{BuildFigures, about_errors};
use super::fact_rows::{PlainPicture, TracesWithFrame, worst_pixel_error};
use super::page::{Page, map_figure, page_of};
use super::sharpness::PlainSharpness;
use crate::profile::{AcceptanceLimits, Profile};
use crate::raster::{EncodingError, FalseColourMap};
use crate::results::{BuildReport, TraceFacts, VerifyReport, error_px, percent};
use crate::trace::FrameFill;

impl Answer for BuildReport {
    fn head(&self) -> Head<'_> {
        Head::judged(&self.profile, self.verdict, &self.reasons).with_warnings(&self.warnings)
    }

    fn rows(&self) -> AnswerRows {
        let Self { design, form, mesh, solid, files, step, sag, drawing, .. } = self;
        let Self { trace, frame, sharpness, accepted, .. } = self;
        let mut rows = self.plain_rows();
        files.add_to(&mut rows);
        let trace = &TracesWithFrame { traces: trace, has_frame: frame.is_some() };
        rows.details(|rows| {
            rows.append(AnswerRows::of(&[
                design, form, mesh, solid, step, sag, drawing, trace, frame, sharpness, accepted,
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

    /// `report.html`: a page that needs nothing beside it.
    ///
    /// # Errors
    /// What an encoder of pictures reports.
    pub fn html(&self, profile: &Profile, figures: &BuildFigures) -> Result<String, EncodingError> {
        let mut page = Page::new(self, "");
        page.paragraph(&self.conclusion());
        page.paragraph(&profile.summary);
        page.list(&self.head().reasons);
        page.warnings(&self.warnings);
        page.plain_facts(&self.plain_rows());
        page.figures(figures.on_page(
            &self.trace,
            self.sharpness.as_ref(),
            &self.made(),
            self.design.least_error.as_ref(),
        )?);
        page.files(&self.files);
        page.folded_facts("All figures, and what each means", &self.page_rows());
        page.links("report.html", profile);
        Ok(page.finish())
    }

    /// What files hold, and its size, in words.
    fn made(&self) -> String {
        match &self.tool {
            Some(tool) => tool.made(),
            None => format!("part, {}", self.layout.map_or(String::new(), |layout| layout.size())),
        }
    }

    /// What the verdict rests on, in three numbers.
    fn conclusion(&self) -> String {
        let worst = worst_pixel_error(&self.trace);
        let (Some(found), Some(allowed), Some(frame)) = (worst, &self.accepted, &self.frame) else {
            return "Without a projection nothing is said of what the picture shows.".into();
        };
        let [rms, max] = [found.rms, found.max].map(error_px);
        format!(
            "The picture is off by {rms} px RMS (allowed {}) and by {max} px at most (allowed {}); {} % of the frame \
             is filled (asked {} %).",
            allowed.pixel_error_rms_px.value,
            allowed.pixel_error_max_px.value,
            (1e3 * frame.filled).floor() / 10.0,
            percent(allowed.frame_filled.value),
        )
    }

    /// Its facts in plain words.
    fn plain_rows(&self) -> AnswerRows {
        let Self { layout, design, unwanted, trace, frame, sharpness, accepted, tool, .. } = self;
        let cavity = &self.cavity;
        let picture = plain_picture(trace, frame, accepted);
        let of_design: [&dyn ToRows; 5] = [
            &design.least_error,
            &design.map,
            &design.straightness,
            &design.dividing_lines,
            unwanted,
        ];
        let mut rows = AnswerRows::of(&[tool, layout, cavity, &picture]);
        rows.append(AnswerRows::of(&of_design));
        sharpness.as_ref().map(PlainSharpness).add_to(&mut rows);
        rows
    }

    /// Its facts in the order of the page.
    fn page_rows(&self) -> AnswerRows {
        let Self { layout, design, unwanted, form, mesh, solid, step, sag, drawing, .. } = self;
        let Self { trace, frame, sharpness, accepted, tool, cavity, .. } = self;
        let trace = &TracesWithFrame { traces: trace, has_frame: frame.is_some() };
        let mut rows = AnswerRows::default();
        rows.page("profile sha256", &self.profile.sha256);
        for file in &self.profile.files {
            rows.page(format!("{} sha256", file.name), &file.sha256);
        }
        rows.append(AnswerRows::of(&[
            tool,
            layout,
            cavity,
            design,
            &design.least_error,
            &design.map,
            &design.straightness,
            &design.dividing_lines,
            unwanted,
            form,
            step,
            sag,
            drawing,
            mesh,
            solid,
            trace,
            sharpness,
            accepted,
            frame,
        ]));
        rows
    }
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
        self.measured_form.add_to(&mut rows);
        self.program.add_to(&mut rows);
        plain_picture(trace, frame, accepted).add_to(&mut rows);
        design.least_error.add_to(&mut rows);
        design.straightness.add_to(&mut rows);
        design.dividing_lines.add_to(&mut rows);
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

    /// `report.html`, with maps of what was found.
    ///
    /// # Errors
    /// What an encoder of pictures reports.
    pub fn html(
        &self,
        errors: Option<&FalseColourMap>,
        form: Option<&FalseColourMap>,
    ) -> Result<String, EncodingError> {
        let mut figures = Vec::new();
        if let Some(map) = form {
            let caption = "Distance of the measured part from its design along the normal, as the camera sees it: \
                           red where there is too much material, blue where there is too little.";
            figures.push(map_figure("Form error, um", map, caption.into())?);
        }
        if let Some(map) = errors {
            figures.push(map_figure("Pixel error, px", map, about_errors(&self.trace))?);
        }
        Ok(page_of(self, (None, "verification"), figures, &self.files))
    }

    /// A readable summary: a line a fact, the reasons, and the verdict last. Plain text, in which what
    /// would steer a terminal is written out.
    #[must_use]
    pub fn text(&self) -> String {
        Answer::text(self)
    }
}
