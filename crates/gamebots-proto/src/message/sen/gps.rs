//! `{Name n} {Latitude d,m,N} {Longitude d,m,W} {Fix 1} {Satellites n}` (GPSSensor.uc); without a fix there is no place.

use super::Body;
use crate::field::{Field, Format, Value, record};
use crate::number::fixed;

/// An angle on the Earth: whole degrees, minutes and a letter.
#[derive(Debug, Clone, PartialEq)]
pub struct Bearing {
    /// Whole degrees, without a sign.
    pub degrees: u32,
    /// Minutes, 0 to 60.
    pub minutes: f32,
    /// `N`, `S`, `E` or `W`.
    pub letter: char,
}

/// Without a fix the block is missing.
impl Value for Option<Bearing> {
    fn write(&self, _: Format) -> Option<String> {
        self.as_ref().map(|Bearing { degrees, minutes, letter }| format!("{degrees},{},{letter}", fixed(*minutes, 4)))
    }

    fn read(text: Option<&str>, _: Format) -> Option<Self> {
        let Some(text) = text else { return Some(None) };
        let mut parts = text.split(',').map(str::trim);
        let (degrees, minutes) = (parts.next()?.parse().ok()?, parts.next()?.parse().ok()?);
        Some(Some(Bearing { degrees, minutes, letter: parts.next()?.chars().next()? }))
    }
}

record! {
    /// Place by satellites.
    Gps {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Degrees, minutes, and `N` or `S`; missing without a fix.
        latitude: Option<Bearing> = Field::new("Latitude", Format::Minutes),
        /// Degrees, minutes, and `E` or `W`; missing without a fix.
        longitude: Option<Bearing> = Field::new("Longitude", Format::Minutes),
        /// 1 with four satellites in view, else 0.
        fix: u32 = Field::new("Fix", Format::Integer),
        /// Satellites in view.
        satellites: u32 = Field::new("Satellites", Format::Integer),
    }
}

impl Body for Gps {
    const TYPE: &'static str = "GPS";
    const TIME: [Format; 2] = [Format::Rounded(4), Format::Absent];

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }
}
