//! The way in for connections.

pub(crate) mod limits;
