//! Classes of robots.

use nalgebra::{Translation3, Vector3};
use serde::{Deserialize, Serialize};

use crate::{
    Actuator, Drivetrain, Footing, Gripper, JointState, Link, Motor, MountedWheel, Part, Pose, SensorDef, Solid,
    ToolChanger, Vacuum, Wheel, pose, stored,
};

/// Steering of a robot: the keys of its commands, and its part of STA. What moves it is in its links and its footing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Steering {
    /// Left and right wheels turn by side.
    Skid,
    /// Four Mecanum wheels, in the order front left, front right, back left, back right.
    Omni,
    /// Wheels steered by joints with FRONTSTEER or REARSTEER in their names.
    Ackermann,
    /// Flight.
    Aerial,
    /// Joints alone.
    Legged,
    /// No steering: the robot is fixed to the ground.
    None,
}

impl Steering {
    /// All kinds of steering, with their names in robot.toml.
    pub const ALL: [(&str, Self); 6] = [
        ("skid", Self::Skid),
        ("omni", Self::Omni),
        ("ackermann", Self::Ackermann),
        ("aerial", Self::Aerial),
        ("legged", Self::Legged),
        ("none", Self::None),
    ];

    /// True if wheels on the ground move the robot.
    pub fn is_on_wheels(self) -> bool {
        matches!(self, Self::Skid | Self::Omni | Self::Ackermann)
    }

    /// Returns the word in `{SteeringType ..}` of CONF, as clients know it.
    pub fn wire_name(self) -> &'static str {
        match self {
            Self::Skid => "SkidSteered",
            Self::Omni => "OmniDrive",
            Self::Ackermann => "AckermanSteered",
            Self::Aerial => "Aerial",
            Self::Legged => "Legged",
            Self::None => "None",
        }
    }
}

/// Model of a robot's motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum DriveModel {
    /// Chassis, wheels and rollers are bodies of the engine with Coulomb contacts: an independent reference.
    Bodies,
    /// Like `Bodies`, but rollers have no inertia and carry force only along their axes.
    Analytic,
    /// A tree of links in reduced coordinates. Servos, contacts and friction are solved together to convergence. Rollers are links.
    #[default]
    Articulated,
    /// The base follows the twist of its wheel commands while it stands on something. The twist accounts for finite rollers.
    Kinematic,
    /// Like `Kinematic`, with the textbook's matrix.
    KinematicTextbook,
}

impl DriveModel {
    /// All drive models, with their names in robot.toml and on the command line.
    pub const ALL: [(&str, Self); 5] = [
        ("bodies", Self::Bodies),
        ("analytic", Self::Analytic),
        ("articulated", Self::Articulated),
        ("kinematic", Self::Kinematic),
        ("kinematic-textbook", Self::KinematicTextbook),
    ];

    /// Returns its name in robot.toml and on the command line.
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].0
    }
}

impl std::str::FromStr for DriveModel {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let known = Self::ALL.iter().find(|(known, _)| *known == name);
        known.map(|&(_, model)| model).ok_or_else(|| {
            let names = Self::ALL.map(|(name, _)| name).join(", ");
            format!("unknown drive model `{name}`: expected one of {names}")
        })
    }
}

/// Side of a wheel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Side {
    /// Driven by `{Left ..}`.
    Left,
    /// Driven by `{Right ..}`.
    Right,
}

/// A class of robots.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(from = "stored::Robot")]
pub struct RobotDef {
    /// Class name as in `USARBot.<class>`; the name of its folder.
    pub class: String,
    /// Description in one sentence.
    pub description: String,
    /// Steering.
    pub steering: Steering,
    /// Steering type that CONF reports instead of the real one. The NIST bridge and the Player drivers refuse OmniDrive, but drive
    /// a Mecanum robot well if it reports SkidSteered.
    pub reported_steering: Option<String>,
    /// Drive model.
    pub drive_model: DriveModel,
    /// True if `{Left ..}` or `{Right ..}` alone moves its side. USARSim (UDK) wants both; controllers of UT2004's robots send one.
    pub one_side_drives: bool,
    /// True if only USARSim for UT2004 had this class. The server then speaks that dialect to its clients.
    pub speaks_ut2004: bool,
    /// Tree of links: parents before their children, so the first is the root. Driven wheels come before casters, in the order of
    /// encoders and tachometers.
    pub links: Vec<Link>,
    /// Sensors, in mounting order.
    pub sensors: Vec<SensorDef>,
    /// Actuators.
    pub actuators: Vec<Actuator>,
    /// Grippers.
    pub grippers: Vec<Gripper>,
    /// Tool changers.
    pub tool_changers: Vec<ToolChanger>,
    /// Vacuums.
    pub vacuums: Vec<Vacuum>,
    /// Battery; without one STA reports 99999.
    pub battery: Option<Battery>,
    /// Torque limit of the wheels as CONF reports it, USARSim's unit (5 = 1 N m).
    pub reported_max_torque: f64,
    /// Support of its root.
    pub footing: Footing,
    /// Assumptions where its file gives no value.
    pub assumptions: Vec<String>,
}

impl RobotDef {
    /// Creates a class of robots without sensors, actuators and a battery. Its footing is that of its steering, without flight.
    pub fn new(class: &str, steering: Steering, links: Vec<Link>) -> Self {
        Self {
            class: class.to_owned(),
            description: String::new(),
            steering,
            reported_steering: None,
            drive_model: DriveModel::default(),
            one_side_drives: false,
            speaks_ut2004: false,
            links,
            sensors: Vec::new(),
            actuators: Vec::new(),
            grippers: Vec::new(),
            tool_changers: Vec::new(),
            vacuums: Vec::new(),
            battery: None,
            reported_max_torque: 50000.0,
            footing: Footing::of(steering, None),
            assumptions: Vec::new(),
        }
    }

    /// Sets the drive model if one is given and it can move the robot.
    pub fn set_drive_model(&mut self, model: Option<DriveModel>) {
        if let Some(model) = model.filter(|&model| self.can_have(model)) {
            self.drive_model = model;
        }
    }

    /// True if a drive model can move the robot. The models of rollers need Mecanum wheels, and `bodies` has no belts.
    pub fn can_have(&self, model: DriveModel) -> bool {
        match model {
            DriveModel::Articulated => true,
            DriveModel::Bodies => self.wheels().all(|wheel| wheel.belt.is_none()),
            DriveModel::Analytic | DriveModel::Kinematic | DriveModel::KinematicTextbook => {
                self.drivetrain() == Drivetrain::Mecanum
            }
        }
    }

    /// Returns the `{SteeringType ..}` of CONF.
    pub fn reported_steering(&self) -> &str {
        self.reported_steering.as_deref().unwrap_or(self.steering.wire_name())
    }

    /// Returns the shapes of the root link.
    pub fn body_solids(&self) -> &[Solid] {
        self.links.first().map_or(&[], |root| &root.solids)
    }

    /// Returns the damping of the body's velocity, N s/m, and angular velocity, N m s/rad, from the material of its first shape.
    pub fn body_damping(&self) -> [f64; 2] {
        let body = self.body_mass();
        let solid = self.body_solids().first();
        solid.map_or([0.0; 2], |solid| solid.material.damping(body.mass, &body.inertia))
    }

    /// Returns all wheels, casters included, in the order of the links.
    pub fn wheels(&self) -> impl Iterator<Item = MountedWheel<'_>> + Clone {
        self.links.iter().enumerate().filter_map(MountedWheel::of)
    }

    /// Returns the driven wheels.
    pub fn driven(&self) -> impl Iterator<Item = MountedWheel<'_>> + Clone {
        self.wheels().filter(|wheel| wheel.drive.is_some())
    }

    /// Returns the number of a wheel among the driven wheels, from its number among all. `None` for a free one.
    pub fn driven_number(&self, wheel: usize) -> Option<usize> {
        let mut wheels = self.wheels().take(wheel + 1);
        let before = wheels.by_ref().take(wheel).filter(|it| it.drive.is_some()).count();
        wheels.next().filter(|it| it.drive.is_some()).map(|_| before)
    }

    /// True if the robot has joints other than those of wheels.
    pub fn has_joints(&self) -> bool {
        self.links.iter().any(|link| link.joint.is_some() && link.wheel.is_none())
    }

    /// Returns all links with their poses in the robot frame at the given joint positions. Missing positions are 0.
    pub fn placed_links(&self, joints: &[JointState]) -> Vec<(&Link, Pose)> {
        let mut values = joints.iter().map(|joint| joint.position);
        let mut placed: Vec<(&Link, Pose)> = Vec::with_capacity(self.links.len());
        for link in &self.links {
            let pose = link.joint.as_ref().map_or_else(Pose::identity, |joint| {
                let value = if joint.kind.has_value() { values.next().unwrap_or(0.0) } else { 0.0 };
                let (from, parent) =
                    placed.get(joint.parent).map_or_else(Default::default, |(parent, pose)| (parent.origin(), *pose));
                let offset = Vector3::from(joint.anchor) - Vector3::from(from);
                parent * Translation3::from(offset) * joint.motion(value)
            });
            placed.push((link, pose));
        }
        placed
    }

    /// Returns the number of the link that carries a sensor, the link, and the sensor's pose in the link's frame.
    pub fn mount_of(&self, sensor: &SensorDef) -> Option<(usize, &Link, Pose)> {
        let link = self.links.get(sensor.link)?;
        let to_link = Translation3::from(link.origin()).inverse();
        Some((sensor.link, link, to_link * pose(sensor.position, sensor.direction)))
    }

    /// Returns the index of a link's joint among the joints that have a value.
    pub fn value_of(&self, link: usize) -> Option<usize> {
        self.links.get(link).filter(|link| link.has_value())?;
        Some(self.links.iter().take(link).filter(|link| link.has_value()).count())
    }

    /// Returns the link that a link's joint hangs on; `None` for the root.
    pub fn parent_of(&self, link: usize) -> Option<usize> {
        Some(self.links.get(link)?.joint.as_ref()?.parent)
    }

    /// Returns the actuator that moves a link, and the number of its joint there, from 1.
    pub fn actuator_of(&self, link: usize) -> Option<(&Actuator, usize)> {
        self.actuators.iter().find_map(|it| Some((it, it.links.iter().position(|&other| other == link)? + 1)))
    }

    /// Returns the limits of the joints that steer an axle, 0 the front and 1 the rear, rad.
    pub fn steering_limits(&self, axle: usize) -> impl Iterator<Item = [f64; 2]> {
        let joints = self.links.iter().filter(move |link| link.steered_axle() == Some(axle));
        joints.filter_map(|link| link.joint.as_ref()?.limits)
    }

    /// Returns the names of the sensors. A name that comes again has a number behind it: `Scanner`, `Scanner#2`.
    pub fn sensor_labels(&self) -> Vec<String> {
        let names: Vec<&str> = self.sensors.iter().map(|sensor| sensor.name.as_str()).collect();
        let label = |(number, name): (usize, &&str)| {
            let before = names[..number].iter().filter(|other| other.eq_ignore_ascii_case(name)).count();
            if before == 0 { (*name).to_owned() } else { format!("{name}#{}", before + 1) }
        };
        names.iter().enumerate().map(label).collect()
    }

    /// Returns the links whose joints have a value, in the order of a state's joints.
    pub fn with_values(&self) -> impl Iterator<Item = &Link> + Clone {
        self.links.iter().filter(|link| link.has_value())
    }

    /// Returns the joints of flippers and the like, with their numbers among the values: those of no wheel, steering, actuator or gripper.
    pub fn flippers(&self) -> impl Iterator<Item = (usize, &Link)> {
        let has_owner = |link: usize| {
            self.actuator_of(link).is_some() || self.grippers.iter().any(|gripper| gripper.links.contains(&link))
        };
        let joints = self.links.iter().enumerate().filter(move |(number, link)| {
            link.wheel.is_none()
                && link.position_limits().is_some()
                && link.steered_axle().is_none()
                && !has_owner(*number)
        });
        joints.filter_map(|(number, link)| Some((self.value_of(number)?, link)))
    }

    /// Returns the parts of all links, without wheels.
    pub fn parts(&self) -> impl Iterator<Item = &Part> + Clone {
        self.links.iter().flat_map(|link| &link.parts)
    }

    /// Returns the parts of all links for modification.
    pub fn parts_mut(&mut self) -> impl Iterator<Item = &mut Part> {
        self.links.iter_mut().flat_map(|link| &mut link.parts)
    }

    /// Returns the wheels for modification.
    pub fn wheels_mut(&mut self) -> impl Iterator<Item = &mut Wheel> {
        self.links.iter_mut().filter_map(|link| link.wheel.as_mut())
    }

    /// Returns the motors of all joints for modification.
    pub fn motors_mut(&mut self) -> impl Iterator<Item = &mut Motor> {
        self.links.iter_mut().filter_map(|link| link.joint.as_mut()?.drive.as_mut())
    }

    /// Sums the masses of every part, wheel and roller in kg, in 32 bits in the order of the links, as USARSim reports it.
    pub fn mass(&self) -> f32 {
        let of_wheel = |wheel: &Wheel| {
            let (mass, count) = wheel.rollers.as_ref().map_or((0.0, 0), |it| (it.mass, it.count as usize));
            std::iter::once(wheel.mass).chain(std::iter::repeat_n(mass, count))
        };
        let masses = self
            .links
            .iter()
            .flat_map(|link| link.parts.iter().map(|part| part.mass).chain(link.wheel.iter().flat_map(of_wheel)));
        masses.fold(0.0, |sum, mass| sum + mass as f32)
    }

    /// Returns the wheel radius, track and wheel base, m, from the foremost left and the rearmost right driven wheel
    /// (WheeledVehicle.uc:19-66).
    pub fn wheel_geometry(&self) -> WheelGeometry {
        let on = |side| self.driven().filter(move |wheel| wheel.side == side);
        let front_left = on(Side::Left).max_by(|a, b| a.position[0].total_cmp(&b.position[0]));
        let rear_right = on(Side::Right).min_by(|a, b| a.position[0].total_cmp(&b.position[0]));
        match (front_left, rear_right) {
            (Some(left), Some(right)) => WheelGeometry {
                radius: left.radius,
                track: right.position[1] - left.position[1],
                wheel_base: left.position[0] - right.position[0],
            },
            _ => WheelGeometry::default(),
        }
    }
}

/// Dimensions of a base for odometry and clients, m.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WheelGeometry {
    /// Radius of the wheels.
    pub radius: f64,
    /// Distance between left and right wheels.
    pub track: f64,
    /// Distance between front and rear wheels.
    pub wheel_base: f64,
}

/// A battery with a linear discharge, independent of what the robot does (Battery.uc:44-129).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Battery {
    /// Energy at the start, J.
    pub max_energy: f64,
    /// Time from full to empty, s.
    pub life: f64,
}
