//! The thread of the served world: its clock, its events, and its end.

use std::any::Any;
use std::panic::AssertUnwindSafe;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError};
use std::thread::JoinHandle;
use std::time::Instant;

use served_world::{Budgets, Event, Next, ServedWorld, Settings};
use sim_core::World;
use tokio::sync::oneshot;
use tracing::warn;

use crate::config::Config;
use crate::error::ServeError;
use crate::subscribers::live::Broadcast;
use crate::subscribers::log::Recording;
use crate::subscribers::publisher::Publisher;
use crate::subscribers::subscriber::Subscriber;
use crate::world::tasks::{Offers, Tasks};

/// Starts the thread. It ends on request, or when every sender of events is gone. `gone` is dropped when the thread ends, even
/// by a panic.
pub(crate) fn spawn(
    config: Config,
    world: World,
    budgets: Budgets,
    events: Receiver<Event>,
    live: Broadcast,
    others: Vec<Box<dyn Subscriber>>,
    gone: oneshot::Sender<()>,
) -> Result<JoinHandle<Result<(), ServeError>>, ServeError> {
    let Config { maps, scenarios, real_time_factor, report_errors, log, ros2_log, unnamed_log, threads, .. } = config;
    let pool = Arc::new(threads.clone());
    let world = world.on_threads(pool.clone());
    let settings = Settings { real_time_factor, report_errors, budgets };
    let mut tasks = Tasks::new(Offers { maps, scenarios }, pool, unnamed_log.with_extension("json"));
    let mut recording = Recording::new(world.options(), real_time_factor, ros2_log, unnamed_log);
    if let Some(path) = log {
        recording.start(&path, &world)?;
        if let Some(numbered) = recording.path().filter(|it| *it != path) {
            warn!("{} exists and is kept: recording to {}", path.display(), numbered.display());
        }
    }
    let thread = std::thread::Builder::new().name("world".to_owned());
    let run = move || {
        let _gone = gone;
        let publisher = Publisher::new(recording, live, others, Instant::now());
        let mut served = ServedWorld::new(world, settings, publisher, Box::new(Instant::now));
        // After a panic the world is only read.
        let result = std::panic::catch_unwind(AssertUnwindSafe(|| serve(&mut served, &events, &mut tasks)));
        end(served, result.err())
    };
    thread.spawn(move || threads.run(run)).map_err(ServeError::Start)
}

/// Turns the loop of a world until it is to end.
fn serve(served: &mut ServedWorld<Publisher>, events: &Receiver<Event>, tasks: &mut Tasks) {
    let mut first = None;
    loop {
        let waiting = || match events.try_recv() {
            Ok(event) => Some(event),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Event::Stop),
        };
        let outcome = tasks.outcome();
        let mut events_of_turn = first.take().into_iter().chain(outcome).chain(std::iter::from_fn(waiting));
        let Some(Next { wake, tasks: due }) = served.turn(&mut events_of_turn) else { return };
        due.into_iter().for_each(|task| tasks.start(task));
        let wait = wake.saturating_duration_since(Instant::now());
        if !wait.is_zero() {
            first = match events.recv_timeout(wait) {
                Ok(event) => Some(event),
                Err(RecvTimeoutError::Timeout) => None,
                Err(RecvTimeoutError::Disconnected) => return,
            };
        }
    }
}

/// Ends logs and connections. After a panic, also writes a report of it.
fn end(served: ServedWorld<Publisher>, panic: Option<Box<dyn Any + Send>>) -> Result<(), ServeError> {
    let (publisher, world) = served.end();
    let Some(panic) = panic else {
        publisher.end(&world, None);
        return Ok(());
    };
    let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
    let reason = text.unwrap_or("without a message").to_owned();
    let report = match publisher.end(&world, Some(&reason)) {
        Some(Ok(path)) => format!("`usarsim log replay {}` reproduces it", path.display()),
        Some(Err(error)) => format!("no report could be written: {error}"),
        None => "no journal was kept".to_owned(),
    };
    Err(ServeError::WorldPanicked { time: world.time(), reason, report })
}
