//! Roll, pitch and yaw of the robot without errors, the oldest inertial sensor of UT2004 (sensors.md 8).

use gamebots_proto::message::{Inu, ItemConf, PlainConf};
use scene::sensor::inu::Reading;
use scene::{SensorDef, position_and_rotation};

use super::{Mount, Sensor, View, floats};

#[derive(Clone)]
pub(crate) struct Mounted {
    name: String,
}

pub(super) fn build(mount: Mount) -> Mounted {
    Mounted { name: mount.name.to_owned() }
}

/// Returns the reading for the wire.
pub(super) fn wire(def: &SensorDef, reading: &Reading) -> Inu {
    Inu { name: def.name.clone(), orientation: floats(reading.angles) }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "INU"
    }

    fn sense(&mut self, view: &View) -> Option<super::Reading> {
        let (_, angles) = position_and_rotation(&view.body.pose);
        Some(Reading { angles }.into())
    }

    fn conf(&self) -> ItemConf {
        PlainConf { name: self.name.clone() }.into()
    }
}
