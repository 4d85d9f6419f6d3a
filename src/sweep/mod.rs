//! `morion sweep`: a study's points, each a run of its own, as rows, with the best of them.
//!
//! Outcomes go into a journal as they are known, by what they depend on: a run goes on where an earlier one has ended,
//! and takes from the journals of several jobs what they have made.

mod cache;
mod facts;
mod front;
mod grid;
mod point;
mod report_keys;
mod runner;
mod study;

pub use study::SweepStudy;

use crate::pipeline::{Error, Observer, Stage, StageTimer};
use crate::publish::Transaction;
use crate::report::Answer;
use crate::results::{FileFacts, ShardReport, SweepReport, SweepTable};
use cache::journal_name;
use facts::{report, table};
use runner::outcomes;
use std::path::{Path, PathBuf};

/// The folder of a study's files below that for results.
#[must_use]
pub fn folder(study: &SweepStudy) -> PathBuf {
    Path::new("sweep").join(study.name())
}

/// Runs the points of a study that no journal in its folder has, and writes `rows.csv`, `rows.ndjson`, `sweep.html` and
/// `sweep.json` into `out`/sweep/NAME.
///
/// # Errors
/// [`enum@Error`] when the folder cannot be written to, or the observer wants an end; what has been made until then is in the
/// journal. (A point without an answer is a row.)
pub fn sweep(
    study: &SweepStudy,
    out: &Path,
    observer: &dyn Observer,
) -> Result<SweepReport, Error> {
    let timer = StageTimer::new(observer);
    let mut files = Transaction::open(&out.join(folder(study)))?;
    let outcomes = outcomes(study, &files, None, &timer)?;
    timer.stage(Stage::Report, || {
        let table = table(&study.spec, outcomes);
        let mut report = report(study, &table);
        for (name, format, text) in rows(&table) {
            report.files.push(FileFacts::of(name, format, text.as_bytes()));
            files.add_bytes(name, text.as_bytes())?;
        }
        files.add_bytes("sweep.html", report.html(&table).as_bytes())?;
        files.add_report("sweep.json", &report.json())?;
        files.commit()?;
        let place = files.place();
        Ok((report, place))
    })
}

/// The tables of all points: name, format and text.
fn rows(table: &SweepTable) -> [(&'static str, &'static str, String); 2] {
    [("rows.csv", "csv", table.csv()), ("rows.ndjson", "ndjson", table.ndjson())]
}

/// Runs those points of a study that are the share of job `number` of `of`, from 1, into a journal of its own.
///
/// # Errors
/// [`enum@Error`] as of [`sweep`].
pub fn sweep_shard(
    study: &SweepStudy,
    [number, of]: [usize; 2],
    out: &Path,
    observer: &dyn Observer,
) -> Result<ShardReport, Error> {
    let timer = StageTimer::new(observer);
    let files = Transaction::open(&out.join(folder(study)))?;
    let points = outcomes(study, &files, Some([number, of]), &timer)?.len();
    let journal = files.path_of(&journal_name(Some([number, of]))).display().to_string();
    Ok(ShardReport { journal, points })
}
