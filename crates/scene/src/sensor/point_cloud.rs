//! Numbers of a rotating scanner and of a grid of sonars, which return points (RotatingPointCloudScanner.uc, ExampleSonarArray.uc).

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::ranges;
use crate::reading::reading;

/// Numbers of a scanner whose fan of beams nods.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Rotating {
    /// Distance of a point without a hit, m.
    pub max_range: f64,
    /// Beams of the fan.
    pub beams: u32,
    /// Angle of the fan, rad.
    pub horizontal_field_of_view: f64,
    /// Angle by which the fan nods, rad.
    pub vertical_field_of_view: f64,
    /// Time from the lowest to the highest position, s. Then it jumps back.
    pub spin_time: f64,
}

impl Default for Rotating {
    /// Defaults of DefaultUSAR.ini:129-135.
    fn default() -> Self {
        Self {
            max_range: 40.0,
            beams: 256,
            horizontal_field_of_view: 2.094395,
            vertical_field_of_view: 0.785398,
            spin_time: 1.0,
        }
    }
}

/// Numbers of a grid of parallel sonars.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Grid {
    /// Distance of a point without an echo, m.
    pub max_range: f64,
    /// Sonars along each edge of the grid.
    pub size: u32,
    /// Distance of two neighbours, m.
    pub spacing: f64,
}

impl Default for Grid {
    /// Defaults of DefaultUSAR.ini:184-188.
    fn default() -> Self {
        Self { max_range: 40.0, size: 30, spacing: 0.05 }
    }
}

impl Rotating {
    /// Checks range, angles, time and number of beams.
    pub(super) fn validate(&self) -> Result<(), &'static str> {
        ranges(0.0, self.max_range)?;
        let good = (2..=2000).contains(&self.beams)
            && (0.0..=std::f64::consts::TAU).contains(&self.horizontal_field_of_view)
            && (0.0..=std::f64::consts::PI).contains(&self.vertical_field_of_view)
            && (0.01..=3600.0).contains(&self.spin_time);
        if good {
            Ok(())
        } else {
            Err("2 to 2000 beams, fields of view of 0 to 2 pi and 0 to pi, a spin time of 0.01 to 3600 s")
        }
    }
}

impl Grid {
    /// Checks range, size and spacing.
    pub(super) fn validate(&self) -> Result<(), &'static str> {
        ranges(0.0, self.max_range)?;
        let good = (1..=60).contains(&self.size) && (0.0..=10.0).contains(&self.spacing);
        if good { Ok(()) } else { Err("a size of 1 to 60 and a spacing of 0 to 10 m") }
    }
}

reading! {
    /// Points in the frame of the sensor.
    {
        /// x, y, z of each point.
        points: Arc<[f64]> = "m",
    }
}
