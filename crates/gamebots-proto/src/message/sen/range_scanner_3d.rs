//! `{Name n} {Resolution v,h} {FOV v,h} {Range d,d,..}`: a scanner of UT2004 that scans rows (sensors.md 8, us_parser.h:155).

use super::Body;
use crate::field::{Field, Format, record};

record! {
    /// Rows of distances from the top to the bottom, each from the right to the left.
    RangeScanner3D {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Angles between two rows and between two beams of a row.
        resolution: Vec<f32> = Field::new("Resolution", Format::Fixed(4)).unit("rad"),
        /// Angles between the first and the last row, and between the ends of a row.
        field_of_view: Vec<f32> = Field::new("FOV", Format::Fixed(4)).unit("rad"),
        /// Distances; the maximum range where nothing is hit.
        ranges: Vec<f32> = Field::new("Range", Format::Fixed(2)).unit("m").ut2004(Format::Fixed(4)),
    }
}

record! {
    /// Configuration of a scanner of rows.
    RangeScanner3DConf {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Greatest range.
        max_range: f32 = Field::new("MaxRange", Format::Fixed(4)).unit("m"),
        /// Least range.
        min_range: f32 = Field::new("MinRange", Format::Fixed(4)).unit("m"),
        /// Angles between two rows and between two beams of a row.
        resolution: Vec<f32> = Field::new("Resolution", Format::Fixed(4)).unit("rad"),
        /// Angles between the first and the last row, and between the ends of a row.
        fov: Vec<f32> = Field::new("Fov", Format::Fixed(4)).unit("rad"),
    }
}

impl Body for RangeScanner3D {
    const TYPE: &'static str = "RangeScanner3D";
    const TIME: [Format; 2] = [Format::Rounded(4), Format::Rounded(2)];

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }

    fn is_whole(&self) -> bool {
        !self.ranges.is_empty()
    }
}
