//! What the world knows of one connection: its robots, its outbox, its mistakes.

use std::sync::Arc;
use std::time::{Duration, Instant};

use gamebots_proto::Problem;
use gamebots_proto::message::{Message, Nfo};
use sim_core::{Controller, RobotId, World};
use tracing::warn;

use crate::connection::ConnectionId;
use crate::outbox::Outbox;

/// Problems of one connection that are logged in a second; the rest is counted.
const MAX_WARNINGS: u64 = 20;
/// Characters of a bad line that are logged.
const SHOWN_CHARS: usize = 200;

/// One connection.
pub(crate) struct Session {
    id: ConnectionId,
    /// Address of the client.
    peer: String,
    outbox: Arc<Outbox>,
    controller: Controller,
    /// The line that made each of its robots, by which they come back in a fresh world.
    inits: Vec<String>,
    lines: u64,
    dropped: u64,
    warnings: Budget,
    report_errors: bool,
}

impl Session {
    pub(crate) fn new(id: ConnectionId, peer: String, outbox: Arc<Outbox>, report_errors: bool) -> Self {
        let (controller, warnings) = (Controller::default(), Budget::default());
        Self { id, peer, outbox, controller, inits: Vec::new(), lines: 0, dropped: 0, warnings, report_errors }
    }

    /// Address of the client.
    pub(crate) fn peer(&self) -> &str {
        &self.peer
    }

    /// Lines that came so far.
    pub(crate) fn lines(&self) -> u64 {
        self.lines
    }

    /// Periodic lines that were dropped, as far as they have been reported.
    pub(crate) fn dropped(&self) -> u64 {
        self.dropped
    }

    pub(crate) fn robots(&self) -> &[RobotId] {
        self.controller.robots()
    }

    pub(crate) fn outbox(&self) -> &Outbox {
        &self.outbox
    }

    /// Handles one line and returns what it answers, and what was logged about it.
    pub(crate) fn handle(
        &mut self,
        line: Result<&str, Problem>,
        world: &mut World,
        now: Instant,
    ) -> (Vec<Message>, Vec<String>) {
        self.lines += 1;
        let mut warnings = Vec::new();
        let mut problems = Vec::new();
        let mut answers = Vec::new();
        let text = match line {
            Ok(text) => {
                answers = self.controller.execute(text, world, &mut problems);
                if self.controller.robots().len() > self.inits.len() {
                    self.inits.push(text.to_owned());
                }
                text
            }
            Err(problem) => {
                problems.push(problem);
                ""
            }
        };
        for problem in problems {
            warnings.extend(self.warn(text, &problem, now));
            if self.report_errors {
                answers.push(Message::Nfo(Nfo::Error(problem.to_string())));
            }
        }
        (answers, warnings)
    }

    /// Forgets its robots and gives back the lines that made them: their world is over.
    pub(crate) fn start_over(&mut self) -> Vec<(RobotId, String)> {
        let robots = self.controller.robots().to_vec();
        self.controller = Controller::default();
        robots.into_iter().zip(self.inits.drain(..)).collect()
    }

    /// Removes the newest robot, and lets the client have what still waits for it.
    pub(crate) fn end(self, world: &mut World) {
        self.controller.end(world);
        self.outbox.close();
    }

    /// Logs the periodic lines that were dropped since the last call.
    pub(crate) fn report_dropped(&mut self) {
        let dropped = self.outbox.take_dropped();
        self.dropped += dropped;
        if dropped > 0 {
            warn!(connection = self.id, dropped, "the client reads too slowly: its oldest sensor lines are dropped");
        }
    }

    /// What is said, if this second has room for it.
    fn warn(&mut self, text: &str, problem: &Problem, now: Instant) -> Option<String> {
        match self.warnings.spend(now) {
            Spent::Granted { suppressed: 0 } => {}
            Spent::Granted { suppressed } => {
                warn!(connection = self.id, suppressed, "further problems were not logged")
            }
            Spent::Refused => return None,
        }
        let shown: String = text.chars().take(SHOWN_CHARS).collect();
        warn!(connection = self.id, line = self.lines, text = shown, "{problem}");
        Some(format!("connection {}, line {}: {problem}: {shown}", self.id, self.lines))
    }
}

/// A number of warnings a second, so that a client cannot fill the disk.
#[derive(Default)]
struct Budget {
    second: Option<Instant>,
    spent: u64,
}

enum Spent {
    /// Go on; so many were refused in the second before.
    Granted {
        suppressed: u64,
    },
    Refused,
}

impl Budget {
    fn spend(&mut self, now: Instant) -> Spent {
        let fresh = self.second.is_none_or(|second| now.duration_since(second) >= Duration::from_secs(1));
        let mut suppressed = 0;
        if fresh {
            suppressed = self.spent.saturating_sub(MAX_WARNINGS);
            (self.second, self.spent) = (Some(now), 0);
        }
        self.spent += 1;
        if self.spent > MAX_WARNINGS { Spent::Refused } else { Spent::Granted { suppressed } }
    }
}
