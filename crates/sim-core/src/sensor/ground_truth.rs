//! Exact pose of the robot's body, or of the sensor itself (GroundTruth.uc:23-41; no noise).

use gamebots_proto::message::{GroundTruth, ItemConf, Reading};
use serde::{Deserialize, Serialize};

use super::{Mount, Sensor, View, floats};
use crate::scene::{Pose, position_and_rotation};

/// Numbers of a ground truth sensor.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// True: the pose of the robot's body. False: of the sensor.
    pub fixed_to_platform: bool,
}

impl Default for Config {
    /// DefaultUSAR.ini:70-72.
    fn default() -> Self {
        Self { fixed_to_platform: true }
    }
}

pub(super) struct Mounted {
    name: String,
    scan_interval: f64,
    /// Pose of what is reported, in the robot frame.
    reported: Pose,
}

impl Config {
    pub(super) fn build(&self, mount: Mount) -> Mounted {
        let reported = if self.fixed_to_platform { Pose::identity() } else { mount.pose };
        Mounted { name: mount.name.to_owned(), scan_interval: mount.scan_interval, reported }
    }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "GroundTruth"
    }

    fn sense(&mut self, view: &View) -> Option<Reading> {
        let (position, rotation) = position_and_rotation(&(view.body.pose * self.reported));
        let reading =
            GroundTruth { name: self.name.clone(), location: floats(position), orientation: floats(rotation) };
        Some(reading.into())
    }

    fn conf(&self) -> ItemConf {
        ItemConf::Timed { name: self.name.clone(), scan_interval: self.scan_interval as f32 }
    }
}
