//! Links of a robot and the joints between them.
//!
//! Every position, axis and orientation is in the robot frame when every joint is at 0. USARSim does the same: offsets add up, and
//! no part rotates its children (robots.md 0). A link's own frame has its origin at its joint's anchor. With every joint at 0 it is
//! parallel to the robot frame. The frame of the root is the robot frame.

use nalgebra::{Matrix3, Translation3, Unit, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use crate::{Motor, Pose, Solid, Visual, Wheel};

/// Name of the root of a robot that its file leaves unnamed.
pub const ROOT: &str = "body";

/// Axis of every wheel, the robot's left. A positive angle rolls the wheel forward, as in USARSim's wheel joints.
pub const WHEEL_AXIS: [f64; 3] = [0.0, -1.0, 0.0];

/// A rigid piece of a robot, and the joint to its parent.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Link {
    /// Its name.
    pub name: String,
    /// Joint to the parent; `None` only for the root.
    pub joint: Option<Joint>,
    /// Masses, without the wheel.
    pub parts: Vec<Part>,
    /// Colliding shapes, without the wheel.
    pub solids: Vec<Solid>,
    /// Wheel, if the link is one.
    pub wheel: Option<Wheel>,
    /// Visible shapes; without any, the solids and the wheel are drawn.
    #[serde(default)]
    pub visuals: Vec<Visual>,
}

/// Motion of a link relative to its parent.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// Parent's number among the links, less than that of the link itself.
    pub parent: usize,
    /// Degrees of freedom.
    pub kind: JointKind,
    /// Position, m.
    pub anchor: [f64; 3],
    /// Unit vector. At a positive value the link is turned about it, right-handed, or moved along it. Fixed joints and balls ignore
    /// it.
    pub axis: [f64; 3],
    /// Least and greatest value, rad or m; a continuous joint has none.
    pub limits: Option<[f64; 2]>,
    /// Viscous friction, N m s/rad or N s/m.
    pub damping: f64,
    /// Dry friction, N m or N: independent of speed, and the least effort that sets the joint in motion.
    #[serde(default)]
    pub friction: f64,
    /// Motor; without one the joint moves freely.
    pub drive: Option<Motor>,
    /// Coupling of its servo to another joint.
    #[serde(default)]
    pub coupling: Option<Coupling>,
}

/// Coupling of a joint to a leader: its target is `multiplier` x leader + `offset`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Coupling {
    /// Number of the leader among the links. The leader has no coupling itself.
    pub leader: usize,
    /// Factor of the leader's value.
    pub multiplier: f64,
    /// Offset, rad or m.
    pub offset: f64,
    /// Quantity of the leader that it follows.
    pub kind: CouplingKind,
}

/// Quantity of the leader that a joint follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum CouplingKind {
    /// The leader's position, as if by a gear; the joint has no motor of its own. `<mimic>` of a URDF, the Nao's hip
    /// (Nao.uc:24-33).
    Mimic,
    /// The leader's target, added to the target of the joint's own servo: the third link of the Fanuc with a multiplier of -1
    /// (Fanuc_M16iB20Arm.uc:20-25).
    Target,
}

/// Degrees of freedom of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum JointKind {
    /// No motion.
    Fixed,
    /// Turns about its axis between limits.
    Revolute,
    /// Turns about its axis without limits.
    Continuous,
    /// Slides along its axis between limits.
    Prismatic,
    /// Turns about every axis.
    Ball,
    /// A belt runs around the link, across the axis. The link itself does not move. The value is the angle of the sprocket.
    Belt,
}

/// Mass properties of a piece of a link.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Its name.
    pub name: String,
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass, m.
    pub centre: Vector3<f64>,
    /// Inertia about the centre of mass, robot axes, kg m².
    pub inertia: Matrix3<f64>,
}

impl JointKind {
    /// Kinds of joints that a `[[joint]]` can have, with their names in robot.toml.
    pub const ALL: [(&str, Self); 5] = [
        ("fixed", Self::Fixed),
        ("revolute", Self::Revolute),
        ("continuous", Self::Continuous),
        ("prismatic", Self::Prismatic),
        ("ball", Self::Ball),
    ];

    /// True if one number gives the position. A state has one value for each such joint.
    pub fn has_value(self) -> bool {
        matches!(self, Self::Revolute | Self::Continuous | Self::Prismatic | Self::Belt)
    }
}

impl CouplingKind {
    /// All kinds of couplings, with their names in robot.toml.
    pub const ALL: [(&str, Self); 2] = [("mimic", Self::Mimic), ("target", Self::Target)];
}

impl Joint {
    /// Creates a joint that moves freely without limits.
    pub fn new(parent: usize, kind: JointKind, anchor: [f64; 3], axis: [f64; 3]) -> Self {
        Self { parent, kind, anchor, axis, limits: None, damping: 0.0, friction: 0.0, drive: None, coupling: None }
    }

    /// Returns the pose of the link at a value, in the link's frame at value 0.
    pub fn motion(&self, value: f64) -> Pose {
        let axis = Vector3::from(self.axis);
        match self.kind {
            JointKind::Revolute | JointKind::Continuous => {
                let turn = UnitQuaternion::from_axis_angle(&Unit::new_unchecked(axis), value);
                Pose::from_parts(Translation3::identity(), turn)
            }
            JointKind::Prismatic => Translation3::from(axis * value).into(),
            JointKind::Fixed | JointKind::Ball | JointKind::Belt => Pose::identity(),
        }
    }
}

impl Link {
    /// Returns the origin of the link's frame in the robot frame when every joint is at 0, m.
    pub fn origin(&self) -> [f64; 3] {
        self.joint.as_ref().map_or([0.0; 3], |joint| joint.anchor)
    }

    /// Returns the pose of one of the link's solids in the link's frame.
    pub fn pose_of(&self, solid: &Solid) -> Pose {
        Translation3::from(-Vector3::from(self.origin())) * solid.pose()
    }

    /// True if its joint has a value in a state.
    pub fn has_value(&self) -> bool {
        self.joint.as_ref().is_some_and(|joint| joint.kind.has_value())
    }

    /// True for a wheel with a motor.
    pub fn is_driven_wheel(&self) -> bool {
        self.wheel.is_some() && self.joint.as_ref().is_some_and(|joint| joint.drive.is_some())
    }

    /// Returns the limits of a position-controlled joint, as by `SET {Type Joint}`, rad or m.
    pub fn position_limits(&self) -> Option<[f64; 2]> {
        let joint = self.joint.as_ref()?;
        let goes = joint.drive.as_ref().is_some_and(|motor| motor.stiffness.is_some());
        joint.limits.filter(|_| goes)
    }

    /// Returns the axle of a car that its joint steers: 0 the front, 1 the rear. A steering joint is revolute and has FRONTSTEER or
    /// REARSTEER in its name, in any case (AckermanSteeredVehicle.uc:22-67).
    pub fn steered_axle(&self) -> Option<usize> {
        let turns = self.joint.as_ref().is_some_and(|joint| joint.kind == JointKind::Revolute);
        let name = self.name.to_ascii_lowercase();
        ["frontsteer", "rearsteer"].iter().position(|steer| turns && name.contains(steer))
    }

    /// Creates a wheel on the root link: driven by a motor about the robot's left, or a ball that is free to turn about every axis. A
    /// wheel with a belt is the sprocket of a track.
    pub fn of_wheel(name: String, position: [f64; 3], drive: Option<Motor>, wheel: Wheel) -> Self {
        let kind = wheel.joint_kind(drive.is_some());
        let joint = Joint { drive, ..Joint::new(0, kind, position, WHEEL_AXIS) };
        Self { name, joint: Some(joint), wheel: Some(wheel), ..Self::default() }
    }
}
