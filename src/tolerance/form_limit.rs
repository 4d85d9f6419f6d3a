//! The form error that a picture bears: what a surface-profile tolerance of the mirror may be.

use super::engine::Engine;
use crate::num::max_or_nan;
use crate::tolerance_terms::Perturbation;

/// The largest form error that keeps a picture within its limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FormLimit {
    /// Width of the zone about the designed surface, along its normals, mm.
    pub width_mm: f64,
    /// The term that limits it.
    pub term: Perturbation,
}

impl Engine {
    /// The largest form error with which the picture, that of the design included, stays within `rms_px` in RMS and
    /// `max_px` at most, whatever its sign and whichever of the low terms it is: by first derivatives at the samples.
    /// None where the design leaves nothing of these limits. A zone along normals holds departures along Z that are
    /// larger by the secant of the slope: the width is that of the steepest sample.
    ///
    /// Finer errors of the same height turn rays further: waviness and slope have limits of their own.
    #[must_use]
    pub fn form_limit(&self, rms_px: f64, max_px: f64) -> Option<FormLimit> {
        let limits = [rms_px, max_px];
        let terms = self.forms.iter().enumerate().map(|(k, &term)| {
            let pv_mm = largest_step(&self.base, self.linear.form(k), limits);
            (pv_mm, term)
        });
        let (pv_mm, term) = terms.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let slopes = self.system.samples.iter().map(|sample| sample.slope);
        let steepest = slopes.map(|[x, y]| x * x + y * y).fold(0.0, max_or_nan);
        let width_mm = pv_mm / (1.0 + steepest).sqrt();
        (width_mm > 0.0 && width_mm.is_finite()).then_some(FormLimit { width_mm, term })
    }
}

/// The largest t for which `base` plus and minus t times `column`, x and y of each sample, stays within limits of its
/// RMS and its largest length; 0 where `base` does not.
fn largest_step(base: &[f64], column: &[f64], [rms, max]: [f64; 2]) -> f64 {
    let (mut sums, mut most) = ([0.0; 3], f64::INFINITY);
    for (d, c) in base.chunks_exact(2).zip(column.chunks_exact(2)) {
        let terms =
            [c[0] * c[0] + c[1] * c[1], d[0] * c[0] + d[1] * c[1], d[0] * d[0] + d[1] * d[1]];
        most = most.min(least_root(terms, max * max));
        sums = [0, 1, 2].map(|k| sums[k] + terms[k]);
    }
    let count = (base.len() / 2) as f64;
    most.min(least_root(sums.map(|sum| sum / count), rms * rms))
}

/// The least t of both signs of b where a t^2 + 2 b t + c reaches `limit`; 0 where c is over it.
fn least_root([a, b, c]: [f64; 3], limit: f64) -> f64 {
    let room = limit - c;
    // (The form without cancellation.)
    if room > 0.0 { room / (b.abs() + (b * b + a * room).sqrt()) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::design;
    use crate::geom::Outline;
    use crate::num::hypot;
    use crate::num::random::RandomStream;
    use crate::pipeline::load;
    use crate::tolerance::{DisplacementPx, ToleranceSpec};

    #[test]
    fn a_step_ends_where_the_first_limit_is_reached() {
        // Of two samples one is moved towards a limit of 3 from 1, at 2 a step.
        let (base, column) = ([1.0, 0.0, 0.0, 0.5], [2.0, 0.0, 0.0, 0.0]);
        assert_eq!(largest_step(&base, &column, [f64::MAX, 3.0]), 1.0);
        let rms = ((9.0 + 0.25) / 2.0f64).sqrt();
        assert!((largest_step(&base, &column, [rms, 1e9]) - 1.0).abs() < 1e-15);
        assert_eq!(largest_step(&base, &column, [1e9, 0.9]), 0.0);
        assert_eq!(largest_step(&base, &[0.0; 4], [1e9, 3.0]), f64::INFINITY);
    }

    /// The full trace of a part with that form error is at the limit, and one with any other term is not over it.
    #[test]
    fn a_part_at_the_limit_reaches_what_is_accepted_and_goes_no_further() {
        for name in ["conquistador", "hyperbolic", "driver"] {
            let profile = load(name).unwrap();
            let limits = profile.acceptance_limits();
            let [rms, max] =
                [limits.pixel_error_rms_px, limits.pixel_error_max_px].map(|l| l.value);
            let design = design(&profile).unwrap();
            let round = matches!(design.mirror.outline, Outline::Ring { .. });
            let view = design.view.as_ref().unwrap();
            let spec = ToleranceSpec::of_form(&profile, round);
            let engine = Engine::new(&design.mirror, &design.camera, view, spec).unwrap();
            let limit = engine.form_limit(rms, max).unwrap();
            let steepest = engine.system.samples.iter().map(|s| s.slope);
            let secant = steepest.map(|[x, y]| (1.0 + x * x + y * y).sqrt()).fold(0.0, f64::max);
            let pv_um = 1e3 * limit.width_mm * secant;
            let mut reached = 0.0f64;
            for &term in &engine.forms {
                for value in [-pv_um, pv_um] {
                    let made = engine.make(&[(term, value)], RandomStream { seed: 1, trial: 0 });
                    let moved = engine.displacements(&[made]).remove(0);
                    let largest =
                        moved.chunks_exact(2).map(|d| hypot(d[0], d[1])).fold(0.0, f64::max);
                    let share = (DisplacementPx::of(&moved).rms_px / rms).max(largest / max);
                    assert!(share < 1.01, "{name}: {share}");
                    reached = reached.max(share);
                }
            }
            assert!(reached > 0.99, "{name}: {reached}");
        }
    }
}
