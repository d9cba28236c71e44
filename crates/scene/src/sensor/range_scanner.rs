//! Lasers: a fan of beams from right to left (RangeScanner.uc:18-71, SICK.uc, HokuyoURG04LX.uc).
//!
//! Angles are rounded to USARSim's whole rotation units, which fixes the number of beams: 21, 181 and 228.

use std::sync::Arc;

use serde::{Deserialize, Deserializer, Serialize};

use super::MAX_BEAMS;
use crate::reading::reading;
use crate::rotation_units;

/// Settings of a laser.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct RangeScanner {
    /// Reading without a hit, m.
    pub max_range: f64,
    /// Smallest range, m; reported, and applied to infrared beams alone.
    pub min_range: f64,
    /// Angle between two beams, rad.
    pub resolution: f64,
    /// Angle of the whole fan, rad.
    pub field_of_view: f64,
    /// True if the fan is spread by yaw.
    pub yaw: bool,
    /// True if the fan is spread by pitch.
    pub pitch: bool,
    /// True if the beams pass through glass.
    #[serde(default)]
    pub infrared: bool,
    /// Smoke that a beam passes before it reads 0: density times path; `None` passes any.
    #[serde(default)]
    pub smoke: Option<f64>,
}

/// Plain scanner (DefaultUSAR.ini:100-107).
pub const PLAIN: RangeScanner = RangeScanner {
    max_range: 4.0,
    min_range: 0.1,
    resolution: 0.157,
    field_of_view: 3.14,
    yaw: true,
    pitch: false,
    infrared: false,
    smoke: None,
};
/// SICK LMS 200 (DefaultUSAR.ini:137-140).
pub const SICK: RangeScanner = RangeScanner { max_range: 20.0, field_of_view: 3.14159, resolution: 0.01745, ..PLAIN };
/// Hokuyo URG-04LX (DefaultUSAR.ini:94-98; the smoke is that of HokuyoURG04LX.uc).
pub const HOKUYO_URG_04LX: RangeScanner =
    RangeScanner { field_of_view: 4.189, resolution: 0.0184086914, smoke: Some(0.00575), ..PLAIN };
/// Infrared scanner (DefaultUSAR.ini:208-215; it has no yaw there, which it needs to scan).
pub const INFRARED: RangeScanner =
    RangeScanner { max_range: 10.0, min_range: 0.2, resolution: 0.087, infrared: true, ..PLAIN };

/// The beams of a laser.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fan {
    /// Angle of the first beam, rad; positive to the right.
    pub first: f64,
    /// Angle between neighbouring beams, rad; each beam is to the left of the previous one.
    pub resolution: f64,
    /// Smallest range, m.
    pub min_range: f64,
    /// Reading without a hit, m.
    pub max_range: f64,
    /// True if all beams are in the sensor's x-y plane.
    pub level: bool,
}

impl Fan {
    /// Returns the number of beams.
    pub(super) fn rays(&self) -> usize {
        (2.0 * self.first / self.resolution) as usize + 1
    }
}

impl RangeScanner {
    /// Returns a copy with the numbers given in `settings`.
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
            smoke: Option<f64>,
        }
        let settings = Settings::deserialize(settings)?;
        Ok(Self {
            max_range: settings.max_range.unwrap_or(self.max_range),
            min_range: settings.min_range.unwrap_or(self.min_range),
            resolution: settings.resolution.unwrap_or(self.resolution),
            field_of_view: settings.field_of_view.unwrap_or(self.field_of_view),
            yaw: settings.yaw.unwrap_or(self.yaw),
            pitch: settings.pitch.unwrap_or(self.pitch),
            infrared: self.infrared,
            smoke: settings.smoke.or(self.smoke),
        })
    }

    /// Checks that these numbers make a scan.
    pub(super) fn validate(&self) -> Result<(), &'static str> {
        let good = self.max_range > 0.0
            && self.max_range <= 10_000.0
            && (0.0..=self.max_range).contains(&self.min_range)
            && (0.0..=std::f64::consts::TAU).contains(&self.field_of_view)
            && self.resolution > 0.0
            && self.resolution <= std::f64::consts::TAU
            && self.smoke.is_none_or(|smoke| (0.0..=1e6).contains(&smoke))
            && self.field_of_view / self.resolution <= MAX_BEAMS as f64;
        if good {
            Ok(())
        } else {
            Err(
                "min_range <= max_range, both 0 to 10000 m, field_of_view and resolution 0 to 2 pi, at most 10000 beams, smoke 0 to 1000000",
            )
        }
    }

    /// Returns the angle between two beams in whole rotation units, at least 1.
    pub fn resolution_units(&self) -> i32 {
        rotation_units::from_radians(self.resolution).max(1)
    }

    /// Returns the fan of beams, with angles in whole rotation units.
    pub fn fan(&self) -> Fan {
        let first = rotation_units::from_radians(self.field_of_view) / 2;
        let [first, resolution] =
            [first, self.resolution_units()].map(|units| f64::from(rotation_units::to_radians(units)));
        let (min_range, max_range) = (self.min_range, self.max_range);
        Fan { first, resolution, min_range, max_range, level: self.yaw && !self.pitch }
    }
}

reading! {
    /// A fan of distances.
    {
        /// Distances from the right to the left; the maximum range where nothing is hit.
        ranges: Arc<[f64]> = "m",
    }
}
