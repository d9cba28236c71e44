//! Settings of a magnetic compass (MagneticCompass.uc).

use serde::{Deserialize, Serialize};

use crate::reading::reading;

/// A compass has no settings of its own, and no noise.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {}

reading! {
    /// Direction of a sensor.
    {
        /// Angle from the sensor's x axis to north, which is the x axis of the map, clockwise as seen from above, in [-pi, pi].
        angle: f64 = "rad",
    }
}
