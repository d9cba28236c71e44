//! `SET {Type t} {Name n} {Opcode o} {Params p}` (protocol.md 3.1), and the two forms that choose pictures (protocol.md 9):
//! `SET {Type Viewports} {Config SingleView} {Viewport1 c} ..` and `SET {Type Camera} {Robot r} {Name c} {Client ip}`. No reply.

use super::{ReadWrite, note_keys, text, with_text};
use crate::{Block, Line, Problem};

/// Most other blocks that are kept.
const MAX_MORE: usize = 8;
/// Keys that have fields of their own.
const OWN_KEYS: [&str; 4] = ["Type", "Name", "Opcode", "Params"];

/// Sends an opcode to every item of a type, or to the one of that name.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Set {
    /// Type of the item, any case.
    pub type_name: String,
    /// Its name, any case; empty means all of the type.
    pub name: String,
    /// The operation, any case.
    pub opcode: String,
    /// Argument of the opcode, as sent.
    pub params: String,
    /// Its other blocks, in the order sent, each with a value.
    pub more: Vec<Block>,
}

impl Set {
    /// Returns the value of another block, by its key in any case; empty if it is missing.
    pub fn other(&self, key: &str) -> &str {
        self.more.iter().find(|block| block.key.eq_ignore_ascii_case(key)).map_or("", |block| block.value.as_str())
    }

    /// Returns the parameters as numbers, split at commas or white space; `None` if any is not a number.
    pub fn numbers(&self) -> Option<Vec<f64>> {
        self.params
            .split(|c: char| c == ',' || c.is_whitespace())
            .filter(|part| !part.is_empty())
            .map(|part| part.parse().ok().filter(|number: &f64| number.is_finite()))
            .collect()
    }

    /// Returns true for the opcode `Close`, false for `Open`, and for `Grip` if its number is not 0, in any case. `None` for another one.
    pub fn closes(&self) -> Option<bool> {
        match self.opcode.to_ascii_uppercase().as_str() {
            "OPEN" => Some(false),
            "CLOSE" => Some(true),
            "GRIP" => Some(self.numbers().is_some_and(|it| it.first().is_some_and(|&number| number != 0.0))),
            _ => None,
        }
    }
}

impl ReadWrite for Set {
    const KEYS: &'static [&'static str] = &[
        "Type",
        "Name",
        "Opcode",
        "Params",
        "Config",
        "Viewport1",
        "Viewport2",
        "Viewport3",
        "Viewport4",
        "Robot",
        "Client",
    ];

    fn read(line: &Line, problems: &mut Vec<Problem>) -> Self {
        note_keys("SET", line, Self::KEYS, problems);
        let is_other = |block: &&Block| {
            !block.value.is_empty() && !OWN_KEYS.iter().any(|key| key.eq_ignore_ascii_case(&block.key))
        };
        Self {
            type_name: text(line, "Type"),
            name: text(line, "Name"),
            opcode: text(line, "Opcode"),
            params: text(line, "Params"),
            more: line.blocks.iter().filter(is_other).take(MAX_MORE).cloned().collect(),
        }
    }

    fn write(&self) -> Line {
        let line = with_text(Line::new("SET"), "Type", &self.type_name);
        let line = with_text(line, "Name", &self.name);
        let line = with_text(with_text(line, "Opcode", &self.opcode), "Params", &self.params);
        self.more.iter().fold(line, |line, Block { key, value }| line.with(key, value))
    }
}
