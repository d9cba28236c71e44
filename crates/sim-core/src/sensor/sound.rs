//! The loudest sound at the moment, a sensor of UT2004.

use gamebots_proto::message::{ItemConf, PlainConf, Sound};
use scene::sensor::acoustic::Config;
use scene::sensor::sound::Reading;
use scene::{Pose, SensorDef};

use super::{Mount, Sensor, View, hearing};

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
pub(super) fn wire(def: &SensorDef, reading: &Reading) -> Sound {
    Sound { name: def.name.clone(), loudness: reading.loudness as f32, duration: reading.duration as f32 }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "Sound"
    }

    fn sense(&mut self, view: &View) -> Option<super::Reading> {
        let place = (view.carrier.pose * self.pose).translation.vector.into();
        let mut reading = Reading { loudness: 0.0, duration: 0.0 };
        for sound in &view.physics.site().sounds {
            // The sounds that began within the last duration are still to be heard.
            if sound.begins((view.time - sound.duration).max(0.0), view.time).next().is_none() {
                continue;
            }
            let loudness = hearing::hear(view, &self.config, &place, sound).loudness;
            if let Some(loudness) = loudness.filter(|loudness| *loudness > reading.loudness) {
                reading = Reading { loudness, duration: sound.duration };
            }
        }
        Some(reading.into())
    }

    fn conf(&self) -> ItemConf {
        PlainConf { name: self.name.clone() }.into()
    }
}
