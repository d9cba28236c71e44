//! Exact pose of the robot's body, or of the sensor itself (GroundTruth.uc:23-41; no noise).

use gamebots_proto::message::{GroundTruth, ItemConf, Reading};
use scene::sensor::ground_truth::Config;
use scene::{Pose, position_and_rotation};

use super::{Mount, Sensor, View, floats};

pub(super) struct Mounted {
    name: String,
    scan_interval: f64,
    /// Pose of what is reported, in the robot frame.
    reported: Pose,
}

pub(super) fn build(config: &Config, mount: Mount) -> Mounted {
    let reported = if config.fixed_to_platform { Pose::identity() } else { mount.pose };
    Mounted { name: mount.name.to_owned(), scan_interval: mount.scan_interval, reported }
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
