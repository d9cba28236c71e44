//! `{Name n} {Resolution r} {FOV f} {Range d,d,..}`: four decimals, ranges two, truncated (RangeScanner.uc:25-50).

use super::super::{floats, number};
use super::{ReadWrite, name};
use crate::Line;
use crate::number::fixed;

/// A fan of distances, from the right to the left.
#[derive(Debug, Clone, PartialEq)]
pub struct RangeScanner {
    /// Name of the sensor.
    pub name: String,
    /// Angle between two beams, rad.
    pub resolution: f32,
    /// Angle between the first and the last beam, rad.
    pub field_of_view: f32,
    /// Distances, m; the maximum range where nothing is hit.
    pub ranges: Vec<f32>,
}

impl ReadWrite for RangeScanner {
    const TYPE: &'static str = "RangeScanner";

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }

    fn write(&self) -> String {
        let ranges: Vec<String> = self.ranges.iter().map(|&range| fixed(range, 2)).collect();
        let [resolution, field_of_view] = [self.resolution, self.field_of_view].map(|angle| fixed(angle, 4));
        format!(
            "{{Name {}}} {{Resolution {resolution}}} {{FOV {field_of_view}}} {{Range {}}}",
            self.name,
            ranges.join(",")
        )
    }

    fn read(line: &Line) -> Option<Self> {
        Some(Self {
            name: name(line)?,
            resolution: number(line, "Resolution")?,
            field_of_view: number(line, "FOV")?,
            ranges: floats(line.get("Range")?)?,
        })
    }
}
