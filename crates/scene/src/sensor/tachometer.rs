//! Settings of a tachometer (Tachometer.uc).

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::reading::reading;

/// A tachometer has no settings of its own.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {}

reading! {
    /// Speed and angle of every driven wheel; empty without wheels, or right after a reset.
    {
        /// Mean speeds since the last reading.
        velocities: Arc<[f64]> = "rad/s",
        /// Angles turned since the last reset up to the reading before.
        positions: Arc<[f64]> = "rad",
    }
}
