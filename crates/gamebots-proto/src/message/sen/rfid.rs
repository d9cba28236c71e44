//! `{Name n} {ID i} {Location x,y,z} {Mem m} {ID ..} ..`, as clients of UT2004 read it (sensors.md 8).

use super::Body;
use crate::field::{Field, Format, record};

record! {
    /// A tag in reach.
    SeenTag {
        /// Its number.
        id: u32 = Field::new("ID", Format::Integer),
        /// Its position in the frame of the sensor.
        location: [f32; 3] = Field::new("Location", Format::Rounded(2)).unit("m"),
        /// The text in its memory; missing if that is empty.
        memory: Option<String> = Field::new("Mem", Format::Word),
    }
}

record! {
    /// Tags in reach of a reader.
    Rfid {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        ;
        /// The tags, the nearest first.
        tags: [SeenTag]
    }
}

impl Body for Rfid {
    const TYPE: &'static str = "RFID";
    const TIME: [Format; 2] = [Format::Absent, Format::Absent];

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }
}
