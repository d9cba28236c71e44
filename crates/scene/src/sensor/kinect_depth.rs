//! Numbers of a depth camera (KinectDepth.uc).

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::ranges;
use crate::reading::reading;

/// Columns of a picture (KinectDepth.uc:168-173).
pub const COLUMNS: u32 = 320;
/// Rows of a picture.
pub const ROWS: u32 = 240;
/// Readings that a picture is sent in.
pub const FRAMES: u32 = 20;
/// Angles of the picture to the sides, and up and down, rad.
pub const FIELD_OF_VIEW: [f64; 2] = [1.01226, 0.7854];

/// Numbers of a depth camera.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Depth without a hit, m.
    pub max_range: f64,
    /// Smallest range, m; reported, not applied.
    pub min_range: f64,
    /// True: takes one picture after the other. False: takes one when it is told to.
    pub continuous: bool,
}

impl Default for Config {
    /// Defaults of DefaultUSAR.ini:142-143.
    fn default() -> Self {
        Self { max_range: 20.0, min_range: 0.1, continuous: false }
    }
}

impl Config {
    /// Checks the ranges.
    pub(super) fn validate(&self) -> Result<(), &'static str> {
        ranges(self.min_range, self.max_range)
    }

    /// Returns the number of rays of one reading.
    pub(super) fn rays() -> usize {
        (COLUMNS * ROWS / FRAMES) as usize
    }
}

reading! {
    /// A part of a depth picture, or none.
    {
        /// Number of parts of the picture; 0 while none is taken.
        frames: f64 = "",
        /// Number of this part, from 0.
        frame: f64 = "",
        /// Depths along the axis of view, rows from the top to the bottom, each from the left to the right.
        depths: Arc<[f64]> = "m",
    }
}
