#![no_main]

#[path = "../properties/profile.rs"]
mod profile;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| profile::holds(bytes));
