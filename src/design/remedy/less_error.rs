//! Changes of one key after which a picture has less of an error that no mirror is without.

use super::KeyChange;
use super::keys::{Edit, best, elevation, mirrored};
use crate::design::{DesignError, LeastError, least_error};
use crate::profile::Profile;

/// Share of the least error that a change has to take off: less is not worth a change of what is seen.
const WORTH: f64 = 0.1;

/// A change of one key, and the least error after it.
#[derive(Debug, Clone, PartialEq)]
pub struct LesserError {
    /// The change.
    pub change: KeyChange,
    /// The least error of the profile that has it.
    pub least_error: LeastError,
}

/// Changes of one key of `profile`, whose own least error is `own`, that leave a tenth less of it: each was tried.
#[must_use]
pub fn lesser_errors(profile: &Profile, own: &LeastError) -> Vec<LesserError> {
    if own.is_exact() {
        return Vec::new();
    }
    let edits: [Edit; 3] = [mirrored, best, elevation];
    let tried = edits.iter().filter_map(|edit| {
        let changed = edit(profile).into_iter().next()?;
        let least: Result<Option<LeastError>, DesignError> = least_error(&changed.profile);
        Some(LesserError { change: changed.change, least_error: least.ok()?? })
    });
    tried
        .filter(|tried| tried.least_error.pixel_rms_px < (1.0 - WORTH) * own.pixel_rms_px)
        .collect()
}
