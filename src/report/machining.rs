//! What a ball cutter makes of a mirror, as JSON and as a summary.

use super::text::{
    digits, errors_line, figures, head_line, pretty, solid_line, verdict_lines, written,
};
use super::{FileFacts, ProfileId, TraceFacts, Verdict};
use crate::machining::{Extreme, Fillet, RasterDirection, ScallopFigures};
use crate::num::rounding::floor_four_digits;
use crate::num::stats::{Summary, or_null};
use serde::{Serialize, Serializer};
use std::fmt::Write;

/// `machining.json`, schema 1.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Machining {
    /// The version of the report's schema, whose rules hold for these keys too.
    pub schema: u32,
    /// Which profile.
    pub profile: ProfileId,
    /// Radius of the ball, mm.
    pub ball_mm: f64,
    /// Distance of the raster's lines in the plan, mm.
    pub stepover_mm: f64,
    /// Their direction, from X towards Y.
    pub angle_deg: f64,
    /// The steepest place of the face, degrees from the horizontal plane.
    pub steepest_deg: Extreme,
    /// Least radius of curvature of hollow ground, mm; none where there is none.
    pub least_hollow_mm: Option<Extreme>,
    /// Where the ball does not fit.
    pub gouge: GougeFacts,
    /// What it leaves of a valley; none where there is none.
    pub fillet: Option<Fillet>,
    /// Scallops of the unpolished face, where the ball fits; none where it fits nowhere.
    #[serde(flatten, serialize_with = "or_nulls")]
    pub scallops: Option<ScallopFigures>,
    /// The designed mirror against the projection, pixels.
    #[serde(serialize_with = "or_null")]
    pub design_pixel_error_px: Option<Summary>,
    /// Directions of the raster.
    pub best: BestFacts,
    /// Stepovers for the budgets that were given.
    pub budget: BudgetFacts,
    /// How deep the tool goes.
    pub reach: ReachFacts,
    /// What the part is cut from.
    pub stock: StockFacts,
    /// The as-cut part as the witness saw it; none when none was made.
    pub as_cut: Option<AsCutFacts>,
    /// The files written but for this one.
    pub files: Vec<FileFacts>,
    /// Pass, or why not.
    pub verdict: Verdict,
    /// Every reason.
    pub reasons: Vec<String>,
    /// What else to know.
    pub warnings: Vec<String>,
}

/// The figures, or the same keys without values.
fn or_nulls<S: Serializer>(
    figures: &Option<ScallopFigures>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    match figures {
        Some(figures) => figures.serialize(serializer),
        None => {
            const KEYS: [&str; 6] = [
                "scallop_um",
                "slope_rms",
                "slope_max",
                "pixels",
                "pixels_unbounded",
                "pixel_error_px",
            ];
            serializer.collect_map(KEYS.map(|key| (key, ())))
        }
    }
}

/// Where the ball does not fit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct GougeFacts {
    /// Whether it fits everywhere, in a valley too.
    pub fits: bool,
    /// Most that it leaves, um; 0 where it fits everywhere.
    pub left_max_um: f64,
    /// X and Y of that, mm.
    pub at_mm: Option<[f64; 2]>,
    /// Share of the face's area in the plan where it leaves something.
    pub share: f64,
    /// Distance of the places that were looked at, mm.
    pub step_mm: f64,
}

/// The best directions of the raster.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BestFacts {
    /// For the root mean square of the pixel error; none without a projection.
    pub pixels: Option<RasterDirection>,
    /// For the height of the highest scallop.
    pub height: RasterDirection,
}

/// Budgets and the stepovers that keep them, at the raster's direction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BudgetFacts {
    /// Pixel error that 95 % of the unpolished face may not exceed.
    pub p95_px: Option<f64>,
    /// The largest stepover for it, mm.
    pub stepover_for_px_mm: Option<f64>,
    /// Height that no scallop may exceed, um.
    pub scallop_um: Option<f64>,
    /// The largest stepover for it, mm.
    pub stepover_for_scallop_mm: Option<f64>,
}

/// How deep the tool goes from the mirror's highest place.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ReachFacts {
    /// To the lowest place of the face, mm.
    pub face_mm: f64,
    /// To the foot of the wall around it, on the flat rim or the base, mm.
    pub wall_mm: f64,
}

/// The box that the part is cut from.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StockFacts {
    /// Along X, Y and Z, mm, with the allowance.
    pub size_mm: [f64; 3],
    /// What stands over the part on each side and on top, mm.
    pub allowance_mm: f64,
    /// Volume of the box, mm^3.
    pub volume_mm3: f64,
    /// Volume of the part, mm^3.
    pub part_mm3: f64,
    /// What is cut away, mm^3.
    pub removed_mm3: f64,
}

/// The as-cut part.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AsCutFacts {
    /// Facets of its optical face.
    pub optical_triangles: usize,
    /// The witness: `pixel_error_px` against the projection, `facet_error_px` against the designed mirror, which
    /// is what the scallops do.
    pub trace: TraceFacts,
}

impl Machining {
    /// `machining.json`.
    #[must_use]
    pub fn json(&self) -> String {
        pretty(self)
    }

    /// A readable summary.
    #[must_use]
    pub fn text(&self) -> String {
        written(|out| self.write_text(out))
    }

    fn write_text(&self, out: &mut String) -> std::fmt::Result {
        head_line(out, &self.profile)?;
        self.write_facts(out)?;
        verdict_lines(out, &self.reasons, self.verdict)
    }

    /// The summary's lines between its head and its reasons.
    pub(super) fn write_facts(&self, out: &mut String) -> std::fmt::Result {
        for (name, value) in self.facts() {
            writeln!(out, "  {name:8} {value}")?;
        }
        Ok(())
    }

    /// What there is to say, with its name; lines without one go on.
    pub(super) fn facts(&self) -> Vec<(&'static str, String)> {
        let mut facts = Vec::new();
        let Self { ball_mm, stepover_mm, angle_deg, .. } = self;
        facts.push((
            "tool",
            format!(
                "ball of {ball_mm} mm radius, lines {stepover_mm} mm apart in the plan, {angle_deg:.2} deg \
                 from X"
            ),
        ));
        let at = |[x, y, _]: [f64; 3]| format!("X {}, Y {} mm", micron(x), micron(y));
        let steepest = &self.steepest_deg;
        let hollow = self.least_hollow_mm.map_or("hollow nowhere".to_owned(), |least| {
            format!("least hollow radius {:.3} mm at {}", least.value, at(least.at_mm))
        });
        let face =
            format!("steepest {:.2} deg at {}; {hollow}", steepest.value, at(steepest.at_mm));
        facts.push(("face", face));
        let ReachFacts { face_mm, wall_mm } = self.reach;
        facts.push((
            "reach",
            format!(
                "{face_mm:.3} mm from the top to the lowest place of the face, {wall_mm:.3} mm to the foot of \
                 its wall"
            ),
        ));
        let gouge = &self.gouge;
        let fit = match gouge.at_mm {
            _ if gouge.fits => "the ball fits everywhere".to_owned(),
            Some([x, y]) => format!(
                "the ball leaves up to {} um, at X {}, Y {} mm, on {:.2} % of the face",
                digits(gouge.left_max_um),
                micron(x),
                micron(y),
                100.0 * gouge.share
            ),
            None => "the ball leaves next to nothing".to_owned(),
        };
        facts.push(("fit", fit));
        if let Some(fillet) = &self.fillet {
            facts.push((
                "valley",
                format!(
                    "fillet of {:.3} mm width ({:.3} mm mean), up to {:.3} mm high: {:.0} pixels",
                    fillet.width_max_mm, fillet.width_mean_mm, fillet.left_max_mm, fillet.pixels
                ),
            ));
        }
        self.write_scallops(&mut facts);
        facts.push(("best", self.best_line()));
        let BudgetFacts { p95_px, stepover_for_px_mm, scallop_um, stepover_for_scallop_mm } =
            self.budget;
        let budgets = [
            (p95_px, stepover_for_px_mm, "px (95 % of the face)"),
            (scallop_um, stepover_for_scallop_mm, "um of scallop"),
        ];
        for (budget, stepover, unit) in budgets {
            if let (Some(budget), Some(stepover)) = (budget, stepover) {
                let stepover = floor_four_digits(stepover);
                facts.push(("budget", format!("{budget} {unit}: a stepover of {stepover} mm")));
            }
        }
        let StockFacts { size_mm: [x, y, z], volume_mm3, part_mm3, removed_mm3, .. } = self.stock;
        facts.push((
            "stock",
            format!(
                "{x:.3} x {y:.3} x {z:.3} mm, {volume_mm3:.0} mm^3; the part {part_mm3:.0}, cut away \
                 {removed_mm3:.0}"
            ),
        ));
        if let Some(AsCutFacts { optical_triangles, trace }) = &self.as_cut {
            facts.push((
                "as cut",
                format!(
                    "{optical_triangles} optical triangles; {} of {} rays hit, {} missed, {} shadowed, {} met \
                     a back face",
                    trace.hit, trace.rays, trace.missed, trace.shadowed, trace.back_face
                ),
            ));
            if self.scallops.as_ref().is_some_and(|found| found.pixel_error_px.is_some()) {
                facts.push(("", format!("{} (against the design)", errors_line(&trace.errors))));
            }
            if !trace.solid.reasons.is_empty() {
                facts.push(("", solid_line(&trace.solid)));
            }
        }
        for file in &self.files {
            facts.push(("file", format!("{}  {:.1} MB", file.name, file.bytes as f64 / 1e6)));
        }
        facts
    }

    /// The lines on scallops and pixels.
    fn write_scallops(&self, facts: &mut Vec<(&'static str, String)>) {
        let Some(ScallopFigures {
            scallop_um, slope_rms, slope_max, pixels, pixel_error_px, ..
        }) = self.scallops
        else {
            facts.push(("scallops", "none: the ball fits nowhere".to_owned()));
            return;
        };
        let [x, y, _] = scallop_um.at_mm;
        let slopes = if pixels > 0 {
            format!("slope {} rms, {} max", digits(slope_rms), digits(slope_max))
        } else {
            "no pixel sees them".to_owned()
        };
        facts.push((
            "scallops",
            format!(
                "{} um at most, at X {}, Y {} mm; {slopes}",
                digits(scallop_um.value),
                micron(x),
                micron(y)
            ),
        ));
        facts.push((
            "pixels",
            match pixel_error_px {
                Some(_) => format!(
                    "unpolished {} px; the design alone {} px",
                    figures(pixel_error_px),
                    figures(self.design_pixel_error_px)
                ),
                None if pixels > 0 => "not known without a projection".to_owned(),
                None => "not known".to_owned(),
            },
        ));
    }

    fn best_line(&self) -> String {
        let of = |direction: RasterDirection, what: &str| {
            if direction.any {
                return format!("no direction is better than another for {what}");
            }
            format!(
                "{:.2} deg from X for {what} ({:.3} of the worst direction's)",
                direction.angle_deg, direction.of_worst
            )
        };
        let BestFacts { pixels, height } = self.best;
        let mut parts: Vec<String> = pixels.map(|d| of(d, "the pixel error")).into_iter().collect();
        parts.push(of(height, "the scallops' height"));
        if pixels.unwrap_or(height).any && height.any {
            parts.push("a spiral about the axis does as well".into());
        }
        parts.join("; ")
    }
}

/// A coordinate in mm to the micrometre, without the sign of a zero.
fn micron(mm: f64) -> String {
    format!("{:.3}", (mm * 1e3).round() / 1e3 + 0.0)
}
