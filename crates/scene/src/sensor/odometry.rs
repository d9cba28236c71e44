//! Settings of odometry (Odometry.uc).

use serde::{Deserialize, Serialize};

use crate::reading::reading;

/// Settings of odometry.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Omni robots: follow the phases of the rollers. The textbook formula over-reports sideways travel by the 4.5 % that six
    /// rollers lose.
    pub finite_rollers: bool,
    /// Skid robots: use the twist that balances the friction of the sliding wheels. USARSim assumes two wheels that roll without
    /// slip, which over-reports the turn of a P3AT on the spot 1.45 times.
    pub sliding: bool,
}

reading! {
    /// Pose of the robot by its wheels, in the frame in which it started.
    {
        /// Position ahead.
        x: f64 = "m",
        /// Position to the right.
        y: f64 = "m",
        /// Angle, clockwise positive, not wrapped.
        theta: f64 = "rad",
    }
}
