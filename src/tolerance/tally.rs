//! How much work tracing made systems was, and how much could be left undone.

use std::array;
use std::sync::atomic::{AtomicU64, Ordering};

/// What is counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Piece {
    /// Rays of made systems, met with the made mirror.
    Rays,
    /// Places of the designed surface that are asked for.
    Surface,
    /// Form errors at a ray.
    Forms,
    /// Derivatives at a ray.
    Derivatives,
    /// Trials for limits that go together.
    LimitTrials,
}

const PIECES: [Piece; 5] =
    [Piece::Rays, Piece::Surface, Piece::Forms, Piece::Derivatives, Piece::LimitTrials];

impl Piece {
    /// What is done.
    #[must_use]
    pub fn what(self) -> &'static str {
        match self {
            Self::Rays => "rays met with the mirror",
            Self::Surface => "evaluations of the mirror",
            Self::Forms => "form errors added up at a ray",
            Self::Derivatives => "derivatives taken along rays",
            Self::LimitTrials => "trials traced for limits that go together",
        }
    }

    /// Why some of it need not be done.
    #[must_use]
    pub fn why(self) -> &'static str {
        match self {
            Self::Rays => "the errors leave mirror and rays alone",
            Self::Surface => "polynomials are the mirror there to rounding",
            Self::Forms => "the errors leave these alone",
            Self::Derivatives => "form errors act through height and slope alone",
            Self::LimitTrials => "first derivatives make quadratic forms of them",
        }
    }
}

/// Of each piece, how many were `[done, avoided]`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Tally([[u64; 2]; PIECES.len()]);

impl Tally {
    /// Counts some of a piece.
    #[inline]
    pub(super) fn count(&mut self, piece: Piece, [done, avoided]: [usize; 2]) {
        let [d, a] = &mut self.0[piece as usize];
        *d += done as u64;
        *a += avoided as u64;
    }

    /// Every piece of which there was any.
    pub fn pieces(&self) -> impl Iterator<Item = (Piece, [u64; 2])> {
        PIECES.into_iter().zip(self.0).filter(|(_, counts)| *counts != [0, 0])
    }
}

/// A tally that threads share. (Sums do not depend on their order.)
#[derive(Debug, Default)]
pub(super) struct Counter([[AtomicU64; 2]; PIECES.len()]);

impl Counter {
    pub fn add(&self, tally: Tally) {
        let both = self.0.as_flattened().iter().zip(tally.0.as_flattened());
        both.for_each(|(all, more)| {
            all.fetch_add(*more, Ordering::Relaxed);
        });
    }

    /// Counts some of a piece.
    pub fn count(&self, piece: Piece, counts: [usize; 2]) {
        let mut tally = Tally::default();
        tally.count(piece, counts);
        self.add(tally);
    }

    /// What was counted since the last call.
    pub fn take(&self) -> Tally {
        Tally(array::from_fn(|k| array::from_fn(|i| self.0[k][i].swap(0, Ordering::Relaxed))))
    }
}
