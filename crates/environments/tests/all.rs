//! All tests of the crate's public items: one program, so that it is linked once.

mod environments;
mod world_batch;
