//! `{Name n} {Location x,y,z} {Orientation r,p,y}`, three decimals, truncated (GroundTruth.uc:23-41).

use super::super::float_array;
use super::{ReadWrite, name};
use crate::Line;
use crate::number::fixed_vector;

/// Where the robot is.
#[derive(Debug, Clone, PartialEq)]
pub struct GroundTruth {
    /// Name of the sensor.
    pub name: String,
    /// Position, m.
    pub location: [f32; 3],
    /// Roll, pitch, yaw, rad.
    pub orientation: [f32; 3],
}

impl ReadWrite for GroundTruth {
    const TYPE: &'static str = "GroundTruth";

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }

    fn write(&self) -> String {
        let [location, orientation] = [self.location, self.orientation].map(|vector| fixed_vector(vector, 3));
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
