//! Direction of a sensor against the map's north (MagneticCompass.uc:8-49). The original rounds the angle to nearly 0 twice; this is what it
//! means.

use gamebots_proto::message::{ItemConf, MagneticCompass, PlainConf};
use scene::sensor::compass::Reading;
use scene::{Pose, SensorDef, wrapped};

use super::{Mount, Sensor, View};

#[derive(Clone)]
pub(crate) struct Mounted {
    name: String,
    pose: Pose,
}

pub(super) fn build(mount: Mount) -> Mounted {
    Mounted { name: mount.name.to_owned(), pose: mount.pose }
}

/// Returns the reading for the wire.
pub(super) fn wire(def: &SensorDef, reading: &Reading) -> MagneticCompass {
    MagneticCompass { name: def.name.clone(), angle: reading.angle as f32 }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "MagneticCompass"
    }

    fn sense(&mut self, view: &View) -> Option<super::Reading> {
        let (_, _, yaw) = (view.carrier.pose.rotation * self.pose.rotation).euler_angles();
        Some(Reading { angle: wrapped(view.physics.site().north - yaw) }.into())
    }

    fn conf(&self) -> ItemConf {
        PlainConf { name: self.name.clone() }.into()
    }
}
