//! Numbers of a reader of RFID tags, a sensor of UT2004.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::ranges;
use crate::reading::{Texts, reading};

/// Numbers of a reader of RFID tags.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Greatest distance of a tag, m.
    pub max_range: f64,
}

impl Default for Config {
    /// The reach of a hand-sized reader.
    fn default() -> Self {
        Self { max_range: 3.0 }
    }
}

impl Config {
    /// Checks the range.
    pub(super) fn validate(&self) -> Result<(), &'static str> {
        ranges(0.0, self.max_range)
    }
}

/// Numbers of a releaser of tags: none.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Releaser {}

reading! {
    /// Tags in reach, the nearest first.
    {
        /// Four numbers for each tag: its number, and its position in the frame of the sensor.
        tags: Arc<[f64]> = "1, m",
        /// Their memories, as text in numbers.
        memories: Texts = "",
    }
}
