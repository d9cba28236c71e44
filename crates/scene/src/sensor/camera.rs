//! Settings of a camera (USARCamera.uc).

use serde::{Deserialize, Serialize};

use crate::reading::reading;

/// Settings of a camera.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Field of view at the start, rad.
    pub field_of_view: f64,
    /// Narrowest field of view, rad.
    pub min_field_of_view: f64,
    /// Widest field of view, rad.
    pub max_field_of_view: f64,
}

impl Default for Config {
    /// Defaults of DefaultUSAR.ini:82-87.
    fn default() -> Self {
        Self { field_of_view: 1.3963, min_field_of_view: 0.3491, max_field_of_view: 2.0944 }
    }
}

impl Config {
    /// Checks the order of the angles that limit the zoom.
    pub(super) fn validate(&self) -> Result<(), &'static str> {
        let angles = [0.0, self.min_field_of_view, self.field_of_view, self.max_field_of_view, std::f64::consts::PI];
        if angles.is_sorted() {
            Ok(())
        } else {
            Err("min_field_of_view <= field_of_view <= max_field_of_view, all 0 to pi")
        }
    }
}

reading! {
    /// The view of a camera at one moment. Whoever wants its picture draws it from a snapshot of that moment.
    {
        /// Angle from the left to the right edge of the picture.
        field_of_view: f64 = "rad",
    }
}
