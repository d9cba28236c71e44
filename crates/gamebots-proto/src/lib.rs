//! The text protocol that controllers and USARSim speak over TCP: bytes to lines, lines to commands and messages, and back.
//!
//! Input is read leniently, as real controllers write it: there is always a result, and a [`Problem`] for each mistake. Output is byte for
//! byte what USARSim sends, in the dialect of UDK or of UT2004. Nothing here knows a socket, a clock or the physics. Input from strangers
//! never panics and never allocates without a limit.
//!
//! Frame and units on the wire: x forward, y right, z down, metres, radians, seconds; angles are roll, pitch, yaw.
//!
//! | type | content |
//! |---|---|
//! | [`Framing`] | bytes of a stream to the lines that they complete |
//! | [`Line`] | a verb and its [`Block`]s: `DRIVE {Left 1.0} {Right 1.0}` |
//! | [`Command`] | a line of a client; [`command`] has a type for each verb |
//! | [`Message`] | a line of a server; [`message`] has a type for each, and each reading of a sensor |
//! | [`Dialect`] | the two forms of a server's lines |
//! | [`Problem`] | a mistake in a client's line |
//! | [`ports`] | lines of the ports for truth, positions, pictures and radio |
//!
//! # Example
//! A server reads a client's line and answers. The client reads the answer.
//!
//! ```
//! use gamebots_proto::message::{GroundTruth, Reading};
//! use gamebots_proto::{Command, Dialect, Framing, Message};
//!
//! let mut framing = Framing::default();
//! let lines = framing.push(b"DRIVE {Left 1,5} {Right fast}\r\nDRIVE {Le");
//! assert_eq!(lines.len(), 1);
//!
//! let mut problems = Vec::new();
//! for line in lines {
//!     let Some(Command::Drive(drive)) = Command::parse(&line?, &mut problems) else { panic!("no DRIVE") };
//!     assert_eq!(drive.number("Left", &mut problems), Some(1.5));
//!     assert_eq!(drive.number("Right", &mut problems), Some(0.0));
//! }
//! assert_eq!(problems[0].to_string(), "{Right fast}: expected a number; read as 0");
//!
//! let truth = GroundTruth { name: "Truth".to_owned(), location: [1.0, -2.5, 0.0], orientation: [0.0, 0.0, 1.57] };
//! let message = Message::Sen(Reading::from(truth).at(12.5));
//! let line = message.write(Dialect::Udk);
//! assert_eq!(
//!     line,
//!     "SEN {Time 12.5000} {Type GroundTruth} {Name Truth} {Location 1.000,-2.500,0.000} {Orientation 0.000,0.000,1.570}"
//! );
//! assert_eq!(Message::read(&line), Some(message));
//! # Ok::<(), gamebots_proto::Problem>(())
//! ```

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
pub use problem::{Problem, expected_of, shown};
pub use value::LIMIT;

/// The examples of the README, as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
