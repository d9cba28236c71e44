//! `{Name W1} {Tick n}`, once for each wheel that the sensor reads (Encoder.uc:29-52); all encoders of a UT2004 robot share a
//! line.

use super::Body;
use crate::field::{Field, Format, record};

record! {
    /// The angle of a wheel.
    Tick {
        /// Name of the encoder.
        name: String = Field::new("Name", Format::Word),
        /// Angle in units of the encoder's resolution.
        tick: i32 = Field::new("Tick", Format::Integer),
    }
}

record! {
    /// Ticks of wheel encoders.
    Encoder {
        ;
        /// Ticks of each wheel, in order; none if the sensor reads no wheel.
        ticks: [Tick]
    }
}

impl Body for Encoder {
    const TYPE: &'static str = "Encoder";
    const TIME: [Format; 2] = [Format::Rounded(4), Format::Absent];
    const IS_GROUPED: bool = true;

    fn name(&self) -> Option<&str> {
        self.ticks.first().map(|tick| tick.name.as_str())
    }
}
