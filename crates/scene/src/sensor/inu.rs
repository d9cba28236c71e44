//! Numbers of an inertial unit that reports angles, the oldest sensor of UT2004.

use serde::{Deserialize, Serialize};

use crate::reading::reading;

/// Numbers of an inertial unit: none.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Config {}

reading! {
    /// Attitude of the robot.
    {
        /// Roll, pitch, yaw.
        angles: [f64; 3] = "rad",
    }
}
