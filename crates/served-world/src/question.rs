//! Questions of guests to the world, and the state of the server in numbers.

use std::sync::Arc;

use page_protocol::{Actor, Control, Fit, Wanted};
use scene::Standings;
use sim_core::SolverEffort;
use tokio::sync::oneshot;

use crate::actors::Actors;

/// A guest's request to the world, and the way of its answer.
pub enum Question {
    /// Everything with a pose.
    Actors(oneshot::Sender<Arc<Actors>>),
    /// The number of walls between two points, m.
    Obstacles([[f64; 3]; 2], oneshot::Sender<usize>),
    /// The state of the server in numbers.
    Health(oneshot::Sender<Health>),
    /// Every team's points; none without a league.
    Standings(oneshot::Sender<Option<Standings>>),
    /// Room for a robot.
    Fit(Wanted, oneshot::Sender<Fit>),
    /// A change of the world, by a viewer.
    Control(Control, Actor),
}

/// The state of a server in numbers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Health {
    /// Simulated time, s.
    pub simulated: f64,
    /// Simulated seconds per real second over the last half second.
    pub real_time_factor: f64,
    /// The factor that is asked for; 0 is as fast as possible.
    pub speed: f64,
    /// True while time stands still.
    pub paused: bool,
    /// Steps since the server started.
    pub steps: u64,
    /// Real time that they took, s.
    pub step_seconds: f64,
    /// Effort of the contact solver in this world.
    pub solver: SolverEffort,
    /// Number of robots.
    pub robots: usize,
    /// Number of clients.
    pub clients: usize,
    /// Periodic lines that were dropped because clients were too slow.
    pub dropped_lines: u64,
    /// Number of times that the world started over.
    pub resets: u64,
}
