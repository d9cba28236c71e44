//! The session that owns each pawn, and the line that spawned it.

use std::collections::BTreeMap;

use scene::PawnId;

use crate::SessionId;

/// Pawns of open sessions, in the order in which they were spawned. Robots that the world has lost stay here: they come back when it
/// starts over.
#[derive(Clone, Default)]
pub(super) struct Owners(BTreeMap<PawnId, Owned>);

#[derive(Clone)]
struct Owned {
    by: SessionId,
    /// Its INIT line.
    init: String,
}

impl Owners {
    pub(super) fn add(&mut self, pawn: PawnId, by: SessionId, init: String) {
        self.0.insert(pawn, Owned { by, init });
    }

    /// Returns the session that a pawn reports to.
    pub(super) fn of(&self, pawn: PawnId) -> Option<SessionId> {
        self.0.get(&pawn).map(|owned| owned.by)
    }

    /// Returns a session's newest pawn, which gets its commands (BotConnection.uc:37-47).
    pub(super) fn newest(&self, session: SessionId) -> Option<PawnId> {
        self.0.iter().rfind(|(_, owned)| owned.by == session).map(|(&pawn, _)| pawn)
    }

    /// Forgets a pawn.
    pub(super) fn remove(&mut self, pawn: PawnId) {
        self.0.remove(&pawn);
    }

    /// Forgets a session and returns its pawns, the newest last.
    pub(super) fn leave(&mut self, session: SessionId) -> Vec<PawnId> {
        self.0.extract_if(.., |_, owned| owned.by == session).map(|(pawn, _)| pawn).collect()
    }

    /// Forgets every pawn and returns the lines that spawned them, in order.
    pub(super) fn start_over(&mut self) -> Vec<(SessionId, String)> {
        std::mem::take(&mut self.0).into_values().map(|Owned { by, init }| (by, init)).collect()
    }
}
