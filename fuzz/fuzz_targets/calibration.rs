#![no_main]

#[path = "../properties/calibration.rs"]
mod calibration;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| calibration::holds(bytes));
