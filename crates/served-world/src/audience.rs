//! The listener of a served world, and what it hears.

use std::sync::Arc;

use page_protocol::Status;
use scene::Standings;
use sessions::News;
use sim_core::World;
use web_time::Instant;

use crate::actors::Actors;

/// Something that an audience is told.
#[derive(Debug)]
pub enum Told<'a> {
    /// News of the sessions.
    News(&'a News<'a>),
    /// A warning about the world, in words.
    Warning(&'a str),
    /// A warning for logs alone. Viewers see it in their status.
    Note(&'a str),
    /// The outcome of a request, in words, for viewers alone.
    Notice(&'a str),
    /// Every team's points when a log ends.
    Standings(&'a Standings),
    /// Every team's points at the end of the world.
    Result(&'a Standings),
    /// A change of the status: a client arrived, or the timing changed.
    Changed,
}

/// The listener of a served world: logs and viewers.
pub trait Audience {
    /// Takes the real time of what it hears from now on.
    fn set_now(&mut self, now: Instant);

    /// Hears of an event.
    fn hear(&mut self, world: &World, event: &Told);

    /// Hears of the end of a step.
    fn stepped(&mut self, world: &World);

    /// Publishes what is due by the clock; called every turn. `status` makes the present status.
    fn publish(&mut self, world: &World, status: &mut dyn FnMut() -> Status);

    /// Starts or ends a log.
    fn record(&mut self, world: &World, on: bool);

    /// Returns everything that has a pose in the world.
    fn actors(&mut self, world: &World) -> Arc<Actors> {
        Arc::new(Actors::of(world))
    }

    /// Checks if the world may start over now.
    ///
    /// # Errors
    /// The reason why not, in words.
    fn may_start_over(&self) -> Result<(), String>;

    /// Follows a fresh world that replaces the old one.
    fn start_over(&mut self, old: &World, new: &World);
}
