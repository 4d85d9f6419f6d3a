//! What a ball cutter makes of a profile's mirror: the survey, the map of where the ball does not fit, and
//! the as-cut part, written, read back and traced.

use super::check_file::{FileCheck, check_file};
use super::files::{Folder, sha256};
use super::observer::StageTimer;
use super::{Error, Observer, Source, Stage, designed, labelled, verdict};
use crate::design::Design;
use crate::export::{stl_bytes, write_stl};
use crate::geom::{Contour, DVec2, DVec3, Precision, TriMesh};
use crate::machining::{
    self, BallRaster, FLOOR_MM, Fillet, Gouge, MOST_POINTS, MachiningError, Passes, ROWS,
    ScallopFigures, SurfaceAnalysis, bounding_corners, facet_estimate, plan_outlines,
};
use crate::mirror::Mirror;
use crate::num::rounding::{ceil_two_digits, floor_four_digits};
use crate::num::{degrees, radians};
use crate::profile::{Format, Profile};
use crate::report::{
    Answer, AsCutFacts, BestFacts, BudgetFacts, FileFacts, GougeFacts, MachiningReport, ProfileId,
    ReachFacts, SCHEMA, StockFacts, Verdict, gouge_picture,
};
use crate::solid::Solid;
use std::path::Path;

/// How a mirror is to be cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MachiningOptions {
    /// Radius of the ball, mm.
    pub ball_mm: f64,
    /// Distance of the raster's lines in the plan, mm; none for the largest that keeps both budgets.
    pub stepover_mm: Option<f64>,
    /// Their direction from X towards Y, degrees; none for the one that is best for the pixels, or for the
    /// scallops' height where there is no projection.
    pub angle_deg: Option<f64>,
    /// Pixel error that 95 % of the unpolished face may not exceed; none for the largest that a build is
    /// held to.
    pub budget_px: Option<f64>,
    /// Height that no scallop may exceed, um.
    pub scallop_um: Option<f64>,
    /// What the stock stands over the part on its sides and on top, mm.
    pub allowance_mm: f64,
    /// Whether the as-cut part is made.
    pub as_cut: bool,
}

/// The most facets of an as-cut face: an STL of 200 MB.
const MOST_FACETS: f64 = 4e6;
/// A ball's radius over the part's size, at most.
const LARGEST: f64 = 10.0;
/// What chords along the lines may add to the slopes of the scallops.
const ALONG: f64 = 0.3;
/// The stepover over the ball's radius at which directions are found where none is asked for.
const FIRST_STEPOVER: f64 = 0.05;
const FILE: &str = "as-cut.stl";

/// Works out what `cutting` leaves of the mirror of `source`, and writes `gouge.png`, `machining.json` and, where
/// the ball fits, `as-cut.stl` into `out`/NAME.
///
/// # Errors
/// [`enum@Error`] when it cannot be done; then nothing under `out` has changed but for new, empty folders. (A
/// ball that does not fit and a budget that is not kept are negative verdicts.)
pub fn machining(
    source: &Source,
    cutting: &MachiningOptions,
    out: &Path,
    observer: &dyn Observer,
) -> Result<MachiningReport, Error> {
    let profile = &source.profile;
    let refused = |source| Error::Machining { profile: profile.name.clone(), source };
    check(cutting, profile.part.width_mm).map_err(refused)?;
    let clock = StageTimer::new(observer);
    let folder = Folder::create(&out.join(&profile.name))?;
    let design = clock.stage(Stage::Design, || designed(source))?;
    let mirror = &design.mirror;

    let (Surveyed { survey, raster, gouge, hollow }, mut found) =
        clock.stage(Stage::Cut, || {
            let (surveyed, found) = surveyed(profile, &design, cutting).map_err(refused)?;
            let note = scalloped(&found);
            Ok::<_, Error>(((surveyed, found), note))
        })?;
    // A valley's fillet is cut as it is; hollow ground that the ball cannot reach is not.
    if let (true, Some(reason)) = (cutting.as_cut, &hollow) {
        found.warnings.push(format!("the as-cut part was not made: {reason}"));
    }

    let mut files = Vec::new();
    let mut cut = None;
    if cutting.as_cut && hollow.is_none() {
        let mesh = clock.stage(Stage::Mesh, || {
            let mesh = match as_cut(mirror, &survey, &raster) {
                Err(error @ MachiningError::TooFine { .. }) => Err(error.to_string()),
                made => Ok(made.map_err(refused)?),
            };
            let note = match &mesh {
                Ok(mesh) => format!("{} optical triangles", mesh.triangles.len()),
                Err(_) => "too fine to be made".to_owned(),
            };
            Ok::<_, Error>((mesh, note))
        })?;
        cut = mesh
            .map_err(|why| found.warnings.push(format!("the as-cut part was not made: {why}")))
            .ok();
    }
    if let Some(mesh) = cut {
        let optical_triangles = mesh.triangles.len();
        let solid = clock.stage(Stage::Solid, || close(profile, &design, mesh))?;
        folder.ensure_space(stl_bytes(solid.mesh().triangles.len()))?;
        let as_cut = format!("as cut, ball {} step {}", raster.ball_mm, raster.stepover_mm);
        let label = labelled(profile, &design, as_cut);
        let staged = clock.stage(Stage::Write, || {
            let staged = folder.stage(FILE, |mut out| write_stl(&mut out, &solid, &label))?;
            clock.written(staged.path());
            Ok::<_, Error>((staged, FILE.to_owned()))
        })?;
        drop(solid);
        // What is cut ends at the mirror's rim.
        let bytes = staged.read()?;
        let mut evidence = check_file(&clock, profile, &design, Format::Stl, bytes, 0.0);
        evidence.rename(FILE.to_owned());
        evidence.altered = evidence.file.sha256 != staged.sha256();
        found.reasons.extend(witnessed(&evidence));
        let errors = evidence.trace.as_ref().and_then(|trace| trace.errors.facet_error_px);
        if errors.is_some_and(|errors| errors.rms.is_nan()) {
            found.warnings.push(format!(
                "{FILE}: some pixels see what has no place in the image, and no pixel error; a smaller \
                 stepover or a larger ball turns rays less"
            ));
        }
        found.files.push(evidence.file);
        found.as_cut = evidence.trace.map(|trace| AsCutFacts { optical_triangles, trace });
        files.push(staged);
    }
    found.verdict = verdict::of(&found.reasons);

    clock.stage(Stage::Report, || {
        let png = gouge_picture(&gouge, cutting.ball_mm)
            .map_err(|error| Error::Picture(error.to_string()))?;
        found.files.push(FileFacts {
            name: "gouge.png".to_owned(),
            format: "png".into(),
            bytes: png.len() as u64,
            sha256: sha256(&png),
        });
        files.push(folder.stage("gouge.png", |out| out.write_all(&png))?);
        let json = found.json();
        files.push(folder.stage("machining.json", |out| out.write_all(json.as_bytes()))?);
        let stale = if found.as_cut.is_none() { &[FILE][..] } else { &[] };
        folder.replace(files, stale)?;
        Ok::<_, Error>(((), folder.path().display().to_string()))
    })?;
    Ok(found)
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

/// The best directions, and the raster in the one asked for or the best to a hundredth of a degree.
fn directed(survey: &SurfaceAnalysis, cutting: &MachiningOptions) -> (BestFacts, BallRaster) {
    let ball_mm = cutting.ball_mm;
    // Directions hardly depend on it.
    let stepover_mm = cutting.stepover_mm.unwrap_or(FIRST_STEPOVER * ball_mm);
    let raster = BallRaster { ball_mm, stepover_mm, angle: 0.0 };
    let (pixels, height) = (survey.best_for_pixels(&raster), survey.best_for_height(&raster));
    let best = (100.0 * pixels.unwrap_or(height).angle_deg).round() / 100.0;
    let angle = radians(cutting.angle_deg.unwrap_or(best));
    (BestFacts { pixels, height }, BallRaster { angle, ..raster })
}

/// Everything but the as-cut part, of a mirror as designed.
///
/// # Errors
/// [`Error::Machining`] when the raster cannot be worked out.
pub(super) fn survey(
    profile: &Profile,
    design: &Design,
    cutting: &MachiningOptions,
) -> Result<MachiningReport, Error> {
    let refused = |source| Error::Machining { profile: profile.name.clone(), source };
    Ok(surveyed(profile, design, cutting).map_err(refused)?.1)
}

/// The stage's result in a few words.
pub(super) fn scalloped(found: &MachiningReport) -> String {
    found.scallops.as_ref().map_or("the ball fits nowhere".to_owned(), |found| {
        format!("scallops of {:.3} um at most", found.scallop_um.value)
    })
}

/// What the as-cut part is made by.
struct Surveyed<'a> {
    survey: SurfaceAnalysis<'a>,
    raster: BallRaster,
    gouge: Gouge,
    /// Why the ball does not reach all of the face but a valley, if so.
    hollow: Option<String>,
}

fn surveyed<'a>(
    profile: &Profile,
    design: &'a Design,
    cutting: &MachiningOptions,
) -> Result<(Surveyed<'a>, MachiningReport), MachiningError> {
    let mirror = &design.mirror;
    let survey = SurfaceAnalysis::new(mirror, &design.camera, design.view.as_ref());
    let (best, mut raster) = directed(&survey, cutting);
    let view = design.view.as_ref();
    let usual_px = view.map(|_| profile.acceptance_limits().pixel_error_max_px.value);
    let budget_px = cutting.budget_px.or(usual_px);
    let least_hollow_mm = survey.least_hollow_mm();
    // But for rounding.
    let tight = least_hollow_mm.filter(|least| cutting.ball_mm > least.value * (1.0 + 1e-9));
    let hollow = tight.map(|least| DVec3::from_array(least.at_mm).truncate());
    let gouge =
        Gouge::new(mirror, bounding_corners(&plan_outlines(mirror)), cutting.ball_mm, hollow);
    let for_pixels = budget_px.and_then(|px| survey.stepover_for_pixels(&raster, px));
    let for_height =
        cutting.scallop_um.and_then(|um| survey.stepover_for_height(&raster, 1e-3 * um));
    if cutting.stepover_mm.is_none() {
        let most = for_pixels.into_iter().chain(for_height).reduce(f64::min);
        // (Written down it still keeps them.)
        raster.stepover_mm = most.map_or(raster.stepover_mm, floor_four_digits);
    }
    let scallops = survey.figures(&raster)?;
    let fillet = Fillet::new(mirror, &design.camera, cutting.ball_mm);
    let budget = BudgetFacts {
        p95_px: budget_px,
        stepover_for_px_mm: for_pixels,
        scallop_um: cutting.scallop_um,
        stepover_for_scallop_mm: for_height,
    };
    let mut reasons = Vec::new();
    let over = |found: f64, limit: Option<f64>| limit.filter(|limit| !(found <= *limit));
    let digits = |mm: Option<f64>| {
        mm.map_or("none".to_owned(), |mm| format!("{} mm", floor_four_digits(mm)))
    };
    let pixel_error_px = scallops.as_ref().and_then(|found| found.pixel_error_px);
    if let Some((error, budget_px)) =
        pixel_error_px.and_then(|e| Some((e.p95, over(e.p95, budget_px)?)))
    {
        reasons.push(format!(
            "the unpolished face has a pixel error of {error:.3} px (95 % of it), over {budget_px} px; \
             a stepover of {} keeps it",
            digits(budget.stepover_for_px_mm)
        ));
    }
    let highest = scallops.as_ref().map(|found| found.scallop_um.value);
    if let Some((height, limit)) = highest.and_then(|um| Some((um, over(um, cutting.scallop_um)?)))
    {
        reasons.push(format!(
            "scallops are up to {height:.3} um high, over {limit} um; a stepover of {} keeps it",
            digits(budget.stepover_for_scallop_mm)
        ));
    }
    if let Some(fillet) = &fillet {
        reasons.push(format!(
            "the ball leaves a fillet of {:.3} mm width in the valley, which takes {:.0} pixels",
            fillet.width_max_mm, fillet.pixels
        ));
    }
    let mut warnings = Vec::new();
    if cutting.budget_px.is_some() && design.view.is_none() {
        warnings
            .push("without a projection there is no pixel error to hold a budget to".to_owned());
    }
    warnings.extend(scallops.as_ref().and_then(unseen));
    let [low, high] = survey.heights_mm();
    let foot = design.border.as_ref().map_or(0.0, |stock| stock.top_mm);
    let mut found = MachiningReport {
        schema: SCHEMA,
        profile: ProfileId { name: profile.name.clone(), sha256: profile.sha256.clone() },
        ball_mm: cutting.ball_mm,
        stepover_mm: raster.stepover_mm,
        angle_deg: degrees(raster.angle),
        steepest_deg: survey.steepest_deg(),
        least_hollow_mm,
        gouge: GougeFacts {
            fits: gouge.largest.is_none() && fillet.is_none() && scallops.is_some(),
            left_max_um: gouge.largest.map_or(0.0, |most| 1e3 * most.0),
            at_mm: gouge.largest.map(|most| most.1.to_array()),
            share: gouge.share(),
            step_mm: gouge.step,
        },
        fillet,
        scallops,
        design_pixel_error_px: design.facts.pixel_error_px,
        best,
        budget,
        reach: ReachFacts { face_mm: high - low, wall_mm: high - foot },
        stock: stock(design, high, cutting.allowance_mm),
        as_cut: None,
        files: Vec::new(),
        verdict: Verdict::Pass,
        reasons,
        warnings,
    };
    let hollow = unreached(&gouge, &found, tight.is_some());
    found.reasons.extend(hollow.clone());
    found.verdict = verdict::of(&found.reasons);
    Ok((Surveyed { survey, raster, gouge, hollow }, found))
}

/// The box around the part, whose highest place is at `high`.
fn stock(design: &Design, high: f64, allowance_mm: f64) -> StockFacts {
    let size = match design.border.as_ref().map(|stock| stock.contour) {
        Some(Contour::Rect { half, .. }) => 2.0 * half,
        Some(Contour::Circle { radius_mm }) => DVec2::splat(2.0 * radius_mm),
        None => {
            let [lo, hi] = bounding_corners(&plan_outlines(&design.mirror));
            hi - lo
        }
    };
    let [x, y] = [size.x, size.y].map(|side| side + 2.0 * allowance_mm);
    let z = high + allowance_mm;
    let (volume_mm3, part_mm3) = (x * y * z, design.volume());
    StockFacts {
        size_mm: [x, y, z],
        allowance_mm,
        volume_mm3,
        part_mm3,
        removed_mm3: volume_mm3 - part_mm3,
    }
}

/// Why the ball does not reach all of the face but a valley, if so; `tight` where the ground is hollow with a smaller
/// radius.
fn unreached(gouge: &Gouge, found: &MachiningReport, tight: bool) -> Option<String> {
    let ball = found.ball_mm;
    let nowhere = found.scallops.is_none();
    let Some((left, at)) = gouge.largest_outside_fillet else {
        return nowhere.then(|| format!("the ball of {ball} mm fits nowhere on the mirror"));
    };
    let fits = if nowhere { "fits nowhere on the mirror" } else { "does not fit" };
    let left = if left > FLOOR_MM {
        format!("up to {:.3} um", 1e3 * left)
    } else {
        format!("less than {} um", 1e3 * FLOOR_MM)
    };
    let share = 100.0 * gouge.share();
    let left = format!("leaves {left}, and something on {share:.2} % of the face");
    Some(match found.least_hollow_mm.filter(|_| tight) {
        Some(least) => format!(
            "the ball of {ball} mm {fits}: at X {:.3} mm, Y {:.3} mm the mirror is hollow with a radius of {:.4} mm; \
             it {left}",
            least.at_mm[0], least.at_mm[1], least.value
        ),
        None => format!(
            "the ball of {ball} mm {fits}: at X {:.3} mm, Y {:.3} mm other ground is in its way, and it {left}",
            at.x, at.y
        ),
    })
}

/// What the pixels' figures leave out.
fn unseen(figures: &ScallopFigures) -> Option<String> {
    let ScallopFigures { pixels, pixels_unbounded, .. } = *figures;
    if pixels == 0 {
        return Some(
            "no pixel sees the mirror where the ball fits: nothing is known of pixels".to_owned(),
        );
    }
    (pixels_unbounded > 0).then(|| {
        format!(
            "{pixels_unbounded} of the {pixels} pixels looked at are moved by no finite number of pixels, and left \
             out of the pixel error"
        )
    })
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

fn close(profile: &Profile, design: &Design, mesh: TriMesh) -> Result<(Solid, String), Error> {
    let solid =
        Solid::from_face(&mesh, design.border.as_ref(), Precision::Single).map_err(|source| {
            Error::Solid { profile: profile.name.clone(), format: Format::Stl, source }
        })?;
    let note = format!("{} triangles, closed", solid.mesh().triangles.len());
    Ok((solid, note))
}

/// What the witness has against the as-cut part.
fn witnessed(evidence: &FileCheck) -> Vec<String> {
    let mut reasons = Vec::new();
    if evidence.altered {
        reasons.push(verdict::ALTERED.to_owned());
    }
    reasons.extend(evidence.unreadable.as_ref().map(ToString::to_string));
    if let Some(trace) = &evidence.trace {
        reasons.extend(trace.solid.reasons.iter().cloned());
        let ends = [(trace.missed, "miss the part"), (trace.back_face, "meet the back of a facet")];
        for (count, what) in ends.into_iter().filter(|(count, _)| *count > 0) {
            reasons.push(format!("{count} of {} rays aimed at the mirror {what}", trace.rays));
        }
    }
    reasons.into_iter().map(|reason| format!("{FILE}: {reason}")).collect()
}
