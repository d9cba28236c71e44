//! `{Name n} {Acceleration x,y,z}` (Acceleration.uc:27-49).

use super::Body;
use crate::field::{Field, Format, record};

record! {
    /// Acceleration of a sensor.
    Acceleration {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Acceleration without gravity along the axes of the sensor.
        acceleration: [f32; 3] = Field::new("Acceleration", Format::Fixed(4)).unit("m/s²"),
    }
}

impl Body for Acceleration {
    const TYPE: &'static str = "Accel";
    const TIME: [Format; 2] = [Format::Rounded(4), Format::Fixed(4)];

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }
}
