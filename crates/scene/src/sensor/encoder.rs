//! Settings of wheel encoders (Encoder.uc).

use std::f64::consts::TAU;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::reading::reading;

/// Settings of an encoder.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Angle of one tick, rad.
    pub resolution: f64,
    /// Half width of the uniform noise, as a fraction of the angle turned.
    pub noise: f64,
    /// Number of the driven wheel it reads, from 0. Without it: every wheel i for which the name contains `W<i>`, as in USARSim.
    pub wheel: Option<usize>,
    /// Name of the joint that it reads in place of a wheel. Of a joint that the robot does not have it counts nothing: UT2004's robots
    /// report encoders of a pan and tilt unit with and without one.
    pub joint: Option<String>,
}

impl Default for Config {
    /// Defaults of DefaultUSAR.ini:89-92.
    fn default() -> Self {
        Self { resolution: 0.01745, noise: 0.005, wheel: None, joint: None }
    }
}

impl Config {
    /// Checks that ticks can be counted with these numbers.
    pub(super) fn validate(&self) -> Result<(), &'static str> {
        let good = (1e-6..=TAU).contains(&self.resolution) && (0.0..1.0).contains(&self.noise);
        if good { Ok(()) } else { Err("resolution 1e-6 to 2 pi, noise 0 to less than 1") }
    }
}

reading! {
    /// Angles of wheels in units of the encoder's resolution.
    {
        /// Ticks of each wheel that the sensor reads, in order.
        ticks: Arc<[i32]> = "",
    }
}
