//! `GEO`: geometry of the robot or of its items (protocol.md 4.7).

use super::conf::{split_items, split_links};
use super::{float_array, number};
use crate::Line;
use crate::number::{engine_vector, fixed, fixed_vector};

/// One `GEO` line.
#[derive(Debug, Clone, PartialEq)]
pub enum Geo {
    /// Answer to `GETGEO {Type Robot}`.
    Robot(RobotGeo),
    /// Answer to `GETGEO {Type Actuator}`.
    Actuators {
        /// The type as the client typed it.
        type_name: String,
        /// The actuators in the order of the robot.
        items: Vec<ActuatorGeo>,
    },
    /// Answer to any other type: every item of that type in one line.
    Items {
        /// The type as the client typed it.
        type_name: String,
        /// The items in mounting order.
        items: Vec<ItemGeo>,
    },
}

/// Geometry of a robot.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotGeo {
    /// The class, or the robot's own name if the client asked by it.
    pub name: String,
    /// What its kind of robot adds.
    pub vehicle: VehicleGeo,
}

/// What a kind of robot adds to its geometry, metres.
#[derive(Debug, Clone, PartialEq)]
pub enum VehicleGeo {
    /// On wheels.
    Ground {
        /// Wheel base, track and 0: axle to axle, not the outline.
        dimensions: [f32; 3],
        /// Centre of gravity in the robot frame.
        centre_of_gravity: [f32; 3],
        /// Radius of the wheels.
        wheel_radius: f32,
        /// Distance of left and right wheels.
        wheel_separation: f32,
        /// Distance of front and rear wheels.
        wheel_base: f32,
    },
    /// Fixed to the ground.
    Static,
    /// In the air or on legs, which add nothing.
    Plain,
}

/// Where an item is mounted.
#[derive(Debug, Clone, PartialEq)]
pub struct ItemGeo {
    /// Name of the item.
    pub name: String,
    /// Position in the robot frame, m. USARSim gives the world-axis difference, which is the same at zero rotation.
    pub location: [f32; 3],
    /// Roll, pitch, yaw in the robot frame, rad.
    pub orientation: [f32; 3],
    /// Class of the robot, or name of the actuator that carries it.
    pub mount: String,
    /// The number of the actuator's joint, from 1, that moves it.
    pub mount_link: Option<usize>,
    /// Of a gripper: its tool point against it, m.
    pub tip: Option<[f32; 3]>,
}

/// An actuator: where it is, and its joints.
#[derive(Debug, Clone, PartialEq)]
pub struct ActuatorGeo {
    /// Name of the actuator.
    pub name: String,
    /// Position in the robot frame, m.
    pub location: [f32; 3],
    /// Roll, pitch, yaw in the robot frame, rad.
    pub orientation: [f32; 3],
    /// Class of the robot that carries it.
    pub mount: String,
    /// Its joints in order.
    pub joints: Vec<JointGeo>,
    /// Its tool point in the frame of its last link, m.
    pub tip: [f32; 3],
}

/// A joint of an actuator, against its parent when every joint is at 0.
#[derive(Debug, Clone, PartialEq)]
pub struct JointGeo {
    /// Number of the parent's joint from 1; 0 is the actuator's base.
    pub parent: usize,
    /// m.
    pub location: [f32; 3],
    /// Roll, pitch, yaw, rad.
    pub orientation: [f32; 3],
}

impl Geo {
    pub(super) fn write(&self) -> String {
        match self {
            Self::Robot(robot) => robot.write(),
            Self::Actuators { type_name, items } => {
                let items: String = items.iter().map(ActuatorGeo::write).collect();
                format!("GEO {{Type {type_name}}}{items}")
            }
            Self::Items { type_name, items } => {
                let items: String = items.iter().map(ItemGeo::write).collect();
                format!("GEO {{Type {type_name}}}{items}")
            }
        }
    }

    pub(super) fn read(line: &Line) -> Option<Self> {
        if let Some(robot) = RobotGeo::read(line) {
            return Some(Self::Robot(robot));
        }
        let type_name = line.get("Type")?.to_owned();
        if line.get("Link").is_some() {
            let items = split_items(line.blocks.get(1..)?).iter().map(ActuatorGeo::read).collect::<Option<_>>()?;
            return Some(Self::Actuators { type_name, items });
        }
        let items = split_items(line.blocks.get(1..)?).iter().map(ItemGeo::read).collect::<Option<_>>()?;
        Some(Self::Items { type_name, items })
    }
}

impl RobotGeo {
    fn write(&self) -> String {
        let name = &self.name;
        match &self.vehicle {
            VehicleGeo::Ground { dimensions, centre_of_gravity, wheel_radius, wheel_separation, wheel_base } => {
                format!(
                    "GEO {{Type GroundVehicle}} {{Name {name}}} {{Dimensions {}}} {{COG {}}} {{WheelRadius {}}} \
                 {{WheelSeparation {}}} {{WheelBase {}}}",
                    fixed_vector(*dimensions, 4),
                    fixed_vector(*centre_of_gravity, 4),
                    fixed(*wheel_radius, 4),
                    fixed(*wheel_separation, 4),
                    fixed(*wheel_base, 4),
                )
            }
            VehicleGeo::Static => format!("GEO {{Type StaticPlatform}} {{Name {name}}}"),
            VehicleGeo::Plain => format!("GEO {{Name {name}}}"),
        }
    }

    /// `None` for the answer to another question.
    fn read(line: &Line) -> Option<Self> {
        let vehicle = match line.get("Type") {
            Some("GroundVehicle") => VehicleGeo::Ground {
                dimensions: float_array(line.get("Dimensions")?)?,
                centre_of_gravity: float_array(line.get("COG")?)?,
                wheel_radius: number(line, "WheelRadius")?,
                wheel_separation: number(line, "WheelSeparation")?,
                wheel_base: number(line, "WheelBase")?,
            },
            Some("StaticPlatform") => VehicleGeo::Static,
            Some(_) => return None,
            None => VehicleGeo::Plain,
        };
        Some(Self { name: line.get("Name")?.to_owned(), vehicle })
    }
}

impl ItemGeo {
    /// No space before `{Mount`, as in Sensor.uc:40-68 and Effector.uc:26-55.
    fn write(&self) -> String {
        format!(
            " {{Name {}}} {{Location {}}} {{Orientation {}}}{{Mount {}}}{}{}",
            self.name,
            engine_vector(self.location),
            engine_vector(self.orientation),
            self.mount,
            self.mount_link.map(|link| format!("{{MountLink {link}}}")).unwrap_or_default(),
            self.tip.map(|tip| format!("{{Tip {}}}", engine_vector(tip))).unwrap_or_default(),
        )
    }

    fn read(item: &Line) -> Option<Self> {
        Some(Self {
            name: item.get("Name")?.to_owned(),
            location: float_array(item.get("Location")?)?,
            orientation: float_array(item.get("Orientation")?)?,
            mount: item.get("Mount")?.to_owned(),
            mount_link: match item.get("MountLink") {
                Some(_) => Some(number(item, "MountLink")?),
                None => None,
            },
            tip: match item.get("Tip") {
                Some(tip) => Some(float_array(tip)?),
                None => None,
            },
        })
    }
}

impl ActuatorGeo {
    /// Spaces as in Actuator.uc:243-317.
    fn write(&self) -> String {
        let joint = |(number, it): (usize, &JointGeo)| {
            let (location, orientation) = (fixed_vector(it.location, 3), engine_vector(it.orientation));
            let (number, parent) = (number + 1, it.parent);
            format!(" {{Link {number}}} {{Parent {parent}}} {{Location {location}}} {{Orientation {orientation}}}")
        };
        format!(
            " {{Name {}}} {{Location {}}} {{Orientation {}}}{{Mount {}}}{}{{Tip {}}}",
            self.name,
            fixed_vector(self.location, 3),
            fixed_vector(self.orientation, 3),
            self.mount,
            self.joints.iter().enumerate().map(joint).collect::<String>(),
            engine_vector(self.tip),
        )
    }

    fn read(item: &Line) -> Option<Self> {
        let joint = |line: Line| {
            Some(JointGeo {
                parent: number(&line, "Parent")?,
                location: float_array(line.get("Location")?)?,
                orientation: float_array(line.get("Orientation")?)?,
            })
        };
        Some(Self {
            name: item.get("Name")?.to_owned(),
            location: float_array(item.get("Location")?)?,
            orientation: float_array(item.get("Orientation")?)?,
            mount: item.get("Mount")?.to_owned(),
            joints: split_links(item).map(joint).collect::<Option<_>>()?,
            tip: float_array(item.get("Tip")?)?,
        })
    }
}
