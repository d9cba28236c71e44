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
    /// True to set a robot that lies on its back onto its wheels (UT2004's manual).
    pub flip: Option<bool>,
    /// All other blocks in the order sent.
    pub given: Vec<Given>,
}

/// A block with its number. A robot that does not use the key does not care if it is a number.
#[derive(Debug, Clone, PartialEq)]
pub struct Given {
    /// The block as it was sent.
    block: Block,
    /// The number; 0 if it is none.
    number: f64,
    /// The problem of the number, if it has one.
    problem: Option<Problem>,
}

impl Given {
    fn new(block: Block) -> Self {
        let mut problems = Vec::new();
        let number = value::scalar_of(&block.key, &block.value, &mut problems);
        Self { block, number, problem: problems.pop() }
    }

    /// True if it has this key, in any case.
    pub fn is(&self, key: &str) -> bool {
        self.block.key.eq_ignore_ascii_case(key)
    }

    /// Returns the key as it was sent.
    pub fn key(&self) -> &str {
        &self.block.key
    }

    /// True if it has a value.
    pub fn has_value(&self) -> bool {
        !self.block.value.is_empty()
    }

    /// True if its value is the number 0.
    pub fn is_zero(&self) -> bool {
        self.number == 0.0 && self.problem.is_none()
    }

    /// Returns the number, and reports its problem. It is 0 if the block has none.
    pub fn number(&self, problems: &mut Vec<Problem>) -> f64 {
        problems.extend(self.problem.clone());
        self.number
    }

    /// Returns the number as an index, counted from 0; `None` if it is not an index.
    pub fn index(&self, problems: &mut Vec<Problem>) -> Option<usize> {
        value::index_of(&self.block, problems)
    }
}

impl Drive {
    /// Adds a number.
    pub fn with(mut self, key: &str, number: f64) -> Self {
        let mut problems = Vec::new();
        let block = Block { key: key.to_owned(), value: number.to_string() };
        let number = value::checked(key, number, &mut problems);
        self.given.push(Given { block, number, problem: problems.pop() });
        self
    }

    /// Returns the number of the first block with this key, in any case; `None` if it is missing or empty.
    pub fn number(&self, key: &str, problems: &mut Vec<Problem>) -> Option<f64> {
        let given = self.given.iter().find(|given| given.is(key))?;
        (!given.block.value.is_empty()).then(|| given.number(problems))
    }

    /// Returns the numbers of several keys.
    pub fn numbers<const N: usize>(&self, keys: [&str; N], problems: &mut Vec<Problem>) -> [Option<f64>; N] {
        keys.map(|key| self.number(key, problems))
    }
}

impl ReadWrite for Drive {
    const KEYS: &'static [&'static str] = &[
        "Left",
        "Right",
        "Front-Left",
        "Front-Right",
        "Back-Left",
        "Back-Right",
        "LinearVelocity",
        "LateralVelocity",
        "RotationalVelocity",
        "AltitudeVelocity",
        "PitchAngle",
        "RollAngle",
        "Speed",
        "FrontSteer",
        "RearSteer",
        "WheelNumber",
        "WheelSpeed",
        "WheelSteer",
        "Normalized",
        "Light",
        "Flip",
    ];

    fn read(line: &Line, problems: &mut Vec<Problem>) -> Self {
        let normalized = value::boolean(line, "Normalized", problems);
        let light = value::boolean(line, "Light", problems);
        let flip = value::boolean(line, "Flip", problems);
        let is_flag =
            |block: &&Block| ["Normalized", "Light", "Flip"].iter().any(|flag| block.key.eq_ignore_ascii_case(flag));
        let given = line.blocks.iter().filter(|block| !is_flag(block)).cloned().map(Given::new).collect();
        Self { normalized, light, flip, given }
    }

    fn write(&self) -> Line {
        let mut line = Line::new("DRIVE");
        line.blocks = self.given.iter().map(|given| given.block.clone()).collect();
        for (key, flag) in [("Normalized", self.normalized), ("Light", self.light), ("Flip", self.flip)] {
            line = flag.into_iter().fold(line, |line, flag| line.with(key, flag));
        }
        line
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Command;

    #[test]
    fn a_number_that_a_program_gives_is_as_one_that_is_read() {
        for (number, problems_expected) in
            [(0.1, 0), (-1e-300, 0), (1e6, 0), (1e7, 1), (f64::INFINITY, 1), (f64::NAN, 1)]
        {
            let given = Drive::default().with("Left", number);
            let Some(Command::Drive(read)) = Command::parse(&given.write().to_string(), &mut Vec::new()) else {
                panic!("no DRIVE: {number}");
            };
            let [given, read] = [given, read].map(|drive| {
                let mut problems = Vec::new();
                (drive.number("Left", &mut problems), problems.len())
            });
            assert_eq!((given, given.1), (read, problems_expected), "{number}");
        }
    }
}
