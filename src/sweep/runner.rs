//! Runs the points of a study side by side, and keeps their outcomes.

use super::cache::{Cache, journal_name, line};
use super::grid::Grid;
use super::point;
use super::study::SweepStudy;
use crate::parallel;
use crate::pipeline::{Error, Stage, StageTimer};
use crate::publish::{FileError, Journal, Transaction};
use crate::results::PointOutcome;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Points between two looks at whether the observer wants an end: threads wait for each other there.
const BATCH: usize = 1000;

/// Outcomes of all points of a study, or of those of the shard `[number, of]`, in the order of their numbers.
///
/// # Errors
/// [`enum@Error`] when the journal cannot be read or written, or the observer wants an end.
pub(super) fn outcomes(
    study: &SweepStudy,
    files: &Transaction,
    shard: Option<[usize; 2]>,
    timer: &StageTimer,
) -> Result<Vec<PointOutcome>, Error> {
    let count = Grid::new(&study.spec.axes).count();
    // (Neighbours take about as long, so every N-th point is a fair share.)
    let points: Vec<usize> = match shard {
        Some([number, of]) => (number - 1..count).step_by(of).collect(),
        None => (0..count).collect(),
    };
    let runner = Runner::new(study, files, &journal_name(shard))?;
    let outcomes: Vec<Mutex<Option<PointOutcome>>> =
        points.iter().map(|_| Mutex::default()).collect();
    timer.stage(Stage::Points, || {
        for from in (0..points.len()).step_by(BATCH) {
            if timer.is_stopped() {
                return Err(Error::Stopped);
            }
            let count = BATCH.min(points.len() - from);
            parallel::each_alone(count, &|k| {
                *locked(&outcomes[from + k]) = runner.outcome(points[from + k]);
            });
            runner.check()?;
        }
        let known = runner.known.load(Ordering::Relaxed);
        Ok(((), format!("{} points, {known} of them known from earlier runs", points.len())))
    })?;
    runner.close()?;
    Ok(outcomes.into_iter().filter_map(|outcome| locked(&outcome).take()).collect())
}

/// What points are run with.
struct Runner<'a> {
    study: &'a SweepStudy,
    grid: Grid<'a>,
    cache: Cache,
    journal: Mutex<Journal>,
    /// Why the journal cannot be written.
    refusal: Mutex<Option<FileError>>,
    /// Number of points whose outcome an earlier run has left.
    known: AtomicUsize,
}

impl<'a> Runner<'a> {
    fn new(study: &'a SweepStudy, files: &Transaction, journal: &str) -> Result<Self, FileError> {
        let cache = match files.folder() {
            Some(folder) => Cache::read(folder, &study.spec.columns)?,
            None => Cache::default(),
        };
        let journal = Mutex::new(Journal::open(&files.path_of(journal))?);
        let (grid, refusal) = (Grid::new(&study.spec.axes), Mutex::default());
        Ok(Self { study, grid, cache, journal, refusal, known: AtomicUsize::new(0) })
    }

    /// The outcome of a point, which is in a journal then; none once the journal cannot be written.
    fn outcome(&self, point: usize) -> Option<PointOutcome> {
        if locked(&self.refusal).is_some() {
            return None;
        }
        let spec = &self.study.spec;
        let text = spec.text_with(self.grid.values(point));
        let point = match point::checked(spec, &self.study.base, text) {
            Ok(point) => point,
            // (It takes no time to find that out again.)
            Err(invalid) => return Some(invalid),
        };
        if let Some(outcome) = self.cache.outcome(&point, &spec.columns) {
            self.known.fetch_add(1, Ordering::Relaxed);
            return Some(outcome);
        }
        let outcome = point.outcome(spec);
        let added = locked(&self.journal).add(&line(&point, &outcome, &spec.columns));
        if let Err(error) = added {
            locked(&self.refusal).get_or_insert(error);
        }
        Some(outcome)
    }

    /// Whether the journal could be written.
    fn check(&self) -> Result<(), FileError> {
        locked(&self.refusal).take().map_or(Ok(()), Err)
    }

    fn close(self) -> Result<(), FileError> {
        self.journal.into_inner().unwrap_or_else(PoisonError::into_inner).close()
    }
}

/// A lock whose value is whole whatever has become of another thread.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
