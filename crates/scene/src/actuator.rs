//! Actuators and grippers: named groups of a robot's joints for controllers.

use serde::{Deserialize, Serialize};

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
