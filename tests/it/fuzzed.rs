//! The fuzzer's seeds and what it once found: what its targets assert holds for all of them.

#[path = "../../fuzz/properties/calibration.rs"]
mod calibration;
#[path = "../../fuzz/properties/csv.rs"]
mod csv;
#[path = "../../fuzz/properties/glb.rs"]
pub(crate) mod glb;
#[path = "../../fuzz/properties/map.rs"]
mod map;
#[path = "../../fuzz/properties/mesh.rs"]
mod mesh;
#[path = "../../fuzz/properties/obj.rs"]
mod obj;
#[path = "../../fuzz/properties/points.rs"]
mod points;
#[path = "../../fuzz/properties/profile.rs"]
mod profile;
#[path = "../../fuzz/properties/program.rs"]
mod program;
#[path = "../../fuzz/properties/step.rs"]
mod step;
#[path = "../../fuzz/properties/stl.rs"]
mod stl;
#[path = "../../fuzz/properties/video.rs"]
mod video;

use std::fs;
use std::path::{Path, PathBuf};

/// The files in a folder, if there is one, in the order of their names.
fn files(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

/// Replays the seeds of a target, and what was found by it.
fn replay(target: &str, holds: impl Fn(&[u8])) {
    let fuzz = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz");
    let [seeds, found] = ["seeds", "found"].map(|kind| files(&fuzz.join(kind).join(target)));
    assert!(!seeds.is_empty(), "no seeds");
    for path in seeds.iter().chain(&found) {
        println!("{}", path.display());
        holds(&fs::read(path).unwrap());
    }
    println!("{target}: {} seeds and {} findings hold", seeds.len(), found.len());
}

#[test]
fn profiles_of_the_fuzzer_are_read_or_refused_at_a_place() {
    replay("profile", profile::holds);
}

#[test]
fn the_shipped_profiles_are_seeds_of_the_fuzzer_too() {
    for shipped in morion::internals::profile::shipped() {
        profile::holds(shipped.text.as_bytes());
    }
}

#[test]
fn stl_files_of_the_fuzzer_come_to_a_verdict() {
    replay("stl", |bytes| stl::holds(bytes, 0));
}

#[test]
fn obj_files_of_the_fuzzer_come_to_a_verdict() {
    replay("obj", |bytes| obj::holds(bytes, 0));
}

#[test]
fn glb_files_of_the_fuzzer_come_to_a_verdict() {
    replay("glb", |bytes| glb::holds(bytes, 0));
}

#[test]
#[ignore = "long: .ci/nightly"]
fn step_files_of_the_fuzzer_are_solids_or_refused() {
    replay("step", step::holds);
}

#[test]
fn points_of_the_fuzzer_are_aligned_or_refused() {
    replay("points", points::holds);
}

#[test]
fn programs_of_the_fuzzer_are_moves_or_refused() {
    replay("program", program::holds);
}

#[test]
fn tables_of_the_fuzzer_are_complete_or_refused() {
    replay("csv", csv::holds);
}

#[test]
fn calibrations_of_the_fuzzer_have_rays_or_are_refused() {
    replay("calibration", calibration::holds);
}

#[test]
fn maps_of_the_fuzzer_are_pictures_or_refused() {
    replay("map", map::holds);
}

#[test]
fn streams_of_the_fuzzer_are_read_or_refused() {
    replay("video", video::holds);
}
