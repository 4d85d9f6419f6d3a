//! The verdict: what the bytes of a file showed, and every reason why a part would not do, with figures.

mod as_cut_face;
mod axis_faults;
mod bar_on_lathe;
mod closer_picture;
mod cusp_search;
mod cut_slopes;
mod cutter_survey;
mod expected_rays;
mod file_check;
mod milled_block;
mod plan_edge;
mod polar_face;
mod polar_rim;
mod polar_section;
mod program_cut;
mod remedy;
pub(crate) mod sharpness;
mod turned_cut;
mod turned_shape;
mod turns_face;
mod vertex_check;

pub(crate) use as_cut_face::AsCutFace;
pub(crate) use axis_faults::axis_faults;
pub(crate) use bar_on_lathe::{BarOnLathe, CutTask, TurnedLeft};
pub(crate) use cut_slopes::CutSlopes;
pub use cutter_survey::MachiningOptions;
pub(crate) use cutter_survey::{CutterSurvey, analysis_of, directed, stock_corners};
pub(crate) use expected_rays::{RimShift, expected_rays};
pub(crate) use file_check::{CheckedMesh, EachStrip, FileCheck, HeldTo, wanted_picture};
pub(crate) use milled_block::{MilledBlock, ProgramLeft, room_for_picture, stepover_for_picture};
pub(crate) use program_cut::ProgramCut;
pub(crate) use remedy::filling;
pub(crate) use turned_cut::turned_cut;
pub(crate) use turned_shape::TurnedShape;

use crate::align::FormError;
use crate::design::{Cavity, Design};
use crate::geom::{Outline, Precision};
use crate::num::stats::Summary;
use crate::part::codec;
use crate::profile::{AcceptanceLimit, AcceptanceLimits, FileFormat, Profile};
use crate::results::{
    FileFacts, FileFault, LeastFilled, PictureFault, PixelErrorFigure, RayFault, Reason,
    ShapeFault, SharpnessFacts, TraceFacts, Verdict,
};
use crate::trace::FrameFill;

/// What rounding to double precision may move a vertex by, as a share of its coordinates, or a volume.
const ROUNDING: f64 = 1e-12;
/// What rounding to single precision may change a volume by, as a share of it: half a unit of the
/// last of 24 digits along each axis, and a little.
const ROUNDING_SINGLE: f64 = 4.0 / (1 << 24) as f64;
/// What it may move a vertex by, as a share of its largest coordinate: the length of half a unit along
/// each axis.
const ROUNDING_VERTEX: f64 = 1.733 / (1 << 24) as f64;

/// Pass, unless there is a reason.
pub(crate) fn of<T>(reasons: &[T]) -> Verdict {
    if reasons.is_empty() { Verdict::Pass } else { Verdict::Fail }
}

/// Figures of the witness over all mesh files, the limits that they were held to, and why they do not pass.
pub(crate) struct Findings {
    /// The files.
    pub files: Vec<FileFacts>,
    /// Figures of those that could be read.
    pub trace: Vec<TraceFacts>,
    /// The frame as the first of them shows it.
    pub frame: Option<FrameFill>,
    /// Sharpness of the picture through a lens.
    pub sharpness: Option<SharpnessFacts>,
    /// The limits; absent without a projection, and of measured parts.
    pub accepted: Option<AcceptanceLimits>,
    /// Why the files do not pass, each with figures.
    pub reasons: Vec<Reason>,
}

impl Findings {
    /// The findings of `checks`, each held to what was promised of it and to what the profile accepts.
    pub(crate) fn new(profile: &Profile, design: &Design, checks: Vec<FileCheck>) -> Self {
        Self::beside(profile, design, checks, sharpness::sharpness(profile, design))
    }

    /// The same beside the `sharpness` of the picture that `design` gives.
    pub(crate) fn beside(
        profile: &Profile,
        design: &Design,
        checks: Vec<FileCheck>,
        sharpness: Option<SharpnessFacts>,
    ) -> Self {
        let mut reasons: Vec<Reason> =
            checks.iter().flat_map(|check| of_file(profile, design, check)).collect();
        let frame = checks.iter().find_map(|check| check.frame.clone());
        match checks.iter().any(|check| check.held_to == HeldTo::Picture) {
            true => remedy::add_as_cut(&mut reasons),
            false => {
                let (filled, facets) = (least_filled(&checks), facet_errors(design, &checks));
                remedy::add((profile, design), filled, facets, &mut reasons);
            }
        }
        reasons.extend(sharpness::reason(profile, sharpness.as_ref()));
        let held =
            design.view.is_some() && checks.iter().all(|check| check.held_to != HeldTo::Form);
        let accepted = held.then(|| profile.acceptance_limits());
        let (files, trace): (Vec<_>, Vec<_>) =
            checks.into_iter().map(|check| (check.file, check.trace)).unzip();
        let trace = trace.into_iter().flatten().collect();
        Self { files, trace, frame, sharpness, accepted, reasons }
    }
}

/// The least share of the frame that any file fills: all of it where none shows one.
fn least_filled(checks: &[FileCheck]) -> f64 {
    checks.iter().filter_map(|check| Some(check.frame.as_ref()?.filled)).fold(1.0, f64::min)
}

/// The largest facet errors, px, of the files that are as the profile asks for them: a file of another making shows nothing of
/// what other keys would make.
fn facet_errors(design: &Design, checks: &[FileCheck]) -> Option<Summary> {
    let as_asked = |check: &FileCheck| {
        let trace = check.trace.as_ref().filter(|_| check.held_to == HeldTo::Design)?;
        let errors = trace.errors.facet_error_px?;
        let is_kept = check.promise.facet.is_none_or(|(px, _)| errors.max <= px.0 + ROUNDING_PX);
        (is_kept && shape(design, check, trace).is_empty()).then_some(errors)
    };
    checks.iter().filter_map(as_asked).reduce(|a, b| if b.max > a.max { b } else { a })
}

/// Why a file does not pass.
fn of_file(profile: &Profile, design: &Design, check: &FileCheck) -> Vec<Reason> {
    let mut reasons: Vec<Reason> = bytes(check).map(Reason::from).collect();
    if let Some(trace) = &check.trace {
        if check.held_to == HeldTo::Design {
            reasons.extend(shape(design, check, trace).into_iter().map(Reason::from));
        }
        let allowed = shadows_allowed(profile, design, trace.rays);
        reasons.extend(rays(trace, check.by_rim, allowed).map(Reason::from));
        reasons.extend(limits(profile, check, trace).map(Reason::from));
    }
    // A scan may be of a piece; what it is not held to by name, its form answers for.
    let held = |bound: &AcceptanceLimit| !(bound.usual && check.held_to == HeldTo::Form);
    let least = Some(profile.acceptance_limits().frame_filled).filter(held);
    if let (Some(frame), Some(least)) = (&check.frame, least) {
        reasons.extend(unfilled(frame, LeastFilled::Accepted(least)).map(Reason::from));
    }
    reasons.into_iter().map(|reason| reason.of_file(&check.file.name)).collect()
}

/// What is wrong with the bytes of a file.
pub(crate) fn bytes(check: &FileCheck) -> impl Iterator<Item = FileFault> {
    let altered = check.altered.then_some(FileFault::Altered);
    let unreadable = check.unreadable.as_ref();
    altered.into_iter().chain(unreadable.map(|error| FileFault::Unreadable(error.clone())))
}

/// That too little of the frame is filled.
pub(crate) fn unfilled(frame: &FrameFill, least: LeastFilled) -> Option<PictureFault> {
    let FrameFill { filled, tolerance_px, pixels: [width, height], lost, .. } = *frame;
    let share = |count: usize| count as f64 / (f64::from(width) * f64::from(height));
    (!(filled >= least.share())).then_some(PictureFault::FrameFilled {
        filled,
        tolerance_px,
        least,
        hidden: share(lost.obstacle),
        shadowed: share(lost.shadow),
    })
}

/// What the chord error, and the chords of a round rim and of the stock's circles, may take off the
/// volume, mm^3.
fn volume_tolerance(design: &Design, chord_mm: f64) -> f64 {
    if let Some(tool) = &design.tool {
        return tool.volume_tolerance_mm3(&design.mirror, chord_mm);
    }
    let outline = design.mirror.full_outline();
    let within = design.cavity.as_ref().map_or(0.0, Cavity::volume_tolerance_mm3);
    let faces = outline.area() * chord_mm + design.made_body().0.chords_mm3() + within;
    match outline {
        Outline::Rect(_) => faces,
        // Chords that cut EDGE of the radius take 4/3 of that share of the disc.
        Outline::Ring { outer, .. } => {
            let disc = std::f64::consts::PI * outer * outer;
            let top = design.mirror.volume() / disc;
            faces + 4.0 / 3.0 * Outline::EDGE * disc * (top + chord_mm)
        }
    }
}

/// Why a measured part's form does not pass. Where the profile accepts pixel errors up to a limit, the
/// picture decides; otherwise the form is held to `limit_um`, peak to valley without outliers.
pub(crate) fn form(
    profile: &Profile,
    design: &Design,
    error: Option<&FormError>,
    limit_um: f64,
) -> Option<Reason> {
    let accept = &profile.accept;
    let limited = accept.pixel_error_rms_px.or(accept.pixel_error_max_px).is_some();
    if limited && design.view.is_some() {
        return None;
    }
    let pv_um = error.map_or(f64::NAN, |error| error.without_outliers.pv);
    (!(pv_um <= limit_um)).then(|| ShapeFault::FormError { pv_um, limit_um }.into())
}

/// Why a file's mesh is not the designed part, or its curved faces no solid.
fn shape(design: &Design, check: &FileCheck, trace: &TraceFacts) -> Vec<ShapeFault> {
    let chord_mm = check.promise.chord_mm;
    let solid = &trace.solid;
    let mut faults: Vec<_> = solid.reasons.iter().cloned().map(ShapeFault::NotSolid).collect();
    // (What curved faces have of the design is held by the limits of their splines.)
    let FileFormat::Mesh(format) = check.format else { return faults };
    let [rounding, moved] = match codec(format).precision() {
        Precision::Double => [ROUNDING; 2],
        Precision::Single => [ROUNDING_SINGLE, ROUNDING_VERTEX],
    };
    let (found_mm3, designed_mm3) = (solid.check.volume_mm3, solid.volume_expected_mm3);
    let allowed_mm3 = volume_tolerance(design, chord_mm) + rounding * designed_mm3;
    if !((found_mm3 - designed_mm3).abs() <= allowed_mm3) {
        faults.push(ShapeFault::Volume { found_mm3, designed_mm3, allowed_mm3 });
    }
    // A mirror without curvature has no chord error; coordinates are rounded all the same.
    let rounding = |at: [f64; 3]| moved * at.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    if let Some(vertex) = trace.worst_vertex
        && !(vertex.off_mm <= chord_mm + rounding(vertex.at_mm))
    {
        let (at_mm, off_mm) = (vertex.at_mm, vertex.off_mm);
        faults.push(ShapeFault::OffSurface { at_mm, off_mm, limit_mm: chord_mm });
    }
    faults
}

/// Share of the aimed rays that walls between panels may shadow where the profile names no share of the frame: rays that
/// lean towards a wall meet it next to its foot, in every order of some views.
const SHADOWED_BY_WALLS: f64 = 0.03;

/// How many of so many aimed rays the part may shadow. Where a share of the frame is named, it judges shadows of walls too.
fn shadows_allowed(profile: &Profile, design: &Design, rays: usize) -> usize {
    match profile.accept.frame_filled {
        _ if !design.mirror.has_steps() => 0,
        Some(_) => rays,
        None => (SHADOWED_BY_WALLS * rays as f64) as usize,
    }
}

/// Rays that do not reach the world, of those that the part shadows `by_rim` by what is around the mirror; so many that
/// the part may shadow are `allowed`.
pub(crate) fn rays(
    trace: &TraceFacts,
    by_rim: usize,
    allowed: usize,
) -> impl Iterator<Item = RayFault> {
    let TraceFacts { rays, missed, shadowed, back_face, .. } = *trace;
    let too_many = if shadowed > allowed { shadowed } else { 0 };
    let faults = [
        (usize::from(rays == 0), RayFault::NothingAimed),
        (missed, RayFault::Missed { count: missed, rays }),
        (too_many, RayFault::Shadowed { count: shadowed, rays, allowed, by_rim }),
        (back_face, RayFault::BackFace { count: back_face, rays }),
    ];
    faults.into_iter().filter(|(count, _)| *count > 0).map(|(_, fault)| fault)
}

/// What the witness's own arithmetic may add to a facet error: a plane's is nothing else.
const ROUNDING_PX: f64 = 1e-9;

fn limits<'a>(
    profile: &'a Profile,
    check: &'a FileCheck,
    trace: &TraceFacts,
) -> impl Iterator<Item = PictureFault> + use<'a> {
    let errors = &trace.errors;
    let pixel = errors.pixel_error_px;
    let is_made = check.held_to != HeldTo::Form;
    // A measured part's slopes are judged by the picture, not by the limit for facets.
    let facet = errors.facet_error_px.filter(|_| is_made).map(|e| e.max);
    let facet = facet.and_then(|found_px| {
        let limit = check.promise.facet.map(|(px, key)| (px.0, key));
        let over = limit.filter(|(limit_px, _)| !(found_px <= limit_px + ROUNDING_PX));
        let fault =
            over.map(|(limit_px, key)| PictureFault::FacetError { found_px, limit_px, key });
        finite("facet error", found_px).or(fault)
    });
    // A measured part is held to what the profile names.
    let pixels = pixel.into_iter().flat_map(move |errors| {
        pixel_errors(profile, errors, move |limit| is_made || !limit.usual)
    });
    facet.into_iter().chain(pixels)
}

/// Why pixel errors do not pass, of the profile's limits those that are `held`.
pub(crate) fn pixel_errors(
    profile: &Profile,
    errors: Summary,
    held: impl Fn(&AcceptanceLimit) -> bool,
) -> impl Iterator<Item = PictureFault> {
    let accepted = profile.acceptance_limits();
    let figures = [
        (PixelErrorFigure::Rms, errors.rms, accepted.pixel_error_rms_px),
        (PixelErrorFigure::Max, errors.max, accepted.pixel_error_max_px),
    ];
    figures.into_iter().filter_map(move |(figure, found_px, limit)| {
        let is_over = held(&limit) && !(found_px <= limit.value);
        let fault = is_over.then_some(PictureFault::PixelError { figure, found_px, limit });
        finite(figure.name(), found_px).or(fault)
    })
}

/// That an error has no finite value.
fn finite(what: &'static str, found_px: f64) -> Option<PictureFault> {
    (!found_px.is_finite()).then_some(PictureFault::NotFinite { what })
}
