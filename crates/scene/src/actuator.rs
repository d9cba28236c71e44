//! Actuators and grippers: named groups of a robot's joints for controllers. Tool changers, and the tools that they hold. Vacuums.

use serde::{Deserialize, Serialize};

use crate::{Object, Pose, pose};

/// A named group of joints, such as an arm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Actuator {
    /// Name on the wire.
    pub name: String,
    /// Numbers of the links that its joints move, in the order that `ACT` numbers them.
    pub links: Vec<usize>,
    /// Tool point in the robot frame when every joint is at 0, m.
    pub tip: [f64; 3],
}

/// A group of joints that open and close together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Gripper {
    /// Name on the wire.
    pub name: String,
    /// Numbers of the links that its joints move.
    pub links: Vec<usize>,
    /// Joint positions when it is open, rad or m.
    pub open: Vec<f64>,
    /// Joint positions when it is closed, rad or m.
    pub closed: Vec<f64>,
}

/// A coupling that takes and drops tools (ToolChanger.uc).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ToolChanger {
    /// Name on the wire.
    pub name: String,
    /// Number of the link that carries it.
    pub link: usize,
    /// Position in the robot frame when every joint is at 0, m.
    pub position: [f64; 3],
    /// Roll, pitch, yaw there, rad.
    pub direction: [f64; 3],
    /// Largest distance of a tool that it takes, m.
    pub position_tolerance: f64,
    /// Largest angle between its x axis and the tool's, and between their y axes, rad.
    pub angle_tolerance: f64,
    /// Tool that it holds when the robot is spawned.
    pub tool: Option<Tool>,
}

/// A tool: a rigid body that a tool changer can hold.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Tool {
    /// Type on the wire, for example `Gripper`.
    pub kind: String,
    /// Name, shape and mass. The pose of the shape is in the frame of the changer that holds it.
    pub object: Object,
}

/// A suction cup, to which the object ahead of it sticks (Vacuum.uc).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Vacuum {
    /// Name on the wire.
    pub name: String,
    /// Number of the link that carries it.
    pub link: usize,
    /// Position of its mouth in the robot frame when every joint is at 0, m.
    pub position: [f64; 3],
    /// Roll, pitch, yaw there, rad. It sucks along its z axis.
    pub direction: [f64; 3],
    /// Distance over which it sucks, m.
    pub reach: f64,
    /// Weight of the heaviest object that sticks to it, N.
    pub force: f64,
    /// Name of the tool that it is part of: it sucks while a tool changer of the robot holds that. `None` if it is part of the link.
    pub tool: Option<String>,
}

impl Vacuum {
    /// Returns its pose in the robot frame when every joint is at 0.
    pub fn pose(&self) -> Pose {
        pose(self.position, self.direction)
    }
}

impl ToolChanger {
    /// Returns its pose in the robot frame when every joint is at 0.
    pub fn pose(&self) -> Pose {
        pose(self.position, self.direction)
    }
}
