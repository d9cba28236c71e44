//! The battery as an item: it answers `GETCONF {Type Sensor}` and sends nothing (Battery.uc:45-77). What it holds
//! is the robot's `battery`.

use gamebots_proto::message::{ItemConf, Reading};
use serde::{Deserialize, Serialize};

use super::{Mount, Sensor, View};

/// The numbers of a battery are the robot's.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {}

pub(super) struct Mounted {
    name: String,
}

impl Config {
    pub(super) fn build(&self, mount: Mount) -> Mounted {
        Mounted { name: mount.name.to_owned() }
    }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "Sensor"
    }

    fn sense(&mut self, _view: &View) -> Option<Reading> {
        None
    }

    fn conf(&self) -> ItemConf {
        ItemConf::Plain { name: self.name.clone() }
    }
}
