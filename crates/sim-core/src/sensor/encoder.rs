//! Ticks of wheel encoders (Encoder.uc:29-60): `trunc(((1 + u) spin mod 2 pi) / resolution)`. The random number `u` is drawn again for
//! each wheel and reading, so the scatter grows with the angle turned.

use std::f64::consts::TAU;

use gamebots_proto::command::Set;
use gamebots_proto::message::{Encoder, EncoderConf, ItemConf, Reading, Tick};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use scene::sensor::encoder::Config;

use super::{Effect, Mount, Sensor, State, View};

#[derive(Clone)]
pub(crate) struct Mounted {
    name: String,
    resolution: f64,
    noise: f64,
    /// Name on the wire, index of the wheel, its angle at the last reset.
    wheels: Vec<(String, usize, f64)>,
    rng: ChaCha8Rng,
}

pub(super) fn build(config: &Config, mount: Mount) -> Mounted {
    let states = mount.view.wheels;
    let wheels = match config.wheel {
        Some(wheel) => vec![(mount.name.to_owned(), wheel)],
        None => {
            let named = (0..states.len()).map(|wheel| (format!("W{wheel}"), wheel));
            named.filter(|(label, _)| mount.name.contains(label)).collect()
        }
    };
    let wheels = wheels.into_iter().filter_map(|(label, wheel)| Some((label, wheel, states.get(wheel)?.angle)));
    Mounted {
        name: mount.name.to_owned(),
        resolution: config.resolution,
        noise: config.noise,
        wheels: wheels.collect(),
        rng: mount.rng,
    }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "Encoder"
    }

    fn sense(&mut self, view: &View) -> Option<Reading> {
        let (noise, resolution, rng) = (self.noise, self.resolution, &mut self.rng);
        let ticks = self.wheels.iter().map(|(label, wheel, reference)| {
            let factor = 1.0 + if noise > 0.0 { rng.random_range(-noise..noise) } else { 0.0 };
            let spin = (view.wheels[*wheel].angle - reference) * factor;
            Tick { name: label.clone(), tick: ((spin % TAU) / resolution) as i32 }
        });
        Some(Encoder { ticks: ticks.collect() }.into())
    }

    /// Executes `RESET`: the current angle of each wheel counts as zero.
    fn set(&mut self, opcode: &str, _set: &Set, view: &View) -> Effect {
        if opcode == "RESET" {
            for (_, wheel, reference) in &mut self.wheels {
                *reference = view.wheels[*wheel].angle;
            }
        }
        Effect::None
    }

    fn state(&mut self) -> State<'_> {
        let numbers = self.wheels.iter_mut().map(|(_, _, reference)| reference).collect();
        State { numbers, random: Some(&mut self.rng), ..State::default() }
    }

    fn conf(&self) -> ItemConf {
        EncoderConf { name: self.name.clone(), resolution: self.resolution as f32 }.into()
    }
}
