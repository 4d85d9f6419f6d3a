#![no_main]

mod lot;
#[path = "../properties/mesh.rs"]
mod mesh;
#[path = "../properties/obj.rs"]
mod obj;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| obj::holds(bytes, lot::of(bytes)));
