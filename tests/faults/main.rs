//! Faults from outside: kills, disks that refuse, absurd requests, and profiles that nobody would
//! think of.
//!
//! With `MORION_THOROUGH` set, builds are killed at 200 moments and 10 000 random profiles are built.

mod absurd;
#[path = "../common/mod.rs"]
mod common;
#[cfg(unix)]
mod disk;
#[cfg(unix)]
mod kills;
mod profiles;
#[path = "../random/mod.rs"]
mod random;
#[cfg(unix)]
mod whole;

/// `usual`, or as many as there should be once in a while.
fn times(usual: usize, thorough: usize) -> usize {
    if std::env::var_os("MORION_THOROUGH").is_some() { thorough } else { usual }
}
