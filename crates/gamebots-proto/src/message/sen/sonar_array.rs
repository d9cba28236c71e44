//! `{Name n}{x,y,z x,y,z ..}`: points of a grid of parallel beams, without blanks between the blocks (ExampleSonarArray.uc).

use super::Body;
use crate::field::{Field, Format, record};

record! {
    /// Points in the frame of a grid of sonars.
    SonarArray {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word).tight(),
        /// Points where beams meet a surface, or at the maximum range.
        points: Vec<[f32; 3]> = Field::new("", Format::Blanks(4)).unit("m").tight(),
    }
}

impl Body for SonarArray {
    const TYPE: &'static str = "PCL";
    const TIME: [Format; 2] = [Format::Rounded(4), Format::Rounded(4)];

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }
}
