//! Lasers: a fan of beams from the right to the left (RangeScanner.uc:18-71, SICK.uc, HokuyoURG04LX.uc).
//!
//! Angles go through USARSim's whole rotation units, which fixes the number of beams: 21, 181 and 228.

#![expect(clippy::approx_constant, reason = "the numbers are those of USARSim's files")]

use serde::{Deserialize, Deserializer, Serialize};

use crate::rotation_units;

/// Numbers of a laser.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct RangeScanner {
    /// What a miss reads, m.
    pub max_range: f64,
    /// Reported, not applied, m.
    pub min_range: f64,
    /// Angle between two beams, rad.
    pub resolution: f64,
    /// Angle of the whole fan, rad.
    pub field_of_view: f64,
    /// Whether the fan is spread by yaw.
    pub yaw: bool,
    /// Whether the fan is spread by pitch.
    pub pitch: bool,
}

/// The plain scanner (DefaultUSAR.ini:100-107).
pub const PLAIN: RangeScanner =
    RangeScanner { max_range: 4.0, min_range: 0.1, resolution: 0.157, field_of_view: 3.14, yaw: true, pitch: false };
/// SICK LMS 200 (DefaultUSAR.ini:137-140).
pub const SICK: RangeScanner = RangeScanner { max_range: 20.0, field_of_view: 3.14159, resolution: 0.01745, ..PLAIN };
/// Hokuyo URG-04LX (DefaultUSAR.ini:94-98).
pub const HOKUYO_URG_04LX: RangeScanner = RangeScanner { field_of_view: 4.189, resolution: 0.0184086914, ..PLAIN };

/// The beams of a laser.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fan {
    /// Angle of the first beam, to the right positive, rad.
    pub first: f64,
    /// How far each beam is to the left of the one before, rad.
    pub resolution: f64,
    /// Smallest range, m.
    pub min_range: f64,
    /// What a miss reads, m.
    pub max_range: f64,
    /// Whether all beams are in the sensor's plane of x and y.
    pub level: bool,
}

impl Fan {
    /// How many beams it has.
    pub(super) fn rays(&self) -> usize {
        (2.0 * self.first / self.resolution) as usize + 1
    }
}

impl RangeScanner {
    /// The same with the numbers that settings name.
    pub(super) fn changed<'de, D: Deserializer<'de>>(&self, settings: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        struct Settings {
            max_range: Option<f64>,
            min_range: Option<f64>,
            resolution: Option<f64>,
            field_of_view: Option<f64>,
            yaw: Option<bool>,
            pitch: Option<bool>,
        }
        let settings = Settings::deserialize(settings)?;
        Ok(Self {
            max_range: settings.max_range.unwrap_or(self.max_range),
            min_range: settings.min_range.unwrap_or(self.min_range),
            resolution: settings.resolution.unwrap_or(self.resolution),
            field_of_view: settings.field_of_view.unwrap_or(self.field_of_view),
            yaw: settings.yaw.unwrap_or(self.yaw),
            pitch: settings.pitch.unwrap_or(self.pitch),
        })
    }

    /// Numbers that a scan can be made with.
    pub(super) fn validate(&self) -> Result<(), &'static str> {
        let good = self.max_range > 0.0
            && self.max_range <= 10_000.0
            && (0.0..=self.max_range).contains(&self.min_range)
            && (0.0..=std::f64::consts::TAU).contains(&self.field_of_view)
            && self.resolution > 0.0
            && self.resolution <= std::f64::consts::TAU
            && self.field_of_view / self.resolution <= 10_000.0;
        if good {
            Ok(())
        } else {
            Err(
                "min_range <= max_range, both 0 to 10000 m, field_of_view and resolution 0 to 2 pi, at most 10000 beams",
            )
        }
    }

    /// Angle between two beams, whole rotation units.
    pub fn resolution_units(&self) -> i32 {
        rotation_units::from_radians(self.resolution).max(1)
    }

    /// The fan as it is cast.
    pub fn fan(&self) -> Fan {
        let first = rotation_units::from_radians(self.field_of_view) / 2;
        let [first, resolution] =
            [first, self.resolution_units()].map(|units| f64::from(rotation_units::to_radians(units)));
        let (min_range, max_range) = (self.min_range, self.max_range);
        Fan { first, resolution, min_range, max_range, level: self.yaw && !self.pitch }
    }
}
