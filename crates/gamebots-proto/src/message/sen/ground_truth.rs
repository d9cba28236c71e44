//! `{Name n} {Location x,y,z} {Orientation r,p,y}` (GroundTruth.uc:23-41): UDK truncates to three decimals; UT2004 has two, and
//! angles without a sign.

use super::Body;
use crate::field::{Field, Format, record};

record! {
    /// True pose of the robot.
    GroundTruth {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Position.
        location: [f32; 3] = Field::new("Location", Format::Fixed(3)).unit("m").ut2004(Format::Rounded(2)),
        /// Roll, pitch, yaw.
        orientation: [f32; 3] = Field::new("Orientation", Format::Fixed(3)).unit("rad").ut2004(Format::Turns(2)),
    }
}

impl Body for GroundTruth {
    const TYPE: &'static str = "GroundTruth";
    const TIME: [Format; 2] = [Format::Rounded(4), Format::Fixed(4)];

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }
}
