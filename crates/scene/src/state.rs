//! Snapshots of a world: poses and velocities at one time.

use std::sync::Arc;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::{Object, Pose};

/// Identifies a pawn while its world lives: a robot or a world controller. Numbers count up from 0, in the order of the INIT lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct PawnId(pub u64);

/// Identifies a movable object while its world lives. Objects of the map come first, in the map's order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct ObjectId(pub u64);

/// Pose and velocity of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyState {
    /// Pose of the robot frame in the world.
    pub pose: Pose,
    /// Velocity of the frame's origin in world axes, m/s.
    pub linear: Vector3<f64>,
    /// Angular velocity in world axes, rad/s.
    pub angular: Vector3<f64>,
}

/// Angle and speed of a wheel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WheelState {
    /// Angle turned since the spawn, rad, not wrapped; positive = forward.
    pub angle: f64,
    /// Speed, rad/s.
    pub speed: f64,
}

/// Position and speed of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JointState {
    /// Angle, rad, not wrapped, or displacement, m, since the spawn.
    pub position: f64,
    /// Speed, rad/s or m/s.
    pub speed: f64,
}

/// Snapshot of a world, shared by all its viewers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Snapshot {
    /// Simulated time, s.
    pub time: f64,
    /// Robots, in the order of their spawns.
    pub robots: Vec<RobotSnapshot>,
    /// Movable objects, by their ids.
    pub objects: Vec<ObjectSnapshot>,
    /// Springs by which world controllers pull robots and objects.
    pub pulls: Vec<PullSnapshot>,
}

impl Snapshot {
    /// Returns the bytes of memory that it takes, approximately: spare capacity of buffers and definitions of objects are not counted.
    pub fn size(&self) -> usize {
        let of_robot = |RobotSnapshot { class, name, joints, targets, rollers, contacts, .. }: &RobotSnapshot| {
            size_of::<RobotSnapshot>()
                + class.len()
                + name.len()
                + size_of_val(joints.as_slice())
                + size_of_val(targets.as_slice())
                + size_of_val(rollers.as_slice())
                + size_of_val(contacts.as_slice())
        };
        let robots: usize = self.robots.iter().map(of_robot).sum();
        size_of::<Self>() + robots + size_of_val(self.objects.as_slice()) + size_of_val(self.pulls.as_slice())
    }
}

/// State of a spring that pulls a robot or an object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PullSnapshot {
    /// Point at which it pulls, m.
    pub from: Vector3<f64>,
    /// Place to which it pulls, m.
    pub to: Vector3<f64>,
    /// Its force, N.
    pub force: Vector3<f64>,
}

/// State of a movable object in a snapshot.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectSnapshot {
    /// The object.
    pub id: ObjectId,
    /// Its definition; the pose in it is the one at which it was spawned.
    pub def: Arc<Object>,
    /// Its pose in the world.
    pub pose: Pose,
}

/// State of a robot in a snapshot.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotSnapshot {
    /// Robot number.
    pub id: PawnId,
    /// Class name.
    pub class: String,
    /// Robot name from INIT.
    pub name: String,
    /// Pose and velocity of the robot frame.
    pub body: BodyState,
    /// Every joint that has a value, wheels included, in the order of the links.
    pub joints: Vec<JointState>,
    /// Target speeds of the driven wheels, rad/s.
    pub targets: Vec<f64>,
    /// Angles of the rollers about their own axes, rad, wheel by wheel.
    pub rollers: Vec<f64>,
    /// Contacts of the last step.
    pub contacts: Vec<Contact>,
}

/// A point at which something pushes a robot.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// Position in the world frame, m.
    pub point: Vector3<f64>,
    /// Force on the robot over the last step, world axes, N: the sum of the normal force, friction and rolling resistance.
    pub force: Vector3<f64>,
    /// Wheel that it pushes, among all wheels of the class. `None` for another part.
    #[serde(default)]
    pub wheel: Option<usize>,
    /// Slip, world axes, m/s: velocity of the robot's surface over what it touches, along that. A free roller slips along its axis only.
    #[serde(default)]
    pub slip: Vector3<f64>,
    /// Friction over the most that the contact can give, 0 to 1. A contact that slides has 1, one without friction 0.
    #[serde(default)]
    pub friction_share: f64,
}
