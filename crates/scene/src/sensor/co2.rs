//! Numbers of a sensor of CO2, a sensor of UT2004.

use serde::{Deserialize, Serialize};

use crate::reading::reading;

/// Numbers of a sensor of CO2.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Density far from every victim, 0 to 1.
    pub background: f64,
    /// Distance from a mouth at which the density has halved, m.
    pub half_distance: f64,
}

impl Default for Config {
    /// Clean air, and a plume of half a metre.
    fn default() -> Self {
        Self { background: 0.0, half_distance: 0.5 }
    }
}

impl Config {
    /// Checks density and distance.
    pub(super) fn validate(&self) -> Result<(), &'static str> {
        let good = (0.0..=1.0).contains(&self.background) && (0.001..=1000.0).contains(&self.half_distance);
        if good { Ok(()) } else { Err("a background of 0 to 1 and a half_distance of 0.001 to 1000 m") }
    }
}

reading! {
    /// Density of CO2.
    {
        /// Density, 0 to 1.
        density: f64 = "",
    }
}
