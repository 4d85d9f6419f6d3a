//! The bracket of a limit between one that is too strict and one that fits, and the power law that leads into it.

use super::tuning::TUNING;
use crate::mesh::error::MeshError;
use crate::num::{exp, log};

/// The power of the limit with which the number of triangles falls, from the tries: where rims need most of the triangles,
/// or a mirror is flat, the number hardly follows the limit.
#[derive(Debug)]
pub(super) struct PowerLaw {
    /// Theory's power, which is the largest.
    theory: f64,
    /// The power that is taken.
    power: f64,
    /// Logarithms of the last limit and its number of triangles.
    last: Option<[f64; 2]>,
}

impl PowerLaw {
    /// The law with theory's power.
    pub(super) fn new(theory: f64) -> Self {
        Self { theory, power: theory, last: None }
    }

    /// The same power for numbers of another kind, as of meshes after forecasts.
    pub(super) fn for_others(self) -> Self {
        Self { last: None, ..self }
    }

    /// A factor on `limit`, which has `count` triangles, towards `target` triangles.
    pub(super) fn step(&mut self, limit: f64, count: f64, target: f64) -> f64 {
        if count.is_infinite() {
            return f64::INFINITY;
        }
        let now = [log(limit), log(count)];
        if let Some(last) = self.last.replace(now) {
            self.learn(now[0] - last[0], last[1] - now[1]);
        }
        exp((now[1] - log(target)) / self.power)
    }

    /// Learns that over a step of the limit's logarithm that of the number fell by so much: little from limits that are near
    /// each other, whose numbers differ by chance.
    fn learn(&mut self, step: f64, fall: f64) {
        let weight = step * step / (step * step + TUNING.chance * TUNING.chance);
        let measured = fall / step;
        if measured.is_finite() {
            let power = self.power + weight * (measured - self.power);
            self.power = power.clamp(TUNING.least_power * self.theory, self.theory);
        }
    }
}

/// Limits (mm) that are too strict and that fit.
#[derive(Debug)]
pub(super) struct Bracket {
    strictest: f64,
    loosest: f64,
    /// The loosest limit known to be too strict.
    fails: f64,
    /// The strictest limit known to fit.
    fits: f64,
}

impl Bracket {
    /// A bracket of which only the ends are known.
    pub(super) fn new(strictest: f64, loosest: f64) -> Self {
        Self { strictest, loosest, fails: 0.0, fits: f64::INFINITY }
    }

    /// The loosest limit that may be tried, mm.
    pub(super) fn loosest(&self) -> f64 {
        self.loosest
    }

    /// The strictest limit known to fit, mm; infinite while there is none.
    pub(super) fn fits(&self) -> f64 {
        self.fits
    }

    /// The number of triangles of a limit that is refused: infinite, where a looser limit may not be.
    ///
    /// # Errors
    /// The given one, where no looser limit helps.
    pub(super) fn too_strict(&self, limit: f64, error: MeshError) -> Result<f64, MeshError> {
        match error {
            MeshError::TooMany { .. }
            | MeshError::NotRefinable { .. }
            | MeshError::PrecisionLimit { .. }
                if limit < self.loosest =>
            {
                Ok(f64::INFINITY)
            }
            error => Err(error),
        }
    }

    /// Notes that `limit` has `count` triangles, of which `target` are wanted at most.
    pub(super) fn note(&mut self, limit: f64, count: f64, target: f64) {
        if count > target {
            self.fails = self.fails.max(limit);
        } else {
            self.fits = self.fits.min(limit);
        }
    }

    /// Whether there is no limit left to try.
    pub(super) fn is_closed(&self) -> bool {
        self.fits <= self.strictest
            || self.fits <= self.fails * (TUNING.grid + TUNING.grid_rounding)
    }

    /// The limit to try after `limit`: `wanted`, where that can be.
    pub(super) fn next(&self, limit: f64, wanted: f64) -> f64 {
        let next = if wanted > self.fails && wanted < self.fits {
            wanted
        } else if self.fits == f64::INFINITY {
            2.0 * limit
        } else if self.fails == 0.0 {
            0.5 * limit
        } else {
            (self.fails * self.fits).sqrt()
        };
        let next = self.on_grid(next);
        if next <= self.fails * (1.0 + TUNING.grid_rounding) {
            self.clamp(next * TUNING.grid)
        } else if next >= self.fits * (1.0 - TUNING.grid_rounding) {
            self.clamp(next / TUNING.grid)
        } else {
            self.clamp(next)
        }
    }

    /// The limit on the grid that is nearest to `limit`: the loosest, divided by a power of the grid's ratio.
    pub(super) fn on_grid(&self, limit: f64) -> f64 {
        let steps = (log(self.loosest / limit) / log(TUNING.grid)).round();
        self.clamp(self.loosest * exp(-steps * log(TUNING.grid)))
    }

    /// The limit itself, or the nearest one that may be tried.
    pub(super) fn clamp(&self, limit: f64) -> f64 {
        limit.clamp(self.strictest, self.loosest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps of a search by `count` from `limit` on until it is within a hundredth of `target`.
    fn steps(count: impl Fn(f64) -> f64, mut limit: f64, target: f64) -> usize {
        let mut power = PowerLaw::new(2.0);
        (1..40)
            .find(|_| {
                let found = count(limit);
                limit *= power.step(limit, found, target);
                (found / target - 1.0).abs() < 0.01
            })
            .unwrap_or(40)
    }

    #[test]
    fn limits_that_are_near_each_other_do_not_mislead_the_next_step() {
        // The number rises by chance where the limit is loosened by a hundredth.
        let mut power = PowerLaw::new(2.0);
        assert!((power.step(1.0, 101.0, 100.0) - 1.005).abs() < 1e-4);
        let next = power.step(1.01, 102.5, 100.0);
        assert!((1.01..1.02).contains(&next), "{next}");
    }

    #[test]
    fn the_power_of_forecasts_leads_to_a_mesh_in_three_steps() {
        for power in [0.25, 0.5, 1.0, 2.0] {
            let count = |limit: f64| 1e4 * exp(-power * log(limit));
            let mut law = PowerLaw::new(2.0);
            // Forecasts that come to the target from far away.
            let mut limit = 0.1;
            for _ in 0..20 {
                limit *= law.step(limit, count(limit), 1e4);
            }
            assert!((count(limit) / 1e4 - 1.0).abs() < 0.01, "{power}");
            // Meshes have 3 % more triangles than were foreseen.
            let mut law = law.for_others();
            let found = (0..3).map(|_| {
                let found = 1.03 * count(limit);
                limit *= law.step(limit, found, 1e4);
                found
            });
            let last = found.last().unwrap();
            assert!((last / 1e4 - 1.0).abs() < 0.01, "{power}: {last}");
        }
    }

    #[test]
    fn a_power_below_theory_is_learnt() {
        assert!(steps(|limit| 1e4 / (limit * limit), 3.0, 1e4) <= 2);
        assert!(steps(|limit| 1e4 / limit.sqrt(), 3.0, 1e4) <= 4);
        // Half of the triangles are at the rim.
        let with_rim = |limit: f64| 5e3 + 5e3 / (limit * limit);
        assert!(steps(with_rim, 0.3, 1e4) <= 5 && steps(with_rim, 3.0, 1e4) <= 7);
    }
}
