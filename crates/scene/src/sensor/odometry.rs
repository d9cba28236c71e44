//! Numbers of an odometry (Odometry.uc).

use serde::{Deserialize, Serialize};

/// How an odometry reckons.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Omni robots: follow the phases of the rollers. The textbook over-reports ways to the side by the 4.5 % that
    /// six rollers lose.
    pub finite_rollers: bool,
    /// Skid robots: the twist at which the friction of their wheels balances, in the place of USARSim's two wheels that roll without
    /// slip, which say 1.45 times as much of a P3AT that turns on the spot.
    pub sliding: bool,
}
