//! `make fuzz TARGET=glb`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz::guided(fuzz::glb, bytes));
