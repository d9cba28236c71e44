//! Whole minutes since a robot was spawned (MissionTime.uc:6-20).

use gamebots_proto::message::{ItemConf, MissionTime, PlainConf};
use scene::SensorDef;
use scene::sensor::mission_time::Reading;

use super::{Mount, Sensor, State, View};

#[derive(Clone)]
pub(crate) struct Mounted {
    name: String,
    /// Time of the spawn, s.
    start: f64,
}

pub(super) fn build(mount: Mount) -> Mounted {
    Mounted { name: mount.name.to_owned(), start: mount.view.time }
}

/// Returns the reading for the wire.
pub(super) fn wire(def: &SensorDef, reading: &Reading) -> MissionTime {
    MissionTime { name: def.name.clone(), minutes: reading.minutes as i32 }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "MissionTime"
    }

    fn sense(&mut self, view: &View) -> Option<super::Reading> {
        Some(Reading { minutes: ((view.time - self.start) / 60.0).floor() }.into())
    }

    fn state(&mut self) -> State<'_> {
        State { numbers: vec![&mut self.start], ..State::default() }
    }

    fn conf(&self) -> ItemConf {
        PlainConf { name: self.name.clone() }.into()
    }
}
