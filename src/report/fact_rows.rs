//! Facts of the mirror, its mesh and what the witness saw, in words.

use super::answer::{AnswerRows, ToRows};
use crate::design::{CurlFacts, DesignFacts, DividingLineFacts, MapFacts, Mounting, Straightness};
use crate::mirror::{Departure, Form};
use crate::num::stats::Summary;
use crate::profile::{AcceptanceLimit, AcceptanceLimits};
use crate::results::{
    ErrorFacts, Limited, MeshFacts, PmiFacts, SagFacts, SolidFacts, StepFacts, TraceFacts, digits,
    error_px, figures, of_at_most, percent, three_digits,
};
use crate::solid::OpenBoundary;
use crate::trace::FrameFill;

impl ToRows for Mounting {
    fn add_to(&self, rows: &mut AnswerRows) {
        rows.add("part", format!("{}, its base at Z = 0", self.size()));
        let above = self.pupil_mm.map_or(String::new(), |[.., z]| {
            format!(", {:.3} mm above the mirror's mean height", z - self.mean_mm)
        });
        rows.add("camera", format!("{}{above}, {}", self.camera(), self.looks()));
        rows.details(|rows| rows.add("world", self.world()));
    }
}

impl ToRows for DesignFacts {
    fn add_to(&self, rows: &mut AnswerRows) {
        let Self { method, degree, unknowns, .. } = self;
        let goal = if self.minimax { ", minimax" } else { "" };
        let method = match *unknowns {
            0 => method.clone(),
            _ => format!("{method}{goal} of degree {degree}, {unknowns} unknowns"),
        };
        let [ray, pixel] = [self.ray_error_mrad, self.pixel_error_px].map(figures);
        rows.terminal("design", format!("{method}; ray error {ray} mrad, pixel error {pixel} px"));
        rows.page("method", method);
        let number = |x: Option<f64>| x.map_or("none".into(), |x| format!("{x:.9e}"));
        rows.page("condition of the fit", number(self.condition));
        rows.page("gradient residual", number(self.gradient_residual));
        let curl = |c: CurlFacts| {
            let CurlFacts { rms, max, condition, rounding } = c;
            format!(
                "{rms:.4e} rms, {max:.4e} max, of which rounding at most {rounding:.1e}; condition \
                 {condition:.1}"
            )
        };
        rows.page("curl of the field", self.curl.map_or("none".into(), curl));
        rows.page("design: ray error, mrad", ray);
        rows.page("design: pixel error, px", pixel);
        if let (Some(curl), 1..) = (self.curl, self.unknowns) {
            rows.named("why", "why not less", why_not_less(&curl, self));
        }
    }
}

/// Why a designed mirror has the error that it has, and what would have less.
fn why_not_less(curl: &CurlFacts, design: &DesignFacts) -> String {
    let degree = design.degree;
    if curl.max <= curl.rounding {
        return format!(
            "a mirror without error exists; what is left is that of degree {degree}, and falls as the degree rises"
        );
    }
    let spread = match design.minimax {
        true => "the largest is the least of this degree",
        false => {
            "the fit's mean square is the least of this degree, minimax = true lowers the largest"
        }
    };
    format!(
        "no single mirror is without error: it is one function of the image point, the picture asks for two slopes at each, \
         and these are those of no surface (curl up to {}); {spread}; a narrower field, another centre, `mirrored` the \
         other way, another law or a panel for each part leaves less",
        three_digits(curl.max)
    )
}

impl ToRows for MapFacts {
    fn add_to(&self, rows: &mut AnswerRows) {
        let Self { samples: [columns, height], gaps, interpolation_px } = *self;
        let px = three_digits(interpolation_px);
        let mut sentence = format!("{columns} x {height} samples, between them good to {px} px");
        if gaps > 0.0 {
            sentence += &format!("; {} % of them may show anything", three_digits(100.0 * gaps));
        }
        rows.named("map", "wanted picture", sentence);
    }
}

impl ToRows for Straightness {
    fn add_to(&self, rows: &mut AnswerRows) {
        let (px, percent) = (error_px(self.departure_px), three_digits(self.departure_percent));
        let share = match self.departure_px {
            1e-3.. => format!(", {percent} % of the width"),
            _ => String::new(),
        };
        let sentence = format!("the design bends straight ones by {px} px at most{share}");
        rows.named("lines", "straight lines", sentence);
    }
}

impl ToRows for DividingLineFacts {
    fn add_to(&self, rows: &mut AnswerRows) {
        let px = error_px(self.departure_px);
        let sentence = format!(
            "those between panels are off the profile's edges by {px} px at most in the picture"
        );
        rows.named("lines", "lines between panels", sentence);
    }
}

impl ToRows for Form {
    fn add_to(&self, rows: &mut AnswerRows) {
        let Self { sphere, plane } = self;
        let of = |departure: &Departure| {
            let Departure { sag_pv_mm, pv_mm, largest_mm, normal_max_mrad } = *departure;
            let sag = sag_pv_mm.map_or(String::new(), |mm| format!("sag {} mm PV, ", digits(mm)));
            let [pv, largest, turned] = [pv_mm, largest_mm, normal_max_mrad].map(digits);
            format!(
                "{sag}square to it {pv} mm PV, {largest} mm at most, normals {turned} mrad at most"
            )
        };
        let radius = match sphere.radius_of_curvature_mm {
            Some(mm) if mm > 0.0 => format!("a hollow sphere of {} mm radius", digits(mm)),
            Some(mm) => format!("a bulging sphere of {} mm radius", digits(-mm)),
            None => "no sphere but a plane".into(),
        };
        let [sphere, plane] = [of(&sphere.departure), of(&plane.departure)];
        let sentence = format!("departure from {radius}: {sphere}; from a plane: {plane}");
        rows.named("form", "best-fit sphere and plane", sentence);
    }
}

impl ToRows for MeshFacts {
    fn add_to(&self, rows: &mut AnswerRows) {
        let limited = |value: &Limited, unit: &str| match value.limit {
            Some(limit) => format!("{} of {limit} {unit}", digits(value.bound)),
            None => format!("{} {unit} (no limit)", digits(value.bound)),
        };
        let [chord, facet] = [limited(&self.chord_um, "um"), limited(&self.facet_px, "px")];
        let [optical, all] = [self.optical_triangles, self.triangles];
        let most = of_at_most(self.max_triangles);
        rows.terminal(
            "mesh",
            format!(
                "{optical} optical triangles ({all} in all{most}); chord {chord}, facet {facet}"
            ),
        );
        rows.page("triangles", format!("{optical} optical, {all} in all{most}"));
        rows.page("chord", chord);
        rows.page("facet", facet);
        let over = |o: Option<f64>| o.map_or("none".into(), |o| format!("{o:.2}"));
        let [chord, facet] = [self.over_optimum.chord, self.over_optimum.facet].map(over);
        rows.page("over the least possible", format!("chord {chord}, facet {facet}"));
    }
}

impl ToRows for SolidFacts {
    fn add_to(&self, rows: &mut AnswerRows) {
        rows.add("solid", solid_sentence(self));
    }
}

impl ToRows for StepFacts {
    fn add_to(&self, rows: &mut AnswerRows) {
        let ([u, v], error) = (self.control_points, digits(self.fit_error_nm));
        let sentence = format!("{u} x {v} control points, within {error} nm of the design");
        rows.named("step", "STEP splines", sentence);
        if let Some(pmi) = &self.pmi {
            rows.named("pmi", "STEP tolerance", pmi_sentence(pmi));
        }
        if let Some(body) = &self.body {
            let sentence = format!(
                "one closed solid of {} faces and {} edges, {:.6} mm^3; on {} rays from the camera its mirror is \
                 within {} nm and {:.1e} rad of the design",
                body.faces,
                body.edges,
                body.volume_mm3,
                body.rays,
                digits(body.surface_error_nm),
                body.normal_error_rad,
            );
            rows.page("STEP read back", sentence);
        }
    }
}

/// Datum features and tolerance of a part in words.
pub(super) fn pmi_sentence(pmi: &PmiFacts) -> String {
    let datums = pmi.datums.join(", ");
    let profile = match (pmi.surface_profile_mm, &pmi.limited_by) {
        (Some(mm), Some(term)) => {
            format!("profile of the mirror within {} mm, which {term} limits", digits(mm))
        }
        _ => "no tolerance, as the design leaves no room in the limits of the picture".into(),
    };
    format!("datums {datums}; {profile}")
}

impl ToRows for SagFacts {
    fn add_to(&self, rows: &mut AnswerRows) {
        let sentence = format!(
            "{} rows; heights within {:.1e} mm of the design, normals within {:.1e} rad",
            self.rows, self.height_error_mm, self.normal_error_rad
        );
        rows.named("table", "sag table", sentence);
    }
}

/// The pixel errors of the file with the largest of them, px; none where none was traced.
pub(super) fn worst_pixel_error(traces: &[TraceFacts]) -> Option<Summary> {
    let errors = traces.iter().filter_map(|trace| trace.errors.pixel_error_px);
    errors.max_by(|a, b| a.max.total_cmp(&b.max))
}

/// The picture in plain words: how far it is off, and what it shows.
pub(super) struct PlainPicture<'a> {
    /// Traces of the files, of which the worst counts.
    pub traces: &'a [TraceFacts],
    /// The frame.
    pub frame: Option<&'a FrameFill>,
    /// What it is held to.
    pub accepted: Option<&'a AcceptanceLimits>,
}

impl ToRows for PlainPicture<'_> {
    fn add_to(&self, rows: &mut AnswerRows) {
        let worst = worst_pixel_error(self.traces);
        if let Some(found) = worst {
            let allowed = self.accepted.map_or(String::new(), |accepted| {
                let [rms, max] = [accepted.pixel_error_rms_px, accepted.pixel_error_max_px];
                let usual = if rms.usual && max.usual { " as usual" } else { "" };
                format!("; allowed{usual} {} and {}", rms.value, max.value)
            });
            let [rms, max] = [found.rms, found.max].map(error_px);
            rows.terminal("picture", format!("off by {rms} px RMS, {max} at most{allowed}"));
        }
        if let Some(frame) = self.frame {
            let [width, height] = frame.pixels;
            let range = |[lo, hi]: [f64; 2]| format!("{lo:.1} to {hi:.1} deg");
            // (Half a pixel and the mirror's error are missing at both ends.)
            let around = |[lo, hi]: [f64; 2]| match hi - lo {
                356.0.. => "360 deg around".to_owned(),
                _ => format!("azimuth {}", range([lo, hi])),
            };
            let azimuth = frame.azimuth_deg.map_or("nothing seen".into(), around);
            let elevation =
                frame.elevation_deg.map_or(String::new(), |e| format!(", elevation {}", range(e)));
            let filled = (1e3 * frame.filled).floor() / 10.0;
            let label = if worst.is_some() { "" } else { "picture" };
            let sentence = format!("{azimuth}{elevation}; {filled} % of {width} x {height} filled");
            rows.terminal(label, sentence);
        }
    }
}

/// Traces of files; their errors are shown in the terminal where a frame could be made of them.
pub(super) struct TracesWithFrame<'a> {
    /// Of each file.
    pub traces: &'a [TraceFacts],
    /// Whether there is a frame.
    pub has_frame: bool,
}

impl ToRows for TracesWithFrame<'_> {
    fn add_to(&self, rows: &mut AnswerRows) {
        for trace in self.traces {
            let TraceFacts { file, errors, interpolated_normals, solid, .. } = trace;
            rows.terminal("witness", format!("{file}: {}", ray_counts(trace, "rays ")));
            if self.has_frame {
                rows.terminal("", errors_sentence(errors));
            }
            if let Some(errors) = interpolated_normals {
                rows.terminal("", format!("with the file's normals: {}", errors_sentence(errors)));
            }
            if !solid.reasons.is_empty() {
                rows.terminal("", solid_sentence(solid));
            }
            rows.page(format!("{file}: rays"), ray_counts(trace, ""));
            let all = [(Some(errors), ""), (interpolated_normals.as_ref(), ", its normals")];
            for (errors, note) in
                all.iter().filter_map(|(errors, note)| Some((errors.as_ref()?, note)))
            {
                let ErrorFacts { ray_error_mrad, pixel_error_px, facet_error_px } = errors;
                rows.page(format!("{file}: ray error{note}, mrad"), figures(*ray_error_mrad));
                rows.page(format!("{file}: pixel error{note}, px"), figures(*pixel_error_px));
                rows.page(format!("{file}: facet error{note}, px"), figures(*facet_error_px));
            }
            rows.page(format!("{file}: solid"), solid_sentence(solid));
        }
    }
}

impl ToRows for FrameFill {
    fn add_to(&self, rows: &mut AnswerRows) {
        let range = |range: &Option<[f64; 2]>| {
            range.map_or("none".into(), |[lo, hi]| format!("{lo:.2} to {hi:.2} deg"))
        };
        let ([width, height], filled) = (self.pixels, 100.0 * self.filled);
        let gain = format!("{:+.1} %", 100.0 * self.gain_over_disc);
        let [azimuth, elevation] = [range(&self.azimuth_deg), range(&self.elevation_deg)];
        rows.terminal(
            "frame",
            format!(
                "{filled:.2} % of {width} x {height} filled; azimuth {azimuth}, elevation {elevation}; \
                 {gain} against a disc"
            ),
        );
        rows.page("frame filled", format!("{filled:.3} % of {width} x {height}"));
        rows.page("gain over a disc", gain);
    }
}

impl ToRows for AcceptanceLimits {
    fn add_to(&self, rows: &mut AnswerRows) {
        let mark = |bound: &AcceptanceLimit| if bound.usual { " (usual)" } else { "" };
        let Self { pixel_error_rms_px: rms, pixel_error_max_px: max, frame_filled: filled } = self;
        let sentence = format!(
            "pixel error {} px rms{}, {} px max{}; at least {} % of the frame{}",
            rms.value,
            mark(rms),
            max.value,
            mark(max),
            percent(filled.value),
            mark(filled)
        );
        rows.add("allowed", sentence);
    }
}

/// What became of the rays that were aimed at the mirror.
pub(super) fn ray_counts(trace: &TraceFacts, noun: &str) -> String {
    let TraceFacts { hit, rays, missed, shadowed, back_face, obstructed, .. } = trace;
    let obstacles = match obstructed {
        0 => String::new(),
        count => format!(", {count} were behind obstacles"),
    };
    format!(
        "{hit} of {rays} {noun}hit, {missed} missed, {shadowed} shadowed, {back_face} met a back \
         face{obstacles}"
    )
}

/// Errors of the picture and of the facets.
pub(super) fn errors_sentence(errors: &ErrorFacts) -> String {
    let [pixel, facet] = [errors.pixel_error_px, errors.facet_error_px].map(figures);
    format!("pixel error {pixel} px; facet error {facet} px")
}

/// The check of a solid.
pub(super) fn solid_sentence(solid: &SolidFacts) -> String {
    let check = &solid.check;
    let yes = |flag: bool, word: &str| {
        if flag { word.into() } else { format!("NOT {word}") }
    };
    let rim = check.open.map_or(String::new(), |OpenBoundary { edges, loops }| {
        let s = if loops == 1 { "" } else { "s" };
        format!(" ({edges} rim edges in {loops} loop{s})")
    });
    format!(
        "{}{rim}, {}, {}; {} piece{}, Euler {}, {:.3} mm^3 ({:.3} expected)",
        yes(check.closed, "closed"),
        yes(check.oriented, "oriented"),
        yes(check.manifold, "manifold"),
        check.components,
        if check.components == 1 { "" } else { "s" },
        check.euler,
        check.volume_mm3,
        solid.volume_expected_mm3,
    )
}
