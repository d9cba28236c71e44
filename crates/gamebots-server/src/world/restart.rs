//! Restarts of the world, by a reset or on another map. A thread makes the fresh world meanwhile.

use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};

use page_protocol::Actor;
use sim_core::World;

use crate::config::AvailableMap;

/// Least time between two restarts.
const INTERVAL: Duration = Duration::from_secs(1);
/// Least time between two restarts, as a multiple of the time that the world's thread took for the first one. So restarts take at most 4 %
/// of the time.
const REST: u32 = 25;

/// A request to restart.
pub(crate) struct Restart {
    pub(crate) map: Option<AvailableMap>,
    pub(crate) actor: Actor,
}

/// The restart that waits, and the one that is being made.
pub(crate) struct Restarts {
    /// The newest request; it replaces an older one.
    waiting: Option<Restart>,
    making: Option<(Restart, Receiver<Result<World, String>>)>,
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

    /// Begins the restart that waits, if it is time. Returns the one whose fresh world is ready, and that world; or an error.
    pub(crate) fn poll(&mut self, now: Instant, world: &World) -> Option<Result<(Restart, World), String>> {
        if self.making.is_none() && now >= self.next {
            let restart = self.waiting.take()?;
            match make(restart.map.clone(), world) {
                Ok(fresh) => self.making = Some((restart, fresh)),
                Err(error) => return Some(Err(error)),
            }
        }
        let made = self.making.as_ref()?.1.try_recv();
        if matches!(made, Err(TryRecvError::Empty)) {
            return None;
        }
        let (restart, _) = self.making.take()?;
        self.next = now + INTERVAL;
        let fresh = made.unwrap_or_else(|_| Err("not reset: the fresh world could not be made".to_owned()));
        Some(fresh.map(|fresh| (restart, fresh)))
    }

    /// Counts time that the world's thread took for the last restart.
    pub(crate) fn add_cost(&mut self, took: Duration) {
        self.next += REST * took;
    }
}

/// Starts to make a fresh world.
fn make(map: Option<AvailableMap>, world: &World) -> Result<Receiver<Result<World, String>>, String> {
    let (done, made) = channel();
    let (scene, options) = (world.scene().clone(), world.options());
    let run = move || {
        let fresh = match map {
            Some(AvailableMap { name, read, .. }) => match read() {
                Ok(map) => Ok(World::new(scene.on_map(map), options)),
                Err(reason) => Err(format!("not changed to the map {name}: {reason}")),
            },
            None => Ok(World::new(scene, options)),
        };
        // The server may have ended.
        let _ = done.send(fresh);
    };
    std::thread::Builder::new().name("restart".to_owned()).spawn(run).map_err(|error| format!("not reset: {error}"))?;
    Ok(made)
}
