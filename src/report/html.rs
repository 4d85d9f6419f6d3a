//! `report.html`: the report as one page, with the picture beside it.

use super::outside::visible;
use super::text::{
    allowed_line, camera_line, figures, form_line, limited, method_line, of_at_most, sag_line,
    solid_line, step_line,
};
use super::{BuildReport, Verdict};
use crate::design::CurlFacts;
use std::fmt::Write;

/// How pages look.
pub(super) const STYLE: &str = "body{font:15px/1.5 system-ui,sans-serif;max-width:52rem;margin:2rem auto;\
padding:0 1rem;color:#222}table{border-collapse:collapse;width:100%;margin:1rem 0}\
th,td{text-align:left;vertical-align:top;padding:.3rem .6rem;border-bottom:1px solid #ddd}\
th{font-weight:600;white-space:nowrap;width:11rem}img{max-width:100%;image-rendering:pixelated}\
code{font-size:.85em;word-break:break-all}.pass{color:#15803d}.fail{color:#b91c1c}";

/// A page that needs nothing but `picture` (a file name) beside it.
#[must_use]
pub fn html(report: &BuildReport, summary: &str, picture: &str) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = page(&mut out, report, summary, picture);
    out
}

fn page(out: &mut String, report: &BuildReport, summary: &str, picture: &str) -> std::fmt::Result {
    head(out, &report.profile.name, STYLE, report.verdict)?;
    writeln!(out, "<p>{}</p>", escaped(summary))?;
    let reasons: Vec<&str> = report.reasons.iter().map(|reason| &**reason).collect();
    let warnings: Vec<&str> = report.warnings.iter().map(String::as_str).collect();
    for list in [reasons, warnings] {
        if !list.is_empty() {
            writeln!(out, "<ul>")?;
            for line in list {
                writeln!(out, "<li>{}</li>", escaped(line))?;
            }
            writeln!(out, "</ul>")?;
        }
    }
    let alt = "What the camera sees of a world marked every 15 degrees";
    writeln!(out, "<p><img src=\"{picture}\" alt=\"{alt}\"></p>\n<table>")?;
    for (head, value) in rows(report) {
        writeln!(out, "<tr><th>{}</th><td>{}</td></tr>", escaped(&head), escaped(&value))?;
    }
    for file in &report.files {
        writeln!(
            out,
            "<tr><th>{}</th><td>{} bytes<br><code>sha256 {}</code></td></tr>",
            escaped(&file.name),
            file.bytes,
            file.sha256
        )?;
    }
    writeln!(out, "</table>\n</html>")
}

/// What a page begins with: its head, and a heading of the name and the verdict.
pub(super) fn head(
    out: &mut String,
    name: &str,
    style: &str,
    verdict: Verdict,
) -> std::fmt::Result {
    let name = escaped(name);
    let verdict = match verdict {
        Verdict::Pass => "pass",
        Verdict::Fail => "fail",
    };
    writeln!(out, "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\">")?;
    writeln!(out, "<title>Morion: {name}</title>\n<style>{style}</style>")?;
    writeln!(out, "<h1>{name}: <span class=\"{verdict}\">{verdict}</span></h1>")
}

fn rows(report: &BuildReport) -> Vec<(String, String)> {
    let mut rows: Vec<(String, String)> = Vec::new();
    let mut row = |head: &str, value: String| rows.push((head.into(), value));
    let design = &report.design;
    row("profile sha256", report.profile.sha256.clone());
    if let Some(layout) = &report.layout {
        row("part", format!("{}, its base at Z = 0", layout.size()));
        row("camera", camera_line(layout));
        row("world", layout.world());
    }
    row("method", method_line(design));
    let number = |x: Option<f64>| x.map_or("none".into(), |x| format!("{x:.9e}"));
    row("condition of the fit", number(design.condition));
    row("gradient residual", number(design.gradient_residual));
    let curl = |c: CurlFacts| {
        let CurlFacts { rms, max, condition, rounding } = c;
        format!(
            "{rms:.4e} rms, {max:.4e} max, of which rounding at most {rounding:.1e}; condition \
             {condition:.1}"
        )
    };
    row("curl of the field", design.curl.map_or("none".into(), curl));
    row("design: ray error, mrad", figures(design.ray_error_mrad));
    row("design: pixel error, px", figures(design.pixel_error_px));
    row("best-fit sphere and plane", form_line(&report.form));
    if let Some(step) = &report.step {
        row("STEP splines", step_line(step));
    }
    if let Some(sag) = &report.sag {
        row("sag table", sag_line(sag));
    }
    if let Some(mesh) = &report.mesh {
        let over = |o: Option<f64>| o.map_or("none".into(), |o| format!("{o:.2}"));
        let most = of_at_most(mesh.max_triangles);
        let [optical, all] = [mesh.optical_triangles, mesh.triangles];
        row("triangles", format!("{optical} optical, {all} in all{most}"));
        row("chord", limited(&mesh.chord_um, "um"));
        row("facet", limited(&mesh.facet_px, "px"));
        let [chord, facet] = [mesh.over_optimum.chord, mesh.over_optimum.facet].map(over);
        row("over the least possible", format!("chord {chord}, facet {facet}"));
    }
    if let Some(solid) = &report.solid {
        row("solid", solid_line(solid));
    }
    for trace in &report.trace {
        let head = |what: &str| format!("{}: {what}", trace.file);
        row(
            &head("rays"),
            format!(
                "{} of {} hit, {} missed, {} shadowed, {} met a back face",
                trace.hit, trace.rays, trace.missed, trace.shadowed, trace.back_face
            ),
        );
        for (errors, note) in
            [(Some(trace.errors), ""), (trace.interpolated_normals, ", its normals")]
        {
            let Some(errors) = errors else { continue };
            row(&head(&format!("ray error{note}, mrad")), figures(errors.ray_error_mrad));
            row(&head(&format!("pixel error{note}, px")), figures(errors.pixel_error_px));
            row(&head(&format!("facet error{note}, px")), figures(errors.facet_error_px));
        }
        row(&head("solid"), solid_line(&trace.solid));
    }
    if let Some(sharpness) = &report.sharpness {
        row("sharpest", sharpness.best.line());
        if let Some(given) = &sharpness.given {
            row("through the lens", given.line());
        }
    }
    if let Some(accepted) = &report.accepted {
        row("allowed", allowed_line(accepted));
    }
    if let Some(frame) = &report.frame {
        let share =
            format!("{:.3} % of {} x {}", 100.0 * frame.filled, frame.pixels[0], frame.pixels[1]);
        row("frame filled", share);
        row("gain over a disc", format!("{:+.1} %", 100.0 * frame.gain_over_disc));
    }
    rows
}

/// `text` as it may stand in a page.
pub(super) fn escaped(text: &str) -> String {
    visible(text)
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    #[test]
    fn text_from_outside_cannot_become_markup() {
        assert_eq!(super::escaped("<b a=\"1\">&"), "&lt;b a=&quot;1&quot;&gt;&amp;");
    }
}
