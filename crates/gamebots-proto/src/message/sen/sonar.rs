//! `{Name n} {Range d}`, four decimals, truncated; one line a sonar (SonarSensor.uc:38-90).

use super::super::number;
use super::{ReadWrite, name};
use crate::Line;
use crate::number::fixed;

/// Distance to the nearest echo.
#[derive(Debug, Clone, PartialEq)]
pub struct Sonar {
    /// Name of the sensor.
    pub name: String,
    /// Distance, m.
    pub range: f32,
}

impl ReadWrite for Sonar {
    const TYPE: &'static str = "Sonar";

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }

    fn write(&self) -> String {
        format!("{{Name {}}} {{Range {}}}", self.name, fixed(self.range, 4))
    }

    fn read(line: &Line) -> Option<Self> {
        Some(Self { name: name(line)?, range: number(line, "Range")? })
    }
}
