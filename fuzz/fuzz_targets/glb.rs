#![no_main]

#[path = "../properties/glb.rs"]
mod glb;
mod lot;
#[path = "../properties/mesh.rs"]
mod mesh;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| glb::holds(bytes, lot::of(bytes)));
