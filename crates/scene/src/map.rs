//! Maps: what stands and lies on them, and where robots start.

use serde::{Deserialize, Serialize};

use crate::Solid;

/// A solid of a map that moves when it is pushed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Object {
    /// Shape, first place and surface.
    pub solid: Solid,
    /// Mass, kg, evenly spread.
    pub mass: f64,
}

/// A named place of a map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NamedPose {
    /// Name without white space or braces.
    pub name: String,
    /// Position, m.
    pub position: [f64; 3],
    /// Roll, pitch, yaw, rad.
    pub rotation: [f64; 3],
}

/// A map: what stands and lies on it, and where robots start.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct MapDef {
    /// Name, sent as `{Level ..}`.
    pub name: String,
    /// One sentence.
    pub description: String,
    /// Gravity, m/s², along +z.
    pub gravity: f64,
    /// Time limit sent in the greeting, minutes; nothing ends by it.
    pub time_limit: u32,
    /// What does not move.
    pub solids: Vec<Solid>,
    /// What can be pushed.
    pub objects: Vec<Object>,
    /// Start poses, in the order of the file.
    pub starts: Vec<NamedPose>,
    /// Path nodes, in the order of the file.
    pub path_nodes: Vec<NamedPose>,
}
