//! Scenes and snapshots: plain data in SI units, in the world frame (x forward, y right, z down).
//!
//! The crate `scene-loader` builds scenes from files. This crate neither reads files nor moves anything. Values written as JSON, as
//! in a log, read back bit for bit.

mod actuator;
mod base;
mod belt;
pub mod check;
mod drawing;
mod fnv;
mod height_field;
mod hull;
mod league;
mod link;
mod map;
mod mass;
mod material;
mod mount;
mod options;
mod reading;
mod robot;
pub mod rotation_units;
pub mod sensor;
mod shape;
mod state;
mod stored;
mod wheel;

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use serde::{Deserialize, Serialize};

pub use actuator::{Actuator, Gripper, Tool, ToolChanger, Vacuum};
pub use base::{Aerial, Drivetrain, Footing};
pub use belt::{Belt, Disc, LOADED, Pads};
pub use drawing::{Drawn, Geometry, Moves, Visual};
pub use fnv::Fnv;
pub use height_field::HeightField;
pub use hull::hull_surface;
pub use league::{Entrant, League, Score, Standing, Standings, Team, VictimRule, Zone};
pub use link::{Coupling, CouplingKind, Joint, JointKind, Link, Part, ROOT, WHEEL_AXIS};
pub use map::{Conveyor, Geographic, MapDef, NamedPose, Object, RfidTag, Smoke, Sound, Victim};
pub use mass::Mass;
pub use material::Material;
pub use options::{Options, TIME_STEP};
pub use reading::{Quantity, Sensed, Texts};
pub use robot::{Battery, DriveModel, RobotDef, Side, Steering, WheelGeometry};
pub use sensor::{Reading, SensorDef};
pub use shape::{Shape, Solid};
pub use state::{
    BodyState, Contact, JointState, ObjectId, ObjectSnapshot, PawnId, RobotSnapshot, Snapshot, WheelState,
};
pub use wheel::{Motor, MountedWheel, Rollers, Wheel};

/// Position and orientation.
pub type Pose = Isometry3<f64>;

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
    pub robots: BTreeMap<String, RobotDef>,
    /// Classes of objects that a world controller can create, by name. Their poses have no meaning.
    #[serde(default)]
    pub objects: BTreeMap<String, Object>,
    /// The league that is played, if any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub league: Option<League>,
}

impl WorldDef {
    /// Finds a sensor of a class by its name on the wire.
    pub fn sensor(&self, class: &str, name: &str) -> Option<&SensorDef> {
        self.robots.get(class)?.sensors.iter().find(|sensor| sensor.name == name)
    }
}

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
