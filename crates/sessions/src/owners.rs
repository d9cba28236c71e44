//! The connection that owns each robot, and the line that spawned it.

use std::collections::BTreeMap;

use sim_core::PawnId;

use crate::connection::ConnectionId;

/// Robots of connected clients, in the order in which they were spawned. Robots that the world has lost stay here: they come
/// back when it starts over.
#[derive(Default)]
pub(crate) struct Owners(BTreeMap<PawnId, Owned>);

struct Owned {
    by: ConnectionId,
    /// Its INIT line.
    init: String,
}

impl Owners {
    pub(crate) fn add(&mut self, robot: PawnId, by: ConnectionId, init: String) {
        self.0.insert(robot, Owned { by, init });
    }

    /// Returns the connection that a robot reports to.
    pub(crate) fn of(&self, robot: PawnId) -> Option<ConnectionId> {
        self.0.get(&robot).map(|owned| owned.by)
    }

    /// Returns a connection's newest robot, which gets its commands (BotConnection.uc:37-47).
    pub(crate) fn newest(&self, connection: ConnectionId) -> Option<PawnId> {
        self.0.iter().rfind(|(_, owned)| owned.by == connection).map(|(&robot, _)| robot)
    }

    /// Forgets a connection and returns its robots, the newest last.
    pub(crate) fn leave(&mut self, connection: ConnectionId) -> Vec<PawnId> {
        self.0.extract_if(.., |_, owned| owned.by == connection).map(|(robot, _)| robot).collect()
    }

    /// Forgets every robot and returns the lines that spawned them, in order.
    pub(crate) fn start_over(&mut self) -> Vec<(ConnectionId, String)> {
        std::mem::take(&mut self.0).into_values().map(|Owned { by, init }| (by, init)).collect()
    }
}
