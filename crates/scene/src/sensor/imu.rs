//! Settings of an inertial measurement unit (IMU.uc).

use serde::{Deserialize, Serialize};

use crate::reading::reading;

/// An IMU has no settings of its own, and no noise.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {}

reading! {
    /// Acceleration and rotation of a sensor.
    {
        /// Acceleration without gravity along the sensor's x, its y and against its z.
        acceleration: [f64; 3] = "m/s²",
        /// Rates of roll, pitch and yaw.
        angular_velocity: [f64; 3] = "rad/s",
        /// Changes of these rates.
        angular_acceleration: [f64; 3] = "rad/s²",
        /// Roll, pitch, yaw.
        angles: [f64; 3] = "rad",
    }
}
