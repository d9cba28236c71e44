//! `make fuzz TARGET=log`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz::guided(fuzz::log, bytes));
