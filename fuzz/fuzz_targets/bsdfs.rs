//! See `lightbox_tests::properties::bsdfs`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| lightbox_tests::properties::bsdfs(bytes));
