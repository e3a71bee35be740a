//! See `crates/viewer/tests/session/property.rs`.
#![no_main]

#[path = "../../crates/viewer/tests/session/property.rs"]
mod property;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| property::session(bytes));
