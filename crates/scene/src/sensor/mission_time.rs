//! Settings of a mission clock (MissionTime.uc).

use serde::{Deserialize, Serialize};

use crate::reading::reading;

/// A mission clock has no settings of its own.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {}

reading! {
    /// Time since a robot was spawned.
    {
        /// Whole minutes.
        minutes: f64 = "min",
    }
}
