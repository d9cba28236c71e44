//! `ASTA` and `EFF`: state of an actuator and of an effector (protocol.md 4.6).

use super::number;
use crate::Line;
use crate::number::engine_float;

/// Where the joints of an actuator are.
#[derive(Debug, Clone, PartialEq)]
pub struct Asta {
    /// Simulated time, s.
    pub time: f32,
    /// Name of the actuator.
    pub name: String,
    /// Of its joints in order, rad or m. On the wire they are numbered from 1.
    pub values: Vec<f32>,
}

/// Whether a gripper is closed.
#[derive(Debug, Clone, PartialEq)]
pub struct Eff {
    /// Simulated time, s.
    pub time: f32,
    /// Name of the gripper.
    pub name: String,
    /// As it was commanded.
    pub closed: bool,
}

impl Asta {
    pub(super) fn write(&self) -> String {
        let link =
            |(number, value): (usize, &f32)| format!(" {{Link {}}} {{Value {}}}", number + 1, engine_float(*value));
        let links: String = self.values.iter().enumerate().map(link).collect();
        format!("ASTA {{Time {}}} {{Name {}}}{links}", engine_float(self.time), self.name)
    }

    pub(super) fn read(line: &Line) -> Option<Self> {
        let values = line.blocks.iter().filter(|block| block.key == "Value").map(|block| block.value.parse().ok());
        Some(Self {
            time: number(line, "Time")?,
            name: line.get("Name")?.to_owned(),
            values: values.collect::<Option<_>>()?,
        })
    }
}

impl Eff {
    pub(super) fn write(&self) -> String {
        let status = if self.closed { "CLOSED" } else { "OPEN" };
        format!("EFF {{Time {}}} {{Type Gripper}} {{Name {}}} {{Status {status}}}", engine_float(self.time), self.name)
    }

    pub(super) fn read(line: &Line) -> Option<Self> {
        let closed = match line.get("Status")? {
            "CLOSED" => true,
            "OPEN" => false,
            _ => return None,
        };
        Some(Self { time: number(line, "Time")?, name: line.get("Name")?.to_owned(), closed })
    }
}
