//! Folders with two complete builds, and whether what is in one is whole.

use crate::builds::{self, SMALL, command, edited, files, morion, save, told};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};

pub type Files = BTreeMap<String, Vec<u8>>;

/// Two complete builds of profiles of the same name that differ in every lasting file.
pub struct Home {
    folder: tempfile::TempDir,
    pub old: Files,
    pub new: Files,
}

impl Home {
    /// The old build in `out`, the new one in `new`.
    pub fn new() -> Self {
        let folder = builds::folder();
        let home = folder.path();
        save(home, SMALL);
        // The map of curl is the picture's own: no other mirror changes it.
        let other = [("[-30, 30]", "[-28, 31]"), ("degree = 8", "degree = 6")];
        save(&home.join("other"), &edited(SMALL, &other));
        let build = |profile: &str, out: &str| {
            let arguments = ["build", profile, "--out", out, "--quiet"];
            let (code, _, err) = told(&morion(home, &arguments));
            assert_eq!(code, 0, "{err}");
            files(&home.join(out).join("small"))
        };
        let (old, new) = (build("small.toml", "out"), build("other/small.toml", "new"));
        assert!(old.keys().eq(new.keys()) && old.iter().all(|(name, bytes)| new[name] != *bytes));
        Self { folder, old, new }
    }

    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Where both are built.
    pub fn made(&self) -> PathBuf {
        self.path().join("out/small")
    }

    /// Starts the new build over the old one.
    pub fn start(&self) -> Child {
        self.start_of("other/small.toml")
    }

    pub fn start_of(&self, profile: &str) -> Child {
        let mut command = command(self.path());
        command.args(["build", profile, "--quiet"]).stdout(Stdio::null()).stderr(Stdio::piped());
        command.spawn().unwrap()
    }

    /// Brings the old build back.
    pub fn put_back(&self) {
        let made = self.made();
        std::fs::remove_dir_all(&made).unwrap();
        std::fs::create_dir(&made).unwrap();
        self.old.iter().for_each(|(name, bytes)| std::fs::write(made.join(name), bytes).unwrap());
    }

    /// Every file is the whole old or the whole new one; where there is a report all are of one build.
    /// Returns how many are new.
    #[track_caller]
    pub fn all_whole(&self) -> usize {
        let mut found = files(&self.made());
        found.retain(|name, _| !is_temporary(name));
        // Those that speak of others may be gone.
        let speaks = |name: &str| name.ends_with(".json") || name.ends_with(".html");
        let kept = |name: &&String| found.contains_key(*name) || speaks(name);
        assert!(self.old.keys().all(|name| kept(&name)), "{:?}", found.keys());
        assert!(found.keys().all(|name| self.old.contains_key(name)), "{:?}", found.keys());
        if let Some(timings) = found.get("timings.json") {
            let timings = String::from_utf8(timings.clone()).unwrap();
            assert!(timings.starts_with('{') && timings.ends_with("}\n"), "{timings}");
        }
        let renewed = |name: &str| {
            let (found, old) = (&found[name], &self.old[name]);
            // Timings are never the same twice.
            let is_new = *found == self.new[name] || name == "timings.json";
            assert!(found == old || is_new, "half {name}");
            found != old
        };
        let count = found.keys().filter(|name| renewed(name)).count();
        if found.contains_key("report.json") || found.contains_key("report.html") {
            let pages = self.old.keys().filter(|name| speaks(name) && !found.contains_key(*name));
            let of_one = count == 0 || pages.count() + count == self.old.len();
            assert!(of_one, "a report beside files of another build: {count} of {}", found.len());
        }
        count
    }
}

fn is_temporary(name: &str) -> bool {
    name.starts_with(".morion-") && name.ends_with(".tmp")
}

/// How many files under temporary names there are; none where there is no folder.
pub fn temporary(folder: &Path) -> usize {
    if !folder.exists() {
        return 0;
    }
    let entries = std::fs::read_dir(folder).unwrap();
    entries
        .filter(|entry| is_temporary(&entry.as_ref().unwrap().file_name().to_string_lossy()))
        .count()
}
