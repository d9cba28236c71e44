//! Numbers of a touch sensor (Touch.uc).

use serde::{Deserialize, Serialize};

use crate::check::Range;
use crate::reading::reading;

/// Diameters of a face.
const DIAMETER: Range = Range { least: 1e-4, most: 1.0, unit: " m" };

/// Numbers of a touch sensor.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Diameter of its face, m.
    pub diameter: f64,
}

impl Default for Config {
    /// The default of DefaultUSAR.ini:217-219.
    fn default() -> Self {
        Self { diameter: 0.01 }
    }
}

impl Config {
    /// Checks the diameter.
    pub(super) fn validate(&self) -> Result<(), &'static str> {
        if DIAMETER.holds(self.diameter) { Ok(()) } else { Err("a diameter of 0.0001 to 1 m") }
    }
}

reading! {
    /// Contact of a touch sensor's face.
    {
        /// True if something is within its reach.
        touch: bool = "",
    }
}
