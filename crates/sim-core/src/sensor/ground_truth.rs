//! Exact pose of the robot's body, or of the sensor itself (GroundTruth.uc:23-41; no noise).

use gamebots_proto::message::{GroundTruth, ItemConf, PoseConf};
use scene::sensor::ground_truth::{Config, Reading};
use scene::{Pose, SensorDef, position_and_rotation};

use super::{Mount, Sensor, View, floats};

#[derive(Clone)]
pub(crate) struct Mounted {
    name: String,
    scan_interval: f64,
    /// Pose of the sensor in the robot frame; `None` reports the robot's body.
    pose: Option<Pose>,
}

pub(super) fn build(config: &Config, mount: Mount) -> Mounted {
    let pose = (!config.fixed_to_platform).then_some(mount.pose);
    Mounted { name: mount.name.to_owned(), scan_interval: mount.scan_interval, pose }
}

/// Returns the reading for the wire.
pub(super) fn wire(def: &SensorDef, reading: &Reading) -> GroundTruth {
    let Reading { position, angles } = *reading;
    GroundTruth { name: def.name.clone(), location: floats(position), orientation: floats(angles) }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "GroundTruth"
    }

    fn sense(&mut self, view: &View) -> Option<super::Reading> {
        let reported = self.pose.map_or(view.body.pose, |pose| view.carrier.pose * pose);
        let (position, angles) = position_and_rotation(&reported);
        Some(Reading { position, angles }.into())
    }

    fn conf(&self) -> ItemConf {
        PoseConf { name: self.name.clone(), scan_interval: self.scan_interval as f32 }.into()
    }
}
