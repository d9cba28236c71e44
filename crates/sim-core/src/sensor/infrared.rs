//! One infrared beam (IRSensor.uc:35-96). It passes through transparent materials.

use gamebots_proto::message::{Ir, IrConf, ItemConf};
use nalgebra::Vector3;
use scene::sensor::infrared::{Config, Reading};
use scene::{Pose, SensorDef};

use super::{Mount, Sensor, View};
use crate::physics::Light;

#[derive(Clone)]
pub(crate) struct Mounted {
    name: String,
    pose: Pose,
    config: Config,
}

pub(super) fn build(config: &Config, mount: Mount) -> Mounted {
    Mounted { name: mount.name.to_owned(), pose: mount.pose, config: config.clone() }
}

/// Returns the reading for the wire.
pub(super) fn wire(def: &SensorDef, reading: &Reading) -> Ir {
    Ir { name: def.name.clone(), range: reading.range as f32 }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "IR"
    }

    fn sense(&mut self, view: &View) -> Option<super::Reading> {
        let pose = view.carrier.pose * self.pose;
        let Config { min_range, max_range } = self.config;
        let sight = view.sight_in(Light::Infrared, &pose.translation.vector.into(), max_range);
        let range = sight.range(&(pose.rotation * Vector3::x()));
        Some(Reading { range: range.clamp(min_range, max_range) }.into())
    }

    fn conf(&self) -> ItemConf {
        let [max_range, min_range] = [self.config.max_range, self.config.min_range].map(|range| range as f32);
        IrConf { name: self.name.clone(), max_range, min_range, max_range_again: max_range, min_range_again: min_range }
            .into()
    }
}
