//! Actuators and grippers: joints of a robot that controllers know by a name of their own.

use serde::{Deserialize, Serialize};

/// A named group of joints, as an arm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Actuator {
    /// Name on the wire.
    pub name: String,
    /// The numbers of the links that its joints move, in the order that `ACT` numbers them.
    pub links: Vec<usize>,
    /// Its tool point in the robot frame when every joint is at 0, m.
    pub tip: [f64; 3],
}

/// Joints that are opened and closed together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Gripper {
    /// Name on the wire.
    pub name: String,
    /// The numbers of the links that its joints move.
    pub links: Vec<usize>,
    /// Where they are when it is open, rad or m.
    pub open: Vec<f64>,
    /// Where they go when it closes, rad or m.
    pub closed: Vec<f64>,
}
