//! `STA`: state of a robot (protocol.md 4.2). UT2004 has the type first and the battery last.

use crate::field::{self, Field, Format, Record, Written, record};
use crate::number::rounded;
use crate::{Dialect, Line};

record! {
    /// State of a robot, whatever its kind.
    StaHead {
        /// Simulated time.
        time: f32 = Field::new("Time", Format::Rounded(4)).unit("s").ut2004(Format::Rounded(2)).rank([0, 1]),
        /// Estimated time left in the battery; 99999 without one.
        battery: i32 = Field::new("Battery", Format::Integer).unit("s").rank([0, 5]).then(&[(["View"; 2], ["", "-1"])]),
    }
}

/// State of a robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Sta {
    /// Simulated time, s.
    pub time: f32,
    /// Estimated seconds left in the battery; 99999 without one.
    pub battery: i32,
    /// The part that depends on the kind of robot.
    pub vehicle: Vehicle,
}

/// The part of a state that depends on the kind of robot.
#[derive(Debug, Clone, PartialEq)]
pub enum Vehicle {
    /// A robot on wheels or tracks, with its other joints by name, rad or m. Only UT2004 writes the joints.
    Ground(GroundSta, Vec<(String, f32)>),
    /// A robot on legs: its joints by name, rad.
    Legged {
        /// Joints in the robot's order.
        joints: Vec<(String, f32)>,
    },
    /// A robot fixed to the ground.
    Static,
    /// A robot in the air. It adds nothing, except a light that is off for UT2004.
    Aerial,
}

record! {
    /// State that a robot on wheels adds.
    GroundSta {
        /// True if the headlight is on.
        light: bool = Field::new("LightToggle", Format::Boolean).rank([2, 4]).then(&[(["LightIntensity"; 2], ["100", "0"])]),
        /// Steering angle of the front as it was asked for; none where a robot does not steer so.
        front_steer: Option<f32> = Field::new("FrontSteer", Format::FixedOrZero(4)).unit("rad").ut2004(Format::Fixed(4)).rank([2, 2]),
        /// Steering angle of the rear as it was asked for.
        rear_steer: Option<f32> = Field::new("RearSteer", Format::FixedOrZero(4)).unit("rad").ut2004(Format::Fixed(4)).rank([2, 2]),
    }
}

/// Keys of a status that are not joints.
const KEYS: [&str; 8] = ["Time", "Battery", "Type", "View", "LightToggle", "LightIntensity", "FrontSteer", "RearSteer"];

fn joint_block((name, value): &(String, f32)) -> Written {
    Written::new(name, rounded(*value, 4))
}

/// Returns the blocks that are joints.
fn joints(line: &Line) -> Option<Vec<(String, f32)>> {
    let joints = line.blocks.iter().filter(|block| !KEYS.contains(&block.key.as_str()));
    joints.map(|block| Some((block.key.clone(), block.value.parse().ok()?))).collect()
}

impl Sta {
    pub(super) fn write(&self, dialect: Dialect) -> String {
        let mut blocks = StaHead { time: self.time, battery: self.battery }.write(dialect);
        let type_name = match &self.vehicle {
            Vehicle::Ground(..) => "GroundVehicle",
            Vehicle::Legged { .. } => "LeggedVehicle",
            Vehicle::Static => "StaticPlatform",
            Vehicle::Aerial => dialect.of(["", "AerialVehicle"]),
        };
        if !type_name.is_empty() {
            blocks.push(Written::new("Type", type_name).ranked(dialect.of([1, 0])));
        }
        match &self.vehicle {
            Vehicle::Ground(ground, joints) => {
                blocks.extend(ground.write(dialect));
                // Between the steering and the light, as ros-usarsim quotes it (usarsimInf.cpp).
                let joints = if dialect == Dialect::Ut2004 { joints.as_slice() } else { &[] };
                blocks.extend(joints.iter().map(|joint| joint_block(joint).ranked(3)));
            }
            Vehicle::Legged { joints } => blocks.extend(joints.iter().map(|joint| joint_block(joint).ranked(2))),
            Vehicle::Aerial if dialect == Dialect::Ut2004 => {
                let light = [("LightToggle", "False"), ("LightIntensity", "0")];
                blocks.extend(light.map(|(key, value)| Written::new(key, value).ranked(4)));
            }
            Vehicle::Static | Vehicle::Aerial => {}
        }
        format!("STA{}", field::blocks(blocks))
    }

    pub(super) fn read(line: &Line) -> Option<Self> {
        let vehicle = match line.get("Type") {
            Some("GroundVehicle") => Vehicle::Ground(GroundSta::read(line)?, joints(line)?),
            Some("LeggedVehicle") => Vehicle::Legged { joints: joints(line)? },
            Some("StaticPlatform") => Vehicle::Static,
            Some("AerialVehicle") | None => Vehicle::Aerial,
            Some(_) => return None,
        };
        let StaHead { time, battery } = StaHead::read(line)?;
        Some(Self { time, battery, vehicle })
    }
}
