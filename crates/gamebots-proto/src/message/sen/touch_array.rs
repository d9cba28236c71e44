//! `{Name n} {Touch True}` of a bow of bumpers (BumperArray.uc).

use super::Body;
use crate::field::{Field, Format, Value, record};
use crate::number::fixed;

/// Pitch, roll and yaw, rad, each with its word.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ArcRotation(pub [f32; 3]);

const WORDS: [&str; 3] = ["Pitch", "Roll", "Yaw"];

impl Value for ArcRotation {
    fn write(&self, _: Format) -> Option<String> {
        let turns: Vec<String> =
            WORDS.iter().zip(self.0).map(|(word, angle)| format!("{word} {}", fixed(angle, 4))).collect();
        Some(turns.join(" "))
    }

    fn read(text: Option<&str>, _: Format) -> Option<Self> {
        let words: Vec<&str> = text?.split_whitespace().collect();
        let [_, pitch, _, roll, _, yaw] = *words else { return None };
        Some(Self([pitch.parse().ok()?, roll.parse().ok()?, yaw.parse().ok()?]))
    }
}

record! {
    /// Contact of any of a bow of bumpers.
    TouchArray {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// True if something is within the reach of one of them.
        touch: bool = Field::new("Touch", Format::Boolean),
    }
}

record! {
    /// Configuration of a bow of bumpers.
    TouchArrayConf {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Diameter of each bumper.
        diameter: f32 = Field::new("Diameter", Format::Fixed(4)).unit("m"),
        /// Pitch, roll and yaw of the bow's plane.
        arc_rotation: ArcRotation = Field::new("ArcRotation", Format::Turns(4)).unit("rad"),
        /// Radius of the bow.
        arc_radius: f32 = Field::new("ArcRadius", Format::Fixed(4)).unit("m"),
        /// Angle of the bow.
        arc_angle: f32 = Field::new("ArcAngle", Format::Fixed(4)).unit("rad"),
    }
}

impl Body for TouchArray {
    const TYPE: &'static str = "TouchArray";
    const TIME: [Format; 2] = [Format::Rounded(4), Format::Rounded(4)];

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }
}
