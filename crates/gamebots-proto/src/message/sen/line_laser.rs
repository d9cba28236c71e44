//! `{Name n} {Location x,y,z} {Orientation r,p,y} {Points [x,y,z][x,y,z]..}` (LineLaser.uc:59-349).

use super::Body;
use crate::field::{Field, Format, record};

record! {
    /// Points of a line of light, from the left to the right, in the world.
    LineLaser {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Position of the sensor in the world.
        location: [f32; 3] = Field::new("Location", Format::Fixed(4)).unit("m"),
        /// Roll, pitch, yaw of the sensor in the world.
        orientation: [f32; 3] = Field::new("Orientation", Format::Fixed(4)).unit("rad"),
        /// Points where the light meets a surface, or at the maximum range.
        points: Vec<[f32; 3]> = Field::new("Points", Format::Brackets(3)).unit("m"),
    }
}

record! {
    /// Configuration of a line laser.
    LineLaserConf {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Greatest range.
        max_range: f32 = Field::new("MaxRange", Format::Fixed(4)).unit("m"),
        /// Least range; reported, not applied.
        min_range: f32 = Field::new("MinRange", Format::Fixed(4)).unit("m"),
        /// Angle between the first and the last beam.
        fov: f32 = Field::new("FOV", Format::Fixed(4)).unit("rad"),
        /// Number of beams.
        resolution: u32 = Field::new("Resolution", Format::Integer),
    }
}

impl Body for LineLaser {
    const TYPE: &'static str = "LineLaser";
    const TIME: [Format; 2] = [Format::Absent, Format::Absent];

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }
}
