//! All tests of the program but the soak, which measures alone: one program, so that it is linked once and waits overlap.

mod attack;
mod book;
mod calibrate;
mod cli;
mod descriptors;
mod experiment;
mod figures;
mod import;
mod import_map;
mod log;
mod open;
mod scenarios;
