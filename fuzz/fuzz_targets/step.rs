#![no_main]

#[path = "../properties/step.rs"]
mod step;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| step::holds(bytes));
