//! Maps: solids, movable objects, start poses, and what sensors perceive beside shapes.

use serde::{Deserialize, Serialize};

use crate::{Pose, Solid, pose};

/// A solid of a map that moves when pushed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Object {
    /// Shape, initial pose and surface.
    pub solid: Solid,
    /// Mass, kg, with uniform density.
    pub mass: f64,
}

/// A box that stands fast and whose surface moves, as a conveyor belt does.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Conveyor {
    /// Index of the box among the solids.
    pub solid: usize,
    /// Velocity of the surface in the frame of the box, m/s. A world controller sets a multiple of it.
    pub velocity: [f64; 3],
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

/// A person to be found. The body is made of solids of the map, named `NAME/PART`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Victim {
    /// Name without white space or braces.
    pub name: String,
    /// Position of the pelvis on its ground, m.
    pub position: [f64; 3],
    /// Roll, pitch, yaw, rad.
    pub rotation: [f64; 3],
    /// True if it moves a limb. Only sensors of motion notice.
    pub moves: bool,
    /// Density of CO2 at the mouth, of 0 to 1.
    pub co2: f64,
}

impl Victim {
    /// Parts of a body with the words of VictSensor for them, in its order.
    pub const PARTS: [&str; 7] = ["Head", "Arm", "Hand", "Chest", "Pelvis", "Leg", "Foot"];

    /// Returns the number of the part, in [`Victim::PARTS`], that a solid of the map is; `None` if it is not a part of this victim.
    pub fn part(&self, solid: &str) -> Option<usize> {
        let part = solid.strip_prefix(&*self.name)?.strip_prefix('/')?;
        Self::PARTS.iter().position(|known| part.trim_end_matches("-right").trim_end_matches("-left") == *known)
    }

    /// Returns the pose of the pelvis.
    pub fn pose(&self) -> Pose {
        pose(self.position, self.rotation)
    }
}

/// A tag that RFID sensors read and write.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RfidTag {
    /// Number that readers report.
    pub id: u32,
    /// Position, m.
    pub position: [f64; 3],
    /// Text that was written to it; empty at first.
    pub memory: String,
}

/// A box of smoke. Lasers lose light in it; nothing else feels it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Smoke {
    /// Name for messages and viewers.
    pub name: String,
    /// Position of its middle, m.
    pub position: [f64; 3],
    /// Edge lengths along x, y, z, m.
    pub size: [f64; 3],
    /// Density, 1/m: a path of a metre takes as much of a laser's budget.
    pub density: f64,
}

/// A source of repeated sounds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sound {
    /// Name for messages and viewers.
    pub name: String,
    /// Position, m.
    pub position: [f64; 3],
    /// Volume of 0 to 1; 1 is 117 dB at 1 m.
    pub volume: f64,
    /// Length of each sound, s.
    pub duration: f64,
    /// Time between the beginnings of two sounds, s. The first begins after one interval.
    pub interval: f64,
}

impl Sound {
    /// Returns the times at which sounds begin after `from` and until `to`, s; the last 16 if there are more.
    pub fn begins(&self, from: f64, to: f64) -> impl Iterator<Item = f64> {
        let number = |time: f64| (time / self.interval + 1e-9).floor().max(0.0);
        let (interval, last) = (self.interval, number(to));
        let first = (number(from) + 1.0).max(last - 15.0);
        (0..16)
            .map(move |step| first + f64::from(step))
            .take_while(move |number| *number <= last)
            .map(move |n| n * interval)
    }
}

/// A place on the Earth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Geographic {
    /// Degrees to the north.
    pub latitude: f64,
    /// Degrees to the east.
    pub longitude: f64,
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
    /// Solids whose surfaces move.
    #[serde(default)]
    pub conveyors: Vec<Conveyor>,
    /// Solids that are only seen: nothing touches them, and no ray hits them.
    #[serde(default)]
    pub markings: Vec<Solid>,
    /// Start poses, in the order of the file.
    pub starts: Vec<NamedPose>,
    /// Path nodes, in the order of the file.
    pub path_nodes: Vec<NamedPose>,
    /// Direction of north against the x axis, rad, clockwise seen from above.
    #[serde(default)]
    pub north: f64,
    /// Place of the origin on the Earth. Without one, each GPS receiver has its own.
    #[serde(default)]
    pub origin: Option<Geographic>,
    /// Persons to be found.
    #[serde(default)]
    pub victims: Vec<Victim>,
    /// RFID tags at the start.
    #[serde(default)]
    pub tags: Vec<RfidTag>,
    /// Boxes of smoke.
    #[serde(default)]
    pub smoke: Vec<Smoke>,
    /// Sources of sounds.
    #[serde(default)]
    pub sounds: Vec<Sound>,
    /// Classes of robots that suit the map, the first one first: pages offer these.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub robots: Vec<String>,
}

impl MapDef {
    /// Finds a start pose by its name, in any case.
    pub fn start(&self, name: &str) -> Option<&NamedPose> {
        self.starts.iter().find(|start| start.name.eq_ignore_ascii_case(name))
    }
}
