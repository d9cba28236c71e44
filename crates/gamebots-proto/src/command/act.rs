//! `ACT` and `MISPKG`: targets of the joints of an actuator. Unlike in other commands, the case of their keys matters, and so
//! does the order of their blocks (BotConnection.uc:70-97, 483-512). In MISPKG the blocks after a `Link` may have any order, and `Order`
//! may be missing, as older clients send it (clients-2.md 4).

use super::{MAX_REPORTED, ReadWrite, text, with_text};
use crate::{Block, Line, Problem, value};

/// Moves the joints of an actuator: `{Link i} {Value v}`, any number of times, links from 0. No reply.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Act {
    /// Name of the actuator, in any case.
    pub name: String,
    /// Links from 0 with their targets, rad or m.
    pub targets: Vec<(usize, f64)>,
    /// Opens a gripper with 0 and closes it with anything else.
    pub gripper: Option<f64>,
}

/// Moves the joints of an actuator in the form before ACT: `{Link i} {Value v} {Order 0}`, links from 1. Without an order it is 0. No
/// reply.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MisPkg {
    /// Name of the actuator, in any case.
    pub name: String,
    /// Links from 1 with their targets, rad or m. Targets of another order than 0 are dropped.
    pub targets: Vec<(usize, f64)>,
    /// Opens a gripper with 0 and closes it with anything else.
    pub gripper: Option<f64>,
}

impl ReadWrite for Act {
    const KEYS: &'static [&'static str] = &["Name", "Link", "Value", "Gripper"];

    fn read(line: &Line, problems: &mut Vec<Problem>) -> Self {
        note_exact_keys("ACT", line, Self::KEYS, problems);
        let pair = |blocks: &[Block], problems: &mut Vec<Problem>| match blocks {
            [link, of_value] if link.key == "Link" && of_value.key == "Value" => target(link, of_value, problems),
            _ => None,
        };
        let targets = line.blocks.windows(2).filter_map(|blocks| pair(blocks, problems)).collect();
        Self { name: text(line, "Name"), targets, gripper: gripper(line, problems) }
    }

    fn write(&self) -> Line {
        let line = with_text(Line::new("ACT"), "Name", &self.name);
        let link = |line: Line, (link, value): &(usize, f64)| line.with("Link", link).with("Value", value);
        let line = self.targets.iter().fold(line, link);
        self.gripper.into_iter().fold(line, |line, gripper| line.with("Gripper", gripper))
    }
}

impl ReadWrite for MisPkg {
    const KEYS: &'static [&'static str] = &["Name", "Link", "Value", "Order", "Gripper"];

    fn read(line: &Line, problems: &mut Vec<Problem>) -> Self {
        note_exact_keys("MISPKG", line, Self::KEYS, problems);
        let group = |blocks: &[Block], problems: &mut Vec<Problem>| {
            let (link, rest) = blocks.split_first().filter(|(link, _)| link.key == "Link")?;
            let find = |key: &str| rest.iter().find(|block| block.key == key);
            let is_position = find("Order").is_none_or(|order| order.value == "0");
            find("Value").filter(|_| is_position).and_then(|of_value| target(link, of_value, problems))
        };
        let groups = line.blocks.chunk_by(|_, next| next.key != "Link");
        let targets = groups.filter_map(|blocks| group(blocks, problems)).collect();
        Self { name: text(line, "Name"), targets, gripper: gripper(line, problems) }
    }

    fn write(&self) -> Line {
        let line = with_text(Line::new("MISPKG"), "Name", &self.name);
        let link =
            |line: Line, (link, value): &(usize, f64)| line.with("Link", link).with("Value", value).with("Order", 0);
        let line = self.targets.iter().fold(line, link);
        self.gripper.into_iter().fold(line, |line, gripper| line.with("Gripper", gripper))
    }
}

/// Reports keys that a command does not have. Of its own only `Name` has any case.
fn note_exact_keys(verb: &'static str, line: &Line, known: &[&str], problems: &mut Vec<Problem>) {
    let is_known = |key: &str| known.contains(&key) || key.eq_ignore_ascii_case("Name");
    let mut wrong: Vec<&str> = Vec::new();
    for key in line.blocks.iter().map(|block| block.key.as_str()).filter(|key| !key.is_empty() && !is_known(key)) {
        if !wrong.contains(&key) {
            wrong.push(key);
            problems.push(Problem::unknown_key(verb, key, known));
        }
        if wrong.len() >= MAX_REPORTED {
            break;
        }
    }
}

fn target(link: &Block, of_value: &Block, problems: &mut Vec<Problem>) -> Option<(usize, f64)> {
    Some((value::index_of(link, problems)?, value::scalar_of(&of_value.key, &of_value.value, problems)))
}

fn gripper(line: &Line, problems: &mut Vec<Problem>) -> Option<f64> {
    let block = line.blocks.iter().find(|block| block.key == "Gripper")?;
    Some(value::scalar_of(&block.key, &block.value, problems))
}
