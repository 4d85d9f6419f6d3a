//! What a process needs of processors and memory.

use crate::builds::{command, told};
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

/// What a process was seen to need.
#[derive(Debug, Clone, Copy, Default)]
pub struct Needs {
    /// Of the processors, whatever else they do.
    pub seconds: f64,
    /// Most memory, where the system says.
    pub memory_kb: u64,
}

impl Needs {
    /// Of the program, with its exit code and what it printed. It is looked at every millisecond, and what
    /// matters takes tens of them.
    pub fn to_run(home: &Path, arguments: &[&str]) -> ((i32, String, String), Self) {
        let mut command = command(home);
        command.args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let mut needs = Self::default();
        while child.try_wait().unwrap().is_none() {
            needs = Self::of(child.id()).unwrap_or(needs);
            std::thread::sleep(Duration::from_millis(1));
        }
        (told(&child.wait_with_output().unwrap()), needs)
    }

    /// Of a process that runs; none where the system does not say.
    fn of(process: u32) -> Option<Self> {
        let read = |name| std::fs::read_to_string(format!("/proc/{process}/{name}")).ok();
        let status = read("status")?;
        let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
        let memory_kb = peak.trim().strip_suffix(" kB")?.parse().ok()?;
        // After the name in brackets the state; ticks of user and system are the 12th and 13th then.
        let stat = read("stat")?;
        let fields = stat.rsplit_once(") ")?.1.split(' ').skip(11).take(2);
        let ticks: f64 = fields.filter_map(|ticks| ticks.parse::<f64>().ok()).sum();
        Some(Self { seconds: ticks / 100.0, memory_kb })
    }
}
