//! `{Name n} {Loudness l} {Duration d}` of UT2004, in the order that clients read (USARSimController's SoundInterface).

use super::Body;
use crate::field::{Field, Format, record};

record! {
    /// The loudest sound at the sensor.
    Sound {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Its loudness; 0 in silence.
        loudness: f32 = Field::new("Loudness", Format::Rounded(2)).unit("dB"),
        /// Its length.
        duration: f32 = Field::new("Duration", Format::Rounded(2)).unit("s"),
    }
}

impl Body for Sound {
    const TYPE: &'static str = "Sound";
    const TIME: [Format; 2] = [Format::Absent, Format::Absent];

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }
}
