//! Numbers of a ground truth sensor (GroundTruth.uc).

use serde::{Deserialize, Serialize};

use crate::reading::reading;

/// Numbers of a ground truth sensor.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// True: reports the pose of the robot's body. False: reports the pose of the sensor.
    pub fixed_to_platform: bool,
}

impl Default for Config {
    /// Default of DefaultUSAR.ini:70-72.
    fn default() -> Self {
        Self { fixed_to_platform: true }
    }
}

reading! {
    /// True pose of the robot or of the sensor, in the world.
    {
        /// Position.
        position: [f64; 3] = "m",
        /// Roll, pitch, yaw.
        angles: [f64; 3] = "rad",
    }
}
