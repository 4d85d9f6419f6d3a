#![no_main]

#[path = "../properties/program.rs"]
mod program;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| program::holds(bytes));
