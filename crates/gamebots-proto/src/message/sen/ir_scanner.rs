//! `{Name n} {Resolution r} {FOV f} {Range d,d,..}`: the scan that IRScanner.uc means, in the form of a laser's.

use super::Body;
use crate::field::{Field, Format, record};

record! {
    /// A fan of infrared distances, from the right to the left.
    IrScanner {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Angle between two beams.
        resolution: f32 = Field::new("Resolution", Format::Fixed(4)).unit("rad"),
        /// Angle between the first and the last beam.
        field_of_view: f32 = Field::new("FOV", Format::Fixed(4)).unit("rad"),
        /// Distances; the maximum range where nothing is hit.
        ranges: Vec<f32> = Field::new("Range", Format::Fixed(2)).unit("m").ut2004(Format::Fixed(4)),
    }
}

impl Body for IrScanner {
    const TYPE: &'static str = "IRScanner";
    const TIME: [Format; 2] = [Format::Rounded(4), Format::Rounded(2)];

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }

    fn is_whole(&self) -> bool {
        !self.ranges.is_empty()
    }
}
