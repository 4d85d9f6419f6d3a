//! Signals that end the program: what it was writing goes first, as does a build of the studio, and the exit code tells the signal.

use super::memory::has_room_for;
use crate::pipeline::{abandon, journal_under_way};
use crate::report::visible;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
use signal_hook::iterator::Signals;
use std::io::Write;
use std::process::exit;
use std::sync::Arc;
use std::sync::mpsc::channel;
use std::thread::Builder;

/// Where Linux tells which signals this process was started to ignore.
const STATUS: &str = "/proc/self/status";

/// Ends the program with 128 and the signal's number on SIGINT, SIGTERM and SIGHUP, unless it was
/// started to ignore them (nohup, jobs in the background). Where no thread can be started, memory is short for
/// one, or what is ignored is not known, signals do what they do by default.
pub(super) fn watch() {
    let Some(ignored) = ignored().filter(|_| has_room_for(1)) else { return };
    let ends: Vec<i32> =
        [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|signal| !is_in(ignored, *signal)).collect();
    // A file over the shell's limit (ulimit -f) is then an error of writing it.
    let _ = signal_hook::flag::register(SIGXFSZ, Arc::default());
    let (watches, watched) = channel();
    let wait = move || {
        let Ok(mut signals) = Signals::new(ends) else { return };
        let _ = watches.send(());
        if let Some(signal) = signals.forever().next() {
            #[cfg(feature = "studio")]
            crate::studio::end_build();
            abandon();
            if let Some((journal, added)) = journal_under_way() {
                // Who cannot read it has the exit code.
                let _ = writeln!(
                    std::io::stderr(),
                    "interrupted: {added} new points are kept in {}; the same command goes on from there",
                    visible(&journal.display().to_string())
                );
            }
            exit(128 + signal);
        }
    };
    // Nothing is written before signals are waited for, however late the thread gets a core. Where there
    // is no thread, the channel is closed.
    if Builder::new().name("signals".to_owned()).spawn(wait).is_ok() {
        let _ = watched.recv();
    }
}

/// The signals that are ignored, one bit each.
fn ignored() -> Option<u64> {
    let status = std::fs::read_to_string(STATUS).ok()?;
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"))?;
    u64::from_str_radix(mask.trim(), 16).ok()
}

fn is_in(mask: u64, signal: i32) -> bool {
    mask >> (signal - 1) & 1 == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masks_hold_a_bit_for_each_signal() {
        assert!(is_in(1, SIGHUP) && is_in(2, SIGINT) && !is_in(2, SIGHUP));
        assert!(is_in(1 << 14, SIGTERM));
    }
}
