//! `make fuzz TARGET=requests`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz::guided(fuzz::requests, bytes));
