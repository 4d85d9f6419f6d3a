//! What a ball cutter makes of a mirror, in words.

use super::answer::{Answer, AnswerRows, Head, ToRows};
use super::fact_rows::{errors_sentence, ray_counts, solid_sentence};
use super::page::{map_figure, page_of};
use crate::machining::{Fillet, RasterDirection, ScallopFigures};
use crate::num::rounding::floor_four_digits;
use crate::profile::Profile;
use crate::raster::{EncodingError, FalseColourMap};
use crate::results::{
    AsCutFacts, BestFacts, BudgetFacts, GougeFacts, MachiningReport, ReachFacts, StockFacts,
    coordinate, digits, figures,
};

impl MachiningReport {
    /// `machining.html`, with the map of what the cutter leaves.
    ///
    /// # Errors
    /// What the encoder of pictures reports.
    pub fn html(&self, profile: &Profile, map: &FalseColourMap) -> Result<String, EncodingError> {
        let caption = format!(
            "The face from above, each square {} mm wide: what a ball of {} mm radius cannot reach. Grey is where it \
             fits everywhere.",
            map.pixel_mm.map_or("0".into(), digits),
            self.ball_mm
        );
        let figures = [map_figure("Left by the cutter, um", map, caption)?];
        Ok(page_of(self, (Some(("machining.html", profile)), "machining"), figures, &self.files))
    }
}

impl Answer for MachiningReport {
    fn head(&self) -> Head<'_> {
        Head::judged(&self.profile, self.verdict, &self.reasons).with_warnings(&self.warnings)
    }

    fn rows(&self) -> AnswerRows {
        let mut rows = AnswerRows::default();
        self.add_tool(&mut rows);
        rows.append(AnswerRows::of(&[&self.reach, &self.gouge, &self.fillet]));
        self.add_scallops(&mut rows);
        rows.append(AnswerRows::of(&[&self.best, &self.budget, &self.stock]));
        self.add_as_cut(&mut rows);
        self.files.add_to(&mut rows);
        rows
    }
}

impl MachiningReport {
    fn add_tool(&self, rows: &mut AnswerRows) {
        let Self { ball_mm, stepover_mm, angle_deg, steepest_deg, least_hollow_mm, .. } = self;
        rows.add(
            "tool",
            format!(
                "ball of {ball_mm} mm radius, lines {stepover_mm} mm apart in the plan, {angle_deg:.2} deg \
                 from X"
            ),
        );
        let hollow = least_hollow_mm.map_or("hollow nowhere".to_owned(), |least| {
            format!("least hollow radius {:.3} mm at {}", least.value, place(least.at_mm))
        });
        let (steepest, at) = (steepest_deg.value, place(steepest_deg.at_mm));
        rows.add("face", format!("steepest {steepest:.2} deg at {at}; {hollow}"));
    }

    /// Scallops, and what they do to the picture.
    fn add_scallops(&self, rows: &mut AnswerRows) {
        let Some(ScallopFigures {
            scallop_um, slope_rms, slope_max, pixels, pixel_error_px, ..
        }) = self.scallops
        else {
            rows.add("scallops", "none: the ball fits nowhere");
            return;
        };
        let slopes = match pixels {
            0 => "no pixel sees them".to_owned(),
            _ => format!("slope {} rms, {} max", digits(slope_rms), digits(slope_max)),
        };
        let (height, at) = (digits(scallop_um.value), place(scallop_um.at_mm));
        rows.add("scallops", format!("{height} um at most, at {at}; {slopes}"));
        let [unpolished, design] = [pixel_error_px, self.design_pixel_error_px].map(figures);
        let pixels = match pixel_error_px {
            Some(_) => format!("unpolished {unpolished} px; the design alone {design} px"),
            None if pixels > 0 => "not known without a projection".to_owned(),
            None => "not known".to_owned(),
        };
        rows.add("pixels", pixels);
    }

    fn add_as_cut(&self, rows: &mut AnswerRows) {
        let Some(AsCutFacts { optical_triangles, trace }) = &self.as_cut else { return };
        let counts = ray_counts(trace, "rays ");
        rows.add("as cut", format!("{optical_triangles} optical triangles; {counts}"));
        if self.scallops.as_ref().is_some_and(|found| found.pixel_error_px.is_some()) {
            rows.add("", format!("{} (against the design)", errors_sentence(&trace.errors)));
        }
        if !trace.solid.reasons.is_empty() {
            rows.add("", solid_sentence(&trace.solid));
        }
    }
}

impl ToRows for ReachFacts {
    fn add_to(&self, rows: &mut AnswerRows) {
        let Self { face_mm, wall_mm } = self;
        rows.add(
            "reach",
            format!(
                "{face_mm:.3} mm from the top to the lowest place of the face, {wall_mm:.3} mm to the foot of \
                 its wall"
            ),
        );
    }
}

impl ToRows for GougeFacts {
    fn add_to(&self, rows: &mut AnswerRows) {
        let sentence = match self.at_mm {
            _ if self.fits => "the ball fits everywhere".to_owned(),
            Some([x, y]) => format!(
                "the ball leaves up to {} um, at {}, on {:.2} % of the face",
                digits(self.left_max_um),
                place([x, y, 0.0]),
                100.0 * self.share
            ),
            None => "the ball leaves next to nothing".to_owned(),
        };
        rows.add("fit", sentence);
    }
}

impl ToRows for Fillet {
    fn add_to(&self, rows: &mut AnswerRows) {
        let Self { width_max_mm, width_mean_mm, left_max_mm, pixels, .. } = self;
        rows.add(
            "valley",
            format!(
                "fillet of {width_max_mm:.3} mm width ({width_mean_mm:.3} mm mean), up to {left_max_mm:.3} mm \
                 high: {pixels:.0} pixels"
            ),
        );
    }
}

impl ToRows for BestFacts {
    fn add_to(&self, rows: &mut AnswerRows) {
        let of = |direction: RasterDirection, what: &str| match direction {
            RasterDirection { any: true, .. } => {
                format!("no direction is better than another for {what}")
            }
            RasterDirection { angle_deg, of_worst, .. } => format!(
                "{angle_deg:.2} deg from X for {what} ({of_worst:.3} of the worst direction's)"
            ),
        };
        let Self { pixels, height } = *self;
        let mut parts: Vec<String> = pixels.map(|d| of(d, "the pixel error")).into_iter().collect();
        parts.push(of(height, "the scallops' height"));
        if pixels.unwrap_or(height).any && height.any {
            parts.push("a spiral about the axis does as well".into());
        }
        rows.add("best", parts.join("; "));
    }
}

impl ToRows for BudgetFacts {
    fn add_to(&self, rows: &mut AnswerRows) {
        let Self { p95_px, stepover_for_px_mm, scallop_um, stepover_for_scallop_mm } = *self;
        let budgets = [
            (p95_px, stepover_for_px_mm, "px (95 % of the face)"),
            (scallop_um, stepover_for_scallop_mm, "um of scallop"),
        ];
        for (budget, stepover, unit) in budgets {
            if let (Some(budget), Some(stepover)) = (budget, stepover) {
                let stepover = floor_four_digits(stepover);
                rows.add("budget", format!("{budget} {unit}: a stepover of {stepover} mm"));
            }
        }
    }
}

impl ToRows for StockFacts {
    fn add_to(&self, rows: &mut AnswerRows) {
        let Self { size_mm: [x, y, z], volume_mm3, part_mm3, removed_mm3, .. } = self;
        rows.add(
            "stock",
            format!(
                "{x:.3} x {y:.3} x {z:.3} mm, {volume_mm3:.0} mm^3; the part {part_mm3:.0}, cut away \
                 {removed_mm3:.0}"
            ),
        );
    }
}

/// X and Y of a place.
fn place([x, y, _]: [f64; 3]) -> String {
    format!("X {}, Y {} mm", coordinate(x, 3), coordinate(y, 3))
}
