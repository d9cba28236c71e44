//! The battery as an item: it answers `GETCONF {Type Sensor}` and sends nothing (Battery.uc:45-77). Its capacity is the robot's
//! `battery`.

use gamebots_proto::message::{ItemConf, PlainConf};

use super::{Mount, Reading, Sensor, View};

#[derive(Clone)]
pub(crate) struct Mounted {
    name: String,
}

pub(super) fn build(mount: Mount) -> Mounted {
    Mounted { name: mount.name.to_owned() }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "Sensor"
    }

    fn sense(&mut self, _view: &View) -> Option<Reading> {
        None
    }

    fn conf(&self) -> ItemConf {
        PlainConf { name: self.name.clone() }.into()
    }
}
