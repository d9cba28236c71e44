//! Restarts and saves of a world: when each is due. Threads make fresh worlds and write files; see [`Task`].

use page_protocol::Actor;
use scene::Options;
use sim_core::{CompiledScene, SavedWorld};
use web_time::{Duration, Instant};

/// Least time between two restarts, and between two saves: each takes time of the world.
const INTERVAL: Duration = Duration::from_secs(1);
/// Least time between two restarts, as a multiple of the time that the world took for the first one. So restarts take at most 4 % of the
/// time.
const REST: u32 = 25;

/// Long work for another thread. Its outcome comes back as an event.
pub enum Task {
    /// Makes a fresh world, for [`crate::Event::Made`].
    Make {
        /// The scene.
        scene: CompiledScene,
        /// Seed and units.
        options: Options,
        /// Setting to change to, if any.
        change: Option<Change>,
    },
    /// Writes the state of a world, for [`crate::Event::Saved`].
    Save {
        /// The scene.
        scene: CompiledScene,
        /// The state.
        state: Box<SavedWorld>,
        /// Simulated time, s.
        time: f64,
    },
}

/// Setting of a fresh world in place of the old one's, by its name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Change {
    /// A map, on which nothing is played.
    Map(String),
    /// A scenario, with its map.
    Scenario(String),
}

/// A request to restart, with a change if one is asked for.
pub(crate) struct Restart {
    pub(crate) change: Option<Change>,
    pub(crate) actor: Actor,
}

/// The restart that waits, and the one whose world is being made.
pub(crate) struct Restarts {
    /// The newest request; it replaces an older one.
    waiting: Option<Restart>,
    making: Option<Restart>,
    /// Earliest time of the next restart.
    next: Instant,
}

impl Restarts {
    pub(crate) fn new(now: Instant) -> Self {
        Self { waiting: None, making: None, next: now }
    }

    /// Requests a restart.
    pub(crate) fn ask(&mut self, restart: Restart) {
        self.waiting = Some(restart);
    }

    /// Begins the restart that waits, if it is time. A fresh world has to be made for it.
    pub(crate) fn begin(&mut self, now: Instant) -> Option<&Restart> {
        if self.making.is_some() || now < self.next {
            return None;
        }
        self.making = Some(self.waiting.take()?);
        self.making.as_ref()
    }

    /// Ends the making of a fresh world. Returns the restart that it was for.
    pub(crate) fn made(&mut self, now: Instant) -> Option<Restart> {
        self.next = now + INTERVAL;
        self.making.take()
    }

    /// Counts time that the world took for the last restart.
    pub(crate) fn add_cost(&mut self, took: Duration) {
        self.next += REST * took;
    }
}

/// The save that waits, and the one that is being written.
#[derive(Default)]
pub(crate) struct Saving {
    /// True if somebody asked for a save that has not begun. Saves that wait become one.
    is_asked: bool,
    is_writing: bool,
    /// Time of the last save's start.
    started: Option<Instant>,
}

impl Saving {
    /// Requests a save.
    pub(crate) fn ask(&mut self) {
        self.is_asked = true;
    }

    /// Begins the save that waits, if it is time. Returns true if it does.
    pub(crate) fn begin(&mut self, now: Instant) -> bool {
        let has_rested = self.started.is_none_or(|started| now.duration_since(started) >= INTERVAL);
        let begins = self.is_asked && !self.is_writing && has_rested;
        if begins {
            *self = Self { is_asked: false, is_writing: true, started: Some(now) };
        }
        begins
    }

    /// Ends the save that was being written.
    pub(crate) fn end(&mut self) {
        self.is_writing = false;
    }
}
