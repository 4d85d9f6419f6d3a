//! The last designs, so that all that is seen of one profile is computed from one design.

use super::failure::RequestFailure;
use crate::design::Design;
use crate::pipeline::designed_unmeasured;
use crate::profile::Profile;
use std::sync::{Arc, Mutex, PoisonError};

/// Designs that are kept: that of the newest profile, and that of the one before, of which something may still be asked.
const KEPT: usize = 2;

/// The last designs, not measured, the newest last.
#[derive(Debug, Default)]
pub(super) struct LastDesigns(Mutex<Vec<Arc<Design>>>);

impl LastDesigns {
    /// The design of `profile`; whoever asks for it while it is made waits for it.
    ///
    /// # Errors
    /// [`RequestFailure`] where there is none.
    pub(super) fn of(&self, profile: &Profile) -> Result<Arc<Design>, RequestFailure> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = kept.iter().find(|design| *design.profile == *profile) {
            return Ok(Arc::clone(known));
        }
        let made = Arc::new(designed_unmeasured(profile)?);
        if kept.len() == KEPT {
            kept.remove(0);
        }
        kept.push(Arc::clone(&made));
        Ok(made)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::shipped;

    #[test]
    fn a_profile_is_designed_once_while_it_is_among_the_last() {
        let shipped = shipped().iter().find(|shipped| shipped.name == "parabolic").unwrap();
        let profile = |base_mm: u32| {
            let text = shipped.text.replace("base_mm = 5", &format!("base_mm = {base_mm}"));
            Profile::parse(shipped.name, shipped.name, text.as_bytes()).unwrap()
        };
        let designs = LastDesigns::default();
        let first = designs.of(&profile(5)).unwrap();
        let second = designs.of(&profile(6)).unwrap();
        assert!(first.mounting != second.mounting);
        assert!(Arc::ptr_eq(&first, &designs.of(&profile(5)).unwrap()));
        designs.of(&profile(7)).unwrap();
        assert!(Arc::ptr_eq(&second, &designs.of(&profile(6)).unwrap()));
        let again = designs.of(&profile(5)).unwrap();
        assert!(!Arc::ptr_eq(&first, &again) && first.mounting == again.mounting);
    }
}
