//! Numbers of a bow of bumpers (BumperArray.uc).

use serde::{Deserialize, Serialize};

use crate::reading::reading;

/// Numbers of a bow of bumpers.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Reach of a bumper, m.
    pub reach: f64,
    /// Diameter of a bumper, m.
    pub diameter: f64,
    /// Radius of the bow, m.
    pub arc_radius: f64,
    /// Angle of the bow, rad.
    pub arc_angle: f64,
    /// Roll, pitch and yaw of the bow's plane, rad.
    pub arc_rotation: [f64; 3],
}

impl Default for Config {
    /// Defaults of DefaultUSAR.ini:151-161.
    fn default() -> Self {
        Self { reach: 0.02, diameter: 0.01, arc_radius: 0.17, arc_angle: 3.14, arc_rotation: [0.0; 3] }
    }
}

impl Config {
    /// Checks lengths and angles.
    pub(super) fn validate(&self) -> Result<(), &'static str> {
        let good = [self.reach, self.diameter, self.arc_radius].iter().all(|it| (1e-4..=10.0).contains(it))
            && (0.0..=std::f64::consts::TAU).contains(&self.arc_angle)
            && self.arc_rotation.iter().all(|it| (-7.0..=7.0).contains(it));
        if good {
            Ok(())
        } else {
            Err("lengths of 0.0001 to 10 m, an arc_angle of 0 to 2 pi, rotations of -7 to 7 rad")
        }
    }
}

reading! {
    /// Contact of any of the bumpers.
    {
        /// True if something is within the reach of one of them.
        touch: bool = "",
    }
}
