//! `{Name n} {Vel v,v,..} {Pos p,p,..}` (Tachometer.uc:27-61).

use super::Body;
use crate::field::{Field, Format, record};

record! {
    /// Speed and angle of every driven wheel.
    Tachometer {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Speeds; left out without wheels.
        velocities: Vec<f32> = Field::new("Vel", Format::Rounded(4)).unit("rad/s"),
        /// Angles turned since the last reset up to the reading before; left out without wheels.
        positions: Vec<f32> = Field::new("Pos", Format::Rounded(4)).unit("rad"),
    }
}

impl Body for Tachometer {
    const TYPE: &'static str = "Tachometer";
    const TIME: [Format; 2] = [Format::Rounded(4), Format::Absent];

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }

    fn is_whole(&self) -> bool {
        self.velocities.len() == self.positions.len()
    }
}
