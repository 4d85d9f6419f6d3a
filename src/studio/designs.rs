//! The last designs, so that all that is seen of one profile is computed from one design.

use super::failure::RequestFailure;
use crate::design::Design;
use crate::optics::CameraModel;
use crate::pipeline::designed_unmeasured;
use crate::profile::{Method, MethodKind, Profile, ShapeSpec};
use std::sync::{Arc, Mutex, PoisonError};

/// Designs that are kept: that of the newest profile, its sketch, and that of the one before, of which something may still be asked.
const KEPT: usize = 3;
/// Highest degree of a sketch: half of a preview of the shipped mirrors by more is their design.
const SKETCH_DEGREE: usize = 10;
/// The same of what takes longer: panels, each of which is a mirror of its own, and behind a lens that bends lines, so that no two places
/// of a row of pixels have a coordinate in common.
const COSTLY_SKETCH_DEGREE: usize = 8;

/// The last designs, not measured, the newest last.
#[derive(Debug, Default)]
pub(super) struct LastDesigns(Mutex<Vec<Arc<KeptDesign>>>);

/// A profile and its design, once it is made.
#[derive(Debug)]
struct KeptDesign {
    profile: Profile,
    made: Mutex<Option<Arc<Design>>>,
}

impl LastDesigns {
    /// The design of `profile`; whoever asks for it while it is made waits for it, and nobody else.
    ///
    /// # Errors
    /// [`RequestFailure`] where there is none.
    pub(super) fn of(&self, profile: &Profile) -> Result<Arc<Design>, RequestFailure> {
        let kept = self.kept(profile);
        let mut made = kept.made.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = &*made {
            return Ok(Arc::clone(known));
        }
        let design = Arc::new(designed_unmeasured(profile)?);
        *made = Some(Arc::clone(&design));
        Ok(design)
    }

    /// The place of the design of `profile`, in which that of another is no longer kept.
    fn kept(&self, profile: &Profile) -> Arc<KeptDesign> {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = all.iter().find(|kept| kept.profile == *profile) {
            return Arc::clone(known);
        }
        let new = Arc::new(KeptDesign { profile: profile.clone(), made: Mutex::new(None) });
        if all.len() == KEPT {
            all.remove(0);
        }
        all.push(Arc::clone(&new));
        new
    }
}

/// The profile of a mirror that is designed sooner and looks much like that of `profile`, for as long as it is being changed: of a low
/// degree, and by least squares of the slopes alone. None where the mirror is made so itself.
pub(super) fn sketch(profile: &Profile) -> Option<Profile> {
    let ShapeSpec::Designed(method) = profile.shape else { return None };
    let kind = MethodKind::VectorField;
    let is_costly =
        !profile.is_one_surface() || matches!(profile.camera, CameraModel::Calibrated { .. });
    let degree = method.degree.min(if is_costly { COSTLY_SKETCH_DEGREE } else { SKETCH_DEGREE });
    let sketched = Method { kind, degree, minimax: false };
    (sketched != method)
        .then(|| Profile { shape: ShapeSpec::Designed(sketched), ..profile.clone() })
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
        designs.of(&profile(8)).unwrap();
        assert!(Arc::ptr_eq(&second, &designs.of(&profile(6)).unwrap()));
        let again = designs.of(&profile(5)).unwrap();
        assert!(!Arc::ptr_eq(&first, &again) && first.mounting == again.mounting);
    }
}
