//! What a world is made of: plain data in SI units, in the world frame (x forward, y right, z down).
//!
//! The crate `scene-loader` makes these from files; nothing here reads anything. Written as JSON, as in a log, they read back
//! with the same bits.

pub mod check;

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use crate::sensor;

/// Position and orientation.
pub type Pose = Isometry3<f64>;

/// A pose from a position in metres and roll, pitch, yaw in radians (yaw first, then pitch, then roll).
pub fn pose(position: [f64; 3], [roll, pitch, yaw]: [f64; 3]) -> Pose {
    Pose::from_parts(Translation3::from(position), UnitQuaternion::from_euler_angles(roll, pitch, yaw))
}

/// Position in metres and roll, pitch, yaw in radians of a pose; the inverse of [`pose`].
pub fn position_and_rotation(pose: &Pose) -> ([f64; 3], [f64; 3]) {
    let (roll, pitch, yaw) = pose.rotation.euler_angles();
    (pose.translation.vector.into(), [roll, pitch, yaw])
}

/// A physical material.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Material {
    /// Its name in `materials.toml`.
    pub name: String,
    /// Coulomb friction, one number for static and sliding.
    pub friction: f64,
    /// Restitution, 0 to 1.
    pub restitution: f64,
    /// Rolling resistance: force against the motion of a wheel's hub over its load; a pair has the sum of both.
    pub rolling_resistance: f64,
    /// Damping of the linear velocity of a body made of it, 1/s.
    pub linear_damping: f64,
    /// Damping of its angular velocity, 1/s.
    pub angular_damping: f64,
    /// Red, green and blue in which it is shown, 0 to 1. A scene written before there were colours reads as black.
    #[serde(default)]
    pub colour: [f64; 3],
    /// Where the numbers come from.
    pub source: String,
}

impl Material {
    /// Friction and restitution between two materials: the mean of each, PhysX's rule and rapier's default.
    ///
    /// So the thesis's roller (0.9) on Unreal's default material (0.7) has 0.8.
    pub fn pair(&self, other: &Self) -> (f64, f64) {
        ((self.friction + other.friction) / 2.0, (self.restitution + other.restitution) / 2.0)
    }
}

/// Geometry of a solid, in its own frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Shape {
    /// Everything on the far side of the plane z = 0: up (negative z) is free.
    HalfSpace,
    /// A box around the origin, by its edge lengths, m.
    Box {
        /// Edge lengths along x, y, z.
        size: [f64; 3],
    },
    /// A cylinder around the z axis, centred on the origin, m.
    Cylinder {
        /// Radius.
        radius: f64,
        /// Length along z.
        length: f64,
    },
    /// A ball around the origin, m.
    Ball {
        /// Radius.
        radius: f64,
    },
    /// The convex hull of points, m.
    Hull {
        /// At least four points that are not in one plane.
        points: Vec<[f64; 3]>,
    },
    /// A surface of triangles, m.
    Mesh {
        /// Corners.
        vertices: Vec<[f64; 3]>,
        /// Indices of three corners each.
        triangles: Vec<[u32; 3]>,
    },
}

/// A shape at a place, of a material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Solid {
    /// Its name, for messages and viewers.
    pub name: String,
    /// Geometry.
    pub shape: Shape,
    /// Position in the frame of the map or of the robot, m.
    pub position: [f64; 3],
    /// Roll, pitch, yaw, rad.
    pub rotation: [f64; 3],
    /// What its surface is made of.
    pub material: Material,
}

impl Solid {
    /// Its place.
    pub fn pose(&self) -> Pose {
        pose(self.position, self.rotation)
    }
}

/// A solid of a map that moves when it is pushed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Object {
    /// Shape, first place and surface.
    pub solid: Solid,
    /// Mass, kg, evenly spread.
    pub mass: f64,
}

/// A named place of a map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NamedPose {
    /// Name without white space or braces.
    pub name: String,
    /// Position, m.
    pub position: [f64; 3],
    /// Roll, pitch, yaw, rad.
    pub rotation: [f64; 3],
}

/// A map: what stands and lies on it, and where robots start.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct MapDef {
    /// Name, sent as `{Level ..}`.
    pub name: String,
    /// One sentence.
    pub description: String,
    /// Gravity, m/s², along +z.
    pub gravity: f64,
    /// Time limit sent in the greeting, minutes; nothing ends by it.
    pub time_limit: u32,
    /// What does not move.
    pub solids: Vec<Solid>,
    /// What can be pushed.
    pub objects: Vec<Object>,
    /// Start poses, in the order of the file.
    pub starts: Vec<NamedPose>,
    /// Path nodes, in the order of the file.
    pub path_nodes: Vec<NamedPose>,
}

/// How a robot is steered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Steering {
    /// Left and right wheels turn by side.
    Skid,
    /// Four Mecanum wheels, in the order front left, front right, back left, back right.
    Omni,
}

impl Steering {
    /// The word in `{SteeringType ..}` of CONF, as clients know it.
    pub fn wire_name(self) -> &'static str {
        match self {
            Self::Skid => "SkidSteered",
            Self::Omni => "OmniDrive",
        }
    }
}

/// How the wheels of a Mecanum robot move it. Other robots are always made of bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum DriveModel {
    /// Chassis, wheels and rollers are bodies of the engine, their contacts Coulomb's: the reference.
    #[default]
    Bodies,
    /// One body; rollers without inertia whose forces are found in closed form for all wheels together.
    Analytic,
    /// The base follows the twist of its wheels' commands, counted with finite rollers, as long as it stands on something.
    Kinematic,
    /// The same by the textbook's matrix.
    KinematicTextbook,
}

impl DriveModel {
    /// All of them, with their names in robot.toml and on the command line.
    pub const ALL: [(&str, Self); 4] = [
        ("bodies", Self::Bodies),
        ("analytic", Self::Analytic),
        ("kinematic", Self::Kinematic),
        ("kinematic-textbook", Self::KinematicTextbook),
    ];

    /// Its name.
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

/// The side of a wheel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Side {
    /// Driven by `{Left ..}`.
    Left,
    /// Driven by `{Right ..}`.
    Right,
}

/// A class of robots.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RobotDef {
    /// Class name as in `USARBot.<class>`; the name of its folder.
    pub class: String,
    /// One sentence.
    pub description: String,
    /// How it is steered.
    pub steering: Steering,
    /// What CONF reports instead of the way it is steered: the NIST bridge and the Player drivers refuse OmniDrive, and drive
    /// a Mecanum robot well that says SkidSteered.
    #[serde(default)]
    pub reported_steering: Option<String>,
    /// How its wheels move it.
    pub drive_model: DriveModel,
    /// Whether `{Left ..}` or `{Right ..}` alone moves its side. USARSim (UDK) wants both; controllers of UT2004's
    /// robots send one.
    pub one_side_drives: bool,
    /// Parts that make up the body, all fixed to each other.
    pub parts: Vec<Part>,
    /// Shapes of the body that touch the world, in the robot frame.
    pub solids: Vec<Solid>,
    /// Driven wheels first, in the order that encoders and tachometers number them, then casters.
    pub wheels: Vec<Wheel>,
    /// What it carries, in mounting order.
    pub sensors: Vec<SensorDef>,
    /// Its battery; without one STA reports 99999.
    pub battery: Option<Battery>,
    /// Torque limit of the wheels as CONF reports it, USARSim's unit (5 = 1 N m).
    pub reported_max_torque: f64,
}

impl RobotDef {
    /// Takes another drive model, where one is given and the robot has Mecanum wheels; others are always made of bodies.
    pub fn set_drive_model(&mut self, model: Option<DriveModel>) {
        if let Some(model) = model.filter(|_| self.steering == Steering::Omni) {
            self.drive_model = model;
        }
    }

    /// `{SteeringType ..}` of CONF.
    pub fn reported_steering(&self) -> &str {
        self.reported_steering.as_deref().unwrap_or(self.steering.wire_name())
    }

    /// The driven wheels.
    pub fn driven(&self) -> &[Wheel] {
        let driven = self.wheels.iter().take_while(|wheel| wheel.drive.is_some()).count();
        &self.wheels[..driven]
    }

    /// Mass of every part, wheel and roller in kg, summed in 32 bits in file order, as USARSim reports it.
    pub fn mass(&self) -> f32 {
        let rollers = |wheel: &Wheel| wheel.rollers.as_ref().map_or((0.0, 0), |r| (r.mass, r.count as usize));
        let wheels = self.wheels.iter().flat_map(|wheel| {
            let (mass, count) = rollers(wheel);
            std::iter::once(wheel.mass).chain(std::iter::repeat_n(mass, count))
        });
        self.parts.iter().map(|part| part.mass).chain(wheels).fold(0.0, |sum, mass| sum + mass as f32)
    }

    /// Wheel radius, track and wheel base, m: of the foremost left and the rearmost right driven wheel
    /// (WheeledVehicle.uc:19-66).
    pub fn wheel_geometry(&self) -> WheelGeometry {
        let on = |side| self.driven().iter().filter(move |wheel| wheel.side == side);
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

/// The numbers of a base that odometry and clients use, m.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WheelGeometry {
    /// Radius of the wheels.
    pub radius: f64,
    /// Distance between left and right wheels.
    pub track: f64,
    /// Distance between front and rear wheels.
    pub wheel_base: f64,
}

/// One part of the body: what it weighs and where.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Its name.
    pub name: String,
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass in the robot frame, m.
    pub centre: Vector3<f64>,
    /// Inertia about the centre of mass, robot axes, kg m².
    pub inertia: Matrix3<f64>,
}

/// A wheel about the robot's y axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Wheel {
    /// Its name.
    pub name: String,
    /// Which side it is on.
    pub side: Side,
    /// Centre in the robot frame, m.
    pub position: [f64; 3],
    /// Outer radius, m.
    pub radius: f64,
    /// Width along its axle, m.
    pub width: f64,
    /// Mass without rollers, kg.
    pub mass: f64,
    /// What its tread is made of.
    pub material: Material,
    /// Its motor; `None` makes it a caster, a ball free to turn about every axis.
    pub drive: Option<Motor>,
    /// Rollers of a Mecanum wheel.
    pub rollers: Option<Rollers>,
}

impl Wheel {
    /// How many rollers it has.
    pub fn roller_count(&self) -> usize {
        self.rollers.as_ref().map_or(0, |rollers| rollers.count as usize)
    }

    /// Pose of the wheel in the robot frame after it turned forward by an angle in radians.
    pub fn pose(&self, angle: f64) -> Pose {
        pose(self.position, [0.0, -angle, 0.0])
    }
}

/// A velocity servo: torque = gain x (target - actual), limited.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Motor {
    /// Speed limit, rad/s.
    pub max_speed: f64,
    /// Servo gain, N m s/rad.
    pub gain: f64,
    /// Torque limit, N m.
    pub max_torque: f64,
    /// Time constant of integral action, s; without it the speed droops under a load by torque over gain.
    pub integral_time: Option<f64>,
    /// Inertia of the rotor as felt at the wheel, kg m². The engine's sliding friction leans toward the direction
    /// in which a contact is heavier; on a skid robot, whose wheels slide sideways in every turn, this has to be
    /// of the order of (mass / 4) radius², or the robot hardly turns.
    pub armature: f64,
}

/// The free rollers of a Mecanum wheel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Rollers {
    /// How many.
    pub count: u32,
    /// Distance of a roller's axis from the wheel's axis, m.
    pub axis_circle: f64,
    /// Angle between the two axes, rad; positive where the roller at the ground points forward-right.
    pub angle: f64,
    /// How far past the front of the wheel, downward, the first roller sits when the wheel's angle is 0, rad.
    pub first_roller: f64,
    /// Phase of the contact at the end of a roller, rad: pi / count hands over to the next roller without a gap or an
    /// overlap, more makes longer rollers.
    pub last_phase: f64,
    /// Mass of one roller, kg.
    pub mass: f64,
    /// Viscous friction of its bearing, N m s/rad.
    pub damping: f64,
    /// What it is made of.
    pub material: Material,
}

impl Rollers {
    /// Pose of a roller in the frame of its wheel, its axis along x. Roller k sits at the angle `first + k 2 pi / count`
    /// from the front downward; its axis leans by the roller angle from the wheel's axis toward the direction of turning
    /// (thesis Appendix A, lines 741 to 762).
    pub fn pose(&self, index: u32) -> Pose {
        let (sin_angle, cos_angle) = self.angle.abs().sin_cos();
        let (sin, cos) = (self.first_roller + TAU * f64::from(index) / f64::from(self.count)).sin_cos();
        let centre = Vector3::new(cos, 0.0, sin) * self.axis_circle;
        let tangent = Vector3::new(-sin, 0.0, cos);
        let axis = tangent * sin_angle - Vector3::y() * cos_angle * self.angle.signum();
        let turn = UnitQuaternion::rotation_between(&Vector3::x(), &axis);
        Pose::from_parts(centre.into(), turn.unwrap_or_default())
    }

    /// The outline of a roller: places along its axis from its middle, m, and the radius there, m, from end to end.
    pub fn outline(&self, wheel_radius: f64, pieces: u32) -> Vec<[f64; 2]> {
        let edge = |piece: u32| {
            let phase = self.last_phase * (2.0 * f64::from(piece) / f64::from(pieces) - 1.0);
            [self.half_length_at(phase, wheel_radius), self.radius_at(phase, wheel_radius)]
        };
        (0..=pieces).map(edge).collect()
    }

    /// Radius of the hub that is drawn between the rollers, m: as far as they leave it free.
    pub fn hub_radius(&self, wheel_radius: f64) -> f64 {
        self.axis_circle - self.radius_at(0.0, wheel_radius)
    }

    /// Radius of a roller where it touches at a phase of the contact, m; at the place [`half_length_at`] that phase.
    ///
    /// [`half_length_at`]: Self::half_length_at
    pub fn radius_at(&self, phase: f64, wheel_radius: f64) -> f64 {
        let cos_angle = self.angle.abs().cos();
        (wheel_radius * phase.cos() - self.axis_circle) * (1.0 + (cos_angle * phase.tan()).powi(2)).sqrt()
    }

    /// Half the length of a roller along its axis, m, that ends at a phase (Gfrerrer, "Geometry and kinematics of the
    /// Mecanum wheel").
    pub fn half_length_at(&self, phase: f64, wheel_radius: f64) -> f64 {
        let (sin, cos) = self.angle.abs().sin_cos();
        wheel_radius * phase.sin() * sin + self.axis_circle * phase.tan() * cos.powi(2) / sin
    }
}

/// A battery that falls linearly, whatever the robot does (Battery.uc:44-129).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Battery {
    /// Energy at the start, J.
    pub max_energy: f64,
    /// Seconds from full to empty.
    pub life: f64,
}

/// A sensor on a robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SensorDef {
    /// Name on the wire.
    pub name: String,
    /// Position in the robot frame, m.
    pub position: [f64; 3],
    /// Roll, pitch, yaw in the robot frame, rad.
    pub direction: [f64; 3],
    /// Seconds between two readings; 0 for none.
    pub scan_interval: f64,
    /// What it is and its numbers.
    pub config: sensor::Config,
}

/// Everything that a world needs.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct WorldDef {
    /// The map.
    pub map: MapDef,
    /// The classes that clients can ask for, by name.
    pub robots: BTreeMap<String, RobotDef>,
}

impl WorldDef {
    /// A sensor of a class by its name on the wire.
    pub fn sensor(&self, class: &str, name: &str) -> Option<&SensorDef> {
        self.robots.get(class)?.sensors.iter().find(|sensor| sensor.name == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn material(friction: f64, restitution: f64) -> Material {
        Material { friction, restitution, ..Material::default() }
    }

    #[test]
    fn a_pair_of_materials_has_the_mean_of_both() {
        let (friction, restitution) = material(0.9, 0.0).pair(&material(0.7, 0.3));
        assert!((friction - 0.8).abs() < 1e-12);
        assert!((restitution - 0.15).abs() < 1e-12);
    }

    #[test]
    fn a_pose_gives_back_its_numbers() {
        let (position, rotation) = position_and_rotation(&pose([1.0, 2.0, 3.0], [0.1, -0.2, 2.5]));
        assert!(position.iter().zip([1.0, 2.0, 3.0]).all(|(a, b): (&f64, f64)| (a - b).abs() < 1e-12));
        assert!(rotation.iter().zip([0.1, -0.2, 2.5]).all(|(a, b): (&f64, f64)| (a - b).abs() < 1e-12));
    }

    /// Places and axes of the six rollers of either handedness, worked out from the thesis's Appendix A by the rules
    /// of Unreal's rotators. Its ring has a radius of 0.0475 m.
    #[test]
    fn rollers_sit_and_point_as_in_the_thesis() {
        let material = Material::default();
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let table = [
            ([0.0475, 0.0], [0.0, -half, half]),
            ([0.02375, 0.04114], [-0.6124, -half, 0.3536]),
            ([-0.02375, 0.04114], [-0.6124, -half, -0.3536]),
            ([-0.0475, 0.0], [0.0, -half, -half]),
            ([-0.02375, -0.04114], [0.6124, -half, -0.3536]),
            ([0.02375, -0.04114], [0.6124, -half, 0.3536]),
        ];
        for sign in [1.0, -1.0] {
            let angle = sign * std::f64::consts::FRAC_PI_4;
            let material = material.clone();
            let rollers = Rollers {
                count: 6,
                axis_circle: 0.0475,
                angle,
                first_roller: 0.0,
                last_phase: std::f64::consts::PI / 6.0,
                mass: 0.1,
                damping: 0.0,
                material,
            };
            for (index, ([x, z], axis)) in (0..).zip(table) {
                let pose = rollers.pose(index);
                let place = pose.translation.vector - Vector3::new(x, 0.0, z);
                let direction = pose.rotation * Vector3::x() - Vector3::new(axis[0], sign * axis[1], axis[2]);
                assert!(place.norm() < 1e-4 && direction.norm() < 1e-3, "roller {index}, {sign}: {pose}");
            }
        }
    }
}
