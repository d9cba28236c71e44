//! Numbers of an odometry (Odometry.uc).

use serde::{Deserialize, Serialize};

/// How an odometry reckons.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Omni robots: follow the phases of the rollers. The textbook over-reports ways to the side by the 4.5 % that
    /// six rollers lose.
    pub finite_rollers: bool,
}
