//! A world that is served: its clients and guests, its pace, pauses and restarts, without sockets, threads or a clock.
//!
//! [`ServedWorld::turn`] is one round of its loop: it takes [`Event`]s, executes what clients ask, steps if a step is due, tells its
//! [`Audience`], and returns when it wants the next turn. Lines for clients wait in their outboxes. The caller has the clock, the threads
//! for long work ([`Task`]) and the ports. Programs and ports send events by an [`Entrance`].

#![warn(clippy::indexing_slicing, clippy::string_slice, clippy::expect_used)]
#![cfg_attr(test, allow(clippy::indexing_slicing, clippy::string_slice, clippy::expect_used))]

mod actors;
mod audience;
mod budget;
mod client;
mod control;
mod event;
mod fit;
mod guests;
mod pace;
mod performance;
mod question;
mod restart;
mod served;
mod session;
mod status;
mod work;

pub use actors::{Actors, point_of};
pub use audience::{Audience, Told};
pub use budget::{Budget, Budgets};
pub use event::{Event, Guest, Kind, Opened, Peer, Segment, Turn};
pub use fit::fit;
pub use pace::Pace;
pub use question::{Health, Question};
pub use restart::{Change, Task};
pub use served::{Next, ServedWorld, Settings};
pub use session::{Ended, Entrance, Inquiry, Session};
