//! Questions of guests to the world, and the state of the server in numbers.

use std::sync::Arc;

use page_protocol::{Actor, Control, Fit, Wanted};
use scene::Standings;
use tokio::sync::oneshot;

use crate::subscribers::actors::Actors;

/// A guest's request to the world's thread, and the way of its answer.
pub(crate) enum Question {
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
pub(crate) struct Health {
    /// Simulated time, s.
    pub(crate) simulated: f64,
    /// Simulated seconds per real second over the last half second.
    pub(crate) real_time_factor: f64,
    /// The factor that is asked for; 0 is as fast as possible.
    pub(crate) speed: f64,
    pub(crate) paused: bool,
    /// Steps since the server started, and the real time that they took, s.
    pub(crate) steps: u64,
    pub(crate) step_seconds: f64,
    /// Steps of this world whose contacts did not converge.
    pub(crate) unsettled_steps: u64,
    pub(crate) robots: usize,
    pub(crate) clients: usize,
    /// Periodic lines that were dropped because clients were too slow.
    pub(crate) dropped_lines: u64,
    /// Number of times that the world started over.
    pub(crate) resets: u64,
}
