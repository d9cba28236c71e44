//! The way of a guest to the world.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::Sender;

use tokio::sync::{Semaphore, oneshot};

use crate::world::event::{Event, Guest, Kind};
use crate::world::question::Question;

/// The way of one guest to the world. It has one question at a time there.
#[derive(Clone)]
pub(crate) struct Inquiry {
    guest: Guest,
    events: Sender<Event>,
    turns: Arc<Semaphore>,
}

impl Inquiry {
    pub(crate) fn new(kind: Kind, events: Sender<Event>) -> Self {
        /// Number of the next guest.
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let guest = Guest { kind, number: NEXT.fetch_add(1, Ordering::Relaxed) };
        Self { guest, events, turns: Arc::new(Semaphore::new(1)) }
    }

    /// Asks the world. `None` if it has ended.
    pub(crate) async fn ask<T>(&self, question: impl FnOnce(oneshot::Sender<T>) -> Question) -> Option<T> {
        let (answer, answered) = oneshot::channel();
        self.send(question(answer)).await?;
        answered.await.ok()
    }

    /// Sends a request to the world. `None` if it has ended.
    pub(crate) async fn send(&self, question: Question) -> Option<()> {
        let turn = self.turns.clone().acquire_owned().await.ok()?;
        self.events.send(Event::Ask(self.guest, question, turn)).ok()
    }
}
