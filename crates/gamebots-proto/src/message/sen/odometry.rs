//! `{Name n} {Pose x,y,theta}` (Odometry.uc:99-135); without a time, and with its angle wrapped, for UT2004.

use super::Body;
use crate::field::{Field, Format, record};

record! {
    /// Pose of the robot by its wheels.
    Odometry {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// x, y and theta (clockwise positive; for UDK not wrapped) in the frame in which the robot started.
        pose: [f32; 3] = Field::new("Pose", Format::Rounded(4)).unit("m, rad").ut2004(Format::Pose(4)),
    }
}

impl Body for Odometry {
    const TYPE: &'static str = "Odometry";
    const TIME: [Format; 2] = [Format::Rounded(4), Format::Absent];

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }
}
