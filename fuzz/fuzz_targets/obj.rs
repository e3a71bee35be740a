//! See `lightbox_tests::properties::obj`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| lightbox_tests::properties::obj(bytes));
