//! Numbers of a line laser (LineLaser.uc).

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::ranges;
use crate::reading::reading;

/// Numbers of a line laser.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Distance of a point without a hit, m.
    pub max_range: f64,
    /// Smallest range, m; reported, not applied.
    pub min_range: f64,
    /// Angle of the fan of light, rad.
    pub field_of_view: f64,
    /// Number of beams. The last one, at the right end, is left out, as in the original.
    pub beams: u32,
}

impl Default for Config {
    /// Defaults of DefaultUSAR.ini:173-182.
    fn default() -> Self {
        Self { max_range: 5.0, min_range: 0.1, field_of_view: 1.570796, beams: 120 }
    }
}

impl Config {
    /// Checks ranges, angle and number of beams.
    pub(super) fn validate(&self) -> Result<(), &'static str> {
        ranges(self.min_range, self.max_range)?;
        let good = (0.0..=std::f64::consts::PI).contains(&self.field_of_view) && (2..=2000).contains(&self.beams);
        if good { Ok(()) } else { Err("a field of view of 0 to pi, and 2 to 2000 beams") }
    }
}

reading! {
    /// Points of a line of light in the world.
    {
        /// Position of the sensor.
        position: [f64; 3] = "m",
        /// Roll, pitch, yaw of the sensor.
        angles: [f64; 3] = "rad",
        /// x, y, z of each point, from the left to the right.
        points: Arc<[f64]> = "m",
    }
}
