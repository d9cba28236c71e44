//! `{Name n} {Vel v,v,..} {Pos p,p,..}`, four decimals, rounded (Tachometer.uc:27-61).

use super::super::floats;
use super::{ReadWrite, name};
use crate::Line;
use crate::number::engine_floats;

/// Speed and angle of every driven wheel.
#[derive(Debug, Clone, PartialEq)]
pub struct Tachometer {
    /// Name of the sensor.
    pub name: String,
    /// Speeds, rad/s; empty without wheels, and then both blocks are missing.
    pub velocities: Vec<f32>,
    /// Angles turned since the last reset up to the reading before, rad.
    pub positions: Vec<f32>,
}

impl ReadWrite for Tachometer {
    const TYPE: &'static str = "Tachometer";

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }

    fn write(&self) -> String {
        if self.velocities.is_empty() {
            return format!("{{Name {}}}", self.name);
        }
        let [velocities, positions] = [&self.velocities, &self.positions].map(|values| engine_floats(values));
        format!("{{Name {}}} {{Vel {velocities}}} {{Pos {positions}}}", self.name)
    }

    fn read(line: &Line) -> Option<Self> {
        let values = |key| line.get(key).map_or(Some(Vec::new()), floats);
        let (velocities, positions) = (values("Vel")?, values("Pos")?);
        let whole = velocities.len() == positions.len();
        if whole { Some(Self { name: name(line)?, velocities, positions }) } else { None }
    }
}
