//! Numbers of a scanner that scans rows, a sensor of UT2004.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{MAX_BEAMS, ranges};
use crate::reading::reading;

/// Numbers of a scanner of rows.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Reading without a hit, m.
    pub max_range: f64,
    /// Smallest range, m; reported, not applied.
    pub min_range: f64,
    /// Angle from the first to the last row, rad.
    pub vertical_field_of_view: f64,
    /// Angle between two rows, rad.
    pub vertical_resolution: f64,
    /// Angle of a row, rad.
    pub horizontal_field_of_view: f64,
    /// Angle between two beams of a row, rad.
    pub horizontal_resolution: f64,
}

impl Default for Config {
    /// A SICK LMS 200 that nods by 20 degrees either way.
    fn default() -> Self {
        Self {
            max_range: 20.0,
            min_range: 0.1,
            vertical_field_of_view: 0.698,
            vertical_resolution: 0.0349,
            horizontal_field_of_view: 3.1415,
            horizontal_resolution: 0.0349,
        }
    }
}

impl Config {
    /// Returns the numbers of rows and of beams in a row.
    pub fn counts(&self) -> [usize; 2] {
        let count = |field: f64, step: f64| (field / step + 1e-6) as usize + 1;
        [
            count(self.vertical_field_of_view, self.vertical_resolution),
            count(self.horizontal_field_of_view, self.horizontal_resolution),
        ]
    }

    /// Checks ranges, angles and the number of beams.
    pub(super) fn validate(&self) -> Result<(), &'static str> {
        ranges(self.min_range, self.max_range)?;
        let turn = 0.0..=std::f64::consts::TAU;
        let good = [self.vertical_field_of_view, self.horizontal_field_of_view].iter().all(|it| turn.contains(it))
            && [self.vertical_resolution, self.horizontal_resolution].iter().all(|step| (1e-4..=7.0).contains(step))
            && self.counts().iter().product::<usize>() <= MAX_BEAMS;
        if good {
            Ok(())
        } else {
            Err("fields of view of 0 to 2 pi, resolutions of 0.0001 to 7 rad, at most 10000 beams")
        }
    }
}

reading! {
    /// Rows of distances.
    {
        /// Distances, rows from the top to the bottom, each from the right to the left; the maximum range where nothing is hit.
        ranges: Arc<[f64]> = "m",
    }
}
