//! The inverse of a map of the plane along a straight way in its image, from the centre outwards.

use super::radial_map::{RadialMap, determinant, relative_change, solved};

/// Largest relative change of the Jacobian over a step (Frobenius norm), which keeps Newton's method within
/// its reach: by Newton-Kantorovich it converges from a first error that moves the Jacobian by no more than
/// a half.
pub(super) const MOST_CHANGE: f64 = 0.5;
/// Shortest step, as a share of the way: the determinant falls as the root of what is left up to a fold, so
/// that a way which ends there has steps four times shorter each time.
const SHORTEST: f64 = 1e-9;
/// Most steps: coefficients of a lens take fewer than ten, the neighbourhood of a fold some fifty.
const MOST_STEPS: usize = 1000;
/// Most corrections of a step: quadratic convergence takes six.
const MOST_CORRECTIONS: usize = 20;

/// The point whose image is the share `share` of `end`, followed from the centre, which is its own image.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lift<'m> {
    map: &'m RadialMap,
    end: [f64; 2],
    /// Share of the way that is done.
    pub share: f64,
    /// The point there.
    pub at: [f64; 2],
    /// Longest step that is tried next.
    step: f64,
}

impl<'m> Lift<'m> {
    pub(super) fn new(map: &'m RadialMap, end: [f64; 2]) -> Self {
        Self { map, end, share: 0.0, at: [0.0; 2], step: 1.0 }
    }

    /// Goes on to the share `share` of the way. `false` where the map folds over before that.
    pub(super) fn advance(&mut self, share: f64) -> bool {
        for _ in 0..MOST_STEPS {
            if self.share >= share {
                return true;
            }
            let step = self.step.min(share - self.share);
            // (The last step ends there exactly.)
            let next = if step < self.step { share } else { self.share + step };
            match self.stepped(next) {
                Some(at) => {
                    (self.share, self.at) = (next, at);
                    self.step = 2.0 * self.step.max(step);
                }
                None => self.step = 0.5 * step,
            }
            if !(self.step >= SHORTEST) {
                return false;
            }
        }
        false
    }

    /// Determinant of the Jacobian here; 1 at the centre.
    pub(super) fn determinant(&self) -> f64 {
        determinant(self.map.jacobian(self.at))
    }

    /// The point at `share`, if that is near enough to be reached safely.
    fn stepped(&self, share: f64) -> Option<[f64; 2]> {
        let target = self.end.map(|e| share * e);
        let here = self.map.jacobian(self.at);
        if !(determinant(here) > 0.0) {
            return None;
        }
        let mut at = self.at;
        let mut last = f64::INFINITY;
        for _ in 0..MOST_CORRECTIONS {
            let jacobian = self.map.jacobian(at);
            let image = self.map.image(at);
            let by = solved(jacobian, [target[0] - image[0], target[1] - image[1]]);
            let size = by[0].abs().max(by[1].abs());
            let scale = at[0].abs().max(at[1].abs());
            let is_settled = size <= f64::EPSILON * scale;
            // It shrinks no more: rounding, or no convergence.
            if !(size < 0.5 * last) && !is_settled {
                return (size <= 1e-12 * scale && self.is_near(here, at)).then_some(at);
            }
            at = [at[0] + by[0], at[1] + by[1]];
            if is_settled {
                return self.is_near(here, at).then_some(at);
            }
            last = size;
        }
        None
    }

    /// Whether the Jacobian stays near `here`, that of this point, all the way to `at`.
    fn is_near(&self, here: [[f64; 2]; 2], at: [f64; 2]) -> bool {
        [0.25, 0.5, 0.75, 1.0].into_iter().all(|part| {
            let between = [0, 1].map(|k| self.at[k] + part * (at[k] - self.at[k]));
            relative_change(here, self.map.jacobian(between)) <= MOST_CHANGE
        })
    }
}
