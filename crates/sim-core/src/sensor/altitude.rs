//! Height of a robot above the place where it was spawned (AltitudeSensor.uc:11-41).

use gamebots_proto::message::{AltitudeSensor, ItemConf, PlainConf};
use scene::SensorDef;
use scene::sensor::altitude::Reading;

use super::{Mount, Sensor, State, View};

/// Height of the place of the spawn that the original takes for granted, m.
const GROUND: f64 = 111.0;

#[derive(Clone)]
pub(crate) struct Mounted {
    name: String,
    /// z of the robot at the spawn, m.
    start: f64,
}

pub(super) fn build(mount: Mount) -> Mounted {
    Mounted { name: mount.name.to_owned(), start: mount.view.body.pose.translation.z }
}

/// Returns the reading for the wire.
pub(super) fn wire(def: &SensorDef, reading: &Reading) -> AltitudeSensor {
    let Reading { relative, absolute } = *reading;
    AltitudeSensor { name: def.name.clone(), relative: relative as f32, absolute: absolute as f32 }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "AltitudeSensor"
    }

    fn sense(&mut self, view: &View) -> Option<super::Reading> {
        // z is down.
        let relative = self.start - view.body.pose.translation.z;
        Some(Reading { relative, absolute: (GROUND + relative).max(0.0) }.into())
    }

    fn state(&mut self) -> State<'_> {
        State { numbers: vec![&mut self.start], ..State::default() }
    }

    fn conf(&self) -> ItemConf {
        PlainConf { name: self.name.clone() }.into()
    }
}
