//! `make fuzz TARGET=ini`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz::guided(fuzz::ini, bytes));
