//! `GEO`: geometry of the robot or of its items (protocol.md 4.7). An item of UT2004 is one block; its mount is `HARD` if it is
//! on the body.

use super::conf::split_items;
use crate::field::{self, Field, Format, Record, Written, record};
use crate::{Dialect, Line};

/// One `GEO` line.
#[derive(Debug, Clone, PartialEq)]
pub enum Geo {
    /// Answer to `GETGEO {Type Robot}`.
    Robot(RobotGeo),
    /// Answer to any other type: every item of that type in one line.
    Items {
        /// The type as the client typed it.
        type_name: String,
        /// The items in mounting order.
        items: Vec<ItemGeo>,
    },
}

/// Geometry of one item, in the form of its type.
#[derive(Debug, Clone, PartialEq)]
pub enum ItemGeo {
    /// An item other than an actuator.
    Mounted(MountedGeo),
    /// An actuator.
    Actuator(ActuatorGeo),
}

/// Geometry of a robot.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotGeo {
    /// The class, or the robot's own name if the client asked by it.
    pub name: String,
    /// The part that depends on the kind of robot.
    pub vehicle: VehicleGeo,
}

/// The part of a geometry that depends on the kind of robot.
#[derive(Debug, Clone, PartialEq)]
pub enum VehicleGeo {
    /// A robot on wheels.
    Ground(GroundGeo),
    /// A robot fixed to the ground.
    Static,
    /// A robot in the air or on legs, which adds nothing.
    Plain,
}

record! {
    /// Geometry that a robot on wheels adds.
    GroundGeo {
        /// Wheel base, track and 0: axle to axle, not the outline.
        dimensions: [f32; 3] = Field::new("Dimensions", Format::Fixed(4)).unit("m"),
        /// Centre of gravity in the robot frame.
        centre_of_gravity: [f32; 3] = Field::new("COG", Format::Fixed(4)).unit("m"),
        /// Radius of the wheels.
        wheel_radius: f32 = Field::new("WheelRadius", Format::Fixed(4)).unit("m"),
        /// Distance of left and right wheels.
        wheel_separation: f32 = Field::new("WheelSeparation", Format::Fixed(4)).unit("m"),
        /// Distance of front and rear wheels.
        wheel_base: f32 = Field::new("WheelBase", Format::Fixed(4)).unit("m"),
    }
}

record! {
    /// Mounting of an item.
    MountedGeo {
        /// Name of the item.
        name: String = Field::new("Name", Format::Word),
        /// Position in the robot frame. USARSim gives the world-axis difference, which is the same at zero rotation.
        location: [f32; 3] = Field::new("Location", Format::Rounded(2)).unit("m").ut2004(Format::Fixed(4)),
        /// Roll, pitch, yaw in the robot frame.
        orientation: [f32; 3] = Field::new("Orientation", Format::Rounded(2)).unit("rad").ut2004(Format::Fixed(4)),
        /// Class of the robot, or name of the actuator that carries it.
        mount: String = Field::new("Mount", Format::Word).tight(),
        /// The number of the actuator's joint, from 1, that moves it.
        mount_link: Option<usize> = Field::new("MountLink", Format::Integer).tight().only_udk(),
        /// Tool point of a gripper, relative to the gripper.
        tip: Option<[f32; 3]> = Field::new("Tip", Format::Rounded(2)).unit("m").tight().only_udk(),
    }
}

record! {
    /// An actuator: where it is, and its joints.
    ActuatorGeo {
        /// Name of the actuator.
        name: String = Field::new("Name", Format::Word),
        /// Position in the robot frame.
        location: [f32; 3] = Field::new("Location", Format::Fixed(3)).unit("m").ut2004(Format::Absent),
        /// Roll, pitch, yaw in the robot frame.
        orientation: [f32; 3] = Field::new("Orientation", Format::Fixed(3)).unit("rad").ut2004(Format::Absent),
        /// Class of the robot that carries it.
        mount: String = Field::new("Mount", Format::Word).tight().ut2004(Format::Absent),
        /// Its tool point in the frame of its last link.
        tip: [f32; 3] = Field::new("Tip", Format::Rounded(2)).unit("m").tight().ut2004(Format::Absent).rank([1, 0]),
        ;
        /// Its joints in order.
        joints: [JointGeo]
    }
}

record! {
    /// A joint of an actuator, against its parent when every joint is at 0.
    JointGeo {
        /// Its number from 1.
        link: usize = Field::new("Link", Format::Integer),
        /// Number of the parent's joint; the actuator's base is 0, and -1 for UT2004.
        parent: i32 = Field::new("Parent", Format::Integer).ut2004_key("ParentLink"),
        /// Position.
        location: [f32; 3] = Field::new("Location", Format::Fixed(3)).unit("m").ut2004(Format::Fixed(4)),
        /// Roll, pitch, yaw.
        orientation: [f32; 3] = Field::new("Orientation", Format::Rounded(2)).unit("rad").ut2004(Format::Fixed(4)),
    }
}

impl Geo {
    pub(super) fn write(&self, dialect: Dialect) -> String {
        match self {
            Self::Robot(robot) => robot.write(dialect),
            Self::Items { type_name, items } => {
                let items: String = items.iter().map(|item| item.write(dialect)).collect();
                format!("GEO {{Type {type_name}}}{items}")
            }
        }
    }

    pub(super) fn read(line: &Line) -> Option<Self> {
        if let Some(robot) = RobotGeo::read(line) {
            return Some(Self::Robot(robot));
        }
        let type_name = line.get("Type")?.to_owned();
        let blocks: Vec<_> = line.blocks.iter().skip(1).flat_map(|block| MountedGeo::TABLE.unmerged(block)).collect();
        let items = split_items(&blocks).iter().map(ItemGeo::read).collect::<Option<_>>()?;
        Some(Self::Items { type_name, items })
    }
}

impl ItemGeo {
    fn write(&self, dialect: Dialect) -> String {
        match (self, dialect) {
            (Self::Mounted(item), Dialect::Udk) => field::blocks(item.write(dialect)),
            (Self::Mounted(item), Dialect::Ut2004) => {
                field::merged(&MountedGeo { mount: item.ut2004_mount(), ..item.clone() }.write(dialect))
            }
            (Self::Actuator(item), Dialect::Udk) => field::blocks(item.write(dialect)),
            (Self::Actuator(item), Dialect::Ut2004) => {
                let mut item = item.clone();
                item.joints.iter_mut().filter(|it| it.parent == 0).for_each(|it| it.parent = -1);
                field::blocks(item.write(dialect))
            }
        }
    }

    fn read(item: &Line) -> Option<Self> {
        let is_actuator = item.get("Link").is_some();
        if is_actuator {
            ActuatorGeo::read(item).map(Self::Actuator)
        } else {
            MountedGeo::read(item).map(Self::Mounted)
        }
    }
}

impl RobotGeo {
    fn write(&self, dialect: Dialect) -> String {
        let name = Written::new("Name", self.name.as_str());
        let blocks = match &self.vehicle {
            VehicleGeo::Ground(ground) => {
                let head = vec![Written::new("Type", "GroundVehicle"), name];
                head.into_iter().chain(ground.write(dialect)).collect()
            }
            VehicleGeo::Static => vec![Written::new("Type", "StaticPlatform"), name],
            VehicleGeo::Plain => vec![name],
        };
        format!("GEO{}", field::blocks(blocks))
    }

    /// Reads the line; `None` if it answers another question.
    fn read(line: &Line) -> Option<Self> {
        let vehicle = match line.get("Type") {
            Some("GroundVehicle") => VehicleGeo::Ground(GroundGeo::read(line)?),
            Some("StaticPlatform") => VehicleGeo::Static,
            Some(_) => return None,
            None => VehicleGeo::Plain,
        };
        Some(Self { name: line.get("Name")?.to_owned(), vehicle })
    }
}

impl MountedGeo {
    /// Returns UT2004's mount: `HARD` on the body, or the link of an actuator, as in `CameraPanTilt_Link2`.
    fn ut2004_mount(&self) -> String {
        self.mount_link.map_or_else(|| "HARD".to_owned(), |link| format!("{}_Link{link}", self.mount))
    }
}
