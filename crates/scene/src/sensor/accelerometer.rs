//! Settings of an accelerometer (AcceleroMeter.uc).

use serde::{Deserialize, Serialize};

use crate::reading::reading;

/// An accelerometer has no settings of its own, and no noise.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {}

reading! {
    /// Acceleration of a sensor with gravity.
    {
        /// Acceleration plus gravity along the axes of the sensor: at rest and level 9.81 along z, which is down.
        acceleration: [f64; 3] = "m/s²",
    }
}
