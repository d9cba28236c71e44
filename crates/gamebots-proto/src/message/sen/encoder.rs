//! `{Name W1} {Tick n}`, once for each wheel that the sensor reads (Encoder.uc:29-52).

use super::ReadWrite;
use crate::Line;

/// Ticks of wheel encoders.
#[derive(Debug, Clone, PartialEq)]
pub struct Encoder {
    /// Name and tick of each wheel, in order; empty when the sensor reads no wheel.
    pub ticks: Vec<(String, i32)>,
}

impl ReadWrite for Encoder {
    const TYPE: &'static str = "Encoder";

    fn name(&self) -> Option<&str> {
        self.ticks.first().map(|(name, _)| name.as_str())
    }

    fn write(&self) -> String {
        let wheels: Vec<String> =
            self.ticks.iter().map(|(name, tick)| format!("{{Name {name}}} {{Tick {tick}}}")).collect();
        wheels.join(" ")
    }

    fn read(line: &Line) -> Option<Self> {
        let body: Vec<_> = line.blocks.iter().filter(|block| block.key == "Name" || block.key == "Tick").collect();
        let ticks = body.chunks(2).map(|pair| match pair {
            [name, tick] => Some((name.value.clone(), tick.value.parse().ok()?)),
            _ => None,
        });
        Some(Self { ticks: ticks.collect::<Option<_>>()? })
    }
}
