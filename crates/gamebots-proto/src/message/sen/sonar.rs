//! `{Name n} {Range d}`, one line per sonar (SonarSensor.uc:38-90); all sonars of a UT2004 robot share a line.

use super::Body;
use crate::field::{Field, Format, record};

record! {
    /// Distance to the nearest echo.
    Sonar {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Distance.
        range: f32 = Field::new("Range", Format::Fixed(4)).unit("m"),
    }
}

impl Body for Sonar {
    const TYPE: &'static str = "Sonar";
    const TIME: [Format; 2] = [Format::Rounded(4), Format::Fixed(4)];
    const IS_GROUPED: bool = true;

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }
}
