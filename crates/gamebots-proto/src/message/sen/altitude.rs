//! `{Name n} {relativeAltitude a} {absoluteAltitude a}` (AltitudeSensor.uc:11-41).

use super::Body;
use crate::field::{Field, Format, record};

record! {
    /// Height of a robot.
    AltitudeSensor {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Height above the place of the spawn.
        relative: f32 = Field::new("relativeAltitude", Format::Fixed(4)).unit("m"),
        /// Height above 111 m below that place, at least 0.
        absolute: f32 = Field::new("absoluteAltitude", Format::Fixed(4)).unit("m"),
    }
}

impl Body for AltitudeSensor {
    const TYPE: &'static str = "AltitudeSensor";
    const TIME: [Format; 2] = [Format::Rounded(4), Format::Fixed(4)];

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }
}
