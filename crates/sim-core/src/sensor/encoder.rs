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
    /// The wheels or the joint that it reads, each with its angle at the last reset.
    turned: Vec<(Turned, f64)>,
    rng: ChaCha8Rng,
}

/// Something whose angle an encoder counts, by its number among the robot's wheels or joints.
#[derive(Debug, Clone, Copy)]
enum Turned {
    Wheel(usize),
    Joint(usize),
    /// A joint that the robot does not have.
    Nothing,
}

impl Turned {
    /// Returns the angle, rad.
    fn angle(self, view: &View) -> f64 {
        let angle = match self {
            Self::Wheel(wheel) => view.wheels.get(wheel).map(|wheel| wheel.angle),
            Self::Joint(joint) => view.joints().get(joint).map(|joint| joint.position),
            Self::Nothing => None,
        };
        angle.unwrap_or(0.0)
    }
}

pub(super) fn build(config: &Config, mount: Mount) -> Mounted {
    let turned = turned(config, mount.name, mount.view.robot, mount.view.wheels.len()).into_iter();
    Mounted {
        name: mount.name.to_owned(),
        resolution: config.resolution,
        noise: config.noise,
        turned: turned.map(|(_, turned)| (turned, turned.angle(mount.view))).collect(),
        rng: mount.rng,
    }
}

/// Returns the wheels or the joint that an encoder reads, with their names on the wire. `wheels` is the number of driven wheels.
fn turned(config: &Config, name: &str, robot: &RobotDef, wheels: usize) -> Vec<(String, Turned)> {
    if let Some(joint) = &config.joint {
        let joint = robot.with_values().position(|link| link.name == *joint);
        return vec![(name.to_owned(), joint.map_or(Turned::Nothing, Turned::Joint))];
    }
    match config.wheel {
        Some(wheel) => (wheel < wheels).then(|| (name.to_owned(), Turned::Wheel(wheel))).into_iter().collect(),
        None => {
            let named = (0..wheels).map(|wheel| (format!("W{wheel}"), Turned::Wheel(wheel)));
            named.filter(|(label, _)| name.contains(label)).collect()
        }
    }
}

/// Returns the reading for the wire.
pub(super) fn wire(robot: &RobotDef, def: &SensorDef, reading: &Reading) -> Encoder {
    let scene::sensor::Config::Encoder(config) = &def.config else { return Encoder { ticks: Vec::new() } };
    let turned = turned(config, &def.name, robot, robot.driven().count()).into_iter();
    let ticks = turned.zip(reading.ticks.iter()).map(|((name, _), tick)| Tick { name, tick: *tick });
    Encoder { ticks: ticks.collect() }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "Encoder"
    }

    fn sense(&mut self, view: &View) -> Option<super::Reading> {
        let (noise, resolution, rng) = (self.noise, self.resolution, &mut self.rng);
        let ticks = self.turned.iter().map(|(turned, reference)| {
            let factor = 1.0 + if noise > 0.0 { rng.random_range(-noise..noise) } else { 0.0 };
            let spin = (turned.angle(view) - reference) * factor;
            ((spin % TAU) / resolution) as i32
        });
        Some(Reading { ticks: ticks.collect() }.into())
    }

    /// Executes `RESET`: the current angle of each wheel or joint counts as zero.
    fn set(&mut self, opcode: &str, _set: &Set, view: &View) -> Effect {
        if opcode == "RESET" {
            for (turned, reference) in &mut self.turned {
                *reference = turned.angle(view);
            }
        }
        Effect::None
    }

    fn state(&mut self) -> State<'_> {
        let numbers = self.turned.iter_mut().map(|(_, reference)| reference).collect();
        State { numbers, random: Some(&mut self.rng), ..State::default() }
    }

    fn conf(&self) -> ItemConf {
        EncoderConf { name: self.name.clone(), resolution: self.resolution as f32 }.into()
    }
}
