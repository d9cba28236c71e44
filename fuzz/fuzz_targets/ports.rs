//! `make fuzz TARGET=ports`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz::guided(fuzz::ports, bytes));
