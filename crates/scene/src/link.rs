//! Links and the joints by which they hang on each other.
//!
//! Every position, axis and orientation is in the robot frame when every joint is at 0, as in USARSim, where offsets add up and
//! no part turns what hangs on it (robots.md 0). A link's own frame has its origin at its joint's anchor and is parallel to the
//! robot frame then; that of the root is the robot frame.

use nalgebra::{Matrix3, Translation3, Unit, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use crate::{Motor, Pose, Solid, Visual, Wheel};

/// Name of the root of a robot whose file does not name it.
pub const ROOT: &str = "body";

/// The axis of every wheel, the robot's left: a positive angle rolls it forward, as of USARSim's wheel joints.
pub const WHEEL_AXIS: [f64; 3] = [0.0, -1.0, 0.0];

/// A rigid piece of a robot, and the joint by which it hangs on its parent.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Link {
    /// Its name.
    pub name: String,
    /// The joint to its parent; `None` of the root alone.
    pub joint: Option<Joint>,
    /// What it weighs, beside its wheel.
    pub parts: Vec<Part>,
    /// Shapes that touch the world, beside its wheel.
    pub solids: Vec<Solid>,
    /// The wheel that it is.
    pub wheel: Option<Wheel>,
    /// What is seen of it; without any, its solids and its wheel.
    #[serde(default)]
    pub visuals: Vec<Visual>,
}

/// How a link moves against its parent.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// The parent's number among the links, less than that of the link itself.
    pub parent: usize,
    /// What it lets the link do.
    pub kind: JointKind,
    /// Where, m.
    pub anchor: [f64; 3],
    /// Unit vector. At a positive value the link is turned about it, right-handed, or moved along it; what is fixed and a ball
    /// have no use for it.
    pub axis: [f64; 3],
    /// Least and greatest value, rad or m; a continuous joint has none.
    pub limits: Option<[f64; 2]>,
    /// Viscous friction, N m s/rad or N s/m.
    pub damping: f64,
    /// Dry friction, N m or N: the same at any speed, and what it takes to set the joint in motion.
    #[serde(default)]
    pub friction: f64,
    /// Its motor; without one it moves freely.
    pub drive: Option<Motor>,
    /// How its servo follows another joint.
    #[serde(default)]
    pub coupling: Option<Coupling>,
}

/// How a joint follows another: to `multiplier` x leader + `offset`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Coupling {
    /// The number of the leader among the links. It follows none itself.
    pub leader: usize,
    /// Of the leader's value.
    pub multiplier: f64,
    /// rad or m.
    pub offset: f64,
    /// What of the leader counts.
    pub kind: CouplingKind,
}

/// What of its leader a joint follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum CouplingKind {
    /// Where it is, as if by a gear: the joint has no motor of its own. `<mimic>` of a URDF, the Nao's hip (Nao.uc:24-33).
    Mimic,
    /// Its target, which is added to that of the joint's own servo: the third link of the Fanuc with a multiplier of -1
    /// (Fanuc_M16iB20Arm.uc:20-25).
    Target,
}

/// What a joint lets its link do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum JointKind {
    /// Nothing.
    Fixed,
    /// Turn about its axis between limits.
    Revolute,
    /// Turn about its axis without an end.
    Continuous,
    /// Slide along its axis between limits.
    Prismatic,
    /// Turn about every axis.
    Ball,
}

/// What a piece of a link weighs and where.
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
    /// All of them, with their names in robot.toml.
    pub const ALL: [(&str, Self); 5] = [
        ("fixed", Self::Fixed),
        ("revolute", Self::Revolute),
        ("continuous", Self::Continuous),
        ("prismatic", Self::Prismatic),
        ("ball", Self::Ball),
    ];

    /// Whether one number says where it is; of those a state has one each.
    pub fn has_value(self) -> bool {
        matches!(self, Self::Revolute | Self::Continuous | Self::Prismatic)
    }
}

impl CouplingKind {
    /// All of them, with their names in robot.toml.
    pub const ALL: [(&str, Self); 2] = [("mimic", Self::Mimic), ("target", Self::Target)];
}

impl Joint {
    /// A joint that moves freely without an end.
    pub fn new(parent: usize, kind: JointKind, anchor: [f64; 3], axis: [f64; 3]) -> Self {
        Self { parent, kind, anchor, axis, limits: None, damping: 0.0, friction: 0.0, drive: None, coupling: None }
    }

    /// How a value moves the link from where it is at 0, in the link's frame then.
    pub fn motion(&self, value: f64) -> Pose {
        let axis = Vector3::from(self.axis);
        match self.kind {
            JointKind::Revolute | JointKind::Continuous => {
                let turn = UnitQuaternion::from_axis_angle(&Unit::new_unchecked(axis), value);
                Pose::from_parts(Translation3::identity(), turn)
            }
            JointKind::Prismatic => Translation3::from(axis * value).into(),
            JointKind::Fixed | JointKind::Ball => Pose::identity(),
        }
    }
}

impl Link {
    /// Origin of its frame in the robot frame when every joint is at 0, m.
    pub fn origin(&self) -> [f64; 3] {
        self.joint.as_ref().map_or([0.0; 3], |joint| joint.anchor)
    }

    /// Pose of one of its solids in its own frame.
    pub fn pose_of(&self, solid: &Solid) -> Pose {
        Translation3::from(-Vector3::from(self.origin())) * solid.pose()
    }

    /// Whether its joint has a place in a state.
    pub fn has_value(&self) -> bool {
        self.joint.as_ref().is_some_and(|joint| joint.kind.has_value())
    }

    /// Whether it is a wheel with a motor.
    pub fn is_driven_wheel(&self) -> bool {
        self.wheel.is_some() && self.joint.as_ref().is_some_and(|joint| joint.drive.is_some())
    }

    /// The limits of a joint that goes to positions, as by `SET {Type Joint}`, rad or m.
    pub fn position_limits(&self) -> Option<[f64; 2]> {
        let joint = self.joint.as_ref()?;
        let goes = joint.drive.as_ref().is_some_and(|motor| motor.stiffness.is_some());
        joint.limits.filter(|_| goes)
    }

    /// Which axle of a car its joint steers, 0 the front and 1 the rear: one that turns and has FRONTSTEER or REARSTEER in its name,
    /// in any case (AckermanSteeredVehicle.uc:22-67).
    pub fn steered_axle(&self) -> Option<usize> {
        let turns = self.joint.as_ref().is_some_and(|joint| joint.kind == JointKind::Revolute);
        let name = self.name.to_ascii_lowercase();
        ["frontsteer", "rearsteer"].iter().position(|steer| turns && name.contains(steer))
    }

    /// A wheel on the body: driven by a motor about the robot's left, or a ball that is free to turn about every axis.
    pub fn of_wheel(name: String, position: [f64; 3], drive: Option<Motor>, wheel: Wheel) -> Self {
        let kind = if drive.is_some() { JointKind::Continuous } else { JointKind::Ball };
        let joint = Joint { drive, ..Joint::new(0, kind, position, WHEEL_AXIS) };
        Self { name, joint: Some(joint), wheel: Some(wheel), ..Self::default() }
    }
}
