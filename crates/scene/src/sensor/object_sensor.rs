//! Numbers of a sensor that names the objects in view (ObjectSensor.uc).

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{MAX_BEAMS, ranges};
use crate::reading::{Texts, reading};

/// Numbers of a sensor of objects.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Greatest distance, m.
    pub max_range: f64,
    /// Angle of the fan of beams, rad.
    pub field_of_view: f64,
    /// Angle between two beams, rad.
    pub resolution: f64,
}

impl Default for Config {
    /// Defaults of DefaultUSAR.ini:114-124.
    fn default() -> Self {
        Self { max_range: 1000.0, field_of_view: 0.174, resolution: 0.017 }
    }
}

impl Config {
    /// Returns the number of beams.
    pub(super) fn rays(&self) -> usize {
        (self.field_of_view / self.resolution) as usize + 1
    }

    /// Checks range and angles.
    pub(super) fn validate(&self) -> Result<(), &'static str> {
        ranges(0.0, self.max_range)?;
        let good = (0.0..=std::f64::consts::TAU).contains(&self.field_of_view)
            && (1e-4..=7.0).contains(&self.resolution)
            && self.rays() <= MAX_BEAMS;
        if good {
            Ok(())
        } else {
            Err("a field of view of 0 to 2 pi, a resolution of 0.0001 to 7 rad, at most 10000 beams")
        }
    }
}

reading! {
    /// Objects in view, each by the beam that hits it first, from the right to the left.
    {
        /// Nine numbers for each object: its position in the world, its roll, pitch, yaw, and the point that the beam hits.
        objects: Arc<[f64]> = "m, rad, m",
        /// Names and materials of the objects, as text in numbers.
        names: Texts = "",
    }
}
