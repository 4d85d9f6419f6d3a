//! Benchmark results as JSON, CSV and a table.

use crate::num::rounding::significant;
use crate::num::{exp, log};
use crate::report::{Answer, AnswerRows, Head, ToRows};
use crate::results::digits;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;

/// One run: what a setting costs, and how far from the truth it leaves the result.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct BenchRun {
    /// Profile.
    pub profile: String,
    /// What else tells curves apart, such as the method.
    pub series: String,
    /// The setting, in the unit of its sweep.
    pub setting: f64,
    /// Run time, or time on the machine, ms.
    pub time_ms: f64,
    /// The error, in the unit of its sweep.
    #[cfg_attr(test, schemars(with = "Option<f64>"))]
    pub error: f64,
    /// Whether no other run of its curves' profile is both faster and nearer.
    pub pareto: bool,
    /// More figures, with their units in the keys.
    #[cfg_attr(test, schemars(with = "BTreeMap<String, Option<f64>>"))]
    pub figures: BTreeMap<&'static str, f64>,
}

/// How one quantity goes with another, y ~ x^p within each curve.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ConvergenceOrder {
    /// The two quantities, as y against x.
    pub of: &'static str,
    /// Exponent p, fitted to all curves at once.
    #[cfg_attr(test, schemars(with = "Option<f64>"))]
    pub order: f64,
    /// Standard error of the exponent.
    #[cfg_attr(test, schemars(with = "Option<f64>"))]
    pub sigma: f64,
    /// Exponent by theory.
    pub theory: f64,
}

/// What takes the time of a sweep's runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum BenchTime {
    /// This program.
    Run,
    /// The machine that cuts the mirror.
    Machine,
}

impl BenchTime {
    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Run => "run time",
            Self::Machine => "time on the machine",
        }
    }

    /// The unit that it is shown in, and how many of them are a millisecond.
    #[must_use]
    pub fn unit(self) -> (&'static str, f64) {
        match self {
            Self::Run => ("ms", 1.0),
            Self::Machine => ("min", 1.0 / 6e4),
        }
    }
}

/// Runs that differ in one setting.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct BenchSweep {
    /// File name without ending.
    pub name: &'static str,
    /// What was swept.
    pub about: &'static str,
    /// What takes the time.
    pub time: BenchTime,
    /// The setting, with its unit.
    pub setting: &'static str,
    /// The error, with its unit.
    pub error: &'static str,
    /// The error in words, with its unit, as an axis has it.
    #[serde(skip)]
    pub error_axis: &'static str,
    /// Runs, curve by curve.
    pub runs: Vec<BenchRun>,
    /// Orders of convergence that were fitted.
    pub orders: Vec<ConvergenceOrder>,
}

/// The cheapest settings that reach a pixel error.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Suggestion {
    /// Profile.
    pub profile: String,
    /// The pixel error asked for, RMS against the projection, px.
    pub target_px: f64,
    /// The settings; none where the design alone is farther off.
    pub settings: Option<SuggestedSettings>,
    /// The least pixel error of any design, px.
    pub least_px: f64,
    /// The program; none where the profile's design is farther off, or no ball mills it so.
    pub program: Option<SuggestedProgram>,
}

/// Settings of a profile, and what came of them.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct SuggestedSettings {
    /// Method.
    pub method: String,
    /// Whether the largest error is made small.
    pub minimax: bool,
    /// Degree.
    pub degree: usize,
    /// Limit of the facets' error, px.
    pub facet_px: f64,
    /// Optical triangles.
    pub triangles: usize,
    /// Pixel error of the mesh, RMS, as the witness finds it, px.
    pub pixel_rms_px: f64,
    /// Time of design and mesh, ms.
    pub time_ms: f64,
    /// The profile with these settings.
    pub file: String,
}

/// The ball and lines that mill the mirror of a profile in the least time on the machine.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct SuggestedProgram {
    /// Radius of the ball, mm.
    pub ball_mm: f64,
    /// Distance of the finishing lines or turns in the plan, mm.
    pub stepover_mm: f64,
    /// Their direction from X towards Y, degrees; none of a spiral.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle_deg: Option<f64>,
    /// Pixel error of the mirror as milled, RMS, as it is foreseen, px.
    pub pixel_rms_px: f64,
    /// Time of all operations on the machine, minutes.
    pub machine_min: f64,
    /// The profile with this ball and these lines.
    pub file: String,
}

/// Version of the keys of `bench.json`.
pub const SCHEMA: u32 = 2;

/// Run times against errors, setting by setting: `bench.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct BenchReport {
    /// Version of these keys.
    pub schema: u32,
    /// What was swept.
    pub sweeps: Vec<BenchSweep>,
    /// Suggested settings, where they were asked for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub suggestions: Vec<Suggestion>,
}

impl BenchSweep {
    /// What to conclude from the sweep: what ten times the time brings, and whose runs are the best ones.
    #[must_use]
    pub fn conclusion(&self) -> String {
        let order = |of: &str| self.orders.iter().find(|order| order.of == of);
        let power = |x: f64| significant(exp(x * log(10.0)), 2);
        if let Some(ConvergenceOrder { order, theory, .. }) = order("error ~ time") {
            return format!(
                "Ten times the time leaves {} of the error; by theory {}.",
                power(*order),
                power(*theory)
            );
        }
        if let Some(ConvergenceOrder { order, theory, .. }) = order("time ~ pixels") {
            return format!(
                "Ten times the pixels take {} times the time; by theory {}.",
                power(*order),
                power(*theory)
            );
        }
        let best: Vec<&BenchRun> = self.runs.iter().filter(|run| run.pareto).collect();
        let count = |series: &str| best.iter().filter(|run| run.series == series).count();
        let leader = best.iter().map(|run| &*run.series).max_by_key(|series| count(series));
        leader.map_or("No run has an error to show.".into(), |series| {
            format!("{} of the {} runs with rings are by {series}.", count(series), best.len())
        })
    }

    /// A line a run.
    #[must_use]
    pub fn csv(&self) -> String {
        let keys: Vec<&str> =
            self.runs.first().map(|run| run.figures.keys().copied().collect()).unwrap_or_default();
        let head = ["profile", "series", self.setting, "time_ms", self.error, "pareto"];
        let mut out = [&head[..], &keys].concat().join(",") + "\n";
        for run in &self.runs {
            let BenchRun { profile, series, setting, time_ms, error, pareto, figures } = run;
            // Writing to a string cannot fail.
            let _ = write!(out, "{profile},{series},{setting},{time_ms:.4},{error:e},{pareto}");
            for key in &keys {
                let _ = match figures.get(key).filter(|x| x.is_finite()) {
                    Some(x) => write!(out, ",{x}"),
                    None => write!(out, ","),
                };
            }
            out.push('\n');
        }
        out
    }
}

impl Answer for BenchReport {
    fn head(&self) -> Head<'_> {
        Head::default()
    }

    fn rows(&self) -> AnswerRows {
        AnswerRows::of(&[&self.sweeps, &self.suggestions])
    }
}

impl ToRows for BenchSweep {
    fn add_to(&self, rows: &mut AnswerRows) {
        let Self { about, setting, error, time, .. } = self;
        let (unit, factor) = time.unit();
        rows.remark(format!("{about} (* nothing is both faster and nearer); error: {error}"));
        let time = format!("time {unit}");
        rows.line(format!("  {:21}{:23}{setting:>12}{time:>10}  error", "profile", ""));
        for run in &self.runs {
            let BenchRun { profile, series, setting, time_ms, error, pareto, .. } = run;
            let star = if *pareto { " *" } else { "" };
            let time = factor * time_ms;
            let setting =
                if setting.fract() == 0.0 { setting.to_string() } else { digits(*setting) };
            rows.line(format!(
                "  {profile:21}{series:23}{setting:>12}{time:>10.2}  {error:.2e}{star}"
            ));
        }
        for ConvergenceOrder { of, order, sigma, theory } in &self.orders {
            rows.remark(format!("{of} ^ {order:.2} +- {sigma:.2}; theory {theory}"));
        }
        rows.line("");
    }
}

impl ToRows for Suggestion {
    fn add_to(&self, rows: &mut AnswerRows) {
        let Self { profile, target_px, settings, least_px, program } = self;
        let Some(found) = settings else {
            let least = digits(*least_px);
            rows.remark(format!(
                "{profile}: no design comes nearer than {least} px; {target_px} px cannot be reached"
            ));
            return;
        };
        let SuggestedSettings { method, minimax, degree, facet_px, triangles, .. } = found;
        let SuggestedSettings { pixel_rms_px, time_ms, file, .. } = found;
        let (goal, reached) = (if *minimax { ", minimax" } else { "" }, digits(*pixel_rms_px));
        rows.remark(format!(
            "{profile}: {method}{goal} of degree {degree}, facet_px = {facet_px}: {reached} px with \
             {triangles} optical triangles in {time_ms:.0} ms -> {file}"
        ));
        rows.remark(match program {
            Some(program) => program.told(profile),
            None => format!("{profile}: no ball mills its own design to {target_px} px"),
        });
    }
}

impl SuggestedProgram {
    fn told(&self, profile: &str) -> String {
        let Self { ball_mm, stepover_mm, angle_deg, pixel_rms_px, machine_min, file } = self;
        let reached = digits(*pixel_rms_px);
        let path = match angle_deg {
            Some(angle_deg) => format!("lines {stepover_mm} mm apart at {angle_deg} deg"),
            None => format!("turns of a spiral {stepover_mm} mm apart"),
        };
        format!(
            "{profile}: milled by a ball of {ball_mm} mm radius, {path}: {reached} px in \
             {machine_min:.0} min on the machine -> {file}"
        )
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Two profiles of two curves.
    pub fn sweep() -> BenchSweep {
        let run = |profile: &str, series: &str, k: i32| BenchRun {
            profile: profile.into(),
            series: series.into(),
            setting: f64::from(k),
            time_ms: f64::from(k * k),
            error: 30.0 / f64::from(k),
            pareto: k == 8,
            figures: [("unknowns", f64::from(k)), ("ray_max_mrad", f64::NAN)].into(),
        };
        let curve = |profile, series| [4, 8].map(|k| run(profile, series, k)).to_vec();
        let runs = [curve("panoramic", "a"), curve("panoramic", "b"), curve("conical", "a")];
        BenchSweep {
            name: "design",
            about: "Degree",
            time: BenchTime::Run,
            setting: "degree",
            error: "surplus_mrad",
            error_axis: "ray error over the least of any design, mrad",
            runs: runs.concat(),
            orders: Vec::new(),
        }
    }

    #[test]
    fn conclusions_are_of_the_fitted_order_or_of_the_best_runs() {
        let mut sweep = sweep();
        assert_eq!(sweep.conclusion(), "2 of the 3 runs with rings are by a.");
        let order = ConvergenceOrder { of: "error ~ time", order: -1.0, sigma: 0.1, theory: -0.5 };
        sweep.orders.push(order);
        let told = "Ten times the time leaves 0.1 of the error; by theory 0.32.";
        assert_eq!(sweep.conclusion(), told);
    }

    #[test]
    fn tables_hold_every_run() {
        let sweep = sweep();
        let csv = sweep.csv();
        assert_eq!(csv.lines().count(), 1 + 6);
        assert_eq!(csv.lines().nth(2), Some("panoramic,a,8,64.0000,3.75e0,true,,8"));
        let bench = BenchReport { schema: 2, sweeps: vec![sweep], suggestions: Vec::new() };
        assert_eq!(bench.text().lines().count(), 2 + 6 + 1);
        assert_eq!(bench.text().matches(" *\n").count(), 3);
    }
}
