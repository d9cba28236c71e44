//! `STA`: state of a robot (protocol.md 4.2).

use super::{boolean, number, read_boolean};
use crate::Line;
use crate::number::{engine_float, fixed};

/// State of a robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Sta {
    /// Simulated time, s.
    pub time: f32,
    /// Estimated seconds left in the battery; 99999 without one.
    pub battery: i32,
    /// What its kind of robot adds.
    pub vehicle: Vehicle,
}

/// What a kind of robot adds to its state.
#[derive(Debug, Clone, PartialEq)]
pub enum Vehicle {
    /// On wheels.
    Ground {
        /// Headlight on.
        light: bool,
        /// Steering angles of front and rear as they were asked for, rad; literally 0 where a robot does not steer so.
        steer: Option<[f32; 2]>,
    },
    /// On legs: its joints by name, rad.
    Legged {
        /// In the order of the robot.
        joints: Vec<(String, f32)>,
    },
    /// Fixed to the ground.
    Static,
    /// In the air, which adds nothing.
    Aerial,
}

impl Sta {
    pub(super) fn write(&self) -> String {
        let head = format!("STA {{Time {}}} {{Battery {}}}", engine_float(self.time), self.battery);
        match &self.vehicle {
            Vehicle::Ground { light, steer } => {
                let [front, rear] = steer.map_or_else(|| ["0"; 2].map(str::to_owned), |it| it.map(|it| fixed(it, 4)));
                let light = boolean(*light);
                format!(
                    "{head} {{Type GroundVehicle}} {{LightToggle {light}}} {{LightIntensity 100}} {{FrontSteer {front}}} \
                     {{RearSteer {rear}}}"
                )
            }
            Vehicle::Legged { joints } => {
                let joint = |(name, angle): &(String, f32)| format!(" {{{name} {}}}", engine_float(*angle));
                format!("{head} {{Type LeggedVehicle}}{}", joints.iter().map(joint).collect::<String>())
            }
            Vehicle::Static => format!("{head} {{Type StaticPlatform}}"),
            Vehicle::Aerial => head,
        }
    }

    pub(super) fn read(line: &Line) -> Option<Self> {
        let vehicle = match line.get("Type") {
            Some("GroundVehicle") => Vehicle::Ground { light: read_boolean(line, "LightToggle")?, steer: steer(line)? },
            Some("LeggedVehicle") => {
                let joint = |block: &crate::Block| Some((block.key.clone(), block.value.parse().ok()?));
                Vehicle::Legged { joints: line.blocks.get(3..)?.iter().map(joint).collect::<Option<_>>()? }
            }
            Some("StaticPlatform") => Vehicle::Static,
            Some(_) => return None,
            None => Vehicle::Aerial,
        };
        Some(Self { time: number(line, "Time")?, battery: number(line, "Battery")?, vehicle })
    }
}

/// The steering angles, of which a literal 0 is none.
fn steer(line: &Line) -> Option<Option<[f32; 2]>> {
    if line.get("FrontSteer") == Some("0") {
        return Some(None);
    }
    Some(Some([number(line, "FrontSteer")?, number(line, "RearSteer")?]))
}
