//! The thread that owns the world, and what it needs.

pub(crate) mod client;
pub(crate) mod guests;
pub(crate) mod pace;
pub(crate) mod restart;
pub(crate) mod saved;
pub(crate) mod thread;
