//! `{Name n} {PartName p} {Location x,y,z} ..` or `{Name n} {Status NoVictims}`, as clients of UT2004 read it (sensors.md 8).

use super::Body;
use crate::field::{Field, Format, record};

record! {
    /// A part of a victim in view.
    SeenPart {
        /// `Head`, `Arm`, `Hand`, `Chest`, `Pelvis`, `Leg` or `Foot`.
        part: String = Field::new("PartName", Format::Word),
        /// Its position in the frame of the sensor.
        location: [f32; 3] = Field::new("Location", Format::Rounded(2)).unit("m"),
    }
}

record! {
    /// Parts of victims in view.
    VictSensor {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// `NoVictims` if no part is in view, else missing.
        status: Option<String> = Field::new("Status", Format::Word),
        ;
        /// The parts, victim by victim.
        parts: [SeenPart]
    }
}

impl Body for VictSensor {
    const TYPE: &'static str = "VictSensor";
    const TIME: [Format; 2] = [Format::Absent, Format::Absent];

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }
}
