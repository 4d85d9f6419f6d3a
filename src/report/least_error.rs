//! The least error that any single mirror has, in words.

use super::answer::{Answer, AnswerRows, Head, ToRows};
use crate::design::{LeastError, SQUARE};
use crate::profile::AcceptanceLimits;
use crate::results::{ProfileCheck, three_digits};

/// The least error as a sentence without its full stop.
pub(super) fn least_error_sentence(least: &LeastError) -> String {
    let LeastError { pixel_rms_px, ray_rms_deg, worst } = least;
    if least.is_exact() {
        return "a mirror without error exists".into();
    }
    let [px, deg] = [*pixel_rms_px, *ray_rms_deg].map(three_digits);
    let mut sentence =
        format!("to first order no single mirror is off by less than {px} px RMS ({deg} deg RMS)");
    if let Some(worst) = worst {
        let [own, best] = [worst.own_px, worst.best_px].map(three_digits);
        sentence += &format!(
            "; its curl is most at the picture's {}, where a square of {SQUARE} of the width is off by {own} px for itself, \
             and least where one is by {best} px",
            worst.name()
        );
    }
    sentence
}

impl ToRows for LeastError {
    fn add_to(&self, rows: &mut AnswerRows) {
        rows.named("least", "least possible error", least_error_sentence(self));
    }
}

/// Why there is no less, and what to do.
fn add_why(rows: &mut AnswerRows, least: &LeastError, accepted: &AcceptanceLimits) {
    if least.is_exact() {
        return;
    }
    rows.terminal(
        "why",
        "a mirror is one function of the image point, and the picture asks for two slopes at each: where they have curl they \
         are those of no surface",
    );
    let (px, limit) = (three_digits(least.pixel_rms_px), accepted.pixel_error_rms_px.value);
    rows.terminal(
        "do",
        match least.pixel_rms_px <= limit {
            true => format!("accept.pixel_error_rms_px = {limit} is not below that"),
            false => format!(
                "accept.pixel_error_rms_px = {limit} cannot be met by a single mirror: accept more than {px}, or ask for a \
                 narrower field, another centre or law, or a panel for each part"
            ),
        },
    );
}

impl Answer for ProfileCheck {
    fn head(&self) -> Head<'_> {
        Head::default()
    }

    fn rows(&self) -> AnswerRows {
        let Self { profile, least_error, alternatives, accepted, unsolved } = self;
        let mut rows = AnswerRows::labelled(5);
        rows.line(format!("{}: valid ({})", profile.name, profile.sha256));
        least_error.add_to(&mut rows);
        if let Some((least, accepted)) = least_error.as_ref().zip(accepted.as_ref()) {
            add_why(&mut rows, least, accepted);
        }
        for changed in alternatives {
            let least = &changed.least_error;
            let then = match least.is_exact() {
                true => "a mirror without error exists".into(),
                false => format!("no less than {} px RMS", three_digits(least.pixel_rms_px)),
            };
            rows.terminal("", format!("{}: {then}", changed.change));
        }
        if let Some(why) = unsolved {
            rows.terminal("least", format!("not known: {why}"));
        }
        rows
    }
}
