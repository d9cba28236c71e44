//! A reading with its robot and sensor.

use crate::{PawnId, sensor::Reading};

/// A reading of a robot's sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensed {
    /// The robot.
    pub robot: PawnId,
    /// Number of the sensor in the robot's class.
    pub sensor: usize,
    /// The reading.
    pub reading: Reading,
}
