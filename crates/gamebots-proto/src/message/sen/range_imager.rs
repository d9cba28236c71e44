//! `{Name n} {Resolution w,h} {FOV x,y} {Frames n} {Frame k} {Range d,d,..}` (KinectDepth.uc:21-164). The original writes 2.05 as
//! `2.5`; here depths have two decimals. It has a comma after the last depth, which is left out.

use super::Body;
use crate::field::{Field, Format, record};

record! {
    /// A part of a depth picture: rows from the top to the bottom, each from the left to the right.
    RangeImager {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Columns and rows of the whole picture.
        resolution: Vec<f32> = Field::new("Resolution", Format::Rounded(0)),
        /// Angles of the whole picture to the sides, and up and down.
        field_of_view: Vec<f32> = Field::new("FOV", Format::Fixed(4)).unit("rad"),
        /// Number of parts of a picture; 0 while none is taken.
        frames: u32 = Field::new("Frames", Format::Integer),
        /// Number of this part, from 0.
        frame: u32 = Field::new("Frame", Format::Integer),
        /// Depths along the axis of view; the maximum range where nothing is hit.
        ranges: Vec<f32> = Field::new("Range", Format::Fixed(2)).unit("m"),
    }
}

record! {
    /// Configuration of a depth camera.
    RangeImagerConf {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Greatest range.
        max_range: f32 = Field::new("MaxRange", Format::Fixed(4)).unit("m"),
        /// Least range; reported, not applied.
        min_range: f32 = Field::new("MinRange", Format::Fixed(4)).unit("m"),
        /// Columns and rows of the whole picture.
        resolution: Vec<f32> = Field::new("Resolution", Format::Rounded(0)),
        /// Angles of the whole picture to the sides, and up and down.
        fov: Vec<f32> = Field::new("Fov", Format::Fixed(4)).unit("rad"),
    }
}

impl Body for RangeImager {
    const TYPE: &'static str = "RangeImager";
    const TIME: [Format; 2] = [Format::Rounded(4), Format::Rounded(4)];

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }
}
