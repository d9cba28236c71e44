//! Links and the joints by which they hang on each other.
//!
//! Every position, axis and orientation is in the robot frame when every joint is at 0, as in USARSim, where offsets add up and
//! no part turns what hangs on it (robots.md 0). A link's own frame has its origin at its joint's anchor and is parallel to the
//! robot frame then; that of the root is the robot frame.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use crate::{Motor, Solid, Wheel};

/// Name of the root of a robot whose file does not name it.
pub const ROOT: &str = "body";

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
    /// Unit vector. At a positive value the link is turned about it, right-handed, or moved along it; a ball has no use for it.
    pub axis: [f64; 3],
    /// Its motor; without one it moves freely.
    pub drive: Option<Motor>,
}

/// What a joint lets its link do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum JointKind {
    /// Turn about its axis without an end.
    Continuous,
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

impl Link {
    /// A wheel on the body: driven by a motor about the robot's left, or a ball that is free to turn about every axis.
    ///
    /// A positive angle about the left (-y) rolls the robot forward: the axis of USARSim's wheel joints.
    pub fn of_wheel(name: String, position: [f64; 3], drive: Option<Motor>, wheel: Wheel) -> Self {
        let kind = if drive.is_some() { JointKind::Continuous } else { JointKind::Ball };
        let joint = Joint { parent: 0, kind, anchor: position, axis: [0.0, -1.0, 0.0], drive };
        Self { name, joint: Some(joint), wheel: Some(wheel), ..Self::default() }
    }
}
