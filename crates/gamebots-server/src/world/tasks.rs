//! Long work of a served world, on threads of its own.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use scene::Options;
use served_world::{Event, Task};
use sim_core::{CompiledScene, World};
use thread_pool::ThreadPool;

use crate::files::{is_kept, numbered};
use crate::maps::Maps;
use crate::world::saves;

/// Threads that make fresh worlds and write saves.
pub(crate) struct Tasks {
    /// Maps that a fresh world can have.
    maps: Maps,
    /// Threads of the fresh worlds' steps.
    pool: Arc<ThreadPool>,
    /// File of saves; it gets a number if the file exists.
    saved_as: PathBuf,
    running: Vec<Running>,
}

/// A thread that works.
struct Running {
    outcome: Receiver<Event>,
    /// Event of a thread that ends without an outcome.
    lost: fn() -> Event,
}

impl Tasks {
    pub(crate) fn new(maps: Maps, pool: Arc<ThreadPool>, saved_as: PathBuf) -> Self {
        Self { maps, pool, saved_as, running: Vec::new() }
    }

    /// Starts a thread for a task.
    pub(crate) fn start(&mut self, task: Task) {
        match task {
            Task::Make { scene, options, map } => {
                let (maps, pool) = (self.maps.clone(), self.pool.clone());
                let make = move || {
                    let fresh = make(scene, options, map, &maps);
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

/// Makes a fresh world, on another map if one is named.
fn make(scene: CompiledScene, options: Options, map: Option<String>, maps: &Maps) -> Result<World, String> {
    let Some(name) = map else { return Ok(World::new(scene, options)) };
    let map = maps.find(&name).ok_or_else(|| {
        let names: Vec<String> = maps.list().into_iter().map(|(name, _)| name).collect();
        format!("no map `{name}`: expected {}", names.join(", "))
    })?;
    let map = (map.read)().map_err(|reason| format!("not changed to the map {name}: {reason}"))?;
    Ok(World::new(scene.on_map(map), options))
}
