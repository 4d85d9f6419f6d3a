//! The inspection's plan as CSV and text, and what measured points say of the form.

use super::answer::{Answer, AnswerRows, Head, ToRows};
use crate::inspection::InspectionPlan;
use crate::results::{InspectionReport, MeasuredForm, digits, error_px};
use std::fmt::Write;

/// `inspection.csv`: a line a point, with its place, its normal and half the zone to either side, if there is one.
#[must_use]
pub fn inspection_csv(
    plan: &InspectionPlan,
    report: &InspectionReport,
    notes: &[String],
) -> String {
    let mut out = String::new();
    let zone = report.pmi.surface_profile_mm.map(|mm| 0.5 * mm);
    // Writing to a string cannot fail.
    for note in notes {
        let plain: String = note.chars().map(|c| if c.is_control() { '?' } else { c }).collect();
        let _ = writeln!(out, "# {plain}");
    }
    out += "X_mm,Y_mm,Z_mm,NX,NY,NZ";
    out += if zone.is_some() { ",lower_mm,upper_mm,point\n" } else { ",point\n" };
    for (k, point) in plan.points.iter().enumerate() {
        let ([x, y, z], [i, j, n]) = (point.at.to_array(), point.normal.to_array());
        let _ = write!(out, "{x:.6},{y:.6},{z:.6},{i:.9},{j:.9},{n:.9}");
        if let Some(zone) = zone {
            let _ = write!(out, ",-{zone},{zone}");
        }
        let _ = writeln!(out, ",P{:05}", k + 1);
    }
    out
}

impl Answer for InspectionReport {
    fn head(&self) -> Head<'_> {
        Head::of(&self.profile)
    }

    fn rows(&self) -> AnswerRows {
        let mut rows = AnswerRows::default();
        rows.add(
            "points",
            format!(
                "{}, {} mm apart, at least {} mm from rims: enough for a form of degree {}",
                self.points,
                digits(self.spacing_mm),
                digits(self.margin_mm),
                self.degree
            ),
        );
        rows.add("datums", self.pmi.datums.join(", "));
        let zone = match (self.pmi.surface_profile_mm, &self.pmi.limited_by) {
            (Some(mm), Some(term)) => format!(
                "all within {} mm, half of it to either side of the design along its normal; {term} limits it",
                digits(mm)
            ),
            _ => "none: the design leaves no room in the limits of the picture".into(),
        };
        rows.add("zone", zone);
        self.files.add_to(&mut rows);
        rows
    }
}

impl ToRows for MeasuredForm {
    fn add_to(&self, rows: &mut AnswerRows) {
        let probe = self
            .probe_mm
            .map_or(String::new(), |mm| format!(", centres of a ball of {} mm radius", digits(mm)));
        rows.add("points", format!("{} of {} on the mirror{probe}", self.used, self.points));
        if let Some(errors) = &self.pixel_error_px {
            let [rms, max] = [errors.rms, errors.max].map(error_px);
            let sentence = format!("with this form off by {rms} px RMS, {max} at most");
            rows.named("picture", "picture with this form", sentence);
        }
        for (k, term) in self.terms.iter().enumerate() {
            // (What is far below its uncertainty is nothing.)
            let is_some = term.pv_um.abs() > 0.001 * term.uncertainty_um;
            let um = if is_some { term.pv_um } else { 0.0 };
            let [um, uncertainty] = [um, term.uncertainty_um].map(digits);
            let sentence =
                format!("{um} um from peak to valley, +- {uncertainty} um: {}", term.term);
            rows.named(if k == 0 { "form" } else { "" }, &format!("form: {}", term.term), sentence);
        }
        match self.rest_um {
            Some(rest) => rows.named(
                if self.terms.is_empty() { "form" } else { "" },
                "form: the rest",
                format!("{} um rms are finer, or the machine's own noise", digits(rest)),
            ),
            None => rows.add("form", "too few points on the mirror for terms of its form"),
        }
        if let (Some(mm), Some(outside)) = (self.surface_profile_mm, self.outside) {
            let sentence = format!(
                "{outside} points are outside of the {} mm that the picture allows",
                digits(mm)
            );
            rows.add("zone", sentence);
        }
    }
}
