//! `{Name n} {Orientation r,p,y}` of the oldest clients (sensors.md 8).

use super::Body;
use crate::field::{Field, Format, record};

record! {
    /// Attitude of the robot.
    Inu {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Roll, pitch, yaw.
        orientation: [f32; 3] = Field::new("Orientation", Format::Rounded(2)).unit("rad").ut2004(Format::Turns(2)),
    }
}

impl Body for Inu {
    const TYPE: &'static str = "INU";
    const TIME: [Format; 2] = [Format::Absent, Format::Absent];

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }
}
