//! `DRIVE`. The meaning of its keys depends on the robot's locomotion.

use super::ReadWrite;
use crate::{Block, Line, Problem, value};

/// Sets speeds that hold until they are replaced. No reply.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Drive {
    /// True if speeds are percent of the limit. It holds from now on, or for an aerial robot in this line alone.
    pub normalized: Option<bool>,
    /// Headlight, shown in STA.
    pub light: Option<bool>,
    /// All other blocks in the order sent.
    pub blocks: Vec<Block>,
}

impl Drive {
    /// Adds a number.
    pub fn with(mut self, key: &str, number: f64) -> Self {
        self.blocks.push(Block { key: key.to_owned(), value: number.to_string() });
        self
    }

    /// Returns the number of the first block with this key, in any case; `None` if it is missing or empty.
    pub fn number(&self, key: &str, problems: &mut Vec<Problem>) -> Option<f64> {
        let block = self.blocks.iter().find(|block| block.key.eq_ignore_ascii_case(key))?;
        (!block.value.is_empty()).then(|| Self::number_of(block, problems))
    }

    /// Returns the number of a block; 0 if it is not a number.
    pub fn number_of(block: &Block, problems: &mut Vec<Problem>) -> f64 {
        value::scalar_of(&block.key, &block.value, problems)
    }

    /// Returns the index in a block, counted from 0; `None` if it is not an index.
    pub fn index_of(block: &Block, problems: &mut Vec<Problem>) -> Option<usize> {
        value::index_of(block, problems)
    }

    /// Returns the numbers of several keys.
    pub fn numbers<const N: usize>(&self, keys: [&str; N], problems: &mut Vec<Problem>) -> [Option<f64>; N] {
        keys.map(|key| self.number(key, problems))
    }
}

impl ReadWrite for Drive {
    fn read(line: &Line, problems: &mut Vec<Problem>) -> Self {
        let normalized = value::boolean(line, "Normalized", problems);
        let light = value::boolean(line, "Light", problems);
        let is_flag = |block: &&Block| ["Normalized", "Light"].iter().any(|flag| block.key.eq_ignore_ascii_case(flag));
        let blocks = line.blocks.iter().filter(|block| !is_flag(block)).cloned().collect();
        Self { normalized, light, blocks }
    }

    fn write(&self) -> Line {
        let mut line = Line::new("DRIVE");
        line.blocks.clone_from(&self.blocks);
        for (key, flag) in [("Normalized", self.normalized), ("Light", self.light)] {
            line = flag.into_iter().fold(line, |line, flag| line.with(key, flag));
        }
        line
    }
}
