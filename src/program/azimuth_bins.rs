//! Moves by the azimuths that pass the tool in them.
//!
//! A slow tool servo writes tens of moves for each turn, of which an azimuth meets one.

/// Parts of a turn: about as many as moves of a servo's turn.
const BINS: usize = 64;
/// More than turns and shares of them are off by rounding, in bins.
const ROUNDING: f64 = 1e-3;

/// Numbers of moves by parts of a turn.
#[derive(Debug, Clone, Default)]
pub(super) struct AzimuthBins {
    /// Where a bin's numbers begin, and the end.
    begins: Vec<usize>,
    /// Numbers of moves, rising in each bin.
    moves: Vec<u32>,
}

impl AzimuthBins {
    /// Bins of moves with numbers that rise and the turns at their ends, rising.
    pub(super) fn new(spans: impl Iterator<Item = (u32, [f64; 2])> + Clone) -> Self {
        let mut begins = vec![0; BINS + 1];
        for (_, span) in spans.clone() {
            bins(span).for_each(|bin| begins[bin + 1] += 1);
        }
        for bin in 0..BINS {
            begins[bin + 1] += begins[bin];
        }
        let mut next = begins.clone();
        let mut moves = vec![0; begins[BINS]];
        for (number, span) in spans {
            for bin in bins(span) {
                moves[next[bin]] = number;
                next[bin] += 1;
            }
        }
        Self { begins, moves }
    }

    /// Numbers of all moves that may pass the azimuth of this share of a turn, and of some beside it, rising.
    pub(super) fn near(&self, share: f64) -> &[u32] {
        let bin = bin(share * BINS as f64);
        &self.moves[self.begins[bin]..self.begins[bin + 1]]
    }
}

/// The bin of a turn in bins.
fn bin(turn: f64) -> usize {
    turn.floor().rem_euclid(BINS as f64) as usize % BINS
}

/// The bins between two turns, each once.
fn bins([begin, end]: [f64; 2]) -> impl Iterator<Item = usize> {
    let [first, last] =
        [begin * BINS as f64 - ROUNDING, end * BINS as f64 + ROUNDING].map(f64::floor);
    let count = ((last - first) as usize + 1).min(BINS);
    let first = bin(first);
    (0..count).map(move |k| (first + k) % BINS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::sample::Draws;

    /// Of moves forwards, backwards and of many turns all that pass an azimuth are found, and few others, each once.
    #[test]
    fn an_azimuth_meets_the_moves_that_pass_it() {
        let mut random = Draws::new(11);
        for longest in [0.01, 0.2, 3.0] {
            let mut turn: f64 = -40.0;
            let spans: Vec<[f64; 2]> = (0..4000)
                .map(|_| {
                    let before = turn;
                    turn += longest * (random.unit() - 0.3);
                    [before.min(turn), before.max(turn)]
                })
                .collect();
            let bins = AzimuthBins::new((0u32..).zip(spans.iter().copied()));
            for k in 0..=300 {
                let share = f64::from(k) / 200.0;
                let near = bins.near(share);
                assert!(near.is_sorted_by(|a, b| a < b));
                let passes = |[begin, end]: [f64; 2]| share + (begin - share).ceil() <= end;
                let met = |slack: f64| {
                    let spans = spans.iter().map(move |[begin, end]| [begin - slack, end + slack]);
                    (0u32..).zip(spans).filter(|&(_, span)| passes(span)).map(|(number, _)| number)
                };
                assert!(met(0.0).all(|number| near.binary_search(&number).is_ok()), "{share}");
                let beside: Vec<u32> = met(1.01 / BINS as f64).collect();
                assert!(near.iter().all(|number| beside.binary_search(number).is_ok()), "{share}");
            }
        }
    }
}
