//! Ways into a served world: sessions of those who drive, and questions of those who do not.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};

use gamebots_proto::{Command, Dialect};
use outbox::Outbox;
use scene::PawnId;
use sessions::{Answer, Request, SessionId};
use tokio::sync::{Semaphore, oneshot};

use crate::event::{Event, Guest, Kind, Opened, Peer, Segment};
use crate::question::Question;

/// The way into a served world. Copies lead to the same one.
#[derive(Clone)]
pub struct Entrance {
    events: Sender<Event>,
    /// Numbers of sessions and of guests so far.
    sessions: Arc<AtomicU64>,
    guests: Arc<AtomicU64>,
}

/// The world has ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ended;

impl Entrance {
    /// Creates the way into a world that takes these events.
    pub fn new() -> (Self, Receiver<Event>) {
        // Unbounded: each sender waits for a turn, see `Turn`.
        let (events, receiver) = channel();
        (Self { events, sessions: Arc::default(), guests: Arc::default() }, receiver)
    }

    /// Returns the number of the next session.
    pub fn next_session(&self) -> SessionId {
        self.sessions.fetch_add(1, Ordering::Relaxed) + 1
    }

    /// Opens a session whose client gets lines, by the outbox. Without a dialect its robots decide.
    ///
    /// # Errors
    /// When the world has ended.
    pub fn open(
        &self,
        id: SessionId,
        address: SocketAddr,
        dialect: Option<Dialect>,
        outbox: Arc<Outbox>,
    ) -> Result<Session, Ended> {
        self.enter(Opened { id, peer: Peer::Address(address), dialect, outbox: Some(outbox) })
    }

    /// Opens a session of a program in this process. It gives commands and gets answers; nothing becomes text for it but in logs. Its
    /// robots leave with it.
    ///
    /// # Errors
    /// When the world has ended.
    pub fn open_program(&self, name: &str) -> Result<Session, Ended> {
        let peer = Peer::Program(name.to_owned());
        self.enter(Opened { id: self.next_session(), peer, dialect: None, outbox: None })
    }

    fn enter(&self, opened: Opened) -> Result<Session, Ended> {
        let id = opened.id;
        self.events.send(Event::Opened(opened)).map_err(|_| Ended)?;
        Ok(Session { id, events: self.events.clone(), turns: Arc::new(Semaphore::new(1)), is_open: true })
    }

    /// Returns the way of a new guest.
    pub fn guest(&self, kind: Kind) -> Inquiry {
        let guest = Guest { kind, number: self.guests.fetch_add(1, Ordering::Relaxed) };
        Inquiry { guest, events: self.events.clone(), turns: Arc::new(Semaphore::new(1)) }
    }

    /// Asks the world to end. It may have ended already.
    pub fn stop(&self) {
        let _ = self.events.send(Event::Stop);
    }
}

/// An open session of a served world. It closes on drop, and its robots leave.
pub struct Session {
    id: SessionId,
    events: Sender<Event>,
    turns: Arc<Semaphore>,
    is_open: bool,
}

impl Session {
    /// Returns its number.
    pub fn id(&self) -> SessionId {
        self.id
    }

    /// Sends requests that lines will answer. Waits until the world has executed those before.
    ///
    /// # Errors
    /// When the world has ended.
    pub async fn send(&self, requests: Vec<Request>) -> Result<(), Ended> {
        self.hand_over(requests, None).await
    }

    /// Gives a command, and waits for the answer.
    ///
    /// # Errors
    /// When the world has ended.
    pub async fn order(&self, command: Command) -> Result<Answer, Ended> {
        self.ask(Request::order(command)).await
    }

    /// Gives a command to a pawn, which may be another session's, and waits for the answer.
    ///
    /// # Errors
    /// When the world has ended.
    pub async fn order_to(&self, pawn: PawnId, command: Command) -> Result<Answer, Ended> {
        self.ask(Request::order(command).to(Some(pawn))).await
    }

    async fn ask(&self, request: Request) -> Result<Answer, Ended> {
        let (answer, answered) = oneshot::channel();
        self.hand_over(vec![request], Some(answer)).await?;
        answered.await.map_err(|_| Ended)
    }

    async fn hand_over(&self, requests: Vec<Request>, answer: Option<oneshot::Sender<Answer>>) -> Result<(), Ended> {
        let turn = self.turns.clone().acquire_owned().await.map_err(|_| Ended)?;
        self.events.send(Event::Requests(self.id, Segment { requests, answer, turn })).map_err(|_| Ended)
    }

    /// Closes the session. The world closes its outbox when all its requests are executed.
    ///
    /// # Errors
    /// When the world has ended.
    pub fn close(mut self) -> Result<(), Ended> {
        self.is_open = false;
        self.events.send(Event::Closed(self.id)).map_err(|_| Ended)
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        if self.is_open {
            // The world may have ended.
            let _ = self.events.send(Event::Closed(self.id));
        }
    }
}

/// The way of one guest to the world. It has one question at a time there.
#[derive(Clone)]
pub struct Inquiry {
    guest: Guest,
    events: Sender<Event>,
    turns: Arc<Semaphore>,
}

impl Inquiry {
    /// Asks the world. `None` if it has ended.
    pub async fn ask<T>(&self, question: impl FnOnce(oneshot::Sender<T>) -> Question) -> Option<T> {
        let (answer, answered) = oneshot::channel();
        self.send(question(answer)).await?;
        answered.await.ok()
    }

    /// Sends a request to the world. `None` if it has ended.
    pub async fn send(&self, question: Question) -> Option<()> {
        let turn = self.turns.clone().acquire_owned().await.ok()?;
        self.events.send(Event::Ask(self.guest, question, turn)).ok()
    }
}
