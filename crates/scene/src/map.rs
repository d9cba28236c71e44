//! Maps: solids, movable objects and start poses.

use serde::{Deserialize, Serialize};

use crate::Solid;

/// A solid of a map that moves when pushed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Object {
    /// Shape, initial pose and surface.
    pub solid: Solid,
    /// Mass, kg, with uniform density.
    pub mass: f64,
}

/// A named pose on a map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NamedPose {
    /// Name without white space or braces.
    pub name: String,
    /// Position, m.
    pub position: [f64; 3],
    /// Roll, pitch, yaw, rad.
    pub rotation: [f64; 3],
}

/// A map: solids, movable objects, start poses and path nodes.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct MapDef {
    /// Name, sent as `{Level ..}`.
    pub name: String,
    /// Description in one sentence.
    pub description: String,
    /// Gravity, m/s², along +z.
    pub gravity: f64,
    /// Time limit sent in the greeting, minutes; the server does not enforce it.
    pub time_limit: u32,
    /// Solids that do not move.
    pub solids: Vec<Solid>,
    /// Solids that can be pushed.
    pub objects: Vec<Object>,
    /// Start poses, in the order of the file.
    pub starts: Vec<NamedPose>,
    /// Path nodes, in the order of the file.
    pub path_nodes: Vec<NamedPose>,
}

impl MapDef {
    /// Finds a start pose by its name, in any case.
    pub fn start(&self, name: &str) -> Option<&NamedPose> {
        self.starts.iter().find(|start| start.name.eq_ignore_ascii_case(name))
    }
}
