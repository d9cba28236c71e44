//! `make fuzz TARGET=stl`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz::guided(fuzz::stl, bytes));
