#![no_main]

mod lot;
#[path = "../properties/mesh.rs"]
mod mesh;
#[path = "../properties/stl.rs"]
mod stl;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| stl::holds(bytes, lot::of(bytes)));
