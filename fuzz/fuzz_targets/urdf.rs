//! `make fuzz TARGET=urdf`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz::guided(fuzz::urdf, bytes));
