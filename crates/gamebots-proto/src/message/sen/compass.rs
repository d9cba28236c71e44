//! `{Name n} {MagneticAngle a}` (MagneticCompass.uc:8-49).

use super::Body;
use crate::field::{Field, Format, record};

record! {
    /// Direction of a sensor.
    MagneticCompass {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Angle from the sensor's x axis to north, clockwise, in [-pi, pi].
        angle: f32 = Field::new("MagneticAngle", Format::Rounded(4)).unit("rad"),
    }
}

impl Body for MagneticCompass {
    const TYPE: &'static str = "MagneticCompass";
    const TIME: [Format; 2] = [Format::Rounded(4), Format::Fixed(4)];

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }
}
