//! Settings of an acceleration sensor (Acceleration.uc).

use serde::{Deserialize, Serialize};

use crate::reading::reading;

/// An acceleration sensor has no settings of its own, and no noise.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {}

reading! {
    /// Acceleration of a sensor.
    {
        /// Acceleration without gravity along the axes of the sensor.
        acceleration: [f64; 3] = "m/s²",
    }
}
