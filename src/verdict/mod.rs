//! The verdict: what the bytes of a file showed, and every reason why a part would not do, with figures.

mod cutter_survey;
mod file_check;
mod remedy;
pub(crate) mod sharpness;
mod vertex_check;

pub(crate) use cutter_survey::CutterSurvey;
pub use cutter_survey::MachiningOptions;
pub(crate) use file_check::{CheckedMesh, FileCheck, expected_rays, tolerance_px};
pub(crate) use remedy::filling;

use crate::align::FormError;
use crate::design::Design;
use crate::geom::{Border, Outline, Precision};
use crate::part::codec;
use crate::profile::{AcceptanceLimit, AcceptanceLimits, Profile};
use crate::results::{FileFacts, Reason, ReasonKind, SharpnessFacts, TraceFacts, Verdict};
use crate::trace::FrameFill;

/// Why a file does not pass that is another than was written.
pub(crate) const ALTERED: &str = "the bytes on the disk are not those that were written";

/// What rounding to double precision may move a vertex by, as a share of its coordinates, or a volume.
const ROUNDING: f64 = 1e-12;
/// What rounding to single precision may change a volume by, as a share of it: half a unit of the
/// last of 24 digits along each axis, and a little.
const ROUNDING_SINGLE: f64 = 4.0 / (1 << 24) as f64;
/// What it may move a vertex by, as a share of its largest coordinate: the length of half a unit along
/// each axis.
const ROUNDING_VERTEX: f64 = 1.733 / (1 << 24) as f64;

/// [`ALTERED`].
pub(crate) fn altered() -> Reason {
    Reason::new(ReasonKind::Altered, ALTERED)
}

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
        remedy::add(profile, design, &mut reasons);
        reasons.extend(sharpness::reason(profile, sharpness.as_ref()));
        let frame = checks.iter().find_map(|check| check.frame.clone());
        let held = design.view.is_some() && checks.iter().all(|check| !check.measured);
        let accepted = held.then(|| profile.acceptance_limits());
        let (files, trace): (Vec<_>, Vec<_>) =
            checks.into_iter().map(|check| (check.file, check.trace)).unzip();
        let trace = trace.into_iter().flatten().collect();
        Self { files, trace, frame, sharpness, accepted, reasons }
    }
}

/// Why a file does not pass.
fn of_file(profile: &Profile, design: &Design, check: &FileCheck) -> Vec<Reason> {
    let mut reasons = Vec::new();
    if check.altered {
        reasons.push(altered());
    }
    if let Some(error) = &check.unreadable {
        reasons.push(Reason::new(ReasonKind::Unreadable, error.to_string()));
    }
    if let Some(trace) = &check.trace {
        if !check.measured {
            reasons.extend(shape(design, check, trace));
        }
        reasons.extend(rays(trace, check.by_rim));
        reasons.extend(limits(profile, check, trace));
    }
    // A scan may be of a piece; what it is not held to by name, its form answers for.
    let held = |bound: &AcceptanceLimit| !(bound.usual && check.measured);
    let least = Some(profile.acceptance_limits().frame_filled).filter(held);
    if let (Some(frame), Some(least)) = (&check.frame, least)
        && !(frame.filled >= least.value)
    {
        reasons.push(unfilled(frame, least));
    }
    reasons.into_iter().map(|reason| reason.of_file(&check.file.name)).collect()
}

/// That too little of the frame is filled.
fn unfilled(frame: &FrameFill, least: AcceptanceLimit) -> Reason {
    let key = "accept.frame_filled";
    let words = if least.usual {
        format!("are usual ({key} sets another share)")
    } else {
        format!("are accepted ({key})")
    };
    let sentence = format!(
        "{:.3} % of the frame see their part of the world within {} px, {:.3} % {words}",
        100.0 * frame.filled,
        frame.tolerance_px,
        100.0 * least.value
    );
    Reason::new(ReasonKind::FrameFilled, sentence)
}

/// What the chord error, and the chords of a round rim and of the stock's circles, may take off the
/// volume, mm^3.
fn volume_tolerance(design: &Design, chord_mm: f64) -> f64 {
    let outline = design.mirror.full_outline();
    let stock = design.border.as_ref().map_or(0.0, Border::chords_mm3);
    let faces = outline.area() * chord_mm + stock;
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
    let pv = error.map_or(f64::NAN, |error| error.without_outliers.pv);
    (!(pv <= limit_um)).then(|| {
        let sentence = format!(
            "form error {pv:.3} um PV without outliers, over {limit_um} um (mesh.chord_um); give \
             accept.pixel_error_max_px to judge it by the picture"
        );
        Reason::new(ReasonKind::FormError, sentence)
    })
}

/// Why a file's mesh is not the designed part.
fn shape(design: &Design, check: &FileCheck, trace: &TraceFacts) -> Vec<Reason> {
    let chord_mm = check.promise.chord_mm;
    let [rounding, moved] = match codec(check.format).precision() {
        Precision::Double => [ROUNDING; 2],
        Precision::Single => [ROUNDING_SINGLE, ROUNDING_VERTEX],
    };
    let volume_tolerance = volume_tolerance(design, chord_mm) + rounding * design.volume();
    let solid = &trace.solid;
    let not_solid = |sentence: &String| Reason::new(ReasonKind::NotSolid, sentence);
    let mut reasons: Vec<Reason> = solid.reasons.iter().map(not_solid).collect();
    let off = solid.check.volume_mm3 - solid.volume_expected_mm3;
    if !(off.abs() <= volume_tolerance) {
        let sentence = format!(
            "volume {:.4} mm^3 where the design has {:.4}, off by {off:.4}, over the {:.4} that the \
             chord error explains",
            solid.check.volume_mm3, solid.volume_expected_mm3, volume_tolerance
        );
        reasons.push(Reason::new(ReasonKind::Volume, sentence));
    }
    // A mirror without curvature has no chord error; coordinates are rounded all the same.
    let rounding = |at: [f64; 3]| moved * at.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    if let Some(vertex) = trace.worst_vertex
        && !(vertex.off_mm <= chord_mm + rounding(vertex.at_mm))
    {
        let [x, y, z] = vertex.at_mm;
        let sentence = format!(
            "the vertex ({x}, {y}, {z}) is {:.6} mm off the designed part, over {chord_mm:.6} mm",
            vertex.off_mm
        );
        reasons.push(Reason::new(ReasonKind::OffSurface, sentence));
    }
    reasons
}

fn rays(trace: &TraceFacts, by_rim: usize) -> Vec<Reason> {
    let mut reasons = Vec::new();
    if trace.rays == 0 {
        let sentence = "no camera ray is aimed at the mirror";
        reasons.push(Reason::new(ReasonKind::NothingAimed, sentence));
    }
    for (kind, count, what) in [
        (ReasonKind::Missed, trace.missed, "miss the part"),
        (ReasonKind::Shadowed, trace.shadowed, "are shadowed by the part itself"),
        (ReasonKind::BackFace, trace.back_face, "meet the back of a facet"),
    ] {
        if count > 0 {
            let mut sentence = format!("{count} of {} rays aimed at the mirror {what}", trace.rays);
            if kind == ReasonKind::Shadowed && by_rim > 0 {
                sentence += &format!(
                    ", {by_rim} of them by its flat rim: lower part.rim_mm, raise base_mm or narrow \
                     border_mm"
                );
            }
            reasons.push(Reason::new(kind, sentence));
        }
    }
    reasons
}

/// What the witness's own arithmetic may add to a facet error: a plane's is nothing else.
const ROUNDING_PX: f64 = 1e-9;

fn limits(profile: &Profile, check: &FileCheck, trace: &TraceFacts) -> Vec<Reason> {
    let errors = &trace.errors;
    let accepted = profile.acceptance_limits();
    let pixel = errors.pixel_error_px;
    let is_made = !check.measured;
    // A measured part's slopes are judged by the picture, not by the limit for facets.
    let facet = errors.facet_error_px.filter(|_| is_made).map(|e| e.max);
    let (limit, key) = check.promise.facet.map_or((None, ""), |(px, key)| (Some(px.0), key));
    // A measured part is held to what the profile names.
    let held = |bound: AcceptanceLimit| Some(bound).filter(|bound| is_made || !bound.usual);
    let of = |bound: Option<AcceptanceLimit>, key: &str, share: f64| match bound {
        Some(AcceptanceLimit { usual: true, .. }) => {
            format!(
                "that are usual, {} % of the frame's width ({key} sets another limit)",
                100.0 * share
            )
        }
        _ => format!("of {key}"),
    };
    let rms = held(accepted.pixel_error_rms_px);
    let max = held(accepted.pixel_error_max_px);
    let value = |bound: Option<AcceptanceLimit>| bound.map(|bound| bound.value);
    let rms_words = of(rms, "accept.pixel_error_rms_px", AcceptanceLimits::RMS);
    let max_words = of(max, "accept.pixel_error_max_px", AcceptanceLimits::MAX);
    let (kind, whole) = (ReasonKind::PixelError, ReasonKind::FacetError);
    [
        (whole, "facet error", facet, limit, ROUNDING_PX, format!("of {key}")),
        (kind, "RMS pixel error", pixel.map(|e| e.rms), value(rms), 0.0, rms_words),
        (kind, "largest pixel error", pixel.map(|e| e.max), value(max), 0.0, max_words),
    ]
    .into_iter()
    .filter_map(|(kind, what, found, limit, rounding, words)| match (found?, limit) {
        (found, _) if !found.is_finite() => {
            Some(Reason::new(ReasonKind::NotFinite, format!("{what} is not finite")))
        }
        (found, Some(limit)) if !(found <= limit + rounding) => {
            let sentence = format!("{what} {found:.3} px, over the {limit} px {words}");
            Some(Reason::new(kind, sentence))
        }
        _ => None,
    })
    .collect()
}
