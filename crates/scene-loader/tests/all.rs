//! All tests of the crate's public items: one program, so that it is linked once.

mod documented;
mod equipment;
mod of_others;
mod robots_of_sdf;
mod suiting;
mod visuals;
