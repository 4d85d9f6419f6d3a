//! Counts of the work done and avoided in tracing perturbed systems.

use std::array;
use std::sync::atomic::{AtomicU64, Ordering};

/// Kind of work that is counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WorkKind {
    /// Rays of made systems, met with the made mirror.
    Rays,
    /// Evaluations of the designed surface.
    Surface,
    /// Form errors at a ray.
    Forms,
    /// Derivatives at a ray.
    Derivatives,
    /// Trials for allocated limits.
    LimitTrials,
}

const WORK_KINDS: [WorkKind; 5] = [
    WorkKind::Rays,
    WorkKind::Surface,
    WorkKind::Forms,
    WorkKind::Derivatives,
    WorkKind::LimitTrials,
];

impl WorkKind {
    /// The work in words, as `timings.json` has it.
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

    /// Reason why some of it need not be done.
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

/// Numbers `[done, avoided]` of each kind of work.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct WorkCounts([[u64; 2]; WORK_KINDS.len()]);

impl WorkCounts {
    /// Counts some work of a kind.
    #[inline]
    pub(super) fn count(&mut self, kind: WorkKind, [done, avoided]: [usize; 2]) {
        let [d, a] = &mut self.0[kind as usize];
        *d += done as u64;
        *a += avoided as u64;
    }

    /// Every kind of which there was any.
    pub fn kinds(&self) -> impl Iterator<Item = (WorkKind, [u64; 2])> {
        WORK_KINDS.into_iter().zip(self.0).filter(|(_, counts)| *counts != [0, 0])
    }
}

/// Counts that threads share. (Sums do not depend on their order.)
#[derive(Debug, Default)]
pub(super) struct WorkCounter([[AtomicU64; 2]; WORK_KINDS.len()]);

impl WorkCounter {
    pub(super) fn add(&self, work: WorkCounts) {
        let both = self.0.as_flattened().iter().zip(work.0.as_flattened());
        both.for_each(|(all, more)| {
            all.fetch_add(*more, Ordering::Relaxed);
        });
    }

    /// Counts some work of a kind.
    pub(super) fn count(&self, kind: WorkKind, counts: [usize; 2]) {
        let mut work = WorkCounts::default();
        work.count(kind, counts);
        self.add(work);
    }

    /// Counts since the last call.
    pub(super) fn take(&self) -> WorkCounts {
        WorkCounts(array::from_fn(|k| array::from_fn(|i| self.0[k][i].swap(0, Ordering::Relaxed))))
    }
}
