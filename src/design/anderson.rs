//! Anderson's acceleration of a fixed-point iteration: Gauss-Newton converges slowly where the
//! residual stays large, and its past steps tell how.

use crate::num::least_squares;
use nalgebra::{DMatrix, DVector};

/// Steps remembered.
const DEPTH: usize = 8;

/// The steps of an iteration so far: from which point each, and where to.
#[derive(Debug, Clone)]
pub(super) struct AndersonAcceleration {
    /// Length that one of each unknown amounts to.
    scale: Vec<f64>,
    past: Vec<(Vec<f64>, Vec<f64>)>,
}

impl AndersonAcceleration {
    /// An empty history.
    pub(super) fn new(scale: Vec<f64>) -> Self {
        Self { scale, past: Vec::new() }
    }

    /// Forgets everything.
    pub(super) fn reset(&mut self) {
        self.past.clear();
    }

    /// Remembers that the iteration would go from `x` by `step`, and proposes where to go instead:
    /// to where the step would vanish were it linear along the directions gone so far.
    pub(super) fn propose(&mut self, x: &[f64], step: &[f64]) -> Option<Vec<f64>> {
        let differences = |k: usize| -> (Vec<f64>, Vec<f64>) {
            let minus = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect();
            (minus(x, &self.past[k].0), minus(step, &self.past[k].1))
        };
        let past: Vec<_> = (0..self.past.len()).map(differences).collect();
        let proposal = (!past.is_empty()).then(|| {
            let matrix = DMatrix::from_fn(x.len(), past.len(), |i, k| self.scale[i] * past[k].1[i]);
            let wanted = DVector::from_fn(x.len(), |i, _| self.scale[i] * step[i]);
            let mix = least_squares::solve(matrix, wanted).ok()?.x;
            let mut to: Vec<f64> = x.iter().zip(step).map(|(x, s)| x + s).collect();
            for (share, (dx, ds)) in mix.iter().zip(&past) {
                to.iter_mut().zip(dx.iter().zip(ds)).for_each(|(t, (x, s))| *t -= share * (x + s));
            }
            Some(to)
        });
        if self.past.len() == DEPTH.min(x.len()) {
            self.past.remove(0);
        }
        self.past.push((x.to_vec(), step.to_vec()));
        proposal.flatten()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_iteration_ends_after_as_many_steps_as_unknowns() {
        // x <- A x + b with eigenvalues near one: plain iteration would take thousands.
        let next = |x: &[f64]| [0.99 * x[0] + 0.1 * x[1] + 1.0, 0.98 * x[1] - 0.5];
        let (mut x, mut anderson) = (vec![0.0, 0.0], AndersonAcceleration::new(vec![1.0, 1.0]));
        for _ in 0..3 {
            let step: Vec<f64> = next(&x).iter().zip(&x).map(|(a, b)| a - b).collect();
            let plain = x.iter().zip(&step).map(|(x, s)| x + s).collect();
            x = anderson.propose(&x, &step).unwrap_or(plain);
        }
        assert!((x[1] + 25.0).abs() < 1e-9 && (x[0] + 150.0).abs() < 1e-8, "{x:?}");
    }
}
