//! `STA`: state of a ground vehicle (protocol.md 4.2).

use super::{boolean, number, read_boolean};
use crate::Line;
use crate::number::engine_float;

/// State of a skid-steered or omnidirectional robot; the steering angles of these are literally 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Sta {
    /// Simulated time, s.
    pub time: f32,
    /// Estimated seconds left in the battery; 99999 without one.
    pub battery: i32,
    /// Headlight on.
    pub light: bool,
}

impl Sta {
    pub(super) fn write(&self) -> String {
        format!(
            "STA {{Time {}}} {{Battery {}}} {{Type GroundVehicle}} {{LightToggle {}}} {{LightIntensity 100}} \
             {{FrontSteer 0}} {{RearSteer 0}}",
            engine_float(self.time),
            self.battery,
            boolean(self.light),
        )
    }

    pub(super) fn read(line: &Line) -> Option<Self> {
        Some(Self {
            time: number(line, "Time")?,
            battery: number(line, "Battery")?,
            light: read_boolean(line, "LightToggle")?,
        })
    }
}
