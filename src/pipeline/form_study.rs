//! What form errors do to the picture of a design, and how much form error the accepted picture leaves.

use crate::design::Design;
use crate::geom::Outline;
use crate::num::hypot;
use crate::num::stats::Summary;
use crate::results::PmiFacts;
use crate::tolerance::{Engine, FormLimit, Perturbation, ToleranceSpec};

/// A design whose picture is traced with low form errors.
pub(super) struct FormStudy<'a> {
    design: &'a Design,
    engine: Engine,
}

impl<'a> FormStudy<'a> {
    /// Prepares the study; none without a projection, or where no pixel sees its target.
    pub(super) fn new(design: &'a Design) -> Option<Self> {
        let round = matches!(design.mirror.outline, Outline::Ring { .. });
        let spec = ToleranceSpec::of_form(&design.profile, round);
        let engine = Engine::new(&design.mirror, &design.camera, design.view.as_ref()?, spec)?;
        Some(Self { design, engine })
    }

    /// The largest form error with which the picture keeps what the profile accepts; none where the design leaves no
    /// room for any.
    pub(super) fn limit(&self) -> Option<FormLimit> {
        let limits = self.design.profile.acceptance_limits();
        self.engine.form_limit(limits.pixel_error_rms_px.value, limits.pixel_error_max_px.value)
    }

    /// The largest slope error with which the picture keeps the RMS that the profile accepts, mrad RMS; none where the
    /// design leaves no room for any.
    pub(super) fn slope_limit(&self) -> Option<f64> {
        let limits = self.design.profile.acceptance_limits();
        self.engine.slope_limit(limits.pixel_error_rms_px.value)
    }

    /// Pixel errors against the projection, px, of a mirror with these form errors, um from peak to valley: traced in
    /// full at places all over the picture; none where a ray does not meet it.
    pub(super) fn pixel_errors(&self, form: &[(Perturbation, f64)]) -> Option<Summary> {
        let made = self.engine.with_errors(form);
        let moved = self.engine.displacements(&[made]).remove(0);
        let lengths: Vec<f64> = moved.chunks_exact(2).map(|d| hypot(d[0], d[1])).collect();
        Summary::of(lengths).filter(|errors| errors.max.is_finite())
    }
}

/// What a part is measured from, and how far its mirror may be off.
pub(super) fn pmi_facts(design: &Design, limit: Option<&FormLimit>) -> PmiFacts {
    PmiFacts {
        datums: design.datums().words(),
        surface_profile_mm: limit.and_then(zone_mm),
        limited_by: limit.map(|limit| limit.term.key().to_owned()),
    }
}

/// The width of a zone, mm, as a drawing has it: two digits, no wider, in whole nanometres; none of less than one.
pub(super) fn zone_mm(limit: &FormLimit) -> Option<f64> {
    let (nm, mut unit) = ((limit.width_mm * 1e6) as u64, 1);
    while nm / unit >= 100 {
        unit *= 10;
    }
    let nm = nm / unit * unit;
    (nm > 0).then_some(nm as f64 / 1e6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tolerances_have_two_digits_and_are_no_wider() {
        let cases = [
            (0.023_7, Some(0.023)),
            (0.1, Some(0.1)),
            (9.99, Some(9.9)),
            (0.000_009_9, Some(0.000_009)),
            (9e-7, None),
        ];
        for (width_mm, found) in cases {
            let limit = FormLimit { width_mm, term: Perturbation::Legendre20 };
            assert_eq!(zone_mm(&limit), found);
        }
    }
}
