#![no_main]

#[path = "../properties/map.rs"]
mod map;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| map::holds(bytes));
