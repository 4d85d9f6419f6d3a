//! Sweeps of a benchmark as plots of error against run time.

use super::{BenchRun, BenchSweep};
use crate::num::rounding::significant;
use crate::raster::Canvas;
use crate::report::{Failure, svg};
use plotters::coord::Shift;
use plotters::prelude::*;
use std::ops::Range;

const SIZE: (u32, u32) = (1240, 640);
const LETTERS: i32 = 15;
/// Room for the names of curves, and for a piece of each before it, pixels.
const NAMES: i32 = 375;
const PIECE: i32 = 28;

impl BenchSweep {
    /// Error against run time, both logarithmic: a curve a profile and series, with rings around the
    /// runs that no other of their profile beats in both.
    ///
    /// # Errors
    /// What the drawing library reports.
    pub fn svg(&self) -> Result<String, Failure> {
        svg(SIZE, |root| self.draw(root))
    }

    /// The same as PNG.
    ///
    /// # Errors
    /// What the drawing library or the encoder reports.
    pub fn png(&self) -> Result<Vec<u8>, Failure> {
        let mut canvas = Canvas::new(SIZE.0, SIZE.1);
        {
            let root = canvas.into_drawing_area();
            self.draw(&root)?;
            root.present()?;
        }
        Ok(canvas.png()?)
    }

    fn draw<B: DrawingBackend>(&self, root: &DrawingArea<B, Shift>) -> Result<(), Failure>
    where
        B::ErrorType: 'static,
    {
        // What is no error has no place on a logarithmic axis.
        let shown = |run: &&BenchRun| run.error > 0.0 && run.error.is_finite();
        let runs: Vec<&BenchRun> = self.runs.iter().filter(shown).collect();
        let font = ("sans-serif", LETTERS);
        let mut chart = ChartBuilder::on(root)
            .caption(self.about, ("sans-serif", 20))
            .margin(12)
            .margin_right(NAMES + 15)
            .x_label_area_size(44)
            .y_label_area_size(76)
            .build_cartesian_2d(
                around(runs.iter().map(|run| run.time_ms)).log_scale(),
                around(runs.iter().map(|run| run.error)).log_scale(),
            )?;
        let power = |x: &f64| match (1e-3..1e5).contains(x) {
            // Ticks are off their round numbers by roundings.
            true => significant(*x, 1).to_string(),
            false => format!("{x:.0e}"),
        };
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .x_labels(6)
            .y_labels(8)
            .x_label_formatter(&power)
            .y_label_formatter(&power)
            .label_style(font)
            .x_desc("run time, ms")
            .y_desc(self.error)
            .draw()?;
        let mut line = FIRST_LINE;
        for curve in curves(&runs) {
            let points = || curve.runs.iter().map(|run| (run.time_ms, run.error));
            let stroke = curve.colour.stroke_width(2);
            if curve.dash == 0 {
                chart.draw_series(LineSeries::new(points(), stroke))?;
            } else {
                let points: Vec<(f64, f64)> = points().collect();
                let [ink, gap] = curve.strokes();
                chart.draw_series(DashedLineSeries::new(points, ink, gap, stroke))?;
            }
            chart.draw_series(points().map(|at| Circle::new(at, 2, curve.colour.filled())))?;
            let best = curve.runs.iter().filter(|run| run.pareto);
            let ring =
                |run: &&BenchRun| Circle::new((run.time_ms, run.error), 5, BLACK.stroke_width(1));
            chart.draw_series(best.map(ring))?;
            curve.draw_name(root, line)?;
            line += LINE;
        }
        Ok(())
    }
}

/// The line of the first curve's name, and from line to line, pixels.
const FIRST_LINE: i32 = 48;
const LINE: i32 = 17;

/// The runs of a profile and series.
struct Curve<'a> {
    name: String,
    colour: RGBAColor,
    /// Number of the series among those of its profile.
    dash: usize,
    runs: Vec<&'a BenchRun>,
}

/// The curves of a sweep, each profile's in a colour of its own.
fn curves<'a>(runs: &[&'a BenchRun]) -> Vec<Curve<'a>> {
    let mut profiles: Vec<&str> = runs.iter().map(|run| &*run.profile).collect();
    profiles.dedup();
    let mut curves = Vec::new();
    for (k, profile) in profiles.iter().enumerate() {
        let of_profile = || runs.iter().copied().filter(|run| run.profile == *profile);
        let colour = HSLColor(k as f64 / profiles.len() as f64, 0.9, 0.38).to_rgba();
        let mut series: Vec<&str> = Vec::new();
        for run in of_profile() {
            if !series.contains(&&*run.series) {
                series.push(&run.series);
            }
        }
        curves.extend(series.iter().enumerate().map(|(dash, series)| {
            let runs = of_profile().filter(|run| run.series == *series).collect();
            let name = match series.is_empty() {
                true => (*profile).to_owned(),
                false => format!("{profile}, {series}"),
            };
            Curve { name, colour, dash, runs }
        }));
    }
    curves
}

impl Curve<'_> {
    /// Lengths of the strokes and of the gaps between them, pixels.
    fn strokes(&self) -> [i32; 2] {
        let dash = self.dash as i32;
        [12 - 2 * dash.min(4), 4 * dash]
    }

    /// Draws a piece of the curve and its name, unless the drawing ends above.
    fn draw_name<B: DrawingBackend>(
        &self,
        root: &DrawingArea<B, Shift>,
        line: i32,
    ) -> Result<(), Failure>
    where
        B::ErrorType: 'static,
    {
        let (width, height) = root.dim_in_pixel();
        if line >= height as i32 - 20 {
            return Ok(());
        }
        let ([ink, gap], legend) = (self.strokes(), width as i32 - NAMES);
        for at in (0..PIECE).step_by((ink + gap) as usize) {
            let end = if self.dash == 0 { PIECE } else { PIECE.min(at + ink) };
            let dash = [(legend + at, line + 5), (legend + end, line + 8)];
            root.draw(&Rectangle::new(dash, self.colour.filled()))?;
        }
        let font = ("sans-serif", LETTERS);
        root.draw(&Text::new(self.name.clone(), (legend + PIECE + 6, line), font))?;
        Ok(())
    }
}

/// Powers of ten around all of `values`.
fn around(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (lo, hi) = values.fold((f64::INFINITY, 0.0f64), |(lo, hi), x| (lo.min(x), hi.max(x)));
    if lo > 0.0 && lo < hi { decade(lo)..10.0 * decade(hi) } else { 0.1..10.0 }
}

/// The largest power of ten that is not over `x`.
fn decade(x: f64) -> f64 {
    let digits = format!("{x:e}");
    let power = digits.split_once('e').map_or("0", |(_, power)| power);
    format!("1e{power}").parse().unwrap_or(1.0)
}

#[cfg(test)]
mod tests {
    use super::super::results::tests::sweep;

    #[test]
    fn axes_run_from_decade_to_decade() {
        let around = |values: &[f64]| super::around(values.iter().copied());
        assert_eq!(around(&[0.0123, 9.99]), 0.01..10.0);
        assert_eq!(around(&[3.0, 2.0, 7.5]), 1.0..10.0);
        assert_eq!(around(&[1e-14, 250.0]), 1e-14..1000.0);
        assert_eq!(around(&[]), 0.1..10.0);
    }

    /// Rows of pixels.
    fn pixels(png: Vec<u8>) -> Vec<Vec<[u8; 3]>> {
        let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
        let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut rgb).unwrap();
        let (pixels, _) = rgb.as_chunks::<3>();
        pixels.chunks(super::SIZE.0 as usize).map(<[_]>::to_vec).collect()
    }

    #[test]
    fn the_longest_name_is_not_cut_off() {
        let mut sweep = sweep();
        for run in &mut sweep.runs {
            run.profile = "conquistador".into();
            run.series = "fixed-surface, minimax".into();
        }
        let rows = pixels(sweep.png().unwrap());
        let is_white = |row: &Vec<[u8; 3]>| row[row.len() - 5..].iter().all(|p| *p == [255; 3]);
        assert!(rows.iter().all(is_white));
    }

    #[test]
    fn every_run_is_a_point_and_the_best_have_rings() {
        let sweep = sweep();
        let svg = sweep.svg().unwrap();
        assert_eq!(svg.matches("<circle").count(), 6 + 3);
        assert!(svg.contains("panoramic, b") && svg.contains("surplus_mrad"));
        assert_eq!(svg, sweep.svg().unwrap());
        let rows = pixels(sweep.png().unwrap());
        let inked = rows.concat().into_iter().filter(|p| *p != [255; 3]).count();
        assert!((5_000..100_000).contains(&inked), "{inked} pixels");
    }
}
