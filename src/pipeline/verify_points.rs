//! A part that a coordinate measuring machine touched: its points to a pose, a form, and the picture of that form.

use super::file_units::{in_millimetres, unit_warning};
use super::form_study::{FormStudy, zone_mm};
use super::run::Run;
use super::{Error, Stage};
use crate::align::{FormMap, LengthUnit, PointAlignment, PointResidual, SizeRange, align_points};
use crate::design::Design;
use crate::export::{PointFormat, read_points};
use crate::geom::{DVec3, TriMesh};
use crate::inspection::{FittedTerm, FormFit, fit_form, rims};
use crate::mirror::Form;
use crate::part::Promise;
use crate::report::InspectionMap;
use crate::results::{
    AlignmentFacts, FileFacts, FileFault, FormTermFacts, MeasuredForm, PictureFault, Reason,
    SCHEMA, UnitFacts, VerifyReport,
};
use crate::tolerance::Perturbation;
use crate::verdict::{self, Findings};

/// A list of measured points.
pub(super) struct PointList {
    /// The file.
    pub name: String,
    /// Its format.
    pub format: PointFormat,
    /// The unit of its coordinates; none: by its size.
    pub units: Option<LengthUnit>,
    /// Radius of the ball whose centres they are, mm; none: points on the part.
    pub probe_mm: Option<f64>,
}

/// What the points showed.
struct PointFindings {
    units: UnitFacts,
    alignment: AlignmentFacts,
    form: MeasuredForm,
    departures: FormMap,
    map: InspectionMap,
}

impl PointList {
    /// Reads the points, brings them to millimetres and into the part's frame, and judges the form that they show; and
    /// where they are.
    pub(super) fn verified(
        &self,
        run: &Run,
        design: &Design,
        bytes: &[u8],
    ) -> Result<(VerifyReport, InspectionMap), Error> {
        let (found, unreadable) = match self.looked_at(run, design, bytes)? {
            Ok(found) => (Some(found), None),
            Err(fault) => (None, Some(Reason::from(fault).of_file(&self.name))),
        };
        let Findings { sharpness, mut reasons, .. } =
            Findings::new(run.profile, design, Vec::new());
        reasons.extend(unreadable);
        let mut warnings = Vec::new();
        if let Some(found) = &found {
            reasons.extend(self.faults(design, found));
            warnings.extend(unit_warning(&self.name, found.units, true));
        }
        let format = match self.format {
            PointFormat::Text => "points",
            PointFormat::Ply => "ply",
        };
        let file = FileFacts::of(&self.name, format, bytes);
        let (form_error_um, found) = match found {
            Some(found) => (found.departures.error(), Some(found)),
            None => (None, None),
        };
        let (units, alignment, measured_form, map) = match found {
            Some(found) => (Some(found.units), Some(found.alignment), Some(found.form), found.map),
            None => (None, None, None, InspectionMap::default()),
        };
        let report = VerifyReport {
            schema: SCHEMA,
            profile: run.profile.into(),
            layout: design.mounting,
            design: design.facts.clone(),
            form: Form::of(&design.mirror),
            files: vec![file],
            trace: Vec::new(),
            units,
            alignment,
            form_error_um,
            measured_form,
            program: None,
            frame: None,
            sharpness,
            accepted: design.view.is_some().then(|| run.profile.acceptance_limits()),
            verdict: verdict::of(&reasons),
            reasons,
            warnings,
        };
        Ok((report, map))
    }

    /// Why the part does not pass.
    fn faults(&self, design: &Design, found: &PointFindings) -> Vec<Reason> {
        let profile = &design.profile;
        let reasons: Vec<Reason> = match (&design.view, &found.form.pixel_error_px) {
            (Some(_), Some(errors)) => {
                verdict::pixel_errors(profile, *errors, |_| true).map(Reason::from).collect()
            }
            (Some(_), None) if !found.form.terms.is_empty() => {
                vec![PictureFault::NotFinite { what: "pixel error" }.into()]
            }
            // Without a picture, or a form that could be traced, the departures have to be small themselves.
            _ => {
                let limit_um = 1e3 * Promise::of_profile(profile).chord_mm;
                let error = found.departures.error();
                verdict::form(profile, design, error.as_ref(), limit_um).into_iter().collect()
            }
        };
        reasons.into_iter().map(|reason| reason.of_file(&self.name)).collect()
    }

    /// What the points show; a fault of a file that cannot be read.
    fn looked_at(
        &self,
        run: &Run,
        design: &Design,
        bytes: &[u8],
    ) -> Result<Result<PointFindings, FileFault>, Error> {
        let read = run.timer.always(Stage::Read, || {
            let read = read_points(self.format, bytes);
            let note = match &read {
                Ok(points) => format!("{}: {} points", self.name, points.len()),
                Err(error) => error.to_string(),
            };
            (read, note)
        });
        let vertices = match read {
            Ok(points) => points,
            Err(error) => return Ok(Err(FileFault::Unreadable(error.to_string()))),
        };
        let mut cloud = TriMesh { vertices, triangles: Vec::new() };
        let size = SizeRange::of(&design.mirror, design.border.as_ref());
        let units = in_millimetres(&mut cloud, &size, self.units);
        let aligned = run.stage(Stage::Align, || {
            let ball_mm = self.probe_mm.unwrap_or(0.0);
            let found = align_points(&design.mirror, &cloud.vertices, ball_mm)
                .map_err(|source| Error::Align { path: self.name.clone(), source })?;
            let rms_um = 1e3 * found.alignment.rms_mm;
            let note = format!("{rms_um:.3} um rms after {} steps", found.alignment.steps);
            Ok((found, note))
        })?;
        let form = run.timer.always(Stage::Trace, || {
            let (form, used) = self.form(design, &aligned);
            let note = format!("{} points, {} terms", form.used, form.terms.len());
            ((form, used), note)
        });
        let (form, used) = form;
        let mm = aligned.residuals.iter().map(|r| r.map_or(f64::NAN, |r| r.distance)).collect();
        Ok(Ok(PointFindings {
            map: map(design, &used),
            units,
            alignment: AlignmentFacts::new(&aligned.alignment),
            form,
            departures: FormMap {
                pixels: [u32::try_from(aligned.residuals.len()).unwrap_or(u32::MAX), 1],
                mm,
            },
        }))
    }

    /// The form of aligned points and what it does to the picture, and the points that it rests on.
    fn form(
        &self,
        design: &Design,
        aligned: &PointAlignment,
    ) -> (MeasuredForm, Vec<PointResidual>) {
        let fit = fit_form(&design.mirror, aligned);
        let study = FormStudy::new(design);
        let zone = study.as_ref().and_then(|study| zone_mm(&study.limit()?));
        let near = |r: &PointResidual| r.distance.abs() < aligned.reach_mm;
        let used: Vec<bool> = match &fit {
            Some(fit) => fit.used.clone(),
            None => aligned.residuals.iter().map(|r| r.as_ref().is_some_and(near)).collect(),
        };
        let all = aligned.residuals.iter().zip(&used).filter(|(_, used)| **used);
        let used: Vec<PointResidual> = all.filter_map(|(r, _)| *r).collect();
        let outside = |zone: f64| used.iter().filter(|r| r.distance.abs() > 0.5 * zone).count();
        let picture = |fit: &FormFit| study.as_ref()?.pixel_errors(&micrometres(fit));
        let form = MeasuredForm {
            points: aligned.residuals.len(),
            used: used.len(),
            probe_mm: self.probe_mm,
            terms: fit.iter().flat_map(|fit| fit.terms.iter().map(facts_of)).collect(),
            rest_um: fit.as_ref().map(|fit| 1e3 * fit.rest_mm),
            pixel_error_px: fit.as_ref().and_then(picture),
            surface_profile_mm: zone,
            outside: zone.map(outside),
        };
        (form, used)
    }
}

/// The points in the plan, between the mirror's rims.
fn map(design: &Design, used: &[PointResidual]) -> InspectionMap {
    let flat = |rim: Vec<DVec3>| rim.into_iter().map(DVec3::truncate).collect();
    InspectionMap {
        rims: rims(&design.mirror).into_iter().map(flat).collect(),
        points: used.iter().map(|r| (r.at.truncate(), 1e3 * r.distance)).collect(),
    }
}

fn facts_of(term: &FittedTerm) -> FormTermFacts {
    FormTermFacts {
        term: term.term.key().to_owned(),
        pv_um: 1e3 * term.pv_mm,
        uncertainty_um: 1e3 * term.uncertainty_mm,
    }
}

/// Terms of a form as errors of a made system.
fn micrometres(fit: &FormFit) -> Vec<(Perturbation, f64)> {
    fit.terms.iter().map(|term| (term.term, 1e3 * term.pv_mm)).collect()
}
