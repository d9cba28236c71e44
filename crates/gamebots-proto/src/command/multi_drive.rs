//! `MULTIDRIVE`: targets of several joints at once, as UT2004's robots with flippers took them.

use super::ReadWrite;
use crate::{Line, Problem, value};

/// Sets the targets of joints, rad or m. No reply.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MultiDrive {
    /// Joints and their targets in the order sent.
    pub targets: Vec<(String, f64)>,
}

impl ReadWrite for MultiDrive {
    fn read(line: &Line, problems: &mut Vec<Problem>) -> Self {
        let with_value = line.blocks.iter().filter(|block| !block.value.is_empty());
        let target = |block: &crate::Block| (block.key.clone(), value::scalar_of(&block.key, &block.value, problems));
        Self { targets: with_value.map(target).collect() }
    }

    fn write(&self) -> Line {
        self.targets.iter().fold(Line::new("MULTIDRIVE"), |line, (joint, target)| line.with(joint, target))
    }
}
