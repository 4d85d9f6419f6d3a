#![no_main]

#[path = "../properties/points.rs"]
mod points;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| points::holds(bytes));
