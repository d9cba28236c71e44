//! Numbers of a sensor of victims, a sensor of UT2004.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::ranges;
use crate::reading::reading;

/// Numbers of a sensor that sees persons.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Greatest distance, m.
    pub max_range: f64,
    /// Angle of view to the sides and up and down, rad.
    pub field_of_view: f64,
}

impl Default for Config {
    /// The view of a camera to 6 m.
    fn default() -> Self {
        Self { max_range: 6.0, field_of_view: 1.3963 }
    }
}

impl Config {
    /// Checks range and angle.
    pub(super) fn validate(&self) -> Result<(), &'static str> {
        ranges(0.0, self.max_range)?;
        if (0.0..=std::f64::consts::TAU).contains(&self.field_of_view) {
            Ok(())
        } else {
            Err("a field of view of 0 to 2 pi")
        }
    }
}

reading! {
    /// Parts of victims in view.
    {
        /// Four numbers for each part: its number (head, arm, hand, chest, pelvis, leg, foot) and its position in the frame of the sensor.
        parts: Arc<[f64]> = "1, m",
    }
}
