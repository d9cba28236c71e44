//! `make fuzz TARGET=sdf`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz::guided(fuzz::sdf, bytes));
