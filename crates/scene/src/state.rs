//! A moment of a world: where everything is and how it moves.

use nalgebra::Vector3;

use crate::Pose;

/// Identifies a robot for as long as its world lives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RobotId(pub u64);

/// Where a body is and how it moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyState {
    /// Pose of the robot frame in the world.
    pub pose: Pose,
    /// Velocity of the frame's origin in world axes, m/s.
    pub linear: Vector3<f64>,
    /// Angular velocity in world axes, rad/s.
    pub angular: Vector3<f64>,
}

/// How a wheel turns.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WheelState {
    /// Angle turned since the spawn, rad, not wrapped; positive = forward.
    pub angle: f64,
    /// Speed, rad/s.
    pub speed: f64,
}

/// Where a joint is and how it moves.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JointState {
    /// Angle, rad, not wrapped, or displacement, m, since the spawn.
    pub position: f64,
    /// Speed, rad/s or m/s.
    pub speed: f64,
}

/// A moment of a world, which whatever looks at it shares.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Snapshot {
    /// Simulated time, s.
    pub time: f64,
    /// The robots, in the order that they came.
    pub robots: Vec<RobotSnapshot>,
    /// Poses of the map's objects, in its order.
    pub objects: Vec<Pose>,
}

/// A robot at a moment.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotSnapshot {
    /// Its number.
    pub id: RobotId,
    /// Its class.
    pub class: String,
    /// Its name from INIT.
    pub name: String,
    /// Pose and velocity of the robot frame.
    pub body: BodyState,
    /// Every joint that has a value, wheels too, in the order of the links.
    pub joints: Vec<JointState>,
    /// Target speeds of the driven wheels, rad/s.
    pub targets: Vec<f64>,
    /// Angles of the rollers about their own axes, rad, wheel by wheel.
    pub rollers: Vec<f64>,
    /// Everything that pushed it in the last step.
    pub contacts: Vec<Contact>,
}

/// A point where something pushes a robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Where, world frame, m.
    pub point: Vector3<f64>,
    /// Force on the robot over the last step, world axes, N: the normal force, friction and rolling resistance together.
    pub force: Vector3<f64>,
}
