//! Which connection each robot reports to, and the line that made it.

use std::collections::BTreeMap;

use sim_core::RobotId;

use crate::connection::ConnectionId;

/// The robots of those who are connected, in the order that they came; also those that the world has lost, which come back
/// when it begins anew.
#[derive(Default)]
pub(crate) struct Owners(BTreeMap<RobotId, Owned>);

struct Owned {
    by: ConnectionId,
    /// Its INIT.
    init: String,
}

impl Owners {
    pub(crate) fn add(&mut self, robot: RobotId, by: ConnectionId, init: String) {
        self.0.insert(robot, Owned { by, init });
    }

    /// The connection that a robot reports to.
    pub(crate) fn of(&self, robot: RobotId) -> Option<ConnectionId> {
        self.0.get(&robot).map(|owned| owned.by)
    }

    /// The newest robot of a connection, to which its commands go (BotConnection.uc:37-47).
    pub(crate) fn newest(&self, connection: ConnectionId) -> Option<RobotId> {
        self.0.iter().rfind(|(_, owned)| owned.by == connection).map(|(&robot, _)| robot)
    }

    /// Forgets a connection and gives back its robots, the newest last.
    pub(crate) fn leave(&mut self, connection: ConnectionId) -> Vec<RobotId> {
        self.0.extract_if(.., |_, owned| owned.by == connection).map(|(robot, _)| robot).collect()
    }

    /// Forgets every robot and gives back the lines that made them, in their order.
    pub(crate) fn start_over(&mut self) -> Vec<(ConnectionId, String)> {
        std::mem::take(&mut self.0).into_values().map(|Owned { by, init }| (by, init)).collect()
    }
}
