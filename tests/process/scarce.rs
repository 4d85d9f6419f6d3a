//! A system that starts no more threads, or gives no more memory.

use crate::builds::{SMALL, assert_same, files, folder, lasting, save};
use crate::package::{TYPES, package};
use crate::thorough::times;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::Path;
use std::process::{Command, Output};

/// Runs the program in `folder` with `limit` of prlimit. The system lets root have all threads it asks
/// for: root's program runs as nobody.
fn limited(folder: &Path, limit: &str, arguments: &[&str]) -> Output {
    let program = folder.join("morion");
    if !program.exists() {
        // By a process of its own: a child that another test starts while this one copied would hold the
        // copy open for writing, and the system runs no such file.
        let mut copy = Command::new("cp");
        copy.args([Path::new(env!("CARGO_BIN_EXE_morion")), &program]);
        assert!(copy.status().unwrap().success());
        std::fs::set_permissions(folder, PermissionsExt::from_mode(0o777)).unwrap();
    }
    let is_root = std::fs::metadata("/proc/self").unwrap().uid() == 0;
    let mut command = Command::new(if is_root { "setpriv" } else { "env" });
    if is_root {
        command.args(["--reuid=65534", "--regid=65534", "--clear-groups"]);
    }
    command.args(["prlimit", limit]).arg(program).args(arguments);
    command.current_dir(folder).output().unwrap()
}

#[test]
fn where_no_thread_can_be_started_one_does_the_work() {
    let folder = folder();
    let home = folder.path();
    save(home, SMALL);
    let build = |limit: &str, out: &str, threads: &[&str]| {
        let arguments = [&["build", "small.toml", "--out", out], threads].concat();
        let output = limited(home, limit, &arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(0), "{threads:?}: {said}");
        assert!(!said.contains("panicked"), "{said}");
        lasting(files(&home.join(out).join("small")))
    };
    let free = build("--core=0:0", "free", &[]);
    for (out, threads) in
        [("one", &["--threads", "1"][..]), ("two", &["--threads", "2"]), ("n", &[])]
    {
        assert_same(&free, &build("--nproc=1", out, threads), out);
    }
}

/// A 3MF of so many vertices in one place, and as many facets: 200 kB for each million.
fn dense(path: &Path, count: usize) {
    let model = [
        "<model><resources><object id=\"1\"><mesh><vertices>",
        &"<vertex x=\"0\" y=\"0\" z=\"0\"/>".repeat(count),
        "</vertices><triangles>",
        &"<triangle v1=\"0\" v2=\"1\" v3=\"2\"/>".repeat(count),
        "</triangles></mesh></object></resources><build><item objectid=\"1\"/></build></model>",
    ];
    package(path, Some(TYPES), &model);
}

#[test]
fn a_3mf_that_memory_does_not_hold_is_told_from_a_broken_one() {
    let folder = folder();
    let home = folder.path();
    save(home, SMALL);
    dense(&home.join("dense.3mf"), 3_000_000);
    for megabytes in [100, 150, 200, 250] {
        let limit = format!("--as={megabytes}000000");
        let arguments = ["verify", "dense.3mf", "--profile", "small.toml", "--threads", "1"];
        let output = limited(home, &limit, &arguments);
        let said = String::from_utf8(output.stdout).unwrap();
        assert_eq!(output.status.code(), Some(1), "{megabytes} MB: {said}");
        assert!(said.contains("there is not enough memory for "), "{megabytes} MB: {said}");
    }
}

#[test]
fn under_every_limit_of_memory_above_60_megabytes_the_program_begins() {
    let folder = folder();
    let kilobytes = (60_000..200_000).step_by(times(700, 50));
    for limit in kilobytes.map(|kilobytes| format!("--as={kilobytes}000")) {
        let output = limited(folder.path(), &limit, &["--version"]);
        assert!(output.status.success(), "{limit}: {output:?}");
    }
}

/// No thread is started where its own first memory, or the next of the thread that goes on, could be refused, which
/// would end the program.
#[test]
fn where_memory_is_short_the_program_does_without_its_threads() {
    let folder = folder();
    save(folder.path(), SMALL);
    for megabytes in (70..=160).step_by(10).chain((200..=600).step_by(50)) {
        for (_, threads) in (0..times(2, 25)).flat_map(|k| [(k, "1"), (k, "2")]) {
            let limit = format!("--as={megabytes}000000");
            let arguments = ["check", "small.toml", "--threads", threads];
            let output = limited(folder.path(), &limit, &arguments);
            assert!(output.status.success(), "{threads} in {megabytes} MB: {output:?}");
        }
    }
}
