//! `{Name n} {x,y,z;x,y,z;..}`: points of a rotating scanner, in a block without a key (RotatingPointCloudScanner.uc).

use super::Body;
use crate::field::{Field, Format, record};

record! {
    /// Points in the frame of a rotating scanner.
    PointCloud {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Points where beams meet a surface, or at the maximum range.
        points: Vec<[f32; 3]> = Field::new("", Format::Semicolons(2)).unit("m"),
    }
}

impl Body for PointCloud {
    const TYPE: &'static str = "PCL";
    const TIME: [Format; 2] = [Format::Rounded(4), Format::Rounded(4)];

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }

    fn is_whole(&self) -> bool {
        !self.points.is_empty()
    }
}
