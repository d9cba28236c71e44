//! `MOVE {Type Walk_Forward|Walk_Backward|Run} {Action New|Append} {Location x,y}`, `MOVE {Action Pause|Resume}` and `GOTO {Name n}`: orders
//! for avatars (BotConnection.uc:208-281, 664-701; protocol.md 3.1).

use super::{ReadWrite, note_keys, text};
use crate::{Line, Problem, value};

/// A way of walking.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Gait {
    /// `Walk_Forward`.
    #[default]
    Forward,
    /// `Walk_Backward`.
    Backward,
    /// `Run`.
    Run,
}

/// Names of the gaits, with this case in the original.
const GAITS: [(&str, Gait); 3] =
    [("Walk_Forward", Gait::Forward), ("Walk_Backward", Gait::Backward), ("Run", Gait::Run)];

/// The owner of the words of MOVE, in messages.
const OWNER: &str = "MOVE";

/// The end of a walk.
#[derive(Debug, Clone, PartialEq)]
pub enum Target {
    /// A place, x and y, m.
    Place([f64; 2]),
    /// A path node of the map.
    Node(String),
}

/// An order to an avatar.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Walk {
    /// Walks to a place, after the places before it or instead of them.
    To {
        /// The way of walking.
        gait: Gait,
        /// True to go there after the places before it.
        appends: bool,
        /// The end of the walk.
        target: Target,
    },
    /// Stands still.
    Pause,
    /// Goes on.
    Resume,
    /// An order that the avatar does not understand.
    #[default]
    Nothing,
}

impl ReadWrite for Walk {
    const KEYS: &'static [&'static str] = &["Type", "Action", "Location", "Pathnode"];

    fn read(line: &Line, problems: &mut Vec<Problem>) -> Self {
        note_keys("MOVE", line, Self::KEYS, problems);
        let [gait, action] = ["Type", "Action"].map(|key| text(line, key));
        let is = |word: &str| action.eq_ignore_ascii_case(word);
        if is("Pause") {
            return Self::Pause;
        }
        if is("Resume") {
            return Self::Resume;
        }
        if !is("New") && !is("Append") {
            let known = ["New", "Append", "Pause", "Resume"].into_iter();
            problems.push(Problem::unknown_name("Action", &action, known, OWNER, "the avatar goes on as before"));
            return Self::Nothing;
        }
        let Some((_, gait)) = GAITS.iter().find(|(name, _)| name.eq_ignore_ascii_case(&gait)).copied() else {
            let known = GAITS.iter().map(|(name, _)| *name);
            problems.push(Problem::unknown_name("Type", &gait, known, OWNER, "the avatar goes on as before"));
            return Self::Nothing;
        };
        let target = match (line.get("Location").filter(|text| !text.is_empty()), text(line, "Pathnode")) {
            (Some(place), _) => {
                // A height is ignored. Of two numbers the second is z to the vector's own rule, as the original reads it.
                let [x, y, z] = value::vector_or_part(line, "Location", problems);
                Target::Place(if place.matches(',').count() == 1 { [x, z] } else { [x, y] })
            }
            (None, node) if !node.is_empty() => Target::Node(node),
            _ => {
                problems.push(Problem::MissingKey { verb: "MOVE", key: "Location or Pathnode" });
                return Self::Nothing;
            }
        };
        Self::To { gait, appends: is("Append"), target }
    }

    fn write(&self) -> Line {
        let line = Line::new("MOVE");
        match self {
            Self::To { gait, appends, target } => {
                let name = GAITS.iter().find(|(_, known)| known == gait).map_or("", |(name, _)| name);
                let line = line.with("Type", name).with("Action", if *appends { "Append" } else { "New" });
                match target {
                    Target::Place([x, y]) => line.with("Location", format_args!("{x},{y}")),
                    Target::Node(node) => line.with("Pathnode", node),
                }
            }
            Self::Pause => line.with("Action", "Pause"),
            Self::Resume => line.with("Action", "Resume"),
            Self::Nothing => line,
        }
    }
}

/// Sends an avatar to a path node, by way of others.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct GoTo {
    /// Name of the node.
    pub name: String,
}

impl ReadWrite for GoTo {
    const KEYS: &'static [&'static str] = &["Name"];

    fn read(line: &Line, problems: &mut Vec<Problem>) -> Self {
        note_keys("GOTO", line, Self::KEYS, problems);
        Self { name: text(line, "Name") }
    }

    fn write(&self) -> Line {
        Line::new("GOTO").with("Name", &self.name)
    }
}
