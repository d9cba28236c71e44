//! Numbers of a receiver of satellites (GPSSensor.uc).

use serde::{Deserialize, Serialize};

use crate::check::{LATITUDE, LONGITUDE};
use crate::reading::reading;

/// Numbers of a receiver of satellites.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Error with four satellites, m: three times the standard deviation on each axis.
    pub max_noise: f64,
    /// Error with twelve satellites, m.
    pub min_noise: f64,
    /// Latitude of the map's origin where the map has none, degrees to the north.
    pub latitude: f64,
    /// Its longitude, degrees to the east.
    pub longitude: f64,
}

impl Default for Config {
    /// The intended values of DefaultUSAR.ini:61-68, a section that the original does not find by its name.
    fn default() -> Self {
        Self { max_noise: 2.5, min_noise: 0.75, latitude: 39.0 + 8.0273 / 60.0, longitude: -77.0 - 12.998 / 60.0 }
    }
}

impl Config {
    /// Checks errors and angles.
    pub(super) fn validate(&self) -> Result<(), &'static str> {
        let good = 0.0 <= self.min_noise
            && self.min_noise <= self.max_noise
            && self.max_noise <= 1000.0
            && LATITUDE.holds(self.latitude)
            && LONGITUDE.holds(self.longitude);
        if good {
            Ok(())
        } else {
            Err("0 <= min_noise <= max_noise <= 1000 m, a latitude of -89 to 89 and a longitude of -180 to 180")
        }
    }
}

reading! {
    /// Place by satellites.
    {
        /// Latitude, to the north; 0 without a fix.
        latitude: f64 = "degree",
        /// Longitude, to the east; 0 without a fix.
        longitude: f64 = "degree",
        /// Satellites in view. Four or more are a fix.
        satellites: f64 = "",
    }
}
