//! Directions of sounds (AcousticArraySensor.uc).

use gamebots_proto::command::Set;
use gamebots_proto::message::{Acoustic, Heard, ItemConf, PlainConf};
use scene::sensor::acoustic::{Config, Reading};
use scene::{Pose, SensorDef};

use super::{Effect, Mount, Sensor, State, View, hearing};

/// Numbers of one sound in a reading.
const NUMBERS: usize = 6;

#[derive(Clone)]
pub(crate) struct Mounted {
    name: String,
    pose: Pose,
    config: Config,
    /// Time of the last reading, s.
    last: f64,
}

pub(super) fn build(config: &Config, mount: Mount) -> Mounted {
    Mounted { name: mount.name.to_owned(), pose: mount.pose, config: config.clone(), last: mount.view.time }
}

/// Returns the reading for the wire.
pub(super) fn wire(def: &SensorDef, reading: &Reading) -> Acoustic {
    let sound = |numbers: &[f64]| {
        let &[x, y, z, volume, duration, delay] = numbers else { return None };
        // A sound that is too far has no direction. The original's axes have z up.
        ([x, y, z] != [0.0; 3]).then_some(Heard {
            direction: [x as f32, y as f32, -z as f32],
            volume: volume as f32,
            duration: duration as f32,
            delay: delay as f32,
        })
    };
    Acoustic { name: def.name.clone(), sounds: reading.sounds.chunks_exact(NUMBERS).map(sound).collect() }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "Acoustic"
    }

    fn sense(&mut self, view: &View) -> Option<super::Reading> {
        let pose = view.carrier.pose * self.pose;
        let place = pose.translation.vector.into();
        let mut sounds = Vec::new();
        for sound in &view.physics.site().sounds {
            let begins: Vec<f64> = sound.begins(self.last, view.time).collect();
            if begins.is_empty() {
                continue;
            }
            let heard = hearing::hear(view, &self.config, &place, sound);
            for begin in begins {
                let delay = (heard.away.norm() / self.config.sound_speed + begin - view.time).max(0.0);
                let ahead = pose.rotation.inverse() * heard.away.try_normalize(1e-9).unwrap_or_default();
                match heard.loudness {
                    Some(loudness) => sounds.extend([ahead.x, ahead.y, ahead.z, loudness, sound.duration, delay]),
                    None => sounds.extend([0.0; NUMBERS]),
                }
            }
        }
        self.last = view.time;
        Some(Reading { sounds: sounds.into() }.into())
    }

    /// Executes `SCAN`: one more reading goes out at once.
    fn set(&mut self, opcode: &str, _set: &Set, _view: &View) -> Effect {
        if opcode == "SCAN" { Effect::Scan } else { Effect::None }
    }

    fn state(&mut self) -> State<'_> {
        State { numbers: vec![&mut self.last], ..State::default() }
    }

    fn conf(&self) -> ItemConf {
        PlainConf { name: self.name.clone() }.into()
    }
}
