//! `make fuzz TARGET=robot`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz::guided(fuzz::robot, bytes));
