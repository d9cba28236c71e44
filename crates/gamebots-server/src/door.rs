//! The way in for connections: listening, acceptance, lines, limits.

pub(crate) mod accept;
pub(crate) mod limits;
pub(crate) mod lines;
