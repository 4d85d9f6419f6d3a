//! What to conclude from the plots of a study.

use crate::num::sort_by_number;
use crate::results::{digits, displacement, percent};
use crate::tolerance::{SourceFacts, Study};

/// Share of the variance that the least sources may make together to be called small.
const SMALL: f64 = 0.05;
/// Largest difference of the linear model from the full trace, relative, at which its figures are relied upon.
const LINEAR: f64 = 0.1;

/// Of the sources' shares of the variance.
pub(super) fn shares(study: &Study) -> String {
    let mut sources: Vec<&SourceFacts> = study.sources.iter().collect();
    sort_by_number(&mut sources, |source| -source.share_of_variance);
    let Some(first) = sources.first().filter(|first| first.share_of_variance > 0.0) else {
        return "No error differs from part to part, so there is no variance to share.".into();
    };
    let most = 100.0 * first.share_of_variance;
    let name = &first.source;
    let mut text =
        format!("{name} makes the largest part of the variance, {most:.0} %{}.", hold(first));
    let mut left = 0.0;
    let small = sources.iter().rev().take_while(|source| {
        left += source.share_of_variance;
        left < SMALL
    });
    let small = small.count();
    if small > 1 {
        text += &format!(
            " The least {small} of {} sources make under {} % together: tightening them gains little.",
            sources.len(),
            100.0 * SMALL
        );
    }
    text
}

/// What its limit may be.
fn hold(source: &SourceFacts) -> String {
    let SourceFacts { limit, limit_joint, limit_joint_widest, unit, .. } = source;
    let own = limit.abs();
    match limit_joint {
        Some(joint) if *joint < own => {
            format!(": hold it to {} {unit} instead of {own}", digits(*joint))
        }
        Some(joint) if *joint > own && *limit_joint_widest => {
            format!(
                "; even so its limit may be {} {unit} and more instead of {own}",
                digits(*joint)
            )
        }
        Some(joint) if *joint > own => {
            format!("; its limit may be {} {unit} instead of {own}", digits(*joint))
        }
        _ => ": tightening it gains most".into(),
    }
}

/// Of the trials, of which so many lie beyond the plot.
pub(super) fn trials(study: &Study, beyond: usize) -> String {
    let Study { trials, budget_px, lost_trials, adjusted, .. } = study;
    let [p50, p95] = [adjusted.p50_px, adjusted.p95_px];
    let mut text = match (p50.is_finite(), p95.is_finite()) {
        (true, true) if *trials == 1 => {
            format!("A single part, off by {} px", displacement(p50))
        }
        (true, true) => format!(
            "Half of {trials} parts are off by up to {} px, 95 % by up to {} px",
            displacement(p50),
            displacement(p95)
        ),
        (true, false) => format!(
            "Half of {trials} parts are off by up to {} px, and more than 5 % lose rays",
            displacement(p50)
        ),
        _ => format!("At least half of {trials} parts lose rays"),
    };
    let [share, target] = [study.yields.share, study.target_yield].map(percent);
    let enough = if share >= target { "enough" } else { "too few" };
    text += &format!(
        "; {share:.1} % keep the budget of {budget_px} px, {enough}: {target} % are asked."
    );
    if beyond > 0 {
        text += &format!(" {beyond} lie beyond the plot.");
    }
    if *lost_trials > 0 {
        text += &format!(" {lost_trials} lose rays and are in no bar.");
    }
    text
}

/// Of the linear model against the full trace.
pub(super) fn linearity(study: &Study) -> String {
    let gap = &study.gap;
    if !gap.relative.is_finite() {
        return "No trial keeps all its rays, so there is nothing to compare.".into();
    }
    let meaning = if gap.relative <= LINEAR {
        "the shares and limits, which rest on first derivatives, can be relied upon"
    } else {
        "take the shares and limits, which rest on first derivatives, as a guide only"
    };
    let trials =
        if gap.trials == 1 { "one trial".into() } else { format!("{} trials", gap.trials) };
    let percents = 100.0 * gap.relative;
    format!("Over {trials} both differ by {percents:.1} % (RMS, of the mean): {meaning}.")
}

/// Of the yield against the budget, from the sorted figures of the trials.
pub(super) fn yields_kept(study: &Study, figures: &[f64]) -> String {
    let Study { budget_px, yields, .. } = study;
    let target = percent(study.target_yield);
    let rank = (study.target_yield * figures.len() as f64).ceil().max(1.0) as usize;
    let kept = figures.get(rank - 1).copied().filter(|px| px.is_finite());
    let room = match kept {
        None => format!("No budget is kept by {target} % of the parts: too many lose rays."),
        Some(px) if px <= *budget_px => format!(
            "{target} % of the parts would keep a budget of {} px as well; {budget_px} px is {:.1} times that.",
            displacement(px),
            budget_px / px
        ),
        Some(px) => format!(
            "{target} % of the parts would keep a budget of {} px, but not {budget_px} px: widen the budget or tighten \
             the limits.",
            displacement(px)
        ),
    };
    let [low, high] = [yields.low, yields.high].map(|share| 100.0 * share);
    format!(
        "{room} The band is the yield's 95 % interval, at the budget {low:.1} to {high:.1} %: more trials make it \
         narrower."
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tolerance::Distribution;

    fn source(limit: f64, limit_joint: Option<f64>, limit_joint_widest: bool) -> SourceFacts {
        SourceFacts {
            source: "tilt_x_mrad".into(),
            unit: "mrad",
            limit,
            distribution: Distribution::Uniform,
            weight: 1.0,
            systematic: false,
            minus_px: 0.1,
            plus_px: 0.1,
            minus_adjusted_px: 0.1,
            plus_adjusted_px: 0.1,
            spread: crate::tolerance::BlurAndScatter::default(),
            share_of_variance: 0.5,
            limit_alone: None,
            limit_joint,
            limit_joint_widest,
        }
    }

    #[test]
    fn a_limit_is_said_to_be_tightened_or_widened_as_it_is_allocated() {
        let told = |joint, widest| hold(&source(-0.5, joint, widest));
        assert_eq!(told(Some(0.05), false), ": hold it to 0.050 mrad instead of 0.5");
        assert_eq!(told(Some(0.8), false), "; its limit may be 0.800 mrad instead of 0.5");
        assert!(told(Some(2.0), true).contains("2.000 mrad and more instead of 0.5"));
        for none in [None, Some(0.5)] {
            assert_eq!(told(none, false), ": tightening it gains most");
        }
    }
}
