//! The log of a run: every line in and out, and where the robots are, in an MCAP file.
//!
//! Simulated time is log time. Messages are JSON with a schema each:
//!
//! | channel | content |
//! |---|---|
//! | `/wire/in`, `/wire/out` | [`WireLine`] |
//! | `/wire/closed` | [`WireLine`] of a connection that ended |
//! | `/robot/<id>/state` | [`RobotState`], 50 times a second |
//!
//! The metadata `run` holds the scene with every number in effect, seed and time step; `end` the digest of the world.
//!
//! For a live world writing happens on a thread of its own, so that a slow disk does not hold up the world; what is written reaches
//! the file at least once a second, so a killed process leaves a file that reads up to there.

mod reader;
mod replay;
mod writer;

pub use reader::{Entry, Log, ReadError, read};
pub use replay::{Replay, ReplayError, replay};
pub use writer::{LogWriter, RecordError, Recorder};

use serde::{Deserialize, Serialize};
use sim_core::{RobotId, World};

/// Seconds between two recorded states of the robots.
const STATE_INTERVAL: f64 = 0.02;
/// Name of the metadata that describes a run.
const RUN: &str = "run";
/// Name of the metadata that ends a log.
const END: &str = "end";

/// A line of a connection.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WireLine {
    /// Number of the connection, from 1.
    pub connection: u64,
    /// The text without its end.
    pub line: String,
}

/// State of a robot, in the world frame (x forward, y right, z down).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RobotState {
    /// Number of the robot.
    pub robot: u64,
    /// Its class.
    pub class: String,
    /// Its name from INIT.
    pub name: String,
    /// Position, m.
    pub position: [f64; 3],
    /// Orientation as a quaternion x, y, z, w.
    pub orientation: [f64; 4],
    /// Velocity, m/s, world axes.
    pub linear: [f64; 3],
    /// Angular velocity, rad/s, world axes.
    pub angular: [f64; 3],
    /// Angles of the driven wheels since the spawn, rad.
    pub wheel_angles: Vec<f64>,
    /// Their speeds, rad/s.
    pub wheel_speeds: Vec<f64>,
}

impl RobotState {
    /// The state of a robot (number, class, name) as the world gives it.
    fn of(world: &World, (id, class, name): (RobotId, &str, &str)) -> Option<Self> {
        let (body, wheels) = world.state(id)?;
        Some(Self {
            robot: id.0,
            class: class.to_owned(),
            name: name.to_owned(),
            position: body.pose.translation.vector.into(),
            orientation: body.pose.rotation.coords.into(),
            linear: body.linear.into(),
            angular: body.angular.into(),
            wheel_angles: wheels.iter().map(|wheel| wheel.angle).collect(),
            wheel_speeds: wheels.iter().map(|wheel| wheel.speed).collect(),
        })
    }
}

/// Says when the robots' states are to be recorded.
#[derive(Debug, Default)]
pub struct StateTimer {
    taken: u64,
}

impl StateTimer {
    /// The states of all robots, when another interval has passed; to be asked after every step.
    pub fn due(&mut self, world: &World) -> Vec<RobotState> {
        let passed = (world.time() / STATE_INTERVAL + 1e-6) as u64;
        if passed <= self.taken {
            return Vec::new();
        }
        self.taken = passed;
        world.robots().filter_map(|robot| RobotState::of(world, robot)).collect()
    }
}

/// How a world ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct End {
    /// Simulated time, s.
    pub time: f64,
    /// See [`sim_core::World::digest`].
    pub digest: u64,
    /// Records that did not get into the log.
    pub dropped: u64,
}

/// One thing to record.
#[derive(Debug, Clone, PartialEq)]
pub enum Record {
    /// A line that came.
    In(WireLine),
    /// A line that was sent.
    Out(WireLine),
    /// A connection that ended.
    Closed(WireLine),
    /// Where a robot is.
    State(RobotState),
}
