//! Settings of an inertial navigation sensor (INS.uc).

use serde::{Deserialize, Serialize};

use crate::reading::reading;

/// Settings of an inertial navigation sensor.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// True if increments have a bias, drawn once.
    pub drifting: bool,
    /// Linear biases are within ±0.5 / precision, angular ones within ±0.5 / precision².
    pub precision: f64,
    /// Standard deviation of the noise of one increment, as a fraction of it.
    pub sigma: f64,
}

impl Default for Config {
    /// Defaults of DefaultUSAR.ini:51-59. The sigma of that section has no effect; the one of Sensor.uc:18 counts.
    fn default() -> Self {
        Self { drifting: true, precision: 1000.0, sigma: 0.05 }
    }
}

impl Config {
    /// Checks that noise can be drawn from these numbers.
    pub(super) fn validate(&self) -> Result<(), &'static str> {
        let good = (1e-3..=1e9).contains(&self.precision) && (0.0..=10.0).contains(&self.sigma);
        if good { Ok(()) } else { Err("precision 0.001 to 1e9, sigma 0 to 10") }
    }
}

reading! {
    /// Pose of the robot by inertial navigation, in the world.
    {
        /// Estimated position.
        position: [f64; 3] = "m",
        /// Estimated roll, pitch, yaw, each in [0, 2 pi).
        angles: [f64; 3] = "rad",
    }
}
