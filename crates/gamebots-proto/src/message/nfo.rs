//! `NFO`: the greeting and the answers about the map (protocol.md 4.1).

use crate::field::{self, Field, Format, Record, record};
use crate::{Block, Dialect, Line};

record! {
    /// A start pose or a path node of the map.
    NamedPose {
        /// Its tag: no white space, no braces.
        name: String = Field::new("Name", Format::Word),
        /// Position.
        location: [f32; 3] = Field::new("Location", Format::Rounded(4)).unit("m").ut2004(Format::Rounded(2)),
        /// Roll, pitch, yaw.
        rotation: [f32; 3] = Field::new("Orientation", Format::Rounded(4)).unit("rad").ut2004(Format::Rounded(2)),
    }
}

record! {
    /// The first line of every connection, after `{Gametype BotDeathMatch}`.
    Greeting {
        /// Name of the map.
        level: String = Field::new("Level", Format::Word),
        /// Time limit of the game.
        time_limit: u32 = Field::new("TimeLimit", Format::Integer).unit("min"),
    }
}

record! {
    /// The path node nearest to a position.
    PathNode {
        /// Tag of the node; `None` on a map without nodes.
        name: String = Field::new("Pathnode", Format::Word),
        /// Its position.
        location: [f32; 3] = Field::new("Location", Format::Rounded(4)).unit("m"),
    }
}

/// One `NFO` line.
#[derive(Debug, Clone, PartialEq)]
pub enum Nfo {
    /// The first line of every connection.
    Greeting(Greeting),
    /// Answer to GETSTARTPOSES.
    StartPoses(Vec<NamedPose>),
    /// Answer to GETPATHNODES.
    PathNodes(Vec<NamedPose>),
    /// Answer to GETCLOSESTPATHNODE.
    PathNode(PathNode),
    /// Answer to GETCLASSES: names of classes for INIT, without their package. Not part of USARSim.
    Classes(Vec<String>),
    /// A problem, such as with a line of the client; sent only with `--report-errors` or after REPORT, not part of USARSim.
    Error(String),
}

impl Nfo {
    pub(super) fn write(&self, dialect: Dialect) -> String {
        match self {
            Self::Greeting(greeting) => {
                format!("NFO {{Gametype BotDeathMatch}}{}", field::blocks(greeting.write(dialect)))
            }
            Self::StartPoses(poses) => write_poses("StartPoses", poses, dialect),
            Self::PathNodes(poses) => write_poses("PathNodes", poses, dialect),
            Self::PathNode(node) => format!("NFO{}", field::blocks(node.write(dialect))),
            Self::Classes(classes) => format!("NFO {{Classes {}}} {{Names {}}}", classes.len(), classes.join(",")),
            Self::Error(text) => {
                format!("NFO {{Error {}}}", text.replace(['{', '}', '\r', '\n'], "'"))
            }
        }
    }

    pub(super) fn read(line: &Line) -> Option<Self> {
        let first = line.blocks.first()?;
        match first.key.as_str() {
            "Gametype" => Greeting::read(line).map(Self::Greeting),
            "StartPoses" => read_poses(line).map(Self::StartPoses),
            "PathNodes" => read_poses(line).map(Self::PathNodes),
            "Pathnode" => PathNode::read(line).map(Self::PathNode),
            "Classes" => {
                let names = line.get("Names").unwrap_or_default().split(',').filter(|name| !name.is_empty());
                Some(Self::Classes(names.map(str::to_owned).collect()))
            }
            "Error" => Some(Self::Error(first.value.clone())),
            _ => None,
        }
    }
}

/// Writes poses. UDK has the values of all poses in one block; UT2004 has a block with keys for each pose.
fn write_poses(key: &str, poses: &[NamedPose], dialect: Dialect) -> String {
    let head = format!("NFO {{{key} {}}}", poses.len());
    let written = poses.iter().map(|pose| pose.write(dialect));
    match dialect {
        Dialect::Ut2004 => head + &written.map(|pose| field::merged(&pose)).collect::<String>(),
        Dialect::Udk if poses.is_empty() => head,
        Dialect::Udk => format!("{head} {{{}}}", written.map(|pose| field::bare(&pose)).collect::<Vec<_>>().join(" ")),
    }
}

/// Reads poses in either dialect. UDK's second block is a plain list, so its key is the first tag.
fn read_poses(line: &Line) -> Option<Vec<NamedPose>> {
    let Some(block) = line.blocks.get(1) else { return Some(Vec::new()) };
    let pose = |blocks| NamedPose::read(&Line { blocks, ..Line::default() });
    let items: Vec<Vec<Block>> = line.blocks.iter().skip(1).map(|block| NamedPose::TABLE.unmerged(block)).collect();
    if items.iter().all(|item| item.len() > 1) {
        return items.into_iter().map(pose).collect();
    }
    let words: Vec<&str> = std::iter::once(block.key.as_str()).chain(block.value.split_whitespace()).collect();
    let named = |words: &[&str]| {
        let keys = NamedPose::TABLE.fields.iter().map(|field| field.key[0]);
        let block = |(key, word): (&str, &&str)| Block { key: key.to_owned(), value: (*word).to_owned() };
        keys.zip(words).map(block).collect()
    };
    words.chunks(3).map(|words| pose(named(words))).collect()
}
