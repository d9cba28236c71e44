//! Numbers of an infrared sensor (IRSensor.uc).

use serde::{Deserialize, Serialize};

use super::ranges;
use crate::reading::reading;

/// Numbers of an infrared sensor.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Largest reading, m.
    pub max_range: f64,
    /// Smallest reading, m.
    pub min_range: f64,
}

impl Default for Config {
    /// Defaults of DefaultUSAR.ini:198-201.
    fn default() -> Self {
        Self { max_range: 1.5, min_range: 0.2 }
    }
}

impl Config {
    /// Checks the ranges.
    pub(super) fn validate(&self) -> Result<(), &'static str> {
        ranges(self.min_range, self.max_range)
    }
}

reading! {
    /// Distance to the first surface that stops infrared light.
    {
        /// Distance.
        range: f64 = "m",
    }
}
