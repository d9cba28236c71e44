//! The language that controllers and USARSim speak over TCP.
//!
//! Bytes become a [`Line`] in [`framing`], a line becomes a [`Command`] (client to server) or a
//! [`Message`] (server to client). Input is read leniently, as real controllers write it; output is
//! byte for byte what USARSim sends, in the dialect of UDK or of UT2004. Nothing here knows a socket, a clock or the physics.
//!
//! Frame and units on the wire: x forward, y right, z down, metres, radians, seconds; angles are roll, pitch, yaw.

// This crate parses input from strangers.
#![warn(clippy::indexing_slicing, clippy::string_slice, clippy::expect_used)]
#![cfg_attr(test, allow(clippy::indexing_slicing, clippy::string_slice, clippy::expect_used))]

pub mod command;
mod dialect;
mod field;
pub mod framing;
mod line;
pub mod message;
pub mod number;
pub mod ports;
mod problem;
mod value;

pub use command::Command;
pub use dialect::Dialect;
pub use framing::Framing;
pub use line::{Block, Line, MAX_BLOCKS};
pub use message::Message;
pub use problem::{Problem, shown};
