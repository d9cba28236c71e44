//! `{Name n} {Touch True}` (Touch.uc:75-86); all touch sensors of a UT2004 robot share a line.

use super::Body;
use crate::field::{Field, Format, record};

record! {
    /// Contact of a touch sensor's face.
    Touch {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// True if something is within its reach.
        touch: bool = Field::new("Touch", Format::Boolean),
    }
}

record! {
    /// Configuration of a touch sensor.
    TouchConf {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Diameter of its face.
        diameter: f32 = Field::new("Diameter", Format::Fixed(4)).unit("m"),
    }
}

impl Body for Touch {
    const TYPE: &'static str = "Touch";
    const TIME: [Format; 2] = [Format::Rounded(4), Format::Absent];
    const IS_GROUPED: bool = true;

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }
}
