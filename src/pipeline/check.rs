//! `morion check`: whether a profile is valid, and what no single mirror can do better.

use crate::design::{DesignError, LesserError, least_error, lesser_errors};
use crate::profile::Profile;
use crate::results::{LesserErrorFacts, ProfileCheck};

/// What is known of a valid profile before its mirror is designed.
#[must_use]
pub fn check(profile: &Profile) -> ProfileCheck {
    let (least_error, unsolved) = match least_error(profile) {
        Ok(found) => (found, None),
        Err(DesignError::Unsolved { cause, .. }) => (None, Some(cause.to_string())),
        Err(error) => (None, Some(error.to_string())),
    };
    let alternatives = least_error.map_or(Vec::new(), |own| lesser_errors(profile, &own));
    let facts = |LesserError { change, least_error }| LesserErrorFacts {
        change: change.to_string(),
        least_error,
    };
    ProfileCheck {
        profile: profile.into(),
        least_error,
        alternatives: alternatives.into_iter().map(facts).collect(),
        accepted: least_error.map(|_| profile.acceptance_limits()),
        unsolved,
    }
}
