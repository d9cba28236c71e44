//! Events for a served world, and who sends them.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::sync::Arc;

use gamebots_proto::Dialect;
use outbox::Outbox;
use sessions::{Answer, Request, SessionId};
use sim_core::World;
use tokio::sync::{OwnedSemaphorePermit, oneshot};

use crate::question::Question;

/// An event for a served world.
pub enum Event {
    /// A client opened a session.
    Opened(Opened),
    /// A client sent requests.
    Requests(SessionId, Segment),
    /// A client left.
    Closed(SessionId),
    /// Somebody who does not drive has a request.
    Ask(Guest, Question, Turn),
    /// A fresh world is ready, or could not be made for the reason.
    Made(Result<Box<World>, String>),
    /// A save has ended, as the words say.
    Saved(Result<String, String>),
    /// The server stops.
    Stop,
}

/// A new client.
pub struct Opened {
    /// Its session.
    pub id: SessionId,
    /// The client itself.
    pub peer: Peer,
    /// The dialect of all its lines; if none, robots decide.
    pub dialect: Option<Dialect>,
    /// Lines on their way to it; none for a program, which gets answers.
    pub outbox: Option<Arc<Outbox>>,
}

/// The other end of a session.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Peer {
    /// The address of a client.
    Address(SocketAddr),
    /// The name of a program in this process.
    Program(String),
}

impl Peer {
    /// Returns the host that log lines about it are counted for. Programs share the unspecified one.
    pub fn host(&self) -> IpAddr {
        match self {
            Self::Address(address) => address.ip(),
            Self::Program(_) => Ipv4Addr::UNSPECIFIED.into(),
        }
    }
}

impl std::fmt::Display for Peer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Address(address) => address.fmt(f),
            Self::Program(name) => f.write_str(name),
        }
    }
}

/// Requests that a client sent together. The world handles them before time goes on, if it can.
pub struct Segment {
    /// The requests.
    pub requests: Vec<Request>,
    /// The way of the answer to the last of them; none if lines answer them.
    pub answer: Option<oneshot::Sender<Answer>>,
    /// The client's turn.
    pub turn: Turn,
}

/// A permit that is held while a request waits for the world. Each sender has one, so at most one segment of a client waits. No
/// client can fill the queue for others.
pub type Turn = OwnedSemaphorePermit;

/// Kinds of guests, by the service that they use. Kinds share the world's time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Pages by their WebSocket.
    Page,
    /// Requests by HTTP.
    Http,
    /// Clients of Foxglove.
    Foxglove,
    /// Referees.
    Truth,
    /// Wireless simulators.
    Positions,
    /// Radios between robots.
    Radio,
    /// Nodes of ROS 2.
    Ros2,
}

/// A guest: its kind and its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Guest {
    /// Its kind.
    pub kind: Kind,
    /// Its number among all guests.
    pub number: u64,
}
