//! Remedies of a refused profile: changes of single keys, each of which is followed
//! here by designing the changed profile before it is advised.

mod keys;
mod less_error;

pub use less_error::{LesserError, lesser_errors};

use super::cause::{FailureCause, FitStage, LocalFailure};
use super::solve::SolveError;
use super::{Design, DesignError, try_design};
use crate::profile::{Profile, ShapeSpec};
use keys::{
    Edit, degree, degree_down, distance, elevation, law, least_squares, targets, unfilled,
    untargeted, vector_field,
};
use std::fmt;

/// Most changed profiles that are designed to find a remedy.
pub const MOST_TRIALS: usize = 40;
/// Of these, most with a change of a single key: all that there are for any cause.
const MOST_SINGLE: usize = 20;
/// Alternatives that are told at most.
const ALTERNATIVES: usize = 2;

/// A change of one key of a profile.
#[derive(Debug, Clone, PartialEq)]
pub enum KeyChange {
    /// A key is left out.
    Without(&'static str),
    /// A key has another value.
    Set(&'static str, KeyValue),
    /// A table has another name in its section: another method or another law.
    Take(&'static str, &'static str),
}

/// A value of a key.
#[derive(Debug, Clone, PartialEq)]
pub enum KeyValue {
    /// A number.
    Number(f64),
    /// A range.
    Range([f64; 2]),
    /// True or false.
    Flag(bool),
    /// Entries of a table.
    Rows(Vec<[f64; 2]>),
}

impl fmt::Display for KeyValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(x) => write!(f, "{x}"),
            Self::Flag(flag) => write!(f, "{flag}"),
            Self::Range(range) => write!(f, "{range:?}"),
            Self::Rows(rows) => write!(f, "{rows:?}"),
        }
    }
}

impl fmt::Display for KeyChange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Without(key) => write!(f, "leave {key} out"),
            Self::Set(key, value) => write!(f, "set {key} = {value}"),
            Self::Take(section, name) => write!(f, "take {section}.{name}"),
        }
    }
}

/// Remedy of a refusal: alternatives, each of changes that are made together, after any of
/// which the mirror can be designed.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Remedy {
    /// The alternatives.
    pub alternatives: Vec<Vec<KeyChange>>,
    /// Number of changed profiles that were designed to find them.
    pub trials: usize,
}

impl fmt::Display for Remedy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.alternatives.is_empty() {
            return f.write_str(
                "no change of a single key was found that helps: begin with a profile that is \
                 shipped, and change it step by step",
            );
        }
        let together = |changes: &Vec<KeyChange>| {
            changes.iter().map(ToString::to_string).collect::<Vec<_>>().join(" and ")
        };
        let all: Vec<String> = self.alternatives.iter().map(together).collect();
        f.write_str(&all.join(", or "))
    }
}

/// Remedy of `cause`, for which `profile` is refused.
pub(super) fn remedy(profile: &Profile, cause: &FailureCause) -> Remedy {
    let mut search = TrialDesigns { trials: 0, most: MOST_SINGLE };
    let mut found: Vec<Vec<KeyChange>> = Vec::new();
    for key in keys(profile, cause) {
        if found.len() == ALTERNATIVES {
            break;
        }
        let helps = key(profile).into_iter().find(|changed| search.helps(&changed.profile));
        found.extend(helps.map(|changed| vec![changed.change]));
    }
    if found.is_empty() {
        found.extend(search.together(profile));
    }
    Remedy { alternatives: found, trials: search.trials }
}

/// Trial designs.
struct TrialDesigns {
    trials: usize,
    /// No more are made.
    most: usize,
}

impl TrialDesigns {
    /// Whether the mirror of `profile` can be designed; no more are tried when that has been asked
    /// too often.
    fn helps(&mut self, profile: &Profile) -> bool {
        if self.trials >= self.most {
            return false;
        }
        self.trials += 1;
        let design: Result<Design, DesignError> = try_design(profile);
        // What does not fit around the mirror is another matter.
        matches!(design, Ok(_) | Err(DesignError::Border { .. }))
    }

    /// Changes that help together: the plainest profile, if it can be designed, less what is not
    /// needed for that.
    fn together(&mut self, profile: &Profile) -> Option<Vec<KeyChange>> {
        self.most = MOST_TRIALS;
        let plainest = |key: &Edit, profile: &Profile| key(profile).pop();
        let made = |keys: &[Edit]| {
            let (mut now, mut changes) = (profile.clone(), Vec::new());
            for key in keys {
                if let Some(changed) = plainest(key, &now) {
                    changes.push(changed.change);
                    now = changed.profile;
                }
            }
            (now, changes)
        };
        let all: [Edit; 8] =
            [unfilled, least_squares, vector_field, law, untargeted, degree, elevation, distance];
        let mut keys: Vec<Edit> = Vec::new();
        for key in all {
            keys.push(key);
            if plainest(&key, profile).is_some() && self.helps(&made(&keys).0) {
                break;
            }
        }
        if !self.helps(&made(&keys).0) {
            return None;
        }
        for k in (0..keys.len()).rev() {
            let mut fewer = keys.clone();
            fewer.remove(k);
            if plainest(&keys[k], profile).is_none() || self.helps(&made(&fewer).0) {
                keys = fewer;
            }
        }
        Some(made(&keys).1)
    }
}

/// Edits that may remedy `cause`, the likeliest first.
fn keys(profile: &Profile, cause: &FailureCause) -> Vec<Edit> {
    let given = !matches!(profile.shape, ShapeSpec::Designed(_));
    match cause {
        FailureCause::LeastCurl(_) => vec![law, targets, untargeted, elevation],
        FailureCause::Fit { source: SolveError::Undetermined(_), .. } => {
            vec![degree_down, elevation]
        }
        FailureCause::Fit { stage: FitStage::Method, .. }
        | FailureCause::At { stage: Some(FitStage::Method), .. } => {
            vec![unfilled, vector_field, targets, untargeted, degree, elevation, distance]
        }
        FailureCause::Fit { stage: FitStage::Minimax, .. }
        | FailureCause::At { stage: Some(FitStage::Minimax), .. } => {
            vec![unfilled, least_squares, vector_field, targets, untargeted, degree, elevation]
        }
        FailureCause::BackFacing { .. } => {
            vec![unfilled, elevation, distance, degree, targets, untargeted]
        }
        // What a given mirror shows does not depend on what it should.
        FailureCause::At { failure: LocalFailure::NotInImage { .. }, .. } if given => {
            vec![unfilled, law, distance]
        }
        FailureCause::At { failure: LocalFailure::SeenMissesPlane { .. }, .. } if given => {
            vec![unfilled, untargeted, distance]
        }
        _ if given => vec![unfilled, law, untargeted, targets, distance, elevation],
        _ => vec![unfilled, targets, untargeted, degree, vector_field, elevation, law, distance],
    }
}
