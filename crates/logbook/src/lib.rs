//! Sessions of a world with a log of them, and the replay of that log.
//!
//! News of sessions become records here alone, so logs of the server, of experiments and of the Python package have the same contents.

mod demo;
mod logged;
mod records;
mod replay;

pub use demo::{Demo, DemoError, write_demo};
pub use logged::LoggedSessions;
pub use records::record;
pub use replay::{Replay, ReplayError, replay};
