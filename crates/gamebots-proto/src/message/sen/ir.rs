//! `{Name n} {Range r}` (IRSensor.uc:35-96); all infrared sensors of a UT2004 robot share a line.

use super::Body;
use crate::field::{Field, Format, record};

record! {
    /// Distance that an infrared sensor measures.
    Ir {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Distance to the first surface that stops infrared light.
        range: f32 = Field::new("Range", Format::Fixed(4)).unit("m"),
    }
}

record! {
    /// Configuration of an infrared sensor. The original has both ranges twice (RangeSensor.uc:63-77, IRSensor.uc:85-96).
    IrConf {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Greatest range.
        max_range: f32 = Field::new("MaxRange", Format::Fixed(4)).unit("m"),
        /// Least range.
        min_range: f32 = Field::new("MinRange", Format::Fixed(4)).unit("m"),
        /// Greatest range again.
        max_range_again: f32 = Field::new("MaxRange", Format::Fixed(4)).unit("m").only_udk(),
        /// Least range again.
        min_range_again: f32 = Field::new("MinRange", Format::Fixed(4)).unit("m").only_udk(),
    }
}

impl Body for Ir {
    const TYPE: &'static str = "IR";
    const TIME: [Format; 2] = [Format::Rounded(4), Format::Rounded(2)];
    const IS_GROUPED: bool = true;

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }
}
