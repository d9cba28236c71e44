//! `CONF`: configuration of the robot or of its items (protocol.md 4.7).

use super::{boolean, number, read_boolean};
use crate::number::{engine_float, fixed};
use crate::{Block, Line};

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
    /// What its kind of robot adds.
    pub vehicle: VehicleConf,
}

/// What a kind of robot adds to its configuration.
#[derive(Debug, Clone, PartialEq)]
pub enum VehicleConf {
    /// On wheels.
    Ground {
        /// `SkidSteered`, `AckermanSteered` or `OmniDrive`.
        steering_type: String,
        /// Mass of all parts, kg.
        mass: f32,
        /// Smallest speed limit of the wheels, rad/s.
        max_speed: f32,
        /// Smallest torque limit of the wheels in USARSim's unit (5 to 1 N m).
        max_torque: f32,
        /// Range of the steering angles of front and rear, rad; literally 0 where a robot does not steer so.
        max_steer: Option<[f32; 2]>,
    },
    /// Fixed to the ground.
    Static,
    /// In the air or on legs, which add nothing.
    Plain,
}

/// Configuration of one item, by the form that its type has.
#[derive(Debug, Clone, PartialEq)]
#[expect(missing_docs, reason = "the fields are named after the keys")]
pub enum ItemConf {
    /// Items of which only the name is known.
    Plain { name: String },
    /// GroundTruth, INS, Odometry, Tachometer: seconds between two readings.
    Timed { name: String, scan_interval: f32 },
    /// Angle of one tick, rad.
    Encoder { name: String, resolution: f32 },
    /// Ranges in metres, angles in radians.
    RangeScanner {
        name: String,
        max_range: f32,
        min_range: f32,
        resolution: f32,
        fov: f32,
        panning: bool,
        tilting: bool,
    },
    /// Ranges in metres, seconds, radians.
    Sonar {
        name: String,
        max_range: f32,
        min_range: f32,
        scan_interval: f32,
        beam_angle: f32,
        max_angle_of_incidence: f32,
        traces_per_cone: u32,
        number_of_cones: u32,
    },
    /// The joints of an actuator, by the form of `{Type Actuator}`.
    Actuator { name: String, joints: Vec<JointConf> },
    /// The same by that of `{Type MisPkg}`.
    MisPkg { name: String, joints: Vec<JointConf> },
    /// A gripper: what it takes.
    Gripper { name: String },
    /// Place in the picture in pixels, angles in degrees.
    Camera {
        name: String,
        offset: [i32; 2],
        resolution: [i32; 2],
        default_fov: f32,
        min_fov: f32,
        max_fov: f32,
        fov: f32,
    },
}

/// A joint of an actuator.
#[derive(Debug, Clone, PartialEq)]
pub struct JointConf {
    /// `Revolute`, `Prismatic` or `Unknown`.
    pub kind: String,
    /// Torque limit in USARSim's unit (5 to 1 N m), or force limit, N.
    pub max_torque: f32,
    /// Least value, rad or m.
    pub min: f32,
    /// Greatest value, rad or m.
    pub max: f32,
}

/// What MisPkg says of every joint's speed, rad/s (Actuator.uc:355-382).
const MISPKG_SPEED: &str = "1.571";

impl Conf {
    pub(super) fn write(&self) -> String {
        match self {
            Self::Robot(robot) => robot.write(),
            Self::Items { type_name, items } => {
                let items: String = items.iter().map(|item| format!(" {}", item.write())).collect();
                format!("CONF {{Type {type_name}}}{items}")
            }
        }
    }

    pub(super) fn read(line: &Line) -> Option<Self> {
        let first = line.blocks.first()?;
        if first.key == "Name" {
            return RobotConf::read(line).map(Self::Robot);
        }
        let items: Option<_> =
            split_items(line.blocks.get(1..)?).iter().map(|item| ItemConf::read(&first.value, item)).collect();
        Some(Self::Items { type_name: first.value.clone(), items: items? })
    }
}

impl RobotConf {
    fn write(&self) -> String {
        let name = &self.name;
        match &self.vehicle {
            VehicleConf::Ground { steering_type, mass, max_speed, max_torque, max_steer } => {
                let literal = || ["0"; 2].map(str::to_owned);
                let [front, rear] = max_steer.map_or_else(literal, |it| it.map(|it| fixed(it, 4)));
                let [mass, speed, torque] = [mass, max_speed, max_torque].map(|number| fixed(*number, 4));
                format!(
                    "CONF {{Name {name}}} {{Type GroundVehicle}} {{SteeringType {steering_type}}} {{Mass {mass}}} \
                     {{MaxSpeed {speed}}} {{MaxTorque {torque}}} {{MaxFrontSteer {front}}} {{MaxRearSteer {rear}}}"
                )
            }
            // With the space that USARSim leaves at its end (StaticPlatform.uc:30-33).
            VehicleConf::Static => {
                format!("CONF {{Name {name}}} {{Type StaticPlatform}} {{SteeringType None}} {{Mass 0}} ")
            }
            VehicleConf::Plain => format!("CONF {{Name {name}}}"),
        }
    }

    fn read(line: &Line) -> Option<Self> {
        let vehicle = match line.get("Type") {
            Some("GroundVehicle") => VehicleConf::Ground {
                steering_type: line.get("SteeringType")?.to_owned(),
                mass: number(line, "Mass")?,
                max_speed: number(line, "MaxSpeed")?,
                max_torque: number(line, "MaxTorque")?,
                max_steer: match line.get("MaxFrontSteer") {
                    Some("0") => None,
                    _ => Some([number(line, "MaxFrontSteer")?, number(line, "MaxRearSteer")?]),
                },
            },
            Some("StaticPlatform") => VehicleConf::Static,
            Some(_) => return None,
            None => VehicleConf::Plain,
        };
        Some(Self { name: line.get("Name")?.to_owned(), vehicle })
    }
}

impl ItemConf {
    fn write(&self) -> String {
        match self {
            Self::Plain { name } => format!("{{Name {name}}}"),
            Self::Timed { name, scan_interval } => {
                format!("{{Name {name}}} {{ScanInterval {}}}", engine_float(*scan_interval))
            }
            Self::Encoder { name, resolution } => format!("{{Name {name}}} {{Resolution {}}}", fixed(*resolution, 4)),
            Self::RangeScanner { name, max_range, min_range, resolution, fov, panning, tilting } => format!(
                "{{Name {name}}} {{MaxRange {}}} {{MinRange {}}} {{Resolution {}}} {{Fov {}}} {{Panning {}}} {{Tilting {}}}",
                fixed(*max_range, 4),
                fixed(*min_range, 4),
                fixed(*resolution, 4),
                fixed(*fov, 4),
                boolean(*panning),
                boolean(*tilting),
            ),
            Self::Sonar {
                name,
                max_range,
                min_range,
                scan_interval,
                beam_angle,
                max_angle_of_incidence,
                traces_per_cone,
                number_of_cones,
            } => format!(
                "{{Name {name}}} {{MaxRange {}}} {{MinRange {}}} {{ScanInterval {}}} {{beamAngle {}}} \
                 {{maxAngleOfIncidence {}}} {{tracesPerCone {traces_per_cone}}} {{numberOfCones {number_of_cones}}}",
                fixed(*max_range, 4),
                fixed(*min_range, 4),
                fixed(*scan_interval, 4),
                fixed(*beam_angle, 4),
                fixed(*max_angle_of_incidence, 4),
            ),
            Self::Actuator { name, joints } => {
                let joint = |(number, it): (usize, &JointConf)| {
                    let [torque, min, max] = [it.max_torque, it.min, it.max].map(engine_float);
                    let (number, kind) = (number + 1, &it.kind);
                    format!(
                        " {{Link {number}}} {{JointType {kind}}} {{MaxTorque {torque}}} {{MinValue {min}}} {{MaxValue {max}}}"
                    )
                };
                format!("{{Name {name}}}{}", joints.iter().enumerate().map(joint).collect::<String>())
            }
            Self::MisPkg { name, joints } => {
                let joint = |(number, it): (usize, &JointConf)| {
                    let [torque, min, max] = [it.max_torque, it.min, it.max].map(engine_float);
                    let (number, kind) = (number + 1, &it.kind);
                    format!(
                        " {{Link {number}}} {{JointType {kind}}} {{MaxRotationSpeed {MISPKG_SPEED}}} {{MaxTorque {torque}}} \
                         {{MinRange {min}}} {{MaxRange {max}}}"
                    )
                };
                format!("{{Name {name}}}{}", joints.iter().enumerate().map(joint).collect::<String>())
            }
            Self::Gripper { name } => {
                format!("{{Name {name}}} {{Opcode Grip}} {{MaxVal 1}} {{MinVal 0}} {{Opcode Close}} {{Opcode Open}}")
            }
            Self::Camera { name, offset, resolution, default_fov, min_fov, max_fov, fov } => format!(
                "{{Name {name}}}{{TextureOffsetX {}}}{{TextureOffsetY {}}}{{TextureResolutionX {}}}{{TextureResolutionY {}}}\
                 {{CameraDefFov {}}}{{CameraMinFov {}}}{{CameraMaxFov {}}}{{CameraFov {}}}",
                offset[0],
                offset[1],
                resolution[0],
                resolution[1],
                engine_float(*default_fov),
                engine_float(*min_fov),
                engine_float(*max_fov),
                engine_float(*fov),
            ),
        }
    }

    fn read(type_name: &str, item: &Line) -> Option<Self> {
        let name = item.get("Name")?.to_owned();
        Some(match type_name.to_ascii_lowercase().as_str() {
            "groundtruth" | "ins" | "odometry" | "tachometer" => {
                Self::Timed { name, scan_interval: number(item, "ScanInterval")? }
            }
            "encoder" => Self::Encoder { name, resolution: number(item, "Resolution")? },
            "rangescanner" => Self::RangeScanner {
                name,
                max_range: number(item, "MaxRange")?,
                min_range: number(item, "MinRange")?,
                resolution: number(item, "Resolution")?,
                fov: number(item, "Fov")?,
                panning: read_boolean(item, "Panning")?,
                tilting: read_boolean(item, "Tilting")?,
            },
            "sonar" => Self::Sonar {
                name,
                max_range: number(item, "MaxRange")?,
                min_range: number(item, "MinRange")?,
                scan_interval: number(item, "ScanInterval")?,
                beam_angle: number(item, "beamAngle")?,
                max_angle_of_incidence: number(item, "maxAngleOfIncidence")?,
                traces_per_cone: number(item, "tracesPerCone")?,
                number_of_cones: number(item, "numberOfCones")?,
            },
            "camera" => Self::Camera {
                name,
                offset: [number(item, "TextureOffsetX")?, number(item, "TextureOffsetY")?],
                resolution: [number(item, "TextureResolutionX")?, number(item, "TextureResolutionY")?],
                default_fov: number(item, "CameraDefFov")?,
                min_fov: number(item, "CameraMinFov")?,
                max_fov: number(item, "CameraMaxFov")?,
                fov: number(item, "CameraFov")?,
            },
            "actuator" => Self::Actuator { name, joints: joints(item, ["MinValue", "MaxValue"])? },
            "mispkg" => Self::MisPkg { name, joints: joints(item, ["MinRange", "MaxRange"])? },
            "gripper" => Self::Gripper { name },
            _ => Self::Plain { name },
        })
    }
}

/// The joints of an actuator; the keys of their ends differ.
fn joints(item: &Line, [min, max]: [&str; 2]) -> Option<Vec<JointConf>> {
    let joint = |line: Line| {
        Some(JointConf {
            kind: line.get("JointType")?.to_owned(),
            max_torque: number(&line, "MaxTorque")?,
            min: number(&line, min)?,
            max: number(&line, max)?,
        })
    };
    split_links(item).map(joint).collect()
}

/// The joints of an actuator: each starts with its `{Link ..}`.
pub(super) fn split_links(item: &Line) -> impl Iterator<Item = Line> {
    let runs = item.blocks.chunk_by(|_, next| next.key != "Link");
    let runs = runs.filter(|run| run.first().is_some_and(|first| first.key == "Link"));
    runs.map(|blocks| Line { blocks: blocks.to_vec(), ..Line::default() })
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
