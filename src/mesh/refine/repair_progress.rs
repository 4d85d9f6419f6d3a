//! How a repair goes, round after round: how eagerly it is done, and when it is given up.

/// Most facets for every one proposed, and more for small proposals: past these, splitting does not
/// bring the bounds down. Proposals that suit their mirror need a few in a hundred more, and those of
/// a few facets up to eight times as many.
const MOST_GROWTH: usize = 3;
const SPARE_GROWTH: usize = 20;
const SPARE: [usize; 2] = [2_000, 40_000];
/// Rounds in a row in which more facets fail each time, and how many fail for every one proposed, with
/// some for small proposals, from which on that does not change.
const RISES: usize = 4;
const RISEN: usize = 4;
const SPARE_RISEN: usize = 200;
/// Rounds in which facets are split where what is known of their corners would have it, and these
/// moved, though that may break their neighbours: so many at first, and so many since fewest failed. Then
/// shapes are kept.
const EAGER: usize = 40;
const PATIENCE: usize = 12;

/// Most facets that so many proposed ones are split into.
pub fn most_from(proposed: usize) -> usize {
    let [least, largest] = SPARE;
    MOST_GROWTH * proposed + (SPARE_GROWTH * proposed).clamp(least, largest)
}

/// The course of the repair of so many proposed facets.
#[derive(Debug)]
pub struct RepairProgress {
    proposed: usize,
    /// Rounds that have begun.
    rounds: usize,
    /// Facets before the last of them, and how many failed.
    facets: usize,
    failed: usize,
    /// Rounds in a row with more than in the one before.
    rises: usize,
    /// The fewest that failed, and after how many rounds.
    fewest: (usize, usize),
}

impl RepairProgress {
    pub fn new(proposed: usize) -> Self {
        let fewest = (usize::MAX, 0);
        Self { proposed, rounds: 0, facets: proposed, failed: usize::MAX, rises: 0, fewest }
    }

    /// A round begins with so many facets, of which so many failed.
    pub fn note(&mut self, failed: usize, facets: usize) {
        self.rises = if failed > self.failed { self.rises + 1 } else { 0 };
        if failed < self.fewest.0 {
            self.fewest = (failed, self.rounds);
        }
        (self.facets, self.failed) = (facets, failed);
        self.rounds += 1;
    }

    /// Whether splitting is seen to do no good.
    pub fn is_hopeless(&self) -> bool {
        let risen = self.failed > RISEN * self.proposed + SPARE_RISEN;
        self.facets > most_from(self.proposed) || (self.rises >= RISES && risen)
    }

    /// Whether neighbours may be broken in the round that has begun.
    pub fn is_eager(&self) -> bool {
        self.rounds <= EAGER.max(self.fewest.1 + PATIENCE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn course(failed: impl IntoIterator<Item = usize>) -> RepairProgress {
        let mut course = RepairProgress::new(100);
        failed.into_iter().for_each(|failed| course.note(failed, 100 + failed));
        course
    }

    #[test]
    fn repairs_are_given_up_where_ever_more_facets_fail() {
        assert!(course([100, 150, 300, 600, 1200]).is_hopeless());
        // Not where there are few, nor while there may be fewer again.
        assert!(!course([100, 150, 200, 300, 600]).is_hopeless());
        assert!(!course([100, 150, 300, 600, 500, 1200]).is_hopeless());
        assert!(course([2300]).is_hopeless());
    }

    #[test]
    fn repairs_are_eager_at_first_and_for_some_rounds_since_fewest_failed() {
        assert!(course(1..=40).is_eager());
        assert!(!course(1..=41).is_eager());
        let falling = |rounds: usize| (0..60).rev().chain(1..=rounds);
        assert!(course(falling(11)).is_eager());
        assert!(!course(falling(13)).is_eager());
    }
}
