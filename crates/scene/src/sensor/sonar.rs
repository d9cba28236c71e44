//! Numbers of a sonar (SonarSensor.uc).

use serde::{Deserialize, Serialize};

use crate::reading::reading;

/// Numbers of a sonar.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Reading without an echo, m.
    pub max_range: f64,
    /// Smallest reading, m.
    pub min_range: f64,
    /// Opening angle of the whole cone, rad.
    pub beam_angle: f64,
    /// Largest angle between a beam and the surface's normal at which it echoes, rad.
    pub max_angle_of_incidence: f64,
    /// Beams of one cone.
    pub traces_per_cone: u32,
    /// Cones inside each other.
    pub number_of_cones: u32,
}

impl Default for Config {
    /// Defaults of DefaultUSAR.ini:163-171.
    fn default() -> Self {
        Self {
            max_range: 5.0,
            min_range: 0.1,
            beam_angle: 0.349,
            max_angle_of_incidence: 0.1745329252,
            traces_per_cone: 16,
            number_of_cones: 10,
        }
    }
}

impl Config {
    /// Checks that the cones have valid ranges, angles and ray counts.
    pub(super) fn validate(&self) -> Result<(), &'static str> {
        let good = 0.0 <= self.min_range
            && self.min_range < self.max_range
            && self.max_range <= 10_000.0
            && (0.0..=std::f64::consts::PI).contains(&self.beam_angle)
            && (0.0..=std::f64::consts::PI).contains(&self.max_angle_of_incidence)
            && self.number_of_cones <= 100
            && self.traces_per_cone <= 1000;
        if good { Ok(()) } else { Err("min_range < max_range, angles 0 to pi, at most 100 cones of 1000 traces") }
    }

    /// Returns the number of rays: one ahead, and those of the cones.
    pub(super) fn rays(&self) -> usize {
        (self.number_of_cones as usize).saturating_mul(self.traces_per_cone as usize).saturating_add(1)
    }
}

reading! {
    /// Distance to the nearest echo.
    {
        /// Distance.
        range: f64 = "m",
    }
}
