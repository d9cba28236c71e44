//! Settings of an altitude sensor (AltitudeSensor.uc).

use serde::{Deserialize, Serialize};

use crate::reading::reading;

/// An altitude sensor has no settings of its own, and no noise.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {}

reading! {
    /// Height of a robot.
    {
        /// Height above the place of the spawn.
        relative: f64 = "m",
        /// Height above 111 m below that place, at least 0.
        absolute: f64 = "m",
    }
}
