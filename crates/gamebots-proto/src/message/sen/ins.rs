//! `{Name n} {Location x,y,z} {Orientation r,p,y}`, two decimals, rounded; no time (INS.uc:99-145).

use super::super::float_array;
use super::{ReadWrite, name};
use crate::Line;
use crate::number::engine_vector;

/// Where the inertial navigation believes the robot to be.
#[derive(Debug, Clone, PartialEq)]
pub struct Ins {
    /// Name of the sensor.
    pub name: String,
    /// Estimated position, m.
    pub location: [f32; 3],
    /// Estimated roll, pitch, yaw, rad, each in [0, 2 pi).
    pub orientation: [f32; 3],
}

impl ReadWrite for Ins {
    const TYPE: &'static str = "INS";
    const STAMPED: bool = false;

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }

    fn write(&self) -> String {
        let [location, orientation] = [self.location, self.orientation].map(engine_vector);
        format!("{{Name {}}} {{Location {location}}} {{Orientation {orientation}}}", self.name)
    }

    fn read(line: &Line) -> Option<Self> {
        Some(Self {
            name: name(line)?,
            location: float_array(line.get("Location")?)?,
            orientation: float_array(line.get("Orientation")?)?,
        })
    }
}
