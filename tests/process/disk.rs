//! Disks that refuse, folders that go, and others who write there too.

use crate::builds::{SMALL, assert_same, command, files, folder, lasting, parsed, save, told};
use crate::whole::{Home, temporary};
use morion::internals::pipeline::{Observer, build};
use std::fs::File;
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

const PROGRAM: &str = env!("CARGO_BIN_EXE_morion");

#[test]
fn a_full_disk_leaves_the_earlier_files_as_they_were() {
    let home = Home::new();
    let (made, new) = (home.made(), &home.new);
    assert_same(&files(&made), &home.old, "before");
    // Largest file in blocks of 512 bytes: less than the STL, and less than the OBJ alone.
    let between = (new["mirror.stl"].len() + new["mirror.obj"].len()) / 2 / 512;
    for (blocks, refused) in [(64, "mirror.stl"), (between, "mirror.obj")] {
        let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" \"$@\"");
        let run = |out: &str| {
            let mut shell = Command::new("sh");
            shell.current_dir(home.path()).args(["-c", &script, PROGRAM]);
            let arguments = ["build", "other/small.toml", "--quiet", "--out", out];
            told(&shell.args(arguments).output().unwrap())
        };
        let (code, out, err) = run("out");
        assert_eq!((code, &*out), (2, ""), "{err}");
        assert!(err.starts_with("error: cannot write ") && err.contains(refused), "{err}");
        assert!(err.contains("(ulimit -f)"), "{err}");
        assert_same(&files(&made), &home.old, "a full disk");
        let empty = format!("fresh{blocks}");
        assert_eq!(run(&empty).0, 2);
        assert!(files(&home.path().join(&empty).join("small")).is_empty());
    }
}

/// Builds onto a file system of its own, of `options`, and lists what is on it afterwards: exit
/// code, list, and stderr.
#[track_caller]
fn mounted(home: &Path, options: &str) -> (i32, String, String) {
    let disk = home.join("disk");
    std::fs::create_dir_all(&disk).unwrap();
    let script = format!(
        "mount -t tmpfs -o {options} none disk || exit 99
         '{PROGRAM}' build small.toml --quiet --out disk >result
         code=$?; find disk -type f; exit $code"
    );
    let mut refusals = String::new();
    // Who is root needs no name space for users, and may not get one.
    for spaces in [&["--mount"][..], &["--user", "--map-root-user", "--mount"]] {
        let mut shell = Command::new("unshare");
        let shell = shell.current_dir(home).args(spaces).args(["sh", "-c", &script]);
        let (code, list, err) = told(&shell.output().expect("unshare starts"));
        if code != 99 && !err.starts_with("unshare") {
            return (code, list, err);
        }
        refusals += &err;
    }
    panic!("no file system can be mounted here: {refusals}");
}

#[test]
#[ignore = "mounts a small disk: cargo test --test process -- --ignored"]
fn a_disk_that_runs_full_is_named_and_keeps_nothing() {
    let home = Home::new();
    let all = home.old["mirror.stl"].len() + home.old["mirror.obj"].len();
    // Less than the files will take, but more than is sure beforehand.
    let options = format!("size={}k", 92 * all / 100 / 1024);
    let (code, list, err) = mounted(home.path(), &options);
    assert_eq!((code, &*list), (2, ""), "{err}");
    for word in ["error: cannot write disk/small/", "No space left on device", "; make room"] {
        assert!(err.contains(word), "no {word:?} in {err}");
    }
    // So much too small that it is known beforehand.
    let (code, list, err) = mounted(home.path(), "size=100k");
    assert_eq!((code, &*list), (2, ""), "{err}");
    for word in ["error: cannot write into the folder disk/small: ", " MB are free; make room"] {
        assert!(err.contains(word), "no {word:?} in {err}");
    }
}

#[test]
#[ignore = "mounts a small disk: cargo test --test process -- --ignored"]
fn a_disk_that_is_read_only_is_named() {
    let folder = folder();
    save(folder.path(), SMALL);
    let (code, list, err) = mounted(folder.path(), "ro");
    assert_eq!((code, &*list), (2, ""), "{err}");
    for word in ["error: cannot create the folder disk/small: ", "Read-only", "with --out"] {
        assert!(err.contains(word), "no {word:?} in {err}");
    }
}

#[test]
fn a_folder_that_is_removed_meanwhile_is_named_and_not_made_again() {
    /// Removes the folder when so many files have been written to it.
    struct Remover(AtomicUsize);
    impl Observer for Remover {
        fn written(&self, path: &Path) {
            if self.0.fetch_sub(1, Ordering::Relaxed) == 1 {
                std::fs::remove_dir_all(path.parent().unwrap()).unwrap();
            }
        }
    }
    for files in [1, 2] {
        let folder = folder();
        let remover = Remover(AtomicUsize::new(files));
        let error = build(&parsed(SMALL), folder.path(), &remover).unwrap_err().to_string();
        let path = folder.path().join("small");
        for word in ["cannot ", &path.display().to_string(), "removed meanwhile: run the command"] {
            assert!(error.contains(word), "no {word:?} in {error}");
        }
        assert!(!path.exists());
    }
}

#[test]
fn two_builds_into_one_folder_at_once_leave_the_files_of_one() {
    let home = Home::new();
    for round in 0..4 {
        home.put_back();
        let profiles = ["small.toml", "other/small.toml"];
        let both = profiles.map(|profile| home.start_of(profile));
        for child in both {
            let (code, _, err) = told(&child.wait_with_output().unwrap());
            assert_eq!((code, &*err), (0, ""), "round {round}");
        }
        let found = lasting(files(&home.made()));
        let [old, new] = [&home.old, &home.new].map(|files| lasting(files.clone()));
        assert!(found == old || found == new, "round {round}: {:?}", found.keys());
    }
}

#[test]
fn a_build_waits_until_another_has_given_all_its_files_their_names() {
    let home = Home::new();
    let made = home.made();
    let other = File::open(&made).unwrap();
    // Held as a build holds it that publishes, but for a sweep at the beginning.
    let mut child = home.start();
    let deadline = Instant::now() + Duration::from_secs(60);
    while temporary(&made) < 2 {
        assert!(Instant::now() < deadline, "nothing is written");
    }
    other.lock_shared().unwrap();
    while temporary(&made) < home.old.len() {
        assert!(Instant::now() < deadline, "not all is written");
    }
    std::thread::sleep(Duration::from_millis(100));
    assert!(child.try_wait().unwrap().is_none());
    assert_eq!(home.all_whole(), 0);
    other.unlock().unwrap();
    assert!(child.wait().unwrap().success());
    assert_eq!((home.all_whole(), temporary(&made)), (home.old.len(), 0));
}

#[test]
fn a_reader_that_has_seen_enough_is_no_error() {
    let folder = folder();
    let script =
        "\"$0\" profiles --show conquistador | head -c 1; exec \"$0\" profiles | head -n 1";
    let output =
        Command::new("sh").current_dir(folder.path()).args(["-c", script, PROGRAM]).output();
    let (code, out, err) = told(&output.unwrap());
    assert_eq!((code, &*err), (0, ""));
    assert!(out.starts_with('#') && out.lines().count() == 1, "{out}");
    // Half a report is read, and then no more.
    save(folder.path(), SMALL);
    let mut command = command(folder.path());
    command.args(["build", "small.toml", "--quiet", "--format", "json"]);
    let (mut reader, writer) = std::io::pipe().unwrap();
    let child = command.stdout(writer).stderr(std::process::Stdio::piped()).spawn().unwrap();
    drop(command);
    std::io::Read::read_exact(&mut reader, &mut [0; 10]).unwrap();
    drop(reader);
    let (code, _, err) = told(&child.wait_with_output().unwrap());
    assert_eq!((code, &*err), (0, ""));
}
