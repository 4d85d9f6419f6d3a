//! The plots of a study of tolerances.

use super::conclusions::{linearity, shares, trials, yields_kept};
use crate::num::sort_by_number;
use crate::report::page::Figure;
use crate::report::plot::{Anchor, Axis, Diagram, Ink, Marker, Plot, Stroke};
use crate::results::percent;
use crate::tolerance::{Criterion, PlotData, Study};

/// Width and height of a plot, units.
const SIZE: [f64; 2] = [440.0, 320.0];
/// Sources with bars of their own.
const BARS: usize = 10;
const BINS: usize = 24;
/// Height of a histogram against its highest bar: labels of percentiles go above.
const HEADROOM: f64 = 1.4;
/// Lengths of the trials' range within which a budget is drawn: beyond, bars would be slivers.
const NEAR: f64 = 4.0;

/// All plots of a study, with what to conclude from each.
pub(super) fn figures(study: &Study, points: &PlotData) -> [Figure; 4] {
    let figure = |title: &str, diagram: Diagram, caption: String| Figure {
        title: title.into(),
        body: diagram.svg(title),
        caption,
    };
    let range = TrialRange::of(&points.figures, study.budget_px);
    [
        figure("Shares of the variance", shares_plot(study), shares(study)),
        figure(
            "Displacement of the trials",
            histogram(study, points, &range),
            trials(study, range.beyond),
        ),
        figure(
            "First derivatives against the full trace",
            scatter(study, points),
            linearity(study),
        ),
        figure(
            "Yield against budget",
            yields(study, points, &range),
            yields_kept(study, &points.figures),
        ),
    ]
}

/// What counts, in words.
fn criterion(study: &Study) -> &'static str {
    match study.criterion {
        Criterion::Rms => "RMS displacement",
        Criterion::P95 => "P95 displacement",
    }
}

/// Where the figures of the trials lie, without outliers.
struct TrialRange {
    /// The least figure, px.
    least_px: f64,
    /// The largest, or where that is far beyond P99, as far beyond P99 as that is from the least, px.
    most_px: f64,
    /// Trials beyond it that lose no rays.
    beyond: usize,
}

impl TrialRange {
    /// The range of sorted figures, of which lost ones are infinite; that of a budget where all are.
    fn of(figures: &[f64], budget_px: f64) -> Self {
        let finite = &figures[..figures.partition_point(|x| x.is_finite())];
        let (Some(&least_px), Some(&worst_px)) = (finite.first(), finite.last()) else {
            return Self { least_px: 0.0, most_px: budget_px, beyond: 0 };
        };
        let p99_px = finite[(99 * finite.len()).div_ceil(100) - 1];
        let most_px = worst_px.min(p99_px + (p99_px - least_px));
        let beyond = finite.iter().filter(|x| **x > most_px).count();
        Self { least_px, most_px, beyond }
    }

    fn length_px(&self) -> f64 {
        (self.most_px - self.least_px).max(0.02 * self.most_px)
    }

    /// Both ends, with the budget if it is not far off.
    fn with_near(&self, budget_px: f64) -> [f64; 2] {
        let Self { least_px, most_px, .. } = *self;
        let (low, high) = (least_px.min(budget_px), most_px.max(budget_px));
        if high - low <= NEAR * self.length_px() { [low, high] } else { [least_px, most_px] }
    }
}

/// The sources' shares of the variance, the largest first; beyond [`BARS`] of them the others' sum.
fn largest_shares(study: &Study) -> Vec<(String, f64)> {
    let mut shares: Vec<(String, f64)> =
        study.sources.iter().map(|s| (s.source.clone(), s.share_of_variance)).collect();
    sort_by_number(&mut shares, |share| -share.1);
    if shares.len() > BARS + 1 {
        let rest = shares.split_off(BARS);
        let share = rest.iter().map(|s| s.1).sum();
        shares.push((format!("{} others", rest.len()), share));
    }
    shares
}

/// Bars of the sources' shares, each with the sum from the largest to it.
fn shares_plot(study: &Study) -> Diagram {
    let shares = largest_shares(study);
    let most = shares.iter().map(|share| 100.0 * share.1).fold(1.0, f64::max);
    // Right of the longest bar is room for its text and for the sums.
    let mut x = Axis::linear([0.0, 1.8 * most], "share of the variance, %");
    x.ticks.retain(|tick| tick.0 <= most.max(0.5 * x.ends[1]).min(100.0));
    let y = Axis::of_rows(shares.iter().map(|share| share.0.clone()));
    let mut diagram = Diagram::new(SIZE[0], SIZE[1]);
    let mut plot = Plot::new(&mut diagram, &x, &y);
    let (end, mut sum) = (x.ends[1], 0.0);
    for (row, (_, share)) in (0..).map(f64::from).zip(&shares) {
        let share = 100.0 * share;
        sum += share;
        plot.bar(Ink::Blue, [[0.0, row + 0.15], [share, row + 0.85]]);
        let text = format!("{share:.1} %");
        plot.label(Ink::Text, [share, row + 0.5], [5.0, 4.0], Anchor::Start, &text);
        let text = format!("sum {sum:.1} %");
        plot.label(Ink::Faint, [end, row + 0.5], [0.0, 4.0], Anchor::End, &text);
    }
    diagram
}

/// Where the figures lie, with the budget and percentiles.
fn histogram(study: &Study, points: &PlotData, range: &TrialRange) -> Diagram {
    let TrialRange { least_px, most_px, .. } = *range;
    let width = range.length_px() / BINS as f64;
    let mut bins = [0.0; BINS];
    for x in points.figures.iter().filter(|x| **x <= most_px) {
        let k = ((x - least_px) / width) as usize;
        bins[k.min(BINS - 1)] += 100.0 / points.figures.len() as f64;
    }
    let top = HEADROOM * bins.iter().copied().fold(0.0, f64::max).max(1.0);
    let x = Axis::around(range.with_near(study.budget_px), format!("{}, px", criterion(study)));
    let y = Axis::linear([0.0, top], "share of the trials in a bar, %");
    let mut diagram = Diagram::new(SIZE[0], SIZE[1]);
    let mut plot = Plot::new(&mut diagram, &x, &y);
    for (k, share) in bins.into_iter().enumerate().filter(|(_, share)| *share > 0.0) {
        let [from, to] = [k, k + 1].map(|k| least_px + k as f64 * width);
        plot.bar(Ink::Blue, [[from, 0.0], [to, share]]);
    }
    let s = &study.adjusted;
    let percentiles = [("P50", s.p50_px), ("P95", s.p95_px), ("P99", s.p99_px)];
    let shown = percentiles.into_iter().filter(|(_, px)| *px <= x.ends[1]);
    let lines: Vec<_> =
        shown.map(|(name, px)| (Stroke::dashed(Ink::Text, 1.2), px, name)).collect();
    draw_budget(&mut plot, &x, study, lines);
    diagram
}

/// Draws upright lines, and the budget or, where the axis ends before it, on which side it lies.
fn draw_budget(plot: &mut Plot, x: &Axis, study: &Study, lines: Vec<(Stroke, f64, &str)>) {
    let (budget, [low, high]) = (study.budget_px, x.ends);
    let label = format!("budget {budget} px");
    let mut lines: Vec<(Stroke, f64, &str)> = lines;
    let is_shown = (low..=high).contains(&budget);
    if is_shown {
        lines.push((Stroke::solid(Ink::Red, 2.0), budget, &label));
    }
    plot.mark_x(&lines);
    if budget > high {
        plot.corner_label(Anchor::End, &format!("{label}: to the right"));
    } else if !is_shown {
        plot.corner_label(Anchor::Start, &format!("{label}: to the left"));
    }
}

/// Both ways to the figure, trial by trial.
fn scatter(study: &Study, points: &PlotData) -> Diagram {
    let mut both: Vec<f64> = points.pairs.iter().flatten().copied().collect();
    both.sort_by(f64::total_cmp);
    let TrialRange { least_px, most_px, .. } = TrialRange::of(&both, study.budget_px);
    let axis =
        |way: &str| Axis::around([least_px, most_px], format!("{way}: {}, px", criterion(study)));
    let (x, y) = (axis("full trace"), axis("first derivatives"));
    let mut diagram = Diagram::new(SIZE[0], SIZE[1]);
    let mut plot = Plot::new(&mut diagram, &x, &y);
    let shown = |pair: &&[f64; 2]| pair.iter().all(|px| *px <= most_px);
    let pairs = points.pairs.iter().filter(shown).copied();
    plot.points((Ink::Blue, Marker::Disc, 2.5), pairs);
    let [low, high] = x.ends;
    plot.line(Stroke::solid(Ink::Red, 1.5), [[low, low], [high, high]]);
    plot.label(Ink::Red, [high, high], [-40.0, 18.0], Anchor::End, "both agree");
    diagram
}

/// The share of parts that keep a budget, with its interval.
fn yields(study: &Study, points: &PlotData, range: &TrialRange) -> Diagram {
    let most = 1.05 * range.most_px.max(study.budget_px);
    let shown: Vec<_> = points.yields.iter().filter(|(px, _)| *px <= most).collect();
    let least = shown.first().map_or(0.0, |first| first.0);
    let x = Axis::linear([least, most], format!("budget for the {}, px", criterion(study)));
    let y = Axis::linear([0.0, 100.0], "yield, %");
    let mut diagram = Diagram::new(SIZE[0], SIZE[1]);
    let mut plot = Plot::new(&mut diagram, &x, &y);
    let upper = shown.iter().map(|(px, share)| [*px, 100.0 * share.high]);
    let lower = shown.iter().rev().map(|(px, share)| [*px, 100.0 * share.low]);
    plot.outline((Ink::Blue, 0.3), upper.chain(lower));
    let middle = shown.iter().map(|(px, share)| [*px, 100.0 * share.share]);
    plot.line(Stroke::solid(Ink::Blue, 2.0), middle);
    let target = percent(study.target_yield);
    plot.mark_y(Stroke::dashed(Ink::Green, 2.0), target, &format!("asked {target} %"));
    draw_budget(&mut plot, &x, study, Vec::new());
    diagram
}
