//! `make fuzz TARGET=dae`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz::guided(fuzz::dae, bytes));
