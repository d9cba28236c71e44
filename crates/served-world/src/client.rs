//! One client of a served world: its requests, its outbox, its mistakes.

use std::collections::VecDeque;
use std::sync::Arc;

use gamebots_proto::{Command, Problem};
use outbox::Outbox;
use sessions::{Answer, Mistakes, Request, SessionId};
use tokio::sync::oneshot;
use tracing::warn;
use web_time::{Duration, Instant};

use crate::budget::Budgets;
use crate::event::{Opened, Peer, Turn};

/// One client.
pub(crate) struct Client {
    id: SessionId,
    peer: Peer,
    /// Lines on their way to it; none for a program.
    outbox: Option<Arc<Outbox>>,
    dropped: u64,
    /// Limits of what is logged.
    budgets: Budgets,
    mistakes: Mistakes,
    /// Requests that are not executed yet. The turn is given back after the last one.
    requests: std::vec::IntoIter<Request>,
    turn: Option<Turn>,
    /// Way of the answer to the last of these requests.
    answer: Option<oneshot::Sender<Answer>>,
    /// INIT lines that put its robots back after a restart.
    put_back: VecDeque<Request>,
    /// The client has left.
    is_closed: bool,
    /// Recent cost of its requests.
    cost: Duration,
}

impl Client {
    pub(crate) fn new(opened: Opened, budgets: Budgets) -> Self {
        let Opened { id, peer, outbox, .. } = opened;
        Self {
            id,
            peer,
            outbox,
            dropped: 0,
            budgets,
            mistakes: Mistakes::new(id),
            requests: Vec::new().into_iter(),
            turn: None,
            answer: None,
            put_back: VecDeque::new(),
            is_closed: false,
            cost: Duration::ZERO,
        }
    }

    /// Takes a segment's requests. The client's turn is held, so no earlier requests are waiting.
    pub(crate) fn take(&mut self, requests: Vec<Request>, answer: Option<oneshot::Sender<Answer>>, turn: Turn) {
        (self.requests, self.answer, self.turn) = (requests.into_iter(), answer, Some(turn));
    }

    /// Returns the next request to execute, and the way of its answer if somebody waits for it; none while the outbox is full because the
    /// client does not read.
    pub(crate) fn next_request(&mut self) -> Option<(Request, Option<oneshot::Sender<Answer>>)> {
        let next = if self.has_room() { self.requests.next() } else { None };
        let mut answer = None;
        if self.requests.len() == 0 {
            (answer, self.turn) = (self.answer.take(), None);
        }
        next.map(|request| (request, answer))
    }

    /// True if more answers may wait for it.
    fn has_room(&self) -> bool {
        self.outbox.as_ref().is_none_or(|outbox| outbox.has_room())
    }

    /// Adds an INIT line that puts one of its robots back.
    pub(crate) fn put_back(&mut self, init: Request) {
        self.put_back.push_back(init);
    }

    /// Returns the next INIT line that puts a robot back. It goes before all requests, which are for that robot.
    pub(crate) fn next_put_back(&mut self) -> Option<Request> {
        self.put_back.pop_front()
    }

    /// True if a request can be executed now.
    pub(crate) fn is_ready(&self) -> bool {
        !self.put_back.is_empty() || self.requests.len() > 0 && self.has_room()
    }

    /// True if the next request spawns a robot.
    pub(crate) fn is_next_init(&self) -> bool {
        matches!(self.requests.as_slice(), [Request { command: Some(Command::Init(_)), .. }, ..])
    }

    /// Notes that the client has left. It is gone when all its requests are executed. Its robots are not put back.
    pub(crate) fn close(&mut self) {
        self.put_back.clear();
        self.is_closed = true;
    }

    /// True if the client has left and all its requests are executed.
    pub(crate) fn is_over(&self) -> bool {
        self.is_closed && self.requests.len() == 0
    }

    /// Returns the recent cost of its requests.
    pub(crate) fn cost(&self) -> Duration {
        self.cost
    }

    pub(crate) fn add_cost(&mut self, cost: Duration) {
        self.cost += cost;
    }

    pub(crate) fn forget_half(&mut self) {
        self.cost /= 2;
    }

    /// Returns the client's address or name.
    pub(crate) fn peer(&self) -> String {
        self.peer.to_string()
    }

    /// Returns the number of lines received so far.
    pub(crate) fn lines(&self) -> u64 {
        self.mistakes.lines()
    }

    /// Returns the number of dropped periodic lines, as of the last report.
    pub(crate) fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Adds a line to its outbox.
    pub(crate) fn push(&self, line: String, is_periodic: bool) {
        if let Some(outbox) = &self.outbox {
            outbox.push(line, is_periodic);
        }
    }

    /// Selects if its lines leave one by one or together.
    pub(crate) fn set_paced(&self, is_paced: bool) {
        self.outbox.iter().for_each(|outbox| outbox.set_paced(is_paced));
    }

    /// Closes its outbox. Lines in it are still sent.
    pub(crate) fn close_outbox(&self) {
        self.outbox.iter().for_each(|outbox| outbox.close());
    }

    /// Returns the number of bytes that it has not been sent yet.
    pub(crate) fn waiting_bytes(&self) -> usize {
        self.outbox.as_ref().map_or(0, |outbox| outbox.waiting_bytes())
    }

    /// Counts a line.
    pub(crate) fn note_line(&mut self) {
        self.mistakes.count_line();
    }

    /// Logs the problems of a line. Returns the logged warnings.
    pub(crate) fn warn_of(&mut self, text: &str, problems: &[Problem], now: Instant) -> Vec<String> {
        problems.iter().filter_map(|problem| self.warn(text, problem, now)).collect()
    }

    /// Logs and returns what recurred since the last call: repetitions of logged problems, and dropped periodic lines.
    pub(crate) fn report(&mut self, now: Instant) -> Vec<String> {
        let dropped = self.outbox.as_ref().map_or(0, |outbox| outbox.take_dropped());
        self.dropped += dropped;
        if dropped > 0 && self.budgets.allow(self.peer.host(), now) {
            warn!(connection = self.id, dropped, "the client reads too slowly: its oldest sensor lines are dropped");
        }
        let Self { budgets, peer, mistakes, .. } = self;
        let repeated: Vec<String> = mistakes.repetitions().take_while(|_| budgets.allow(peer.host(), now)).collect();
        repeated.iter().for_each(|text| warn!("{text}"));
        repeated
    }

    /// Logs a problem and returns the text, unless it is a repetition or the budget of this second is spent.
    fn warn(&mut self, text: &str, problem: &Problem, now: Instant) -> Option<String> {
        let warning = self.mistakes.warning(text, problem)?;
        self.budgets.allow(self.peer.host(), now).then(|| {
            warn!("{warning}");
            warning
        })
    }
}
