//! Progress of a repair from round to round: how freely it edits, and when it is given up.

use super::tuning::TUNING;

/// Largest number of facets that so many proposed ones are refined to.
pub(crate) fn most_facets(proposed: usize) -> usize {
    let [least, largest] = TUNING.spare_facets;
    TUNING.most_growth * proposed + (TUNING.spare_growth * proposed).clamp(least, largest)
}

/// How far failures are taken to go when a facet that fails is repaired.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FailureSpread {
    /// To few of its neighbours. A repair that turns out otherwise is given up.
    Local,
    /// From neighbour to neighbour: where facets of a lattice all hold just so, one that is changed makes others fail.
    Wide,
}

/// Numbers of facets, and of those that fail, in the rounds of a repair.
#[derive(Debug)]
pub(crate) struct RepairProgress {
    /// Facets that were proposed.
    proposed: usize,
    /// Rounds that have begun.
    rounds: usize,
    /// Facets that failed at first.
    failed_at_first: usize,
    /// Facets at the beginning of the last round.
    facets: usize,
    /// Those of them that fail.
    failed: usize,
    /// Rounds in a row with more failed facets than the one before.
    rises: usize,
    /// The fewest failed facets, and the number of rounds before those.
    fewest: (usize, usize),
}

impl RepairProgress {
    /// The progress of a repair of so many proposed facets.
    pub(crate) fn new(proposed: usize) -> Self {
        let fewest = (usize::MAX, 0);
        let (failed_at_first, failed) = (usize::MAX, usize::MAX);
        Self { proposed, rounds: 0, failed_at_first, facets: proposed, failed, rises: 0, fewest }
    }

    /// Begins a round with so many facets, of which so many fail.
    pub(crate) fn begin_round(&mut self, failed: usize, facets: usize) {
        self.rises = if failed > self.failed { self.rises + 1 } else { 0 };
        if failed < self.fewest.0 {
            self.fewest = (failed, self.rounds);
        }
        if self.rounds == 0 {
            self.failed_at_first = failed;
        }
        (self.facets, self.failed) = (facets, failed);
        self.rounds += 1;
    }

    /// Whether refinement is seen to do no good.
    pub(crate) fn is_diverging(&self) -> bool {
        let risen = self.failed > TUNING.risen_share * self.proposed + TUNING.risen_spare;
        self.facets > most_facets(self.proposed) || (self.rises >= TUNING.rising_rounds && risen)
    }

    /// Whether failures are seen to spread from facet to facet.
    pub(crate) fn is_spreading(&self) -> bool {
        self.rounds == TUNING.rounds_to_spread
            && self.failed > TUNING.few_failed
            && self.failed as f64 > TUNING.spreading_share * self.failed_at_first as f64
    }

    /// Whether the round that has begun improves shapes, though neighbours may fail by it; else it keeps them.
    pub(crate) fn is_optimising(&self) -> bool {
        self.rounds <= TUNING.optimising_rounds.max(self.fewest.1 + TUNING.optimising_patience)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn progress(failed: impl IntoIterator<Item = usize>) -> RepairProgress {
        let mut progress = RepairProgress::new(100);
        failed.into_iter().for_each(|failed| progress.begin_round(failed, 100 + failed));
        progress
    }

    #[test]
    fn repairs_are_given_up_where_ever_more_facets_fail() {
        assert!(progress([100, 150, 300, 600, 1200]).is_diverging());
        // Not where there are few, nor while there may be fewer again.
        assert!(!progress([100, 150, 200, 300, 600]).is_diverging());
        assert!(!progress([100, 150, 300, 600, 500, 1200]).is_diverging());
        assert!(progress([2300]).is_diverging());
    }

    #[test]
    fn failures_spread_where_the_third_round_has_more_than_an_eighth_of_the_first() {
        assert!(progress([4000, 1200, 501]).is_spreading());
        assert!(!progress([4000, 1200, 500]).is_spreading());
        assert!(!progress([4000, 501]).is_spreading());
        // Few are repaired quickly.
        assert!(!progress([800, 600, 400]).is_spreading());
    }

    #[test]
    fn repairs_optimise_shapes_at_first_and_for_some_rounds_since_fewest_failed() {
        assert!(progress(1..=40).is_optimising());
        assert!(!progress(1..=41).is_optimising());
        let falling = |rounds: usize| (0..60).rev().chain(1..=rounds);
        assert!(progress(falling(11)).is_optimising());
        assert!(!progress(falling(13)).is_optimising());
    }
}
