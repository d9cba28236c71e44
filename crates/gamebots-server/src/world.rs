//! The thread that owns the world, and the requests to it.

pub(crate) mod client;
pub(crate) mod event;
pub(crate) mod fit;
pub(crate) mod guests;
pub(crate) mod inquiry;
pub(crate) mod pace;
pub(crate) mod question;
pub(crate) mod restart;
pub(crate) mod saved;
pub(crate) mod thread;
