//! `morion machining`: what a ball cutter makes of a profile's mirror: the survey, the map of where the ball
//! does not fit, and the as-cut part, written, read back and traced.

use super::as_cut::{FILE, written_as_cut};
use super::run::{Command, Run};
use super::{Error, Stage};
use crate::design::Design;
use crate::geom::TriMesh;
use crate::machining::{
    self, BallRaster, MOST_POINTS, MachiningError, Passes, ROWS, SurfaceAnalysis, bounding_corners,
    facet_estimate, plan_outlines,
};
use crate::mirror::Mirror;
use crate::num::rounding::ceil_two_digits;
use crate::profile::Profile;
use crate::raster::EncodingError;
use crate::report::{Answer, gouge_map};
use crate::results::{AsCutFacts, FileFacts, MachiningReport, RayFault, Reason, ShapeFault};
use crate::verdict::{self, CutterSurvey, FileCheck, MachiningOptions};

/// The most facets of an as-cut face: an STL of 200 MB.
const MOST_FACETS: f64 = 4e6;
/// A ball's radius over the part's size, at most.
const LARGEST: f64 = 10.0;
/// What chords along the lines may add to the slopes of the scallops.
const ALONG: f64 = 0.3;

fn refused(profile: &Profile, source: MachiningError) -> Error {
    Error::Machining { profile: profile.name.clone(), source }
}

impl Command for MachiningOptions {
    type Report = MachiningReport;

    fn check(&self, profile: &Profile) -> Result<(), Error> {
        check(self, profile.part.width_mm).map_err(|source| refused(profile, source))
    }

    fn run(&self, run: &mut Run) -> Result<MachiningReport, Error> {
        let design = run.design()?;
        let mut survey = run.stage(Stage::Cut, || {
            let survey = CutterSurvey::new(run.profile, &design, self)
                .map_err(|source| refused(run.profile, source))?;
            let note = survey.note();
            Ok((survey, note))
        })?;
        let cut = if self.as_cut { cut_face(run, &design, &survey)? } else { Ok(None) };
        match cut {
            Ok(Some(mesh)) => check_as_cut(run, &design, mesh, &mut survey)?,
            Ok(None) => {}
            Err(why) => {
                survey.found.warnings.push(format!("the as-cut part was not made: {why}"));
            }
        }
        let CutterSurvey { gouge, mut found, .. } = survey;
        found.verdict = verdict::of(&found.reasons);
        run.publish(Stage::Report, |files, _| {
            let map = gouge_map(&gouge, self.ball_mm);
            let picture = |error: EncodingError| Error::Picture(error.to_string());
            let png = map.png().map_err(picture)?;
            found.files.push(FileFacts::of("gouge.png", "png", &png));
            files.add_bytes("gouge.png", &png)?;
            files.add_bytes(
                "machining.html",
                found.html(run.profile, &map).map_err(picture)?.as_bytes(),
            )?;
            files.add_report("machining.json", &found.json())?;
            if found.as_cut.is_none() {
                files.remove(FILE);
            }
            Ok(())
        })?;
        Ok(found)
    }
}

/// Holds numbers from outside to what they can mean.
fn check(cutting: &MachiningOptions, width_mm: f64) -> Result<(), MachiningError> {
    let positive = "positive and finite";
    let bad = |option, must: &str, found| {
        Err(MachiningError::Input { option, must: must.to_owned(), found })
    };
    for (option, found) in [
        ("--ball-mm", Some(cutting.ball_mm)),
        ("--stepover-mm", cutting.stepover_mm),
        ("--budget-px", cutting.budget_px),
        ("--scallop-um", cutting.scallop_um),
    ] {
        if let Some(found) = found.filter(|x| !(*x > 0.0 && x.is_finite())) {
            return bad(option, positive, found);
        }
    }
    if !(cutting.allowance_mm >= 0.0 && cutting.allowance_mm.is_finite()) {
        return bad("--allowance-mm", "0 or positive, and finite", cutting.allowance_mm);
    }
    if let Some(angle) = cutting.angle_deg.filter(|angle| !(angle.abs() <= 360.0)) {
        return bad("--angle-deg", "within +-360", angle);
    }
    let largest = LARGEST * width_mm;
    let lengths = [("--ball-mm", cutting.ball_mm), ("--allowance-mm", cutting.allowance_mm)];
    if let Some((option, found)) = lengths.into_iter().find(|(_, mm)| *mm > largest) {
        return bad(option, &format!("at most {largest}, ten times the part's width"), found);
    }
    let finest = 1e-6 * width_mm;
    if let Some((option, found)) =
        [("--ball-mm", Some(cutting.ball_mm)), ("--stepover-mm", cutting.stepover_mm)]
            .into_iter()
            .find_map(|(option, x)| Some((option, x.filter(|x| *x < finest)?)))
    {
        return bad(option, &format!("at least {finest}, a millionth of the part's width"), found);
    }
    if let Some(stepover) = cutting.stepover_mm.filter(|mm| *mm >= 2.0 * cutting.ball_mm) {
        return bad("--stepover-mm", "less than the ball's diameter", stepover);
    }
    Ok(())
}

/// The as-cut face, or why there is none: hollow ground that the ball cannot reach is not cut (a valley's
/// fillet is cut as it is), nor what would have too many facets.
fn cut_face(
    run: &Run,
    design: &Design,
    survey: &CutterSurvey,
) -> Result<Result<Option<TriMesh>, String>, Error> {
    if let Some(reason) = &survey.hollow {
        return Ok(Err(reason.to_string()));
    }
    run.stage(Stage::Mesh, || match as_cut(&design.mirror, &survey.analysis, &survey.raster) {
        Ok(mesh) => {
            let note = format!("{} optical triangles", mesh.triangles.len());
            Ok((Ok(Some(mesh)), note))
        }
        Err(error @ MachiningError::TooFine { .. }) => {
            Ok((Err(error.to_string()), "too fine to be made".to_owned()))
        }
        Err(error) => Err(refused(run.profile, error)),
    })
}

/// Closes the as-cut face, writes it, reads it back and traces it.
fn check_as_cut(
    run: &mut Run,
    design: &Design,
    mesh: TriMesh,
    survey: &mut CutterSurvey,
) -> Result<(), Error> {
    let optical_triangles = mesh.triangles.len();
    let raster = &survey.raster;
    let words = format!("as cut, ball {} step {}", raster.ball_mm, raster.stepover_mm);
    let check = written_as_cut(run, design, (mesh, None), words, &mut |_| {})?;
    let found = &mut survey.found;
    found.reasons.extend(witnessed(&check));
    let errors = check.trace.as_ref().and_then(|trace| trace.errors.facet_error_px);
    if errors.is_some_and(|errors| errors.rms.is_nan()) {
        found.warnings.push(format!(
            "{FILE}: some pixels see what has no place in the image, and no pixel error; a smaller \
             stepover or a larger ball turns rays less"
        ));
    }
    found.files.push(check.file);
    found.as_cut = check.trace.map(|trace| AsCutFacts { optical_triangles, trace });
    Ok(())
}

/// The as-cut face.
fn as_cut(
    mirror: &Mirror,
    survey: &SurfaceAnalysis,
    raster: &BallRaster,
) -> Result<TriMesh, MachiningError> {
    let outlines = plan_outlines(mirror);
    let [lo, hi] = bounding_corners(&outlines);
    let along = |raster: &BallRaster| {
        let across = raster.stepover_mm / ROWS as f64;
        survey.along_mm(raster, ALONG).min(0.02 * (hi - lo).max_element()).max(across)
    };
    let too_many = |raster: &BallRaster| {
        let facets = facet_estimate(&outlines, raster, along(raster));
        let points = Passes::points([lo, hi], raster);
        [(facets, MOST_FACETS, "facets"), (points, MOST_POINTS, "points of passes")]
            .into_iter()
            .find(|(count, most, _)| !(count <= most))
    };
    if let Some((count, _, what)) = too_many(raster) {
        let BallRaster { stepover_mm, .. } = *raster;
        let widest_mm = survey.widest_mm(raster);
        // The first of stepovers 5 % apart that will do.
        let steps = std::iter::successors(Some(stepover_mm), |mm| Some(1.05 * mm));
        let least_mm = steps
            .map(ceil_two_digits)
            .take_while(|mm| *mm <= widest_mm)
            .find(|&stepover_mm| too_many(&BallRaster { stepover_mm, ..*raster }).is_none());
        return Err(MachiningError::TooFine { stepover_mm, count, what, least_mm });
    }
    let passes = Passes::new(mirror, [lo, hi], *raster)?;
    machining::as_cut_face(&outlines, &passes, along(raster))
}

/// What the witness has against the as-cut part, whose shadows and picture are the cutter's survey's.
fn witnessed(check: &FileCheck) -> Vec<Reason> {
    let mut reasons: Vec<Reason> = verdict::bytes(check).map(Reason::from).collect();
    if let Some(trace) = &check.trace {
        let defects = trace.solid.reasons.iter().cloned();
        reasons.extend(defects.map(|defect| ShapeFault::NotSolid(defect).into()));
        let counts =
            |fault: &RayFault| matches!(fault, RayFault::Missed { .. } | RayFault::BackFace { .. });
        reasons.extend(verdict::rays(trace, check.by_rim, 0).filter(counts).map(Reason::from));
    }
    reasons.into_iter().map(|reason| reason.of_file(FILE)).collect()
}
