//! `NFO`: the greeting and the answers about the map (protocol.md 4.1).

use super::{float_array, number};
use crate::Line;
use crate::number::engine_floats;

/// A start pose or a path node of the map.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedPose {
    /// Its tag: no white space, no braces.
    pub name: String,
    /// Position, m.
    pub location: [f32; 3],
    /// Roll, pitch, yaw, rad.
    pub rotation: [f32; 3],
}

/// One `NFO` line.
#[derive(Debug, Clone, PartialEq)]
pub enum Nfo {
    /// The first line of every connection.
    Greeting {
        /// Name of the map.
        level: String,
        /// Time limit of the game, minutes.
        time_limit: u32,
    },
    /// Answer to GETSTARTPOSES.
    StartPoses(Vec<NamedPose>),
    /// Answer to GETPATHNODES.
    PathNodes(Vec<NamedPose>),
    /// Answer to GETCLOSESTPATHNODE.
    PathNode {
        /// Tag of the node; `None` on a map without nodes.
        name: String,
        /// Its position, m.
        location: [f32; 3],
    },
    /// What was wrong with a line of the client; sent only with `--report-errors`, not part of USARSim.
    Error(String),
}

impl Nfo {
    pub(super) fn write(&self) -> String {
        match self {
            Self::Greeting { level, time_limit } => {
                format!("NFO {{Gametype BotDeathMatch}} {{Level {level}}} {{TimeLimit {time_limit}}}")
            }
            Self::StartPoses(poses) => write_poses("StartPoses", poses),
            Self::PathNodes(poses) => write_poses("PathNodes", poses),
            Self::PathNode { name, location } => {
                format!("NFO {{Pathnode {name}}} {{Location {}}}", engine_floats(location))
            }
            Self::Error(text) => {
                format!("NFO {{Error {}}}", text.replace(['{', '}', '\r', '\n'], "'"))
            }
        }
    }

    pub(super) fn read(line: &Line) -> Option<Self> {
        let first = line.blocks.first()?;
        match first.key.as_str() {
            "Gametype" => {
                Some(Self::Greeting { level: line.get("Level")?.to_owned(), time_limit: number(line, "TimeLimit")? })
            }
            "StartPoses" => read_poses(line).map(Self::StartPoses),
            "PathNodes" => read_poses(line).map(Self::PathNodes),
            "Pathnode" => {
                Some(Self::PathNode { name: first.value.clone(), location: float_array(line.get("Location")?)? })
            }
            "Error" => Some(Self::Error(first.value.clone())),
            _ => None,
        }
    }
}

fn write_poses(key: &str, poses: &[NamedPose]) -> String {
    let list: Vec<String> = poses
        .iter()
        .map(|pose| format!("{} {} {}", pose.name, engine_floats(&pose.location), engine_floats(&pose.rotation)))
        .collect();
    let head = format!("NFO {{{key} {}}}", poses.len());
    if list.is_empty() { head } else { format!("{head} {{{}}}", list.join(" ")) }
}

/// The second block is a plain list, so its key is the first tag.
fn read_poses(line: &Line) -> Option<Vec<NamedPose>> {
    let Some(block) = line.blocks.get(1) else { return Some(Vec::new()) };
    let words: Vec<&str> = std::iter::once(block.key.as_str()).chain(block.value.split_whitespace()).collect();
    words
        .chunks(3)
        .map(|words| match words {
            [name, location, rotation] => Some(NamedPose {
                name: (*name).to_owned(),
                location: float_array(location)?,
                rotation: float_array(rotation)?,
            }),
            _ => None,
        })
        .collect()
}
