//! One connection as the world's thread sees it: what it has sent, its outbox, its mistakes.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use gamebots_proto::message::{Message, Nfo};
use gamebots_proto::{Command, Dialect, Problem};
use outbox::Outbox;
use tracing::warn;

use crate::connection::{ConnectionId, Opened, Request, Turn};

/// Problems of one connection that are logged in a second; the rest is counted.
const MAX_WARNINGS: u64 = 20;
/// Different problems of one connection whose repetitions are counted; of others each is logged.
const MAX_COUNTED: usize = 50;
/// Characters of a bad line that are logged.
const SHOWN_CHARS: usize = 200;

/// One connection.
pub(crate) struct Session {
    id: ConnectionId,
    /// Address of the client.
    peer: String,
    /// The dialect of all its lines; without one, robots decide.
    dialect: Option<Dialect>,
    outbox: Arc<Outbox>,
    lines: u64,
    dropped: u64,
    warnings: Budget,
    /// Problems that were logged since the last report or before it, with how often they came again since.
    repeated: BTreeMap<String, u64>,
    /// Whether problems go back to the client: by the server's own option, or because the client asked for it.
    report_errors: bool,
    /// What it has sent and is not executed yet; the turn is given back with the last request.
    requests: std::vec::IntoIter<Request>,
    turn: Option<Turn>,
    /// The client has left.
    is_closed: bool,
    /// What its requests have cost of late.
    cost: Duration,
}

impl Session {
    pub(crate) fn new(opened: Opened, report_errors: bool) -> Self {
        let Opened { id, peer, dialect, outbox } = opened;
        Self {
            id,
            peer,
            dialect,
            outbox,
            lines: 0,
            dropped: 0,
            warnings: Budget::default(),
            repeated: BTreeMap::new(),
            report_errors,
            requests: Vec::new().into_iter(),
            turn: None,
            is_closed: false,
            cost: Duration::ZERO,
        }
    }

    /// Takes what the client has sent. Its turn is held, so nothing of it waits already.
    pub(crate) fn take(&mut self, requests: Vec<Request>, turn: Turn) {
        (self.requests, self.turn) = (requests.into_iter(), Some(turn));
    }

    /// The next request to be executed; none while the client does not take the answers that it has already.
    pub(crate) fn next_request(&mut self) -> Option<Request> {
        let next = if self.outbox.has_room() { self.requests.next() } else { None };
        if self.requests.len() == 0 {
            self.turn = None;
        }
        next
    }

    /// Whether there is a request that can be executed now.
    pub(crate) fn is_ready(&self) -> bool {
        self.requests.len() > 0 && self.outbox.has_room()
    }

    /// Whether the next request makes a robot.
    pub(crate) fn is_next_init(&self) -> bool {
        matches!(self.requests.as_slice(), [Request { command: Some(Command::Init(_)), .. }, ..])
    }

    /// The client has left; it is over when all that it had sent is executed.
    pub(crate) fn close(&mut self) {
        self.is_closed = true;
    }

    /// Whether nothing more comes of it.
    pub(crate) fn is_over(&self) -> bool {
        self.is_closed && self.requests.len() == 0
    }

    /// What its requests have cost of late.
    pub(crate) fn cost(&self) -> Duration {
        self.cost
    }

    pub(crate) fn add_cost(&mut self, cost: Duration) {
        self.cost += cost;
    }

    pub(crate) fn forget_half(&mut self) {
        self.cost /= 2;
    }

    /// The dialect of all its lines; without one, robots decide.
    pub(crate) fn dialect(&self) -> Option<Dialect> {
        self.dialect
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

    /// True if the client is told what goes wrong.
    pub(crate) fn reports_errors(&self) -> bool {
        self.report_errors
    }

    pub(crate) fn outbox(&self) -> &Outbox {
        &self.outbox
    }

    /// Counts a line, and heeds what it says about the connection itself.
    pub(crate) fn note(&mut self, command: Option<&Command>) {
        self.lines += 1;
        if let Some(Command::Report(report)) = command {
            self.report_errors = report.errors;
        }
    }

    /// Logs what was wrong with a line; returns what the client is told of it, and what was logged.
    pub(crate) fn refuse(&mut self, text: &str, problems: &[Problem], now: Instant) -> (Vec<Message>, Vec<String>) {
        let warnings = problems.iter().filter_map(|problem| self.warn(text, problem, now)).collect();
        let answer = |problem: &Problem| Message::Nfo(Nfo::Error(problem.to_string()));
        let answers = if self.report_errors { problems.iter().map(answer).collect() } else { Vec::new() };
        (answers, warnings)
    }

    /// Logs, and returns, what has happened again and again since the last call: problems that were logged before, and periodic
    /// lines that were dropped.
    pub(crate) fn report(&mut self) -> Vec<String> {
        let dropped = self.outbox.take_dropped();
        self.dropped += dropped;
        if dropped > 0 {
            warn!(connection = self.id, dropped, "the client reads too slowly: its oldest sensor lines are dropped");
        }
        // One that did not come again is logged in full when it does.
        self.repeated.retain(|_, times| *times > 0);
        let again = self.repeated.iter_mut().map(|(problem, times)| (problem, std::mem::take(times)));
        let more = |times| names::count(usize::try_from(times).unwrap_or(usize::MAX), "time");
        let text = |(problem, times)| format!("connection {}: {problem} ({} more)", self.id, more(times));
        let said: Vec<String> = again.map(text).collect();
        said.iter().for_each(|text| warn!("{text}"));
        said
    }

    /// What is said, if it was not said before and this second has room for it.
    fn warn(&mut self, text: &str, problem: &Problem, now: Instant) -> Option<String> {
        let shown = problem.to_string();
        if let Some(times) = self.repeated.get_mut(&shown) {
            *times += 1;
            return None;
        }
        if self.repeated.len() < MAX_COUNTED {
            self.repeated.insert(shown, 0);
        }
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
pub(crate) struct Budget {
    second: Option<Instant>,
    spent: u64,
}

/// Whether the present second has room for another warning.
pub(crate) enum Spent {
    /// Go on; so many were refused in the second before.
    Granted {
        suppressed: u64,
    },
    Refused,
}

impl Budget {
    pub(crate) fn spend(&mut self, now: Instant) -> Spent {
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
