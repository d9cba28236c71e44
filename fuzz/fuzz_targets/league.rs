//! `make fuzz TARGET=league`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz::guided(fuzz::league, bytes));
