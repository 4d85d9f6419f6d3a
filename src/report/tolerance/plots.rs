//! The plots of a study of tolerances, as SVG.

use crate::report::plot::{Area, BLUE, Failure, GREEN, RED, svg};
use crate::results::percent;
use crate::tolerance::{Criterion, PlotData, Statistics, Study};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Two side by side on A4 have letters of 6 points.
const SIZE: (u32, u32) = (720, 540);
const LABEL: i32 = 23;
const TICK: i32 = 22;
/// Sources with bars of their own.
const BARS: usize = 10;
const BINS: usize = 30;
/// Height of a histogram against its highest bar: names of percentiles go above.
const HEADROOM: f64 = 1.4;

/// A plot with what it shows in words.
pub(super) struct Plot {
    /// Its title.
    pub title: &'static str,
    /// The drawing.
    pub svg: String,
    /// What it shows.
    pub caption: String,
}

/// All plots of a study.
///
/// # Errors
/// What the drawing library reports.
pub(super) fn plots(study: &Study, points: &PlotData) -> Result<[Plot; 4], Failure> {
    let plot = |title, caption: String, draw: &dyn Fn(&Area) -> Result<(), Failure>| {
        Ok::<_, Failure>(Plot { title, svg: svg(SIZE, draw)?, caption })
    };
    let figure = figure(study);
    let lost = points.figures.iter().filter(|x| !x.is_finite()).count();
    let lost = if lost == 0 { String::new() } else { format!(" {lost} trials lose rays.") };
    let percent = percent(study.target_yield);
    Ok([
        plot(
            "Shares of the variance",
            "What makes the variance after adjustment, by first derivatives, and its sum.".into(),
            &|area| pareto(area, study),
        )?,
        plot(
            "Monte Carlo, full traces",
            format!("{} trials: {figure}, and the share below.{lost}", study.trials),
            &|area| histogram(area, study, points),
        )?,
        plot(
            "Linear model against full trace",
            format!(
                "First derivatives against the full trace, {} trials; on the line both agree.",
                points.pairs.len()
            ),
            &|area| scatter(area, study, points),
        )?,
        plot(
            "Yield against budget",
            format!(
                "Yield against budget, with its 95 % interval. Asked: {percent} % within {} px.",
                study.budget_px
            ),
            &|area| yields(area, study, points),
        )?,
    ])
}

/// What counts, in words.
fn figure(study: &Study) -> &'static str {
    match study.criterion {
        Criterion::Rms => "RMS displacement",
        Criterion::P95 => "P95 displacement",
    }
}

fn font(size: i32) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&BLACK)
}

/// A number on an axis.
fn tick(x: &f64) -> String {
    // Steps from a negative end meet zero to rounding.
    if x.abs() < 1e-12 {
        return "0".into();
    }
    if x.abs() < 1e-2 {
        return format!("{x:.1e}");
    }
    format!("{x:.4}").trim_end_matches('0').trim_end_matches('.').into()
}

/// What an axis has beyond both ends of its figures.
fn room(least: f64, most: f64, study: &Study) -> f64 {
    let room = 0.05 * (most - least);
    if room > 1e-9 * study.budget_px { room } else { 0.05 * study.budget_px }
}

fn percents(share: &f64) -> String {
    tick(&(100.0 * share))
}

fn builder<'a, 'b>(area: &'a Area<'b>) -> ChartBuilder<'a, 'b, SVGBackend<'b>> {
    let mut builder = ChartBuilder::on(area);
    builder.margin(14).margin_right(30).x_label_area_size(60).y_label_area_size(85);
    builder
}

/// The sources' shares of the variance, the largest first; beyond [`BARS`] of them the others' sum.
fn largest_shares(study: &Study) -> Vec<(String, f64)> {
    let mut shares: Vec<(String, f64)> =
        study.sources.iter().map(|s| (s.source.clone(), s.share_of_variance)).collect();
    shares.sort_by(|a, b| b.1.total_cmp(&a.1));
    if shares.len() > BARS + 1 {
        let rest = shares.split_off(BARS);
        let share = rest.iter().map(|s| s.1).sum();
        shares.push((format!("{} others", rest.len()), share));
    }
    shares
}

/// The text of the `k`-th share, beside its bar: inside where there is no room.
fn share_text(k: usize, share: f64, row: i32) -> Text<'static, (f64, SegmentValue<i32>), String> {
    let (at, side, colour) = match k {
        0 if share > 0.8 => (share - 0.02, HPos::Right, &WHITE),
        0 => (share + 0.02, HPos::Left, &BLACK),
        _ => (share + 0.01, HPos::Left, &BLACK),
    };
    let style = font(TICK).color(colour).pos(Pos::new(side, VPos::Center));
    Text::new(format!("{:.1} %", 100.0 * share), (at, SegmentValue::CenterOf(row)), style)
}

/// Bars of the sources' shares, and their sum.
fn pareto(area: &Area, study: &Study) -> Result<(), Failure> {
    let shares = largest_shares(study);
    // The axis goes from segment to segment, so there are two at least.
    let count = shares.len().max(2) as i32;
    // From above.
    let named = |at: &SegmentValue<i32>| match at {
        SegmentValue::CenterOf(k) => {
            shares.get((count - 1 - k) as usize).map_or(String::new(), |s| s.0.clone())
        }
        _ => String::new(),
    };
    let mut chart = builder(area)
        .y_label_area_size(205)
        .build_cartesian_2d(0.0..1.0, (0..count - 1).into_segmented())?;
    chart
        .configure_mesh()
        .disable_y_mesh()
        .light_line_style(TRANSPARENT)
        .y_labels(count as usize)
        .y_label_formatter(&named)
        .x_label_formatter(&percents)
        .x_desc("share of the variance, %")
        .label_style(font(TICK))
        .axis_desc_style(font(LABEL))
        .draw()?;
    let (mut sum, mut sums) = (0.0, Vec::new());
    for (k, (_, share)) in shares.iter().enumerate() {
        let row = count - 1 - k as i32;
        let below = SegmentValue::Exact(row);
        let above = if k == 0 { SegmentValue::Last } else { SegmentValue::Exact(row + 1) };
        let mut bar = Rectangle::new([(0.0, below), (*share, above)], BLUE.filled());
        bar.set_margin(6, 6, 0, 0);
        chart.draw_series([bar])?;
        sum += share;
        // Out of the way of the sums' line.
        if sum - share > 0.12 || k == 0 {
            chart.draw_series([share_text(k, *share, row)])?;
        }
        sums.push((sum, SegmentValue::CenterOf(row)));
    }
    let line = LineSeries::new(sums.clone(), RED.stroke_width(3));
    chart
        .draw_series(line)?
        .label("sum")
        .legend(|(x, y)| PathElement::new([(x, y), (x + 24, y)], RED.stroke_width(3)));
    chart.draw_series(sums.into_iter().map(|at| Circle::new(at, 5, RED.filled())))?;
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerMiddle)
        .label_font(font(LABEL))
        .border_style(BLACK.mix(0.3))
        .background_style(WHITE)
        .draw()?;
    Ok(())
}

/// The percentiles that a histogram names, px.
fn percentiles(of: &Statistics) -> [(&'static str, f64); 5] {
    [
        ("P50", of.p50_px),
        ("P80", of.p80_px),
        ("P90", of.p90_px),
        ("P95", of.p95_px),
        ("P99", of.p99_px),
    ]
}

/// Where the figures lie, with the budget, the percentiles and the share below.
fn histogram(area: &Area, study: &Study, points: &PlotData) -> Result<(), Failure> {
    let finite = || points.figures.iter().copied().filter(|x| x.is_finite());
    let (lo, hi) = finite().fold((f64::INFINITY, 0.0f64), |(lo, hi), x| (lo.min(x), hi.max(x)));
    let (lo, hi) = if lo <= hi { (lo, hi) } else { (0.0, study.budget_px) };
    let (least, most) = (lo.min(study.budget_px), hi.max(study.budget_px));
    let room = room(least, most, study);
    let width = ((hi - lo) / BINS as f64).max(1e-3 * room);
    let mut bins = [0.0; BINS];
    for x in finite() {
        let k = ((x - lo) / width) as usize;
        bins[k.min(BINS - 1)] += 1.0 / points.figures.len() as f64;
    }
    let top = HEADROOM * bins.iter().copied().fold(0.0, f64::max).max(0.01);
    let xs = least - room..most + room;
    let mut chart = builder(area)
        .right_y_label_area_size(80)
        .margin_right(14)
        .build_cartesian_2d(xs.clone(), 0.0..top)?
        .set_secondary_coord(xs, 0.0..HEADROOM);
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .x_label_formatter(&tick)
        .y_label_formatter(&percents)
        .x_desc(format!("{}, px", figure(study)))
        .y_desc("share of the trials in a bar, %")
        .label_style(font(TICK))
        .axis_desc_style(font(LABEL))
        .draw()?;
    chart
        .configure_secondary_axes()
        .y_label_formatter(&|share| if *share > 1.001 { String::new() } else { percents(share) })
        .y_desc("share below, %")
        .label_style(font(TICK))
        .axis_desc_style(font(LABEL))
        .draw()?;
    chart.draw_series(bins.iter().enumerate().map(|(k, &share)| {
        let from = lo + k as f64 * width;
        Rectangle::new([(from, 0.0), (from + width, share)], BLUE.mix(0.55).filled())
    }))?;
    let count = points.figures.len() as f64;
    let below = finite().enumerate().map(|(k, x)| (x, (k + 1) as f64 / count));
    chart.draw_secondary_series(LineSeries::new(below, BLACK.stroke_width(3)))?;
    let finite = percentiles(&study.adjusted).into_iter().enumerate();
    for (k, (name, x)) in finite.filter(|(_, (_, x))| x.is_finite()) {
        let line = [(x, 0.0), (x, top)];
        let dashes = DashedLineSeries::new(line, 8, 6, BLACK.mix(0.6).stroke_width(2));
        chart.draw_series(dashes)?;
        // Neighbours at different heights.
        let at = (x, top * (0.99 - 0.054 * k as f64));
        chart.draw_series([Text::new(format!(" {name}"), at, font(TICK))])?;
    }
    let budget = study.budget_px;
    chart.draw_series([PathElement::new([(budget, 0.0), (budget, top)], RED.stroke_width(4))])?;
    let left = budget > 0.5 * (least + most);
    let side = if left { HPos::Right } else { HPos::Left };
    let style = font(LABEL).color(&RED).pos(Pos::new(side, VPos::Top));
    chart.draw_series([Text::new(" budget ".to_owned(), (budget, 0.6 * top), style)])?;
    Ok(())
}

/// Both ways to the figure, trial by trial.
fn scatter(area: &Area, study: &Study, points: &PlotData) -> Result<(), Failure> {
    let pairs = || points.pairs.iter().filter(|pair| pair.iter().all(|x| x.is_finite()));
    let all = || pairs().flatten().copied();
    let (lo, hi) = all().fold((f64::INFINITY, 0.0f64), |(lo, hi), x| (lo.min(x), hi.max(x)));
    let (lo, hi) = if lo <= hi { (lo, hi) } else { (0.0, study.budget_px) };
    let room = room(lo, hi, study);
    let range = lo - room..hi + room;
    let mut chart = builder(area).build_cartesian_2d(range.clone(), range)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .x_label_formatter(&tick)
        .y_label_formatter(&tick)
        .x_desc(format!("full trace: {}, px", figure(study)))
        .y_desc("first derivatives: the same, px")
        .label_style(font(TICK))
        .axis_desc_style(font(LABEL))
        .draw()?;
    let diagonal = [(lo - room, lo - room), (hi + room, hi + room)];
    chart.draw_series([PathElement::new(diagonal, RED.stroke_width(3))])?;
    chart.draw_series(pairs().map(|&[x, y]| Circle::new((x, y), 3, BLUE.mix(0.6).filled())))?;
    Ok(())
}

/// The share of parts that keep a budget.
fn yields(area: &Area, study: &Study, points: &PlotData) -> Result<(), Failure> {
    let least = points.yields.first().map_or(0.0, |first| first.0);
    let most = points.yields.last().map_or(study.budget_px, |last| last.0);
    let xs = least..most;
    let mut chart = builder(area).build_cartesian_2d(xs, 0.0..1.0)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .x_label_formatter(&tick)
        .y_label_formatter(&percents)
        .x_desc(format!("budget for the {}, px", figure(study)))
        .y_desc("yield, %")
        .label_style(font(TICK))
        .axis_desc_style(font(LABEL))
        .draw()?;
    let upper = points.yields.iter().map(|(x, y)| (*x, y.high));
    let lower = points.yields.iter().rev().map(|(x, y)| (*x, y.low));
    let band: Vec<(f64, f64)> = upper.chain(lower).collect();
    chart.draw_series([Polygon::new(band, BLUE.mix(0.3).filled())])?;
    let middle = points.yields.iter().map(|(x, y)| (*x, y.share));
    chart.draw_series(LineSeries::new(middle, BLUE.stroke_width(3)))?;
    let target = study.target_yield;
    let across = [(least, target), (most, target)];
    chart.draw_series(DashedLineSeries::new(across, 10, 7, GREEN.stroke_width(3)))?;
    let style = font(LABEL).color(&GREEN);
    let name = format!("target {} %", percent(target));
    chart.draw_series([Text::new(name, (least + 0.01 * (most - least), target - 0.01), style)])?;
    let budget = study.budget_px;
    chart.draw_series([PathElement::new([(budget, 0.0), (budget, 1.0)], RED.stroke_width(3))])?;
    let side = if budget > 0.5 * (least + most) { HPos::Right } else { HPos::Left };
    let style = font(LABEL).color(&RED).pos(Pos::new(side, VPos::Top));
    chart.draw_series([Text::new(" budget ".to_owned(), (budget, 0.15), style)])?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_short() {
        for (x, text) in
            [(0.0, "0"), (-1e-17, "0"), (0.25, "0.25"), (10.0, "10"), (1.2e-3, "1.2e-3")]
        {
            assert_eq!(tick(&x), text);
        }
        assert_eq!(percents(&0.1), "10");
    }
}
