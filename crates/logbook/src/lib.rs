//! Sessions of a world with a log of them, and the replay of that log.

mod logged;
mod replay;

pub use logged::LoggedSessions;
pub use replay::{Replay, ReplayError, replay};
