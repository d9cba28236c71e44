//! `{Name n} {Pose x,y,theta}`, four decimals, rounded (Odometry.uc:99-135).

use super::super::float_array;
use super::{ReadWrite, name};
use crate::Line;
use crate::number::engine_floats;

/// Where the wheels say the robot is.
#[derive(Debug, Clone, PartialEq)]
pub struct Odometry {
    /// Name of the sensor.
    pub name: String,
    /// x, y in metres and theta in radians (clockwise positive, not wrapped), in the start frame of the robot.
    pub pose: [f32; 3],
}

impl ReadWrite for Odometry {
    const TYPE: &'static str = "Odometry";

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }

    fn write(&self) -> String {
        format!("{{Name {}}} {{Pose {}}}", self.name, engine_floats(&self.pose))
    }

    fn read(line: &Line) -> Option<Self> {
        Some(Self { name: name(line)?, pose: float_array(line.get("Pose")?)? })
    }
}
