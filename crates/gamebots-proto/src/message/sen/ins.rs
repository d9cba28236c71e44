//! `{Name n} {Location x,y,z} {Orientation r,p,y}`; no time in either dialect (INS.uc:99-145, DefaultUSAR.ini:51).

use super::Body;
use crate::field::{Field, Format, record};

record! {
    /// Pose of the robot by inertial navigation.
    Ins {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Estimated position.
        location: [f32; 3] = Field::new("Location", Format::Rounded(2)).unit("m"),
        /// Estimated roll, pitch, yaw, each in [0, 2 pi).
        orientation: [f32; 3] = Field::new("Orientation", Format::Rounded(2)).unit("rad"),
    }
}

impl Body for Ins {
    const TYPE: &'static str = "INS";
    const TIME: [Format; 2] = [Format::Absent, Format::Absent];

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }
}
