//! `{Name n} {ProperAcceleration x,y,z}` (AcceleroMeter.uc:9-32).

use super::Body;
use crate::field::{Field, Format, record};

record! {
    /// Acceleration of a sensor with gravity.
    AcceleroMeter {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Acceleration plus gravity along the axes of the sensor.
        acceleration: [f32; 3] = Field::new("ProperAcceleration", Format::Fixed(4)).unit("m/s²"),
    }
}

impl Body for AcceleroMeter {
    const TYPE: &'static str = "AcceleroMeter";
    const TIME: [Format; 2] = [Format::Rounded(4), Format::Fixed(4)];

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }
}
