//! The process and its limits: builds that are killed or told to end, disks that refuse, and requests that no memory
//! holds.
//!
//! With `MORION_THOROUGH=1` builds are killed at 200 moments.

mod absurd;
#[path = "../it/support/builds.rs"]
mod builds;
#[cfg(unix)]
mod disk;
#[cfg(unix)]
#[path = "../it/support/draws.rs"]
mod draws;
#[cfg(target_os = "linux")]
mod frames;
#[cfg(unix)]
mod kills;
mod needs;
#[cfg(target_os = "linux")]
#[path = "../it/support/package.rs"]
mod package;
// prlimit and setpriv are Linux's.
#[cfg(target_os = "linux")]
mod scarce;
#[cfg(unix)]
mod signals;
#[cfg(unix)]
#[path = "../it/support/thorough.rs"]
mod thorough;
#[cfg(unix)]
mod whole;
