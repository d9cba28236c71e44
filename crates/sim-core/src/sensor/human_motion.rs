//! Motion of victims in view, a sensor of UT2004.

use gamebots_proto::message::{HumanMotion, ItemConf, PlainConf};
use scene::sensor::human_motion::{Config, Reading};
use scene::{Pose, SensorDef};

use super::{Mount, Sensor, View, victim};

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
pub(super) fn wire(def: &SensorDef, reading: &Reading) -> HumanMotion {
    HumanMotion { name: def.name.clone(), probability: reading.probability as f32 }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "HumanMotion"
    }

    fn sense(&mut self, view: &View) -> Option<super::Reading> {
        let moves = |victim: usize| view.physics.site().victims.get(victim).is_some_and(|victim| victim.moves);
        let seen = victim::in_view(view, &self.pose, &self.config);
        let moving = seen.iter().filter(|(part, _)| moves(part.victim));
        let nearest = moving.map(|(_, place)| place.coords.norm()).fold(f64::INFINITY, f64::min);
        Some(Reading { probability: (1.0 - nearest / self.config.max_range).max(0.0) }.into())
    }

    fn conf(&self) -> ItemConf {
        PlainConf { name: self.name.clone() }.into()
    }
}
