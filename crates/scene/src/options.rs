//! Run options of a world.

/// Default length of a step, s: 500 Hz, where free rollers are within 0.3 % of their exact kinematics.
pub const TIME_STEP: f64 = 0.002;

/// Run options of a world, independent of its scene.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Options {
    /// Seed of all randomness.
    pub seed: u64,
    /// Wheel-speed unit of the wire in rad/s: 1 for rad/s, 2 pi for revolutions a second.
    pub speed_unit: f64,
    /// Length of a step, s.
    pub time_step: f64,
    /// True if only the newest robot of a connection leaves when it closes, as in USARSim (BotConnection.uc:765-787). Its other
    /// robots then stay for ever.
    pub keep_robots: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self { seed: 0, speed_unit: 1.0, time_step: TIME_STEP, keep_robots: false }
    }
}
