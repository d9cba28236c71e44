//! `make fuzz TARGET=obj`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz::guided(fuzz::obj, bytes));
