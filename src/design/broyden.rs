//! Fixed points of two numbers that cost a solution to follow.

use crate::num::hypot;

/// Broyden's method for x = f(x): the first step repeats, the others use what the steps before
/// them showed of f.
#[derive(Debug, Clone)]
pub(super) struct Broyden {
    /// The inverse of the derivative of f(x) - x, as far as it is known.
    inverse: [[f64; 2]; 2],
    /// x and f(x) - x of the last step.
    last: Option<([f64; 2], [f64; 2])>,
    /// The longest step.
    most: f64,
}

fn times(m: &[[f64; 2]; 2], v: [f64; 2]) -> [f64; 2] {
    m.map(|row| row[0] * v[0] + row[1] * v[1])
}

fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

impl Broyden {
    /// The method before any step: f is taken to be constant. No step is longer than `most`.
    #[must_use]
    pub(super) fn new(most: f64) -> Self {
        Self { inverse: [[-1.0, 0.0], [0.0, -1.0]], last: None, most }
    }

    /// The next x to try after `x`, where the value of f is `f`.
    pub(super) fn next(&mut self, x: [f64; 2], f: [f64; 2]) -> [f64; 2] {
        let gap = minus(f, x);
        if let Some((old_x, old_gap)) = self.last {
            let step = minus(x, old_x);
            let foreseen = times(&self.inverse, minus(gap, old_gap));
            let [a, b] = self.inverse;
            // The step's row times the inverse.
            let row = [step[0] * a[0] + step[1] * b[0], step[0] * a[1] + step[1] * b[1]];
            let size = step[0] * foreseen[0] + step[1] * foreseen[1];
            let off = minus(step, foreseen);
            if size != 0.0 {
                for (line, off) in self.inverse.iter_mut().zip(off) {
                    line.iter_mut().zip(row).for_each(|(x, r)| *x += off * r / size);
                }
            }
        }
        self.last = Some((x, gap));
        let back = times(&self.inverse, gap);
        let share = (self.most / hypot(back[0], back[1])).min(1.0);
        minus(x, back.map(|b| b * share))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::{cos, exp};

    #[test]
    fn finds_fixed_points_from_which_repetition_runs_away() {
        // The derivatives at (0, 0) are 3 and -5: repeating leaves it.
        let f = |[x, y]: [f64; 2]| [exp(3.0 * x) - cos(y), -5.0 * y + 0.5 * x * y + x];
        let (mut search, mut x) = (Broyden::new(0.1), [0.05, -0.04]);
        let mut rounds = 0;
        while minus(f(x), x).iter().any(|gap| gap.abs() > 1e-13) {
            x = search.next(x, f(x));
            rounds += 1;
            assert!(rounds < 20, "{x:?}");
        }
        assert!(x[0].abs() + x[1].abs() < 1e-13, "{x:?}");
    }
}
