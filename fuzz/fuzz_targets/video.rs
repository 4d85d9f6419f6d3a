#![no_main]

#[path = "../properties/video.rs"]
mod video;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| video::holds(bytes));
