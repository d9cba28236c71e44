//! Events for the world's thread, and who sends them.

use std::net::SocketAddr;
use std::sync::Arc;

use gamebots_proto::Dialect;
use outbox::Outbox;
use sessions::{Request, SessionId};
use tokio::sync::OwnedSemaphorePermit;

use crate::world::question::Question;

/// An event for the world's thread.
pub(crate) enum Event {
    /// A client connected.
    Opened(Opened),
    /// Lines of one segment, handed over together so that the world can handle them before time goes on.
    Requests(SessionId, Vec<Request>, Turn),
    /// A client disconnected.
    Closed(SessionId),
    /// A request of somebody who does not drive.
    Ask(Guest, Question, Turn),
    /// The server stops.
    Stop,
}

/// A new client.
pub(crate) struct Opened {
    pub(crate) id: SessionId,
    pub(crate) address: SocketAddr,
    /// The dialect of all its lines; if none, robots decide.
    pub(crate) dialect: Option<Dialect>,
    pub(crate) outbox: Arc<Outbox>,
}

/// A permit that is held while a request waits for the world. Each sender has one, so at most one segment of a client waits. No
/// client can fill the queue for others.
pub(crate) type Turn = OwnedSemaphorePermit;

/// Kinds of guests, by the service that they use. Kinds share the world's time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    Page,
    Http,
    Foxglove,
    Truth,
    Positions,
    Radio,
}

/// A guest: its kind and its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Guest {
    pub(crate) kind: Kind,
    pub(crate) number: u64,
}
