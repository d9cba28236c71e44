//! Numbers of an array of microphones (AcousticArraySensor.uc).

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::reading::reading;

/// Numbers of an array of microphones.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Speed of sound, m/s.
    pub sound_speed: f64,
    /// Greatest distance at which a sound is heard, m.
    pub hear_threshold: f64,
}

impl Default for Config {
    /// Defaults of DefaultUSAR.ini:145-149.
    fn default() -> Self {
        Self { sound_speed: 343.0, hear_threshold: 4000.0 }
    }
}

impl Config {
    /// Checks speed and distance.
    pub(super) fn validate(&self) -> Result<(), &'static str> {
        let good = (1.0..=1e5).contains(&self.sound_speed) && (0.0..=1e5).contains(&self.hear_threshold);
        if good { Ok(()) } else { Err("a sound_speed of 1 to 100000 m/s and a hear_threshold of 0 to 100000 m") }
    }
}

reading! {
    /// Sounds since the last reading.
    {
        /// Six numbers for each sound: its direction in the sensor's frame with length 1 (0, 0, 0 for a sound that is too far), its loudness,
        /// its duration, and the time until it arrives.
        sounds: Arc<[f64]> = "1, dB, s",
    }
}
