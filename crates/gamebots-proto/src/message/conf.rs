//! `CONF`: configuration of the robot or of its items (protocol.md 4.7).

use super::{IrConf, LineLaserConf, RangeImagerConf, RangeScanner3DConf, TouchArrayConf, TouchConf};
use crate::field::{self, Field, Format, Record, Table, Written, record};
use crate::{Block, Dialect, Line};

/// One `CONF` line.
#[derive(Debug, Clone, PartialEq)]
pub enum Conf {
    /// Answer to `GETCONF {Type Robot}`.
    Robot(RobotConf),
    /// Answer to any other type: every item of that type in one line.
    Items {
        /// The type as the client typed it.
        type_name: String,
        /// The items in mounting order; none for `MisPkg` on a robot without actuators.
        items: Vec<ItemConf>,
    },
}

/// Configuration of a robot.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotConf {
    /// The class, or the robot's own name if the client asked by it.
    pub name: String,
    /// The part that depends on the kind of robot.
    pub vehicle: VehicleConf,
}

/// The part of a configuration that depends on the kind of robot.
#[derive(Debug, Clone, PartialEq)]
pub enum VehicleConf {
    /// A robot on wheels.
    Ground(GroundConf),
    /// A robot fixed to the ground.
    Static,
    /// A robot in the air or on legs, which adds nothing.
    Plain,
}

record! {
    /// Configuration that a robot on wheels adds.
    GroundConf {
        /// `SkidSteered`, `AckermanSteered` or `OmniDrive`.
        steering_type: String = Field::new("SteeringType", Format::Word),
        /// Mass of all parts.
        mass: f32 = Field::new("Mass", Format::Fixed(4)).unit("kg"),
        /// Smallest speed limit of the wheels.
        max_speed: f32 = Field::new("MaxSpeed", Format::Fixed(4)).unit("rad/s"),
        /// Smallest torque limit of the wheels, 5 to 1 N m.
        max_torque: f32 = Field::new("MaxTorque", Format::Fixed(4)).unit("N m / 5"),
        /// Range of the steering angles of the front; none where a robot does not steer so.
        max_front_steer: Option<f32> = Field::new("MaxFrontSteer", Format::FixedOrZero(4)).unit("rad").ut2004(Format::Fixed(4)),
        /// Range of the steering angles of the rear.
        max_rear_steer: Option<f32> = Field::new("MaxRearSteer", Format::FixedOrZero(4)).unit("rad").ut2004(Format::Fixed(4)),
    }
}

record! {
    /// Configuration of an item of which only the name is known.
    PlainConf {
        /// Name of the item.
        name: String = Field::new("Name", Format::Word),
    }
}

record! {
    /// Configuration of GroundTruth and INS.
    PoseConf {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Time between two readings.
        scan_interval: f32 = Field::new("ScanInterval", Format::Rounded(4)).unit("s").ut2004(Format::Rounded(2)),
    }
}

record! {
    /// Configuration of Odometry and Tachometer.
    WheelsConf {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Time between two readings.
        scan_interval: f32 = Field::new("ScanInterval", Format::Rounded(4)).unit("s"),
    }
}

record! {
    /// Configuration of an encoder.
    EncoderConf {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Angle of one tick.
        resolution: f32 = Field::new("Resolution", Format::Fixed(4)).unit("rad"),
    }
}

record! {
    /// Configuration of a laser scanner.
    RangeScannerConf {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Greatest range.
        max_range: f32 = Field::new("MaxRange", Format::Fixed(4)).unit("m"),
        /// Least range.
        min_range: f32 = Field::new("MinRange", Format::Fixed(4)).unit("m"),
        /// Angle between two beams.
        resolution: f32 = Field::new("Resolution", Format::Fixed(4)).unit("rad"),
        /// Angle between the first and the last beam.
        fov: f32 = Field::new("Fov", Format::Fixed(4)).unit("rad"),
        /// True if it scans to the sides.
        panning: bool = Field::new("Panning", Format::Boolean).ut2004_key("Paning"),
        /// True if it scans up and down.
        tilting: bool = Field::new("Tilting", Format::Boolean),
    }
}

record! {
    /// Configuration of a sonar.
    SonarConf {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Greatest range.
        max_range: f32 = Field::new("MaxRange", Format::Fixed(4)).unit("m"),
        /// Least range.
        min_range: f32 = Field::new("MinRange", Format::Fixed(4)).unit("m"),
        /// Time between two readings.
        scan_interval: f32 = Field::new("ScanInterval", Format::Fixed(4)).unit("s").only_udk(),
        /// Opening angle of the cone.
        beam_angle: f32 = Field::new("beamAngle", Format::Fixed(4)).unit("rad").ut2004_key("BeamAngle"),
        /// Greatest angle against a surface's normal that still gives an echo.
        max_angle_of_incidence: f32 = Field::new("maxAngleOfIncidence", Format::Fixed(4)).unit("rad").only_udk(),
        /// Rays on each cone.
        traces_per_cone: u32 = Field::new("tracesPerCone", Format::Integer).only_udk(),
        /// Cones within one another.
        number_of_cones: u32 = Field::new("numberOfCones", Format::Integer).only_udk(),
    }
}

record! {
    /// Configuration of a camera: where its picture is in the image server's.
    CameraConf {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Column of the picture's first pixel.
        offset_x: i32 = Field::new("TextureOffsetX", Format::Integer).tight(),
        /// Row of the picture's first pixel.
        offset_y: i32 = Field::new("TextureOffsetY", Format::Integer).tight(),
        /// Columns.
        resolution_x: i32 = Field::new("TextureResolutionX", Format::Integer).tight(),
        /// Rows.
        resolution_y: i32 = Field::new("TextureResolutionY", Format::Integer).tight(),
        /// Field of view to begin with.
        default_fov: f32 = Field::new("CameraDefFov", Format::Rounded(4)).unit("degree").tight(),
        /// Least field of view.
        min_fov: f32 = Field::new("CameraMinFov", Format::Rounded(4)).unit("degree").tight(),
        /// Greatest field of view.
        max_fov: f32 = Field::new("CameraMaxFov", Format::Rounded(4)).unit("degree").tight(),
        /// Field of view now.
        fov: f32 = Field::new("CameraFov", Format::Rounded(4)).unit("degree").tight(),
    }
}

record! {
    /// Configuration of an actuator.
    ActuatorConf {
        /// Name of the actuator.
        name: String = Field::new("Name", Format::Word),
        ;
        /// Its joints in order.
        joints: [JointConf]
    }
}

record! {
    /// A joint of an actuator.
    JointConf {
        /// Its number from 1.
        link: usize = Field::new("Link", Format::Integer),
        /// `Revolute`, `Prismatic` or `Unknown`.
        kind: String = Field::new("JointType", Format::Word),
        /// Torque limit, 5 to 1 N m, or force limit in N.
        max_torque: f32 = Field::new("MaxTorque", Format::Rounded(4)).unit("N m / 5, or N").ut2004(Format::Rounded(2)),
        /// Least value.
        min: f32 = Field::new("MinValue", Format::Rounded(4)).unit("rad or m").ut2004(Format::Rounded(2)),
        /// Greatest value.
        max: f32 = Field::new("MaxValue", Format::Rounded(4)).unit("rad or m").ut2004(Format::Rounded(2)),
    }
}

record! {
    /// Configuration of an actuator as a mission package.
    MisPkgConf {
        /// Name of the actuator.
        name: String = Field::new("Name", Format::Word),
        ;
        /// Its joints in order.
        joints: [MisPkgJoint]
    }
}

record! {
    /// A joint of a mission package; its speed is a constant of USARSim, rad/s (Actuator.uc:355-382).
    MisPkgJoint {
        /// Its number from 1.
        link: usize = Field::new("Link", Format::Integer),
        /// `Revolute`, `Prismatic` or `Unknown`.
        kind: String = Field::new("JointType", Format::Word).then(&[(["MaxRotationSpeed", "MaxSpeed"], ["1.571", "1.57"])]),
        /// Torque limit, 5 to 1 N m, or force limit in N.
        max_torque: f32 = Field::new("MaxTorque", Format::Rounded(4)).unit("N m / 5, or N").ut2004(Format::Rounded(2)),
        /// Least value.
        min: f32 = Field::new("MinRange", Format::Rounded(4)).unit("rad or m").ut2004(Format::Rounded(2)),
        /// Greatest value.
        max: f32 = Field::new("MaxRange", Format::Rounded(4)).unit("rad or m").ut2004(Format::Rounded(2)),
    }
}

record! {
    /// A gripper: what it takes.
    GripperConf {
        /// Name of the gripper.
        name: String = Field::new("Name", Format::Word).then(&[
            (["Opcode"; 2], ["Grip"; 2]),
            (["MaxVal"; 2], ["1"; 2]),
            (["MinVal"; 2], ["0"; 2]),
            (["Opcode"; 2], ["Close"; 2]),
            (["Opcode"; 2], ["Open"; 2]),
        ]),
    }
}

record! {
    /// A tool changer: the limits within which it takes a tool.
    ToolChangerConf {
        /// Name of the tool changer.
        name: String = Field::new("Name", Format::Word),
        /// Largest distance of a tool.
        position_tolerance: f32 = Field::new("PositionTolerance", Format::Rounded(4)).unit("m").tight(),
        /// Largest angle between its axes and the tool's.
        angle_tolerance: f32 = Field::new("AngleTolerance", Format::Rounded(4)).unit("rad").then(&[
            (["Opcode"; 2], ["Close"; 2]),
            (["Opcode"; 2], ["Open"; 2]),
        ]),
    }
}

macro_rules! items {
    ($($name:ident: $record:ident $($type_name:literal)*,)*) => {
        /// Configuration of one item, in the form of its type.
        #[derive(Debug, Clone, PartialEq)]
        #[expect(missing_docs, reason = "each variant is documented at its type")]
        pub enum ItemConf { $($name($record),)* }

        /// Tables of all forms.
        pub(crate) const TABLES: &[Table] = &[$($record::TABLE,)*];

        impl ItemConf {
            fn write(&self, dialect: Dialect) -> Vec<Written> {
                match self { $(Self::$name(item) => item.write(dialect),)* }
            }

            /// Reads an item; the type is in lower case.
            fn read(type_name: &str, item: &Line) -> Option<Self> {
                match type_name {
                    $($($type_name => $record::read(item).map(Self::$name),)*)*
                    _ => PlainConf::read(item).map(Self::Plain),
                }
            }
        }

        $(impl From<$record> for ItemConf {
            fn from(item: $record) -> Self { Self::$name(item) }
        })*
    };
}

items! {
    Plain: PlainConf,
    Pose: PoseConf "groundtruth" "ins" "gps",
    Wheels: WheelsConf "odometry" "tachometer",
    Encoder: EncoderConf "encoder",
    RangeScanner: RangeScannerConf "rangescanner" "irscanner",
    RangeScanner3D: RangeScanner3DConf "rangescanner3d",
    RangeImager: RangeImagerConf "rangeimager",
    LineLaser: LineLaserConf "linelaser",
    Ir: IrConf "ir",
    Sonar: SonarConf "sonar",
    Touch: TouchConf "touch",
    TouchArray: TouchArrayConf "toucharray",
    Camera: CameraConf "camera",
    Actuator: ActuatorConf "actuator",
    MisPkg: MisPkgConf "mispkg",
    Gripper: GripperConf "gripper",
    ToolChanger: ToolChangerConf "toolchanger",
}

impl Conf {
    pub(super) fn write(&self, dialect: Dialect) -> String {
        match self {
            Self::Robot(robot) => robot.write(dialect),
            Self::Items { type_name, items } => {
                let items: String = items.iter().map(|item| field::blocks(item.write(dialect))).collect();
                format!("CONF {{Type {type_name}}}{items}")
            }
        }
    }

    pub(super) fn read(line: &Line) -> Option<Self> {
        let first = line.blocks.first()?;
        if let Some(robot) = RobotConf::read(line) {
            return Some(Self::Robot(robot));
        }
        let type_name = first.value.to_ascii_lowercase();
        let items = split_items(line.blocks.get(1..)?);
        let items: Option<_> = items.iter().map(|item| ItemConf::read(&type_name, item)).collect();
        Some(Self::Items { type_name: first.value.clone(), items: items? })
    }
}

impl RobotConf {
    /// Writes the line. UDK has the name first, UT2004 the type.
    fn write(&self, dialect: Dialect) -> String {
        let mut blocks = vec![Written::new("Name", self.name.as_str()).ranked(dialect.of([0, 1]))];
        let type_name = |name| Written::new("Type", name).ranked(dialect.of([1, 0]));
        match &self.vehicle {
            VehicleConf::Ground(ground) => {
                blocks.push(type_name("GroundVehicle"));
                blocks.extend(ground.write(dialect).into_iter().map(|block| block.ranked(2)));
            }
            VehicleConf::Static => {
                let constants = [("SteeringType", "None"), ("Mass", "0")];
                blocks.push(type_name("StaticPlatform"));
                blocks.extend(constants.map(|(key, value)| Written::new(key, value).ranked(2)));
            }
            VehicleConf::Plain => {}
        }
        // USARSim leaves a space at the end (StaticPlatform.uc:30-33).
        let end = if self.vehicle == VehicleConf::Static { " " } else { "" };
        format!("CONF{}{end}", field::blocks(blocks))
    }

    /// Reads the line; `None` if it answers another question.
    fn read(line: &Line) -> Option<Self> {
        let vehicle = match line.get("Type") {
            Some("GroundVehicle") => VehicleConf::Ground(GroundConf::read(line)?),
            Some("StaticPlatform") => VehicleConf::Static,
            Some(_) => return None,
            None => VehicleConf::Plain,
        };
        Some(Self { name: line.get("Name")?.to_owned(), vehicle })
    }
}

/// Groups blocks by item: each starts with its `{Name ..}`.
pub(super) fn split_items(blocks: &[Block]) -> Vec<Line> {
    let mut items: Vec<Line> = Vec::new();
    for block in blocks {
        if block.key == "Name" || items.is_empty() {
            items.push(Line::default());
        }
        if let Some(item) = items.last_mut() {
            item.blocks.push(block.clone());
        }
    }
    items
}
