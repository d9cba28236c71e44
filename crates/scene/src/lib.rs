//! Definitions of simulated worlds as plain data: maps, robots, materials, sensors, and the limits of every number.
//!
//! A definition can be built by hand, checked, written as JSON and read back bit for bit, as a log does. A snapshot is the state of a
//! world at one time. The crate `scene-loader` builds scenes from files, and `sim-core` simulates them. This crate neither reads files
//! nor moves anything.
//!
//! SI units, in the world frame: x forward, y right, z down, right-handed. Rotations are roll, pitch and yaw in radians. Positions of a
//! robot's parts are in the robot frame with every joint at 0.
//!
//! | type | content |
//! |---|---|
//! | [`WorldDef`] | a scene: a map and classes of robots; [`WorldDef::check`] finds numbers outside the limits in [`check`] |
//! | [`MapDef`] | a map: [`Solid`]s, movable [`Object`]s, gravity, start poses, victims, tags |
//! | [`RobotDef`] | a class of robots: a tree of [`Link`]s with [`Joint`]s, [`Wheel`]s and [`Motor`]s, and what it carries |
//! | [`Shape`], [`Material`] | geometry and surface of solids |
//! | [`SensorDef`], [`Reading`] | a sensor of a robot, and one measurement in 64-bit numbers; [`sensor`] has a module for each kind |
//! | [`Actuator`], [`Gripper`], [`ToolChanger`], [`Vacuum`] | arms and hands |
//! | [`Snapshot`] | poses, velocities and contacts of robots and objects at one time |
//! | [`Options`] | seed and time step of a run |
//! | [`League`] | rules of a round with teams and points |
//! | [`Scenario`] | something to do: robots, times and texts beside a league's goals |
//!
//! # Example
//! A cart with four driven wheels on a plane:
//!
//! ```
//! use nalgebra::{Matrix3, Vector3};
//! use scene::{Link, MapDef, Material, Motor, Part, RobotDef, Shape, Side, Solid, Steering, Wheel, WorldDef};
//!
//! let material = Material { name: "rubber".to_owned(), friction: 0.8, ..Material::default() };
//! let solid = |name: &str, shape: Shape| Solid {
//!     name: name.to_owned(),
//!     shape,
//!     position: [0.0; 3],
//!     rotation: [0.0; 3],
//!     material: material.clone(),
//! };
//! let floor = solid("floor", Shape::HalfSpace);
//! let map = MapDef { name: "plane".to_owned(), gravity: 9.81, solids: vec![floor], ..MapDef::default() };
//!
//! let part = Part { name: "frame".to_owned(), mass: 10.0, centre: Vector3::zeros(), inertia: Matrix3::identity() * 0.2 };
//! let solids = vec![solid("frame", Shape::Box { size: [0.4, 0.3, 0.1] })];
//! let mut links = vec![Link { name: "frame".to_owned(), parts: vec![part], solids, ..Link::default() }];
//! let (left, right) = (Side::Left, Side::Right);
//! for (name, x, y, side) in [("FL", 0.15, -0.2, left), ("FR", 0.15, 0.2, right), ("BL", -0.15, -0.2, left), ("BR", -0.15, 0.2, right)] {
//!     let motor = Motor { max_speed: 10.0, gain: 50.0, max_torque: 20.0, stiffness: None, integral_time: Some(0.05), armature: 0.0 };
//!     let wheel = Wheel { side, radius: 0.1, width: 0.05, mass: 0.5, material: material.clone(), rollers: None, belt: None, tyre: None };
//!     links.push(Link::of_wheel(name.to_owned(), [x, y, 0.03], Some(motor), wheel));
//! }
//! let cart = RobotDef::new("Cart", Steering::Skid, links);
//! let world = WorldDef { map, robots: [("Cart".to_owned(), cart)].into(), ..WorldDef::default() };
//! world.check()?;
//!
//! let text = serde_json::to_string(&world)?;
//! assert_eq!(serde_json::from_str::<WorldDef>(&text)?, world);
//!
//! let mut heavy = world;
//! heavy.map.gravity = 1e6;
//! assert!(heavy.check().is_err_and(|problem| problem.message.contains("gravity")));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod actuator;
mod base;
mod belt;
pub mod check;
mod classes;
mod drawing;
mod fnv;
pub mod goal;
mod height_field;
mod hull;
mod league;
mod link;
mod map;
mod mass;
mod material;
mod mount;
mod options;
#[cfg(test)]
#[path = "../page_types.rs"]
mod page_types;
mod reading;
mod robot;
pub mod rotation_units;
mod scenario;
mod sensed;
pub mod sensor;
mod shape;
mod state;
mod stored;
mod tyre;
mod wheel;

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use serde::{Deserialize, Serialize};

pub use actuator::{Actuator, Gripper, Tool, ToolChanger, Vacuum};
pub use base::{Aerial, Drivetrain, Footing};
pub use belt::{Belt, Disc, LOADED, Pads, convex_hull};
pub use classes::Classes;
pub use drawing::{Drawn, Geometry, Moves, Visual};
pub use fnv::Fnv;
pub use height_field::HeightField;
pub use hull::hull_surface;
pub use league::{Entrant, League, Score, ScoredGoal, Standing, Standings, Team, VictimRule};
pub use link::{Coupling, CouplingKind, Joint, JointKind, Link, Part, ROOT, WHEEL_AXIS};
pub use map::{Conveyor, Geographic, MapDef, NamedPose, Object, RfidTag, Smoke, Sound, Victim};
pub use mass::Mass;
pub use material::Material;
pub use options::{Options, TIME_STEP};
pub use reading::{Quantity, Texts};
pub use robot::{Battery, DriveModel, RobotDef, Side, Steering, WheelGeometry};
pub use scenario::{Scenario, ScenarioCard, ScenarioRobot, Setting, Viewpoint};
pub use sensed::Sensed;
pub use sensor::{Reading, SensorDef};
pub use shape::{Shape, Solid};
pub use state::{
    BodyState, Contact, JointState, ObjectId, ObjectSnapshot, PawnId, PullSnapshot, RobotSnapshot, Snapshot, WheelState,
};
pub use tyre::{Tyre, isotropic};
pub use wheel::{Motor, MountedWheel, Rollers, Wheel};

/// Position and orientation.
pub type Pose = Isometry3<f64>;

/// Wraps an angle to -pi to pi, rad.
pub fn wrapped(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

/// Builds a pose from a position in metres and roll, pitch, yaw in radians (yaw first, then pitch, then roll).
pub fn pose(position: [f64; 3], [roll, pitch, yaw]: [f64; 3]) -> Pose {
    Pose::from_parts(Translation3::from(position), UnitQuaternion::from_euler_angles(roll, pitch, yaw))
}

/// Returns the position in metres and roll, pitch, yaw in radians of a pose; the inverse of [`pose`].
pub fn position_and_rotation(pose: &Pose) -> ([f64; 3], [f64; 3]) {
    let (roll, pitch, yaw) = pose.rotation.euler_angles();
    (pose.translation.vector.into(), [roll, pitch, yaw])
}

/// Scene that a world simulates: a map and classes of robots.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct WorldDef {
    /// The map.
    pub map: MapDef,
    /// Classes that clients can spawn, by name.
    pub robots: Classes,
    /// Classes of objects that a world controller can create, by name. Their poses have no meaning.
    #[serde(default)]
    pub objects: BTreeMap<String, Object>,
    /// The league that is played, if any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub league: Option<League>,
    /// The scenario that is played, if any. Its goals are those of `league`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scenario: Option<Scenario>,
}

impl WorldDef {
    /// True if teams play against each other, so that nobody may change the world. A scenario has one team.
    pub fn is_contest(&self) -> bool {
        self.league.is_some() && self.scenario.is_none()
    }

    /// Returns the scene in another setting, with the same classes.
    #[must_use]
    pub fn on(self, Setting { map, league, scenario }: Setting) -> Self {
        Self { map, league, scenario, ..self }
    }

    /// Finds a sensor of a class by its name on the wire.
    pub fn sensor(&self, class: &str, name: &str) -> Option<&SensorDef> {
        self.robots.get(class)?.sensors.iter().find(|sensor| sensor.name == name)
    }
}

/// The examples of the README, as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_gives_back_its_numbers() {
        let (position, rotation) = position_and_rotation(&pose([1.0, 2.0, 3.0], [0.1, -0.2, 2.5]));
        assert!(position.iter().zip([1.0, 2.0, 3.0]).all(|(a, b): (&f64, f64)| (a - b).abs() < 1e-12));
        assert!(rotation.iter().zip([0.1, -0.2, 2.5]).all(|(a, b): (&f64, f64)| (a - b).abs() < 1e-12));
    }
}
