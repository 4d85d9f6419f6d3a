//! Requests that no memory holds: refused at once, and before any memory is asked for.

use crate::builds::{SMALL, edited, folder, save};
use crate::needs::Needs;
use std::fs::File;
use std::path::Path;

/// Of the processors, whatever else they do.
const MOST_SECONDS: f64 = 1.0;
const MOST_KB: u64 = 100_000;

/// Asserts that a request is answered with `code` and all of `words`, soon and with little memory.
#[track_caller]
fn refused(home: &Path, arguments: &[&str], code: i32, words: &[&str]) {
    let ((exit, out, err), needs) = Needs::to_run(home, arguments);
    assert_eq!(exit, code, "{arguments:?}: {out}{err}");
    for word in words {
        let told = if code == 2 { &err } else { &out };
        assert!(told.contains(word), "{arguments:?}: no {word:?} in {out}{err}");
    }
    let is_modest = needs.seconds <= MOST_SECONDS && needs.memory_kb <= MOST_KB;
    assert!(is_modest, "{arguments:?} took {needs:?}");
}

#[test]
fn absurd_profiles_are_refused_before_the_work() {
    let folder = folder();
    let home = folder.path();
    let facets = "chord_um = 20\nfacet_px = 3";
    for (from, to, words) in [
        ("facet_px = 3", "facet_px = 1e-9", &["small.toml:24:", "mesh.facet_px must be"][..]),
        (facets, "max_triangles = 1e12", &["mesh.max_triangles must be", "40000000"]),
        ("[160, 120]", "[40000, 25000]", &["camera.orthographic.pixels must be", "32767"]),
        ("[160, 120]", "[32767, 32767]", &["at most 400 million pixels"]),
        ("degree = 8", "degree = 1e9", &["method.vector-field.degree must be"]),
        // Within what a key may say, but not all at once.
        (facets, "facet_px = 0.001", &["cannot mesh small: ", "facets", "that fit in memory"]),
        (
            "formats = [\"stl\", \"obj\"]",
            "formats = [\"csv\"]\nsag.pitch_mm = 0.001\nsag.step_mm = 0.001",
            &["export.sag must ask for at most 2e7 points"],
        ),
    ] {
        save(home, &edited(SMALL, &[(from, to)]));
        refused(home, &["build", "small.toml", "--quiet"], 2, words);
        refused(home, &["build", "small.toml", "--quiet", "--dry-run"], 2, words);
    }
    let nested = format!("a = {}", "[".repeat(60_000));
    for (text, words) in [
        (nested, "brackets must be nested at most"),
        (SMALL.to_owned() + &"# ".repeat(100_000), "must be at most 65536 bytes long"),
    ] {
        save(home, &text);
        refused(home, &["check", "small.toml"], 2, &[words]);
    }
}

#[test]
fn absurd_arguments_are_refused_before_the_work() {
    let folder = folder();
    let home = folder.path();
    save(home, SMALL);
    for (arguments, words) in [
        (&["build", "small.toml", "--threads", "1000000000"][..], "from 1 to 1024"),
        (&["tolerance", "small.toml", "--trials", "1000000000000"], "at most 10000000"),
        (&["blur", "small.toml", "--na", "1e9"], "from 1e-6 to 0.99"),
    ] {
        refused(home, arguments, 2, &[words]);
    }
    let machining = ["machining", "small.toml", "--quiet", "--ball-mm", "1", "--stepover-mm"];
    refused(home, &[&machining[..], &["1e-9"]].concat(), 2, &["cannot machine small: "]);
}

/// A file that is said to be so long, and takes no place on the disk.
fn hollow(path: &Path, length: u64) {
    File::create(path).unwrap().set_len(length).unwrap();
}

#[test]
fn files_that_claim_gigabytes_are_refused_before_memory_is_asked_for() {
    let folder = folder();
    let home = folder.path();
    save(home, SMALL);
    let verify = |name: &str, bytes: &[u8], code: i32, words: &[&str]| {
        std::fs::write(home.join(name), bytes).unwrap();
        refused(home, &["verify", name, "--profile", "small.toml", "--quiet"], code, words);
    };
    // 40 million facets are 2 GB.
    let claim = [&[b'x'; 80][..], &40_000_000_u32.to_le_bytes()].concat();
    verify("claim.stl", &claim, 1, &["which take 2000000084 bytes, but it has 84"]);
    let far = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 ";
    for last in ["4294967295", "-4294967295", "18446744073709551617", "0", "4"] {
        let text = format!("{far}{last}\n");
        verify("far.obj", text.as_bytes(), 1, &["far.obj: not a readable OBJ: "]);
    }

    let given = "camera.orthographic.pixels = [64, 48]
mirror.grid.file = \"sag.csv\"
part = { width_mm = 3, height_mm = 3, base_mm = 5 }
mesh.chord_um = 2
export.formats = [\"stl\"]
";
    std::fs::write(home.join("given.toml"), given).unwrap();
    for (table, words) in [
        // A quintillion nodes by the steps between the first ones.
        ("0,0,1\n1,0,1\n2,0,1\n1e9,0,1\n0,1,1\n0,2,1\n0,1e9,1\n1,1,1\n", "sag.csv: "),
        ("-1e308,0,1\n0,0,1\n1e308,0,1\n0,1e-308,1\n", "sag.csv: "),
        ("0,0,1e999\n", "sag.csv: line 1: Z must be a finite number"),
    ] {
        std::fs::write(home.join("sag.csv"), table).unwrap();
        refused(home, &["build", "given.toml", "--quiet"], 2, &[words]);
    }

    hollow(&home.join("long.toml"), 3_000_000_000);
    refused(home, &["check", "long.toml"], 2, &["cannot read long.toml: it has more than "]);
    hollow(&home.join("sag.csv"), 50_000_000_000);
    refused(home, &["build", "given.toml"], 2, &["sag.csv: it has more than 800000000 bytes"]);
    hollow(&home.join("long.stl"), 200_000_000_000);
    let arguments = ["verify", "long.stl", "--profile", "small.toml", "--quiet"];
    refused(home, &arguments, 2, &["long.stl: it has more than 8000000000 bytes"]);
    assert!(!home.join("out").join("given").join("mirror.stl").exists());
}
