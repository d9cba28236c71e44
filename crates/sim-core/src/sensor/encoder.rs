//! Ticks of wheel encoders (Encoder.uc:29-60): `trunc(((1 + u) spin mod 2 pi) / resolution)`. The random number `u` is drawn again for
//! each wheel and reading, so the scatter grows with the angle turned.

use std::f64::consts::TAU;

use gamebots_proto::command::Set;
use gamebots_proto::message::{Encoder, EncoderConf, ItemConf, Tick};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use scene::sensor::encoder::{Config, Reading};
use scene::{RobotDef, SensorDef};

use super::{Effect, Mount, Sensor, State, View};

#[derive(Clone)]
pub(crate) struct Mounted {
    name: String,
    resolution: f64,
    noise: f64,
    /// Index of each wheel, and its angle at the last reset.
    wheels: Vec<(usize, f64)>,
    rng: ChaCha8Rng,
}

pub(super) fn build(config: &Config, mount: Mount) -> Mounted {
    let states = mount.view.wheels;
    let wheels = wheels(config, mount.name, states.len()).into_iter();
    let wheels = wheels.filter_map(|(_, wheel)| Some((wheel, states.get(wheel)?.angle)));
    Mounted {
        name: mount.name.to_owned(),
        resolution: config.resolution,
        noise: config.noise,
        wheels: wheels.collect(),
        rng: mount.rng,
    }
}

/// Returns the wheels that an encoder reads, with their names on the wire.
fn wheels(config: &Config, name: &str, count: usize) -> Vec<(String, usize)> {
    match config.wheel {
        Some(wheel) => (wheel < count).then(|| (name.to_owned(), wheel)).into_iter().collect(),
        None => {
            let named = (0..count).map(|wheel| (format!("W{wheel}"), wheel));
            named.filter(|(label, _)| name.contains(label)).collect()
        }
    }
}

/// Returns the reading for the wire.
pub(super) fn wire(robot: &RobotDef, def: &SensorDef, reading: &Reading) -> Encoder {
    let scene::sensor::Config::Encoder(config) = &def.config else { return Encoder { ticks: Vec::new() } };
    let wheels = wheels(config, &def.name, robot.driven().count()).into_iter();
    let ticks = wheels.zip(reading.ticks.iter()).map(|((name, _), tick)| Tick { name, tick: *tick });
    Encoder { ticks: ticks.collect() }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "Encoder"
    }

    fn sense(&mut self, view: &View) -> Option<super::Reading> {
        let (noise, resolution, rng) = (self.noise, self.resolution, &mut self.rng);
        let ticks = self.wheels.iter().map(|(wheel, reference)| {
            let factor = 1.0 + if noise > 0.0 { rng.random_range(-noise..noise) } else { 0.0 };
            let spin = (view.wheels[*wheel].angle - reference) * factor;
            ((spin % TAU) / resolution) as i32
        });
        Some(Reading { ticks: ticks.collect() }.into())
    }

    /// Executes `RESET`: the current angle of each wheel counts as zero.
    fn set(&mut self, opcode: &str, _set: &Set, view: &View) -> Effect {
        if opcode == "RESET" {
            for (wheel, reference) in &mut self.wheels {
                *reference = view.wheels[*wheel].angle;
            }
        }
        Effect::None
    }

    fn state(&mut self) -> State<'_> {
        let numbers = self.wheels.iter_mut().map(|(_, reference)| reference).collect();
        State { numbers, random: Some(&mut self.rng), ..State::default() }
    }

    fn conf(&self) -> ItemConf {
        EncoderConf { name: self.name.clone(), resolution: self.resolution as f32 }.into()
    }
}
