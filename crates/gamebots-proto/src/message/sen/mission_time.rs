//! `{Name n} {Minutes m}` (MissionTime.uc:6-20).

use super::Body;
use crate::field::{Field, Format, record};

record! {
    /// Time since a robot was spawned.
    MissionTime {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Whole minutes.
        minutes: i32 = Field::new("Minutes", Format::Integer).unit("min"),
    }
}

impl Body for MissionTime {
    const TYPE: &'static str = "MissionTime";
    const TIME: [Format; 2] = [Format::Rounded(4), Format::Fixed(4)];

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }
}
