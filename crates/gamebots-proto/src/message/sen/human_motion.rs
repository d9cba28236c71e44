//! `{Name n} {Prob p}` of UT2004. The lines of this type are named in the manual only; the form is that of its other sensors.

use super::Body;
use crate::field::{Field, Format, record};

record! {
    /// Motion of a person in view.
    HumanMotion {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Probability that a person moves, 0 to 1.
        probability: f32 = Field::new("Prob", Format::Rounded(2)),
    }
}

impl Body for HumanMotion {
    const TYPE: &'static str = "HumanMotion";
    const TIME: [Format; 2] = [Format::Absent, Format::Absent];

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }
}
