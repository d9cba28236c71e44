//! `make fuzz TARGET=saved`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz::guided(fuzz::saved, bytes));
