//! Long work of a served world, on threads of its own.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use scene::Options;
use served_world::{Change, Event, Task};
use sim_core::{CompiledScene, World};
use thread_pool::ThreadPool;

use crate::files::{is_kept, numbered};
use crate::maps::Maps;
use crate::scenarios::Scenarios;
use crate::world::saves;

/// Threads that make fresh worlds and write saves.
pub(crate) struct Tasks {
    offers: Offers,
    /// Threads of the fresh worlds' steps.
    pool: Arc<ThreadPool>,
    /// File of saves; it gets a number if the file exists.
    saved_as: PathBuf,
    running: Vec<Running>,
}

/// Maps and scenarios that a fresh world can have.
#[derive(Clone)]
pub(crate) struct Offers {
    pub(crate) maps: Maps,
    pub(crate) scenarios: Scenarios,
}

/// A thread that works.
struct Running {
    outcome: Receiver<Event>,
    /// Event of a thread that ends without an outcome.
    lost: fn() -> Event,
}

impl Tasks {
    pub(crate) fn new(offers: Offers, pool: Arc<ThreadPool>, saved_as: PathBuf) -> Self {
        Self { offers, pool, saved_as, running: Vec::new() }
    }

    /// Starts a thread for a task.
    pub(crate) fn start(&mut self, task: Task) {
        match task {
            Task::Make { scene, options, change } => {
                let (offers, pool) = (self.offers.clone(), self.pool.clone());
                let make = move || {
                    let fresh = make(scene, options, change, &offers);
                    Event::Made(fresh.map(|fresh| Box::new(fresh.on_threads(pool))))
                };
                self.run("restart", make, || {
                    Event::Made(Err("not reset: the fresh world could not be made".to_owned()))
                });
            }
            Task::Save { scene, state, time } => {
                let name = self.saved_as.clone();
                let save = move || {
                    let path = (1..).map(|number| numbered(&name, number)).find(|path| !is_kept(path));
                    let path = path.unwrap_or_default();
                    Event::Saved(match saves::write(&path, &scene, &state) {
                        Ok(()) => Ok(format!("saved the world at {time:.3} s to {}", path.display())),
                        Err(error) => Err(format!("not saved: {}: {error}", path.display())),
                    })
                };
                self.run("save", save, || Event::Saved(Err("not saved: the file was not finished".to_owned())));
            }
        }
    }

    fn run(&mut self, name: &str, work: impl FnOnce() -> Event + Send + 'static, lost: fn() -> Event) {
        let (done, outcome) = channel();
        // The server may have ended when the work is done. Without a thread the outcome is lost at once.
        let _ = std::thread::Builder::new().name(name.to_owned()).spawn(move || _ = done.send(work()));
        self.running.push(Running { outcome, lost });
    }

    /// Returns the outcome of a task that has ended since the last call.
    pub(crate) fn outcome(&mut self) -> Option<Event> {
        let mut outcome = None;
        self.running.retain(|Running { outcome: end, lost }| {
            if outcome.is_some() {
                return true;
            }
            outcome = match end.try_recv() {
                Ok(event) => Some(event),
                Err(TryRecvError::Disconnected) => Some(lost()),
                Err(TryRecvError::Empty) => None,
            };
            outcome.is_none()
        });
        outcome
    }
}

/// Makes a fresh world, with a change if one is asked for.
fn make(scene: CompiledScene, options: Options, change: Option<Change>, offers: &Offers) -> Result<World, String> {
    let scene = match change {
        None => scene,
        Some(Change::Map(name)) => scene.on(offers.maps.read(&name)?),
        Some(Change::Scenario(name)) => {
            let fresh = scene.on(offers.scenarios.read(&name)?);
            fresh.def().check().map_err(|problem| format!("the scenario {name} is not begun: {problem}"))?;
            fresh
        }
    };
    Ok(World::new(scene, options))
}
