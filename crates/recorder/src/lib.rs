//! The log of a run: every line in and out, and where the robots are, in an MCAP file.
//!
//! Simulated time is log time. Messages are JSON with a schema each:
//!
//! | channel | content |
//! |---|---|
//! | `/wire/in`, `/wire/out` | [`WireLine`] |
//! | `/robot/<id>/state` | [`RobotState`], 50 times a second |
//!
//! Writing happens on a thread of its own, so that a slow disk does not hold up the world; what is written reaches
//! the file at least once a second, so a killed process leaves a file that reads up to there.

mod reader;
mod writer;

pub use reader::{Entry, ReadError, read};
pub use writer::{RecordError, Recorder};

use serde::{Deserialize, Serialize};
use sim_core::{BodyState, RobotId, WheelState};

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
    /// The state of a robot as the world gives it.
    pub fn new(id: RobotId, class: &str, name: &str, body: &BodyState, wheels: &[WheelState]) -> Self {
        Self {
            robot: id.0,
            class: class.to_owned(),
            name: name.to_owned(),
            position: body.pose.translation.vector.into(),
            orientation: body.pose.rotation.coords.into(),
            linear: body.linear.into(),
            angular: body.angular.into(),
            wheel_angles: wheels.iter().map(|wheel| wheel.angle).collect(),
            wheel_speeds: wheels.iter().map(|wheel| wheel.speed).collect(),
        }
    }
}

/// One thing to record.
#[derive(Debug, Clone, PartialEq)]
pub enum Record {
    /// A line that came.
    In(WireLine),
    /// A line that was sent.
    Out(WireLine),
    /// Where a robot is.
    State(RobotState),
}
