//! `{Name n} {Gas CO2} {Density d}` of UT2004 (usarsimInf.cpp:1339).

use super::Body;
use crate::field::{Field, Format, record};

record! {
    /// Density of CO2 at the sensor.
    Co2 {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word).then(&[(["Gas"; 2], ["CO2"; 2])]),
        /// Density, 0 to 1.
        density: f32 = Field::new("Density", Format::Rounded(2)),
    }
}

impl Body for Co2 {
    const TYPE: &'static str = "CO2Sensor";
    const TIME: [Format; 2] = [Format::Absent, Format::Absent];

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }
}
