//! Signals that end a build, or forbid a file its size.

use crate::builds::{SMALL, files, folder, save};
use crate::whole::{Home, temporary};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// The program in `folder`, to which signals do what they do by default: who runs the tests may ignore some.
fn command(folder: &Path) -> Command {
    let mut command = Command::new("env");
    command.args(["--default-signal", env!("CARGO_BIN_EXE_morion")]).current_dir(folder);
    command.stdout(Stdio::null()).stderr(Stdio::piped());
    command
}

/// A build in `folder` by a shell that has done `first`.
fn after(first: &str, folder: &Path) -> Command {
    let script = format!("{first}; exec \"$0\" build small.toml --quiet");
    let mut command = Command::new("sh");
    command.args(["-c", &script, env!("CARGO_BIN_EXE_morion")]).current_dir(folder);
    command
}

#[test]
fn a_build_that_is_told_to_end_removes_what_it_was_writing() {
    let home = Home::new();
    for (signal, code) in [("INT", 130), ("TERM", 143), ("HUP", 129)] {
        home.put_back();
        let mut child = command(home.path());
        let mut child = child.args(["build", "other/small.toml", "--quiet"]).spawn().unwrap();
        let deadline = Instant::now() + Duration::from_secs(60);
        while temporary(&home.made()) == 0 {
            assert!(Instant::now() < deadline, "{signal}: no temporary file");
            std::thread::sleep(Duration::from_millis(1));
        }
        let kill =
            Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status();
        assert!(kill.unwrap().success());
        assert_eq!(child.wait().unwrap().code(), Some(code), "{signal}");
        assert_eq!(temporary(&home.made()), 0, "{signal}");
        assert_eq!(home.all_whole(), 0, "{signal}");
    }
}

#[test]
fn a_signal_that_is_ignored_ends_nothing() {
    let folder = folder();
    save(folder.path(), SMALL);
    let mut child = after("trap '' HUP", folder.path()).stdout(Stdio::null()).spawn().unwrap();
    let made = folder.path().join("out/small");
    while !made.exists() {
        std::thread::sleep(Duration::from_millis(1));
    }
    let kill = Command::new("kill").args(["-HUP", &child.id().to_string()]).status();
    assert!(kill.unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(0));
    assert!(files(&made).contains_key("report.json"));
}

#[test]
fn a_file_over_the_shells_limit_is_an_error_with_a_remedy() {
    let folder = folder();
    save(folder.path(), SMALL);
    let output = after("ulimit -f 8", folder.path()).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("the shell (ulimit -f) allows no file of this size"), "{said}");
    assert_eq!(temporary(&folder.path().join("out/small")), 0);
}
