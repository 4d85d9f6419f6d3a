//! The terminal's summary of a report.

use super::measured::{AlignmentFacts, error_line};
use super::outside::visible;
use super::tolerance::percent;
use super::{
    BuildReport, ErrorFacts, FileFacts, Limited, MeshFacts, ProfileId, SagFacts, Sharpness,
    SolidFacts, StepFacts, TraceFacts, Verdict, VerifyReport,
};
use crate::design::{DesignFacts, Mounting};
use crate::mirror::{Departure, Form};
use crate::num::stats::Summary;
use crate::profile::{AcceptanceLimit, AcceptanceLimits};
use crate::solid::OpenBoundary;
use crate::trace::FrameFill;
use serde::Serialize;
use std::fmt::{Display, Write};

impl BuildReport {
    /// A readable summary: a line a stage, the reasons, and the verdict last. Plain text, in which what
    /// would steer a terminal is written out.
    #[must_use]
    pub fn text(&self) -> String {
        written(|out| {
            head_line(out, &self.profile)?;
            mounting_lines(out, self.layout.as_ref())?;
            design_lines(out, &self.design, &self.form)?;
            mesh_lines(out, self.mesh.as_ref(), self.solid.as_ref())?;
            file_lines(out, &self.files)?;
            if let Some(step) = &self.step {
                writeln!(out, "  step     {}", step_line(step))?;
            }
            if let Some(sag) = &self.sag {
                writeln!(out, "  table    {}", sag_line(sag))?;
            }
            trace_lines(out, &self.trace, self.frame.as_ref())?;
            sharpness_lines(out, self.sharpness.as_ref(), self.accepted.as_ref())?;
            verdict_lines(out, &self.reasons, self.verdict)
        })
    }
}

impl VerifyReport {
    /// A readable summary: a line a stage, the reasons, and the verdict last. Plain text, in which what
    /// would steer a terminal is written out.
    #[must_use]
    pub fn text(&self) -> String {
        written(|out| {
            head_line(out, &self.profile)?;
            mounting_lines(out, Some(&self.layout))?;
            design_lines(out, &self.design, &self.form)?;
            file_lines(out, &self.files)?;
            if let Some(units) = &self.units {
                writeln!(out, "  units    {}", units.line())?;
            }
            for (k, line) in self.alignment.iter().flat_map(AlignmentFacts::lines).enumerate() {
                writeln!(out, "  {:8} {line}", if k == 0 { "pose" } else { "" })?;
            }
            if let Some(error) = &self.form_error_um {
                writeln!(out, "  error    {}", error_line(error))?;
            }
            trace_lines(out, &self.trace, self.frame.as_ref())?;
            sharpness_lines(out, self.sharpness.as_ref(), self.accepted.as_ref())?;
            verdict_lines(out, &self.reasons, self.verdict)
        })
    }
}

/// A result as JSON of several lines.
pub(crate) fn pretty(result: &impl Serialize) -> String {
    let mut text = serde_json::to_string_pretty(result).expect("string keys and plain values only");
    text.push('\n');
    text
}

/// What `write` writes, in which nothing steers a terminal.
pub(crate) fn written(write: impl FnOnce(&mut String) -> std::fmt::Result) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = write(&mut out);
    visible(&out)
}

/// The first line: which profile.
pub(super) fn head_line(out: &mut String, profile: &ProfileId) -> std::fmt::Result {
    writeln!(out, "{}  ({})", profile.name, short(&profile.sha256))
}

/// Places of camera and target.
fn mounting_lines(out: &mut String, layout: Option<&Mounting>) -> std::fmt::Result {
    if let Some(layout) = layout {
        writeln!(out, "  part     {}, its base at Z = 0", layout.size())?;
        writeln!(out, "  camera   {}", camera_line(layout))?;
        writeln!(out, "  world    {}", layout.world())?;
    }
    Ok(())
}

fn design_lines(out: &mut String, design: &DesignFacts, form: &Form) -> std::fmt::Result {
    writeln!(
        out,
        "  design   {}; ray error {} mrad, pixel error {} px",
        method_line(design),
        figures(design.ray_error_mrad),
        figures(design.pixel_error_px),
    )?;
    writeln!(out, "  form     {}", form_line(form))
}

fn mesh_lines(
    out: &mut String,
    mesh: Option<&MeshFacts>,
    solid: Option<&SolidFacts>,
) -> std::fmt::Result {
    if let Some(mesh) = mesh {
        writeln!(
            out,
            "  mesh     {} optical triangles ({} in all{}); chord {}, facet {}",
            mesh.optical_triangles,
            mesh.triangles,
            of_at_most(mesh.max_triangles),
            limited(&mesh.chord_um, "um"),
            limited(&mesh.facet_px, "px"),
        )?;
    }
    if let Some(solid) = solid {
        writeln!(out, "  solid    {}", solid_line(solid))?;
    }
    Ok(())
}

fn file_lines(out: &mut String, files: &[FileFacts]) -> std::fmt::Result {
    for file in files {
        writeln!(out, "  file     {}  {:.1} MB", file.name, file.bytes as f64 / 1e6)?;
    }
    Ok(())
}

/// The witness's figures of each mesh, and the frame as the first one shows it.
fn trace_lines(
    out: &mut String,
    traces: &[TraceFacts],
    frame: Option<&FrameFill>,
) -> std::fmt::Result {
    for trace in traces {
        writeln!(
            out,
            "  witness  {}: {} of {} rays hit, {} missed, {} shadowed, {} met a back face",
            trace.file, trace.hit, trace.rays, trace.missed, trace.shadowed, trace.back_face
        )?;
        if frame.is_some() {
            writeln!(out, "           {}", errors_line(&trace.errors))?;
        }
        if let Some(errors) = &trace.interpolated_normals {
            writeln!(out, "           with the file's normals: {}", errors_line(errors))?;
        }
        if !trace.solid.reasons.is_empty() {
            writeln!(out, "           {}", solid_line(&trace.solid))?;
        }
    }
    if let Some(frame) = frame {
        let range = |range: &Option<[f64; 2]>| {
            range.map_or("none".into(), |[lo, hi]| format!("{lo:.2} to {hi:.2} deg"))
        };
        writeln!(
            out,
            "  frame    {:.2} % of {} x {} filled; azimuth {}, elevation {}; {:+.1} % against a disc",
            100.0 * frame.filled,
            frame.pixels[0],
            frame.pixels[1],
            range(&frame.azimuth_deg),
            range(&frame.elevation_deg),
            100.0 * frame.gain_over_disc,
        )?;
    }
    Ok(())
}

fn sharpness_lines(
    out: &mut String,
    sharpness: Option<&Sharpness>,
    accepted: Option<&AcceptanceLimits>,
) -> std::fmt::Result {
    if let Some(sharpness) = sharpness {
        writeln!(out, "  sharp    best through {}", sharpness.best.line())?;
        if let Some(given) = &sharpness.given {
            writeln!(out, "           through {}", given.line())?;
        }
    }
    if let Some(accepted) = accepted {
        writeln!(out, "  allowed  {}", allowed_line(accepted))?;
    }
    Ok(())
}

/// The limits that the picture is held to.
pub(super) fn allowed_line(accepted: &AcceptanceLimits) -> String {
    let mark = |bound: &AcceptanceLimit| if bound.usual { " (usual)" } else { "" };
    let AcceptanceLimits { pixel_error_rms_px: rms, pixel_error_max_px: max, frame_filled: filled } =
        accepted;
    format!(
        "pixel error {} px rms{}, {} px max{}; at least {} % of the frame{}",
        rms.value,
        mark(rms),
        max.value,
        mark(max),
        percent(filled.value),
        mark(filled)
    )
}

/// The last lines.
pub(super) fn verdict_lines(
    out: &mut String,
    reasons: &[impl Display],
    verdict: Verdict,
) -> std::fmt::Result {
    reasons.iter().try_for_each(|reason| writeln!(out, "  - {reason}"))?;
    let word = match verdict {
        Verdict::Pass => "pass",
        Verdict::Fail => "fail",
    };
    writeln!(out, "  verdict  {word}")
}

/// The number of triangles allowed, if there is one.
pub(super) fn of_at_most(most: Option<usize>) -> String {
    most.map_or(String::new(), |most| format!(", of at most {most}"))
}

/// The first digits of a hash.
pub(super) fn short(sha256: &str) -> &str {
    &sha256[..sha256.len().min(8)]
}

/// Where the camera goes.
pub(super) fn camera_line(layout: &Mounting) -> String {
    let above = layout.pupil_mm.map_or(String::new(), |[.., z]| {
        format!(", {:.3} mm above the mirror's mean height", z - layout.mean_mm)
    });
    format!("{}{above}, on the axis, looking along -Z; the picture's top is +Y", layout.camera())
}

/// How the mirror was found.
pub(super) fn method_line(design: &DesignFacts) -> String {
    let DesignFacts { method, degree, unknowns, .. } = design;
    if design.unknowns == 0 {
        return method.clone();
    }
    let goal = if design.minimax { ", minimax" } else { "" };
    format!("{method}{goal} of degree {degree}, {unknowns} unknowns")
}

/// The best-fit sphere and plane, and how far off they are.
pub(super) fn form_line(form: &Form) -> String {
    let Form { sphere, plane } = form;
    let of = |departure: &Departure| {
        let Departure { sag_pv_mm, pv_mm, largest_mm, normal_max_mrad } = *departure;
        let sag = sag_pv_mm.map_or(String::new(), |mm| format!("sag {} mm PV, ", digits(mm)));
        let [pv, largest, turned] = [pv_mm, largest_mm, normal_max_mrad].map(digits);
        format!("{sag}square to it {pv} mm PV, {largest} mm at most, normals {turned} mrad at most")
    };
    let radius = match sphere.radius_of_curvature_mm {
        Some(mm) if mm > 0.0 => format!("a hollow sphere of {} mm radius", digits(mm)),
        Some(mm) => format!("a bulging sphere of {} mm radius", digits(-mm)),
        None => "no sphere but a plane".into(),
    };
    format!(
        "departure from {radius}: {}; from a plane: {}",
        of(&sphere.departure),
        of(&plane.departure)
    )
}

/// The splines of the STEP file.
pub(super) fn step_line(step: &StepFacts) -> String {
    let [u, v] = step.control_points;
    format!("{u} x {v} control points, within {} nm of the design", digits(step.fit_error_nm))
}

/// The sag table read back.
pub(super) fn sag_line(sag: &SagFacts) -> String {
    format!(
        "{} rows; heights within {:.1e} mm of the design, normals within {:.1e} rad",
        sag.rows, sag.height_error_mm, sag.normal_error_rad
    )
}

/// RMS, P95 and maximum.
pub(super) fn figures(summary: Option<Summary>) -> String {
    summary.map_or("none".into(), |s| {
        format!("{} rms, {} p95, {} max", digits(s.rms), digits(s.p95), digits(s.max))
    })
}

/// Three or four digits that matter.
pub(crate) fn digits(x: f64) -> String {
    if x != 0.0 && x.abs() < 1e-3 { format!("{x:.2e}") } else { format!("{x:.3}") }
}

pub(super) fn limited(value: &Limited, unit: &str) -> String {
    match value.limit {
        Some(limit) => format!("{} of {limit} {unit}", digits(value.bound)),
        None => format!("{} {unit} (no limit)", digits(value.bound)),
    }
}

pub(super) fn errors_line(errors: &ErrorFacts) -> String {
    format!(
        "pixel error {} px; facet error {} px",
        figures(errors.pixel_error_px),
        figures(errors.facet_error_px)
    )
}

pub(super) fn solid_line(solid: &SolidFacts) -> String {
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
