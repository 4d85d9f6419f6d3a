//! Benchmark results as JSON, CSV, a table and a plot.

use super::plot::{Area, Failure, svg};
use super::text::pretty;
use plotters::prelude::*;
use serde::Serialize;
use std::fmt::Write;

/// One design, timed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DesignRun {
    /// Shipped profile.
    pub profile: String,
    /// Name of the method.
    pub method: String,
    /// Whether the largest error was made small.
    pub minimax: bool,
    /// Polynomial degree.
    pub degree: usize,
    /// Number of coefficients.
    pub unknowns: usize,
    /// Median run time on one core, ms.
    pub time_ms: f64,
    /// Ray error, mrad.
    pub ray_rms_mrad: f64,
    /// Largest ray error, mrad.
    pub ray_max_mrad: f64,
    /// Pixel error, pixels.
    pub pixel_rms_px: f64,
    /// Largest pixel error, pixels.
    pub pixel_max_px: f64,
}

impl DesignRun {
    /// What a line of the plot has in common.
    fn line(&self) -> String {
        format!("{}{}", self.method, if self.minimax { ", minimax" } else { "" })
    }
}

/// `bench.json`, schema 1.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Bench {
    /// Version of these keys.
    pub schema: u32,
    /// Error against degree and run time, method by method.
    pub design: Vec<DesignRun>,
    /// The shipped profiles as they are.
    pub shipped: Vec<DesignRun>,
}

impl Bench {
    /// `bench.json`.
    #[must_use]
    pub fn json(&self) -> String {
        pretty(self)
    }

    /// `design.csv`: the sweep, a line a design.
    #[must_use]
    pub fn csv(&self) -> String {
        let mut out = String::from(
            "profile,method,minimax,degree,unknowns,time_ms,ray_rms_mrad,ray_max_mrad,\
             pixel_rms_px,pixel_max_px\n",
        );
        for run in self.design.iter().chain(&self.shipped) {
            let DesignRun { profile, method, minimax, degree, unknowns, time_ms, .. } = run;
            // Writing to a string cannot fail.
            let _ = writeln!(
                out,
                "{profile},{method},{minimax},{degree},{unknowns},{time_ms:.3},{:.6e},{:.6e},\
                 {:.6e},{:.6e}",
                run.ray_rms_mrad, run.ray_max_mrad, run.pixel_rms_px, run.pixel_max_px
            );
        }
        out
    }

    /// The table for the terminal.
    #[must_use]
    pub fn text(&self) -> String {
        let mut out = String::new();
        for (title, runs) in
            [("error against degree and run time", &self.design), ("as shipped", &self.shipped)]
        {
            let _ = writeln!(
                out,
                "{title}\n  {:22}{:28}{:>6}{:>11}{:>12}{:>12}{:>12}",
                "profile", "method", "degree", "time ms", "ray rms", "ray max", "pixel max"
            );
            for run in runs {
                let _ = writeln!(
                    out,
                    "  {:22}{:28}{:>6}{:>11.2}{:>12.3e}{:>12.3e}{:>12.3e}",
                    run.profile,
                    run.line(),
                    run.degree,
                    run.time_ms,
                    run.ray_rms_mrad,
                    run.ray_max_mrad,
                    run.pixel_max_px
                );
            }
        }
        out
    }

    /// `design.svg`: for each profile of the sweep the largest ray error against degree (left) and
    /// run time (right).
    ///
    /// # Errors
    /// What the drawing library reports.
    pub fn svg(&self) -> Result<String, Failure> {
        let mut profiles: Vec<&str> = self.design.iter().map(|run| run.profile.as_str()).collect();
        profiles.dedup();
        svg((1100, 420 * profiles.len().max(1) as u32), |root| {
            for (area, profile) in root.split_evenly((profiles.len(), 1)).iter().zip(&profiles) {
                let runs: Vec<&DesignRun> =
                    self.design.iter().filter(|run| run.profile == *profile).collect();
                let [left, right] = &area.split_evenly((1, 2))[..] else { continue };
                let by_degree = |run: &DesignRun| run.degree as f64;
                panel(left, &runs, &format!("{profile}: ray error, mrad"), "degree", by_degree)?;
                panel(right, &runs, "", "run time, ms", |run| run.time_ms)?;
            }
            Ok(())
        })
    }
}

/// One chart: a line a method.
fn panel(
    area: &Area,
    runs: &[&DesignRun],
    title: &str,
    across: &str,
    x: impl Fn(&DesignRun) -> f64,
) -> Result<(), Failure> {
    let range = |values: &mut dyn Iterator<Item = f64>| {
        let (lo, hi) = values.fold((f64::INFINITY, 0.0f64), |(lo, hi), v| (v.min(lo), v.max(hi)));
        0.85 * lo..1.2 * hi
    };
    let xs = range(&mut runs.iter().map(|run| x(run)));
    let ys = range(&mut runs.iter().map(|run| run.ray_max_mrad));
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 18))
        .margin(12)
        .x_label_area_size(38)
        .y_label_area_size(56)
        .build_cartesian_2d(xs.log_scale(), ys.log_scale())?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .x_desc(across)
        .y_desc("largest ray error, mrad")
        .draw()?;
    let mut lines: Vec<String> = Vec::new();
    for run in runs {
        if !lines.contains(&run.line()) {
            lines.push(run.line());
        }
    }
    for (k, line) in lines.iter().enumerate() {
        let colour = Palette99::pick(k).to_rgba();
        let points: Vec<(f64, f64)> = runs
            .iter()
            .filter(|run| run.line() == *line)
            .map(|run| (x(run), run.ray_max_mrad))
            .collect();
        chart
            .draw_series(LineSeries::new(points.iter().copied(), colour.stroke_width(2)))?
            .label(line)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour));
        chart.draw_series(points.iter().map(|&at| Circle::new(at, 3, colour.filled())))?;
    }
    chart
        .configure_series_labels()
        .background_style(WHITE.mix(0.8))
        .border_style(BLACK.mix(0.3))
        .position(SeriesLabelPosition::UpperRight)
        .draw()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_csv_and_plot_hold_every_run() {
        let run = |degree: usize, minimax| DesignRun {
            profile: "panoramic".into(),
            method: "distribution".into(),
            minimax,
            degree,
            unknowns: degree * degree,
            time_ms: degree as f64,
            ray_rms_mrad: 7.0,
            ray_max_mrad: 30.0 / degree as f64,
            pixel_rms_px: 1.0,
            pixel_max_px: 4.0,
        };
        let design = vec![run(4, false), run(8, false), run(4, true), run(8, true)];
        let bench = Bench { schema: 1, design, shipped: vec![run(12, false)] };
        assert_eq!(bench.csv().lines().count(), 1 + 5);
        assert_eq!(bench.text().lines().count(), 4 + 5);
        let svg = bench.svg().unwrap();
        assert_eq!(svg.matches("<circle").count(), 2 * 4);
        assert!(svg.contains("distribution, minimax") && svg.contains("run time, ms"));
        assert_eq!(svg, bench.svg().unwrap());
    }
}
