//! How a world runs.

/// Length of a step, s, unless it is chosen: 500 Hz, where free rollers are within 0.3 % of their exact kinematics.
pub const TIME_STEP: f64 = 0.002;

/// How a world runs, beside what it is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Seed of all randomness.
    pub seed: u64,
    /// What one wheel-speed unit of the wire is in rad/s: 1 for rad/s, 2 pi for revolutions a second.
    pub speed_unit: f64,
    /// Length of a step, s.
    pub time_step: f64,
    /// Whether only the newest robot of a connection leaves with it, as in USARSim (BotConnection.uc:765-787), where every
    /// other one stands for ever.
    pub keep_robots: bool,
    /// For tests of what happens then: the number of steps after which the world panics.
    pub panic_at: Option<u64>,
}

impl Default for Options {
    fn default() -> Self {
        Self { seed: 0, speed_unit: 1.0, time_step: TIME_STEP, keep_robots: false, panic_at: None }
    }
}
