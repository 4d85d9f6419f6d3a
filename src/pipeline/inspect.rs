//! `morion inspect`: where a coordinate measuring machine has to touch a part, as a table and as a program.

use super::form_study::{FormStudy, pmi_facts};
use super::run::{Command, Run};
use super::{Error, Stage};
use crate::design::Design;
use crate::inspection::{InspectionPlan, MOST_DEGREE, least_margin_mm, plan_points, write_dmis};
use crate::profile::Profile;
use crate::report::{Answer, inspection_csv};
use crate::results::{FileFacts, InspectionReport, SCHEMA};

/// How an inspection is planned: writes `inspection.csv`, `inspection.dmi` and `inspection.json` into NAME.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InspectOptions {
    /// Degree of the form that the points have to be enough for.
    pub degree: usize,
    /// Least distance of a point from rims, ridges and steps, mm; none: the usual one.
    pub margin_mm: Option<f64>,
}

impl InspectOptions {
    /// The degree of the error sources' terms.
    pub const DEGREE: usize = 4;
}

impl Default for InspectOptions {
    fn default() -> Self {
        Self { degree: Self::DEGREE, margin_mm: None }
    }
}

impl Command for InspectOptions {
    type Report = InspectionReport;

    fn check(&self, _profile: &Profile) -> Result<(), Error> {
        let bad = |option, must: String, found: String| Err(Error::Option { option, must, found });
        if !(1..=MOST_DEGREE).contains(&self.degree) {
            let must = format!("a whole number from 1 to {MOST_DEGREE}");
            return bad("--degree", must, self.degree.to_string());
        }
        match self.margin_mm.filter(|mm| !(*mm >= 0.0 && mm.is_finite())) {
            Some(mm) => bad("--margin-mm", "0 or positive, and finite".into(), mm.to_string()),
            None => Ok(()),
        }
    }

    fn run(&self, run: &mut Run) -> Result<InspectionReport, Error> {
        let design = run.design()?;
        let margin_mm = self.margin_mm.unwrap_or_else(|| least_margin_mm(&design.mirror));
        let (plan, limit) = run.timer.always(Stage::Plan, || {
            let plan = plan_points(&design.mirror, self.degree, margin_mm);
            let limit = FormStudy::new(&design).and_then(|study| study.limit());
            let note = format!("{} points", plan.points.len());
            ((plan, limit), note)
        });
        if plan.points.is_empty() {
            return Err(Error::Option {
                option: "--margin-mm",
                must: "less than half of the mirror's smaller side".into(),
                found: margin_mm.to_string(),
            });
        }
        let mut report = InspectionReport {
            schema: SCHEMA,
            profile: run.profile.into(),
            degree: self.degree,
            points: plan.points.len(),
            spacing_mm: plan.spacing_mm,
            margin_mm,
            pmi: pmi_facts(&design, limit.as_ref()),
            files: Vec::new(),
        };
        let notes = notes(&design, &report);
        let csv = inspection_csv(&plan, &report, &notes);
        let dmis = dmis(&plan, &report, &notes);
        report.files = vec![
            FileFacts::of("inspection.csv", "csv", csv.as_bytes()),
            FileFacts::of("inspection.dmi", "dmis", &dmis),
        ];
        run.publish(Stage::Report, |files, _| {
            files.add_bytes("inspection.csv", csv.as_bytes())?;
            files.add_bytes("inspection.dmi", &dmis)?;
            files.add_report("inspection.json", &report.json())?;
            Ok(())
        })?;
        Ok(report)
    }
}

/// The plan as a program of a machine.
fn dmis(plan: &InspectionPlan, report: &InspectionReport, notes: &[String]) -> Vec<u8> {
    let mut bytes = Vec::new();
    // Writing to memory cannot fail.
    let _ = write_dmis(&mut bytes, plan, report.pmi.surface_profile_mm, notes);
    bytes
}

/// What an inspector has to know before the first point.
fn notes(design: &Design, report: &InspectionReport) -> Vec<String> {
    let profile = &design.profile;
    let zone = match report.pmi.surface_profile_mm {
        Some(mm) => {
            format!("profile of the mirror within {mm} mm of the design, along its normals")
        }
        None => {
            "no profile tolerance: the design leaves no room in the limits of the picture".into()
        }
    };
    vec![
        format!("Morion: profile {}, sha256 {}", profile.name, profile.sha256),
        "millimetres; part frame: X right in the picture, Y up in it, Z towards the camera; base at Z = 0".into(),
        format!("datum features: {}", report.pmi.datums.join(", ")),
        zone,
        format!(
            "{} points for a form of degree {}, at least {:.3} mm from rims; then `morion verify POINTS.csv --profile \
             PROFILE --align`, with --probe-mm where centres of the ball are measured",
            report.points, report.degree, report.margin_mm
        ),
    ]
}
