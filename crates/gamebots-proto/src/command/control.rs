//! `CONTROL {Type t} ..`: a world controller's orders (protocol.md 3.2). Only `GetSTA` is answered.

use super::{ReadWrite, note_keys, text, with_text, with_vector};
use crate::{Line, Problem, shown, value};

/// Most way points of a line that are taken.
const MAX_POINTS: usize = 256;

/// Values of `Type`, with this case, each with its keys.
const TYPES: [(&str, &[&str]); 12] = [
    (
        "Create",
        &[
            "Type",
            "ClassName",
            "Name",
            "Location",
            "Rotation",
            "Start",
            "Scale",
            "Physics",
            "Material",
            "Memory",
            "Permanent",
        ],
    ),
    ("AbsMove", &["Type", "Name", "Location", "Rotation"]),
    ("RelMove", &["Type", "Name", "Location", "Rotation"]),
    ("Pull", &["Type", "Name", "Grip", "Location", "Rotation"]),
    ("Rotate", &["Type", "Name", "Speed"]),
    ("AddWP", &["Type", "Name", "WP"]),
    ("SetWP", &["Type", "Name", "Speed", "Loop", "Moving", "ResetOnClear", "Time"]),
    ("ClearWP", &["Type", "Name"]),
    ("Conveyor", &["Type", "Name", "Speed"]),
    ("Kill", &["Type", "Name"]),
    ("KillAll", &["Type", "MinPos", "MaxPos"]),
    ("GetSTA", &["Type", "ClassName", "Name"]),
];
/// Values of `Physics`; with the last one an object stays where it is put.
const PHYSICS: [&str; 4] = ["RigidBody", "Falling", "Ground", "None"];

/// An order of a world controller.
#[derive(Debug, Clone, PartialEq)]
pub enum Control {
    /// Creates an object.
    Create(Create),
    /// Puts an object or a robot at a place.
    Move(Move),
    /// Pulls an object or a robot by a spring, or lets it go. The original has no such order.
    Pull(Pull),
    /// Turns an object for ever.
    Rotate {
        /// Name of the object.
        name: String,
        /// Rates of roll, pitch and yaw, rad/s.
        speed: [f64; 3],
    },
    /// Adds points to an object's path.
    AddPoints {
        /// Name of the object.
        name: String,
        /// Positions, m.
        points: Vec<[f64; 3]>,
    },
    /// Changes the motion of an object along its path.
    SetPath(SetPath),
    /// Removes an object's path. The object returns to its first pose.
    ClearPath {
        /// Name of the object.
        name: String,
    },
    /// Sets the speed of a conveyor.
    Conveyor {
        /// Tag of the conveyor.
        name: String,
        /// Share of its default speed.
        speed: f64,
    },
    /// Removes an object.
    Kill {
        /// Name of the object.
        name: String,
    },
    /// Removes all objects that are not permanent, or those in a box.
    KillAll {
        /// Two corners of the box, m; `None` for all objects. The first has the smaller x and y and the larger z, as the original
        /// compares in its own axes, where z is up (WorldController.uc:419-421).
        corners: Option<[[f64; 3]; 2]>,
    },
    /// Asks for the states of objects.
    GetSta {
        /// Class of the objects; empty for all.
        class_name: String,
        /// Name of the object, with this case; empty for all.
        name: String,
    },
    /// An order that does not exist.
    Unknown {
        /// Its type.
        type_name: String,
    },
}

/// Creates an object.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Create {
    /// Class, as in `USARPhysObj.WCCrate`; without a package, `USARPhysObj` is meant.
    pub class_name: String,
    /// Name of the object.
    pub name: String,
    /// A text that `GetSTA` gives back.
    pub memory: String,
    /// Position, m, world frame (z down).
    pub location: [f64; 3],
    /// Roll, pitch, yaw, rad.
    pub rotation: [f64; 3],
    /// Name of a start pose. If it is not empty, location and rotation are ignored.
    pub start: String,
    /// Factors of the class's size along x, y, z.
    pub scale: [f64; 3],
    /// True if forces move the object: `Physics` is `RigidBody`, `Falling` or `Ground`. Otherwise it stays where it is put.
    pub is_rigid: bool,
    /// Material of its surface; empty for the class's.
    pub material: String,
    /// True if the object stays when its controller leaves.
    pub permanent: bool,
}

/// Puts an object or a robot at a place.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Move {
    /// Name of the object or robot.
    pub name: String,
    /// True if the numbers are added to the present ones.
    pub is_relative: bool,
    /// Position, m, world frame (z down).
    pub location: [f64; 3],
    /// Roll, pitch, yaw, rad.
    pub rotation: [f64; 3],
}

/// Pulls an object or a robot by a spring, or lets it go if neither a place nor a rotation is given.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Pull {
    /// Name of the object or robot.
    pub name: String,
    /// Point that is pulled, m, in the frame of the object or robot.
    pub grip: [f64; 3],
    /// Place to which that point is pulled, m, world frame (z down).
    pub location: Option<[f64; 3]>,
    /// Roll, pitch, yaw to which it is turned, rad.
    pub rotation: Option<[f64; 3]>,
}

/// Changes the motion of an object along its path. Values that are `None` stay.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SetPath {
    /// Name of the object.
    pub name: String,
    /// Speed along the path, m/s.
    pub speed: Option<f64>,
    /// True to begin again at the end of the path.
    pub is_loop: Option<bool>,
    /// True to move.
    pub moving: Option<bool>,
    /// True to return to the first pose when the path is cleared. The original never reads it (WorldController.uc:44-59).
    pub reset_on_clear: Option<bool>,
    /// Time from the beginning of the path, s.
    pub time: Option<f64>,
}

impl Control {
    /// Returns the value of `Type`.
    pub fn type_name(&self) -> &str {
        match self {
            Self::Create(_) => "Create",
            Self::Move(Move { is_relative: false, .. }) => "AbsMove",
            Self::Move(_) => "RelMove",
            Self::Pull(_) => "Pull",
            Self::Rotate { .. } => "Rotate",
            Self::AddPoints { .. } => "AddWP",
            Self::SetPath(_) => "SetWP",
            Self::ClearPath { .. } => "ClearWP",
            Self::Conveyor { .. } => "Conveyor",
            Self::Kill { .. } => "Kill",
            Self::KillAll { .. } => "KillAll",
            Self::GetSta { .. } => "GetSTA",
            Self::Unknown { type_name } => type_name,
        }
    }

    /// Returns the name of the object or robot that it is about; empty if it is about several.
    pub fn name(&self) -> &str {
        match self {
            Self::Create(Create { name, .. })
            | Self::Move(Move { name, .. })
            | Self::Pull(Pull { name, .. })
            | Self::SetPath(SetPath { name, .. })
            | Self::Rotate { name, .. }
            | Self::AddPoints { name, .. }
            | Self::ClearPath { name }
            | Self::Conveyor { name, .. }
            | Self::Kill { name }
            | Self::GetSta { name, .. } => name,
            Self::KillAll { .. } | Self::Unknown { .. } => "",
        }
    }
}

impl ReadWrite for Control {
    const KEYS: &'static [&'static str] = &[
        "Type",
        "ClassName",
        "Name",
        "Location",
        "Rotation",
        "Grip",
        "Start",
        "Scale",
        "Physics",
        "Material",
        "Memory",
        "Permanent",
        "Speed",
        "WP",
        "Loop",
        "Moving",
        "ResetOnClear",
        "Time",
        "MinPos",
        "MaxPos",
    ];

    fn read(line: &Line, problems: &mut Vec<Problem>) -> Self {
        let name = text(line, "Name");
        let type_name = line.get("Type").unwrap_or_default();
        if let Some((_, keys)) = TYPES.iter().find(|(known, _)| *known == type_name) {
            note_keys("CONTROL", line, keys, problems);
        }
        let mut vector = |key: &str| value::vector(line, key, problems);
        match type_name {
            "Create" => {
                let scale = match vector("Scale") {
                    [0.0, 0.0, 0.0] => [1.0; 3],
                    scale => scale,
                };
                let [location, rotation] = ["Location", "Rotation"].map(vector);
                let physics = line.get("Physics").unwrap_or_default();
                if !physics.is_empty() && !PHYSICS.contains(&physics) {
                    let known = PHYSICS.iter().copied();
                    let instead = "the object stays where it is put";
                    problems.push(Problem::unknown_name("Physics", physics, known, "Create", instead));
                }
                Self::Create(Create {
                    class_name: text(line, "ClassName"),
                    name,
                    memory: text(line, "Memory"),
                    location,
                    rotation,
                    start: text(line, "Start"),
                    scale,
                    is_rigid: matches!(physics, "RigidBody" | "Falling" | "Ground"),
                    material: text(line, "Material"),
                    permanent: flag(line, "Permanent", problems).unwrap_or_default(),
                })
            }
            type_name @ ("AbsMove" | "RelMove") => Self::Move(Move {
                name,
                is_relative: type_name == "RelMove",
                location: vector("Location"),
                rotation: vector("Rotation"),
            }),
            "Pull" => {
                let grip = vector("Grip");
                let mut given = |key: &str| line.get(key).is_some().then(|| vector(key));
                Self::Pull(Pull { name, grip, location: given("Location"), rotation: given("Rotation") })
            }
            "Rotate" => Self::Rotate { name, speed: vector("Speed") },
            "AddWP" => {
                let parts = line.get("WP").unwrap_or_default().split(';').filter(|part| !part.trim().is_empty());
                let got = parts.clone().count();
                if got > MAX_POINTS {
                    let why = format!("got {got} points, expected at most {MAX_POINTS} a line");
                    problems.push(Problem::Ignored { what: "the end of {WP ..}".to_owned(), why });
                }
                let mut point = |part: &str| value::vector(&Line::new("WP").with("WP", part), "WP", problems);
                Self::AddPoints { name, points: parts.take(MAX_POINTS).map(&mut point).collect() }
            }
            "SetWP" => {
                let number = |key: &str, problems: &mut Vec<Problem>| {
                    let text = line.get(key).filter(|text| !text.is_empty())?;
                    Some(value::scalar_of(key, text, problems))
                };
                Self::SetPath(SetPath {
                    name,
                    speed: number("Speed", problems),
                    is_loop: flag(line, "Loop", problems),
                    moving: flag(line, "Moving", problems),
                    reset_on_clear: flag(line, "ResetOnClear", problems),
                    time: number("Time", problems),
                })
            }
            "ClearWP" => Self::ClearPath { name },
            "Conveyor" => {
                let speed = line.get("Speed").map_or(0.0, |text| value::scalar_of("Speed", text, problems));
                Self::Conveyor { name, speed }
            }
            "Kill" => Self::Kill { name },
            "KillAll" => {
                let corners = [vector("MinPos"), vector("MaxPos")];
                let given = ["MinPos", "MaxPos"].map(|key| (key, text(line, key)));
                let is_given = given.iter().all(|(_, text)| !text.is_empty());
                for ((key, text), (other, _)) in given.iter().zip(given.iter().rev()) {
                    if !is_given && !text.is_empty() {
                        let why = format!("without {other} all objects are meant");
                        problems.push(Problem::Ignored { what: format!("{{{key} {}}}", shown(text)), why });
                    }
                }
                Self::KillAll { corners: Some(corners).filter(|[least, most]| is_given && least != most) }
            }
            "GetSTA" => Self::GetSta { class_name: text(line, "ClassName"), name },
            type_name => {
                let known = TYPES.iter().map(|(known, _)| *known);
                problems.push(Problem::unknown_name("Type", type_name, known, "CONTROL", "nothing is done"));
                Self::Unknown { type_name: shown(type_name) }
            }
        }
    }

    fn write(&self) -> Line {
        let line = with_text(Line::new("CONTROL"), "Type", self.type_name());
        let named = |name: &str| with_text(line.clone(), "Name", name);
        match self {
            Self::Create(create) => {
                let line = with_text(named(&create.name), "ClassName", &create.class_name);
                let line = with_text(line, "Memory", &create.memory);
                let line = with_vector(line, "Location", create.location);
                let line = with_vector(line, "Rotation", create.rotation);
                let line = with_vector(with_text(line, "Start", &create.start), "Scale", create.scale);
                let line = if create.is_rigid { line.with("Physics", "RigidBody") } else { line };
                with_text(line, "Material", &create.material).with("Permanent", create.permanent)
            }
            Self::Move(Move { name, location, rotation, .. }) => {
                with_vector(with_vector(named(name), "Location", *location), "Rotation", *rotation)
            }
            Self::Pull(Pull { name, grip, location, rotation }) => {
                let line = with_vector(named(name), "Grip", *grip);
                let line = location.iter().fold(line, |line, location| with_vector(line, "Location", *location));
                rotation.iter().fold(line, |line, rotation| with_vector(line, "Rotation", *rotation))
            }
            Self::Rotate { name, speed } => with_vector(named(name), "Speed", *speed),
            Self::AddPoints { name, points } => {
                let points: Vec<String> = points.iter().map(|[x, y, z]| format!("{x},{y},{z}")).collect();
                with_text(named(name), "WP", &points.join(";"))
            }
            Self::SetPath(SetPath { name, speed, is_loop, moving, reset_on_clear, time }) => {
                let line = speed.iter().fold(named(name), |line, speed| line.with("Speed", speed));
                let line = is_loop.iter().fold(line, |line, is_loop| line.with("Loop", is_loop));
                let line = moving.iter().fold(line, |line, moving| line.with("Moving", moving));
                let line = reset_on_clear.iter().fold(line, |line, reset| line.with("ResetOnClear", reset));
                time.iter().fold(line, |line, time| line.with("Time", time))
            }
            Self::Conveyor { name, speed } => named(name).with("Speed", speed),
            Self::ClearPath { name } | Self::Kill { name } => named(name),
            Self::KillAll { corners } => {
                let corners = corners.iter().flatten().zip(["MinPos", "MaxPos"]);
                corners.fold(line, |line, (corner, key)| with_vector(line, key, *corner))
            }
            Self::GetSta { class_name, name } => with_text(named(name), "ClassName", class_name),
            Self::Unknown { .. } => line,
        }
    }
}

/// Reads a boolean in any case, as `SetWP` does (WorldController.uc:474-517).
fn flag(line: &Line, key: &str, problems: &mut Vec<Problem>) -> Option<bool> {
    let text = line.get(key).filter(|text| !text.is_empty())?;
    let known = ["true", "false"].iter().any(|word| text.eq_ignore_ascii_case(word));
    if !known {
        problems.push(Problem::NotABool { key: key.to_owned(), got: shown(text) });
    }
    Some(text.eq_ignore_ascii_case("true"))
}
