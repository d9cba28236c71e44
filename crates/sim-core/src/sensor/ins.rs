//! Inertial navigation: integrates noisy increments of the true pose (INS.uc:59-147).
//!
//! Each reading adds `change x (1 + G(bias, sigma))` to every angle and `change + distance x G(bias, sigma)` to every coordinate. So a
//! sideways axis drifts as much as the direction of travel. Integration starts after the first reading at which the robot did not turn.

use std::f64::consts::TAU;

use gamebots_proto::command::Set;
use gamebots_proto::message::{Ins, ItemConf, PoseConf};
use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use scene::rotation_units;

use super::{Effect, Mount, Sensor, State, View, floats};
use scene::sensor::ins::{Config, Reading};
use scene::{Pose, SensorDef, position_and_rotation, wrapped};

#[derive(Clone)]
pub(crate) struct Mounted {
    name: String,
    scan_interval: f64,
    sigma: f64,
    position: Vector3<f64>,
    angles: [f64; 3],
    angle_bias: [f64; 3],
    position_bias: [f64; 3],
    last: Pose,
    integrating: bool,
    rng: ChaCha8Rng,
}

pub(super) fn build(config: &Config, mut mount: Mount) -> Mounted {
    let mut bias =
        |range: f64| [(); 3].map(|()| if config.drifting { mount.rng.random_range(-0.5..0.5) / range } else { 0.0 });
    let (angle_bias, position_bias) = (bias(config.precision.powi(2)), bias(config.precision));
    let (position, angles) = position_and_rotation(&(mount.view.carrier.pose * mount.pose));
    Mounted {
        name: mount.name.to_owned(),
        scan_interval: mount.scan_interval,
        sigma: config.sigma,
        position: position.into(),
        angles: angles.map(|angle| angle.rem_euclid(TAU)),
        angle_bias,
        position_bias,
        last: mount.view.body.pose,
        integrating: false,
        rng: mount.rng,
    }
}

impl Mounted {
    fn noise(&mut self, bias: f64) -> f64 {
        let normal: f64 = StandardNormal.sample(&mut self.rng);
        bias + self.sigma * normal
    }

    fn integrate(&mut self, pose: &Pose) {
        let ((now, angles), (before, last_angles)) = (position_and_rotation(pose), position_and_rotation(&self.last));
        let turned: [f64; 3] = std::array::from_fn(|axis| {
            // In whole rotation units, like the angles of USARSim's engine, so that a resting robot does not turn at all.
            let change = rotation_units::from_radians(angles[axis]) - rotation_units::from_radians(last_angles[axis]);
            wrapped(f64::from(rotation_units::to_radians(change)))
        });
        if self.integrating {
            for (axis, change) in turned.iter().enumerate() {
                let factor = 1.0 + self.noise(self.angle_bias[axis]);
                self.angles[axis] = (self.angles[axis] + change * factor).rem_euclid(TAU);
            }
            let moved = Vector3::from(now) - Vector3::from(before);
            for axis in 0..3 {
                let error = moved.norm() * self.noise(self.position_bias[axis]);
                self.position[axis] += moved[axis] + error;
            }
        }
        self.integrating |= turned == [0.0; 3];
        self.last = *pose;
    }
}

/// Returns the reading for the wire.
pub(super) fn wire(def: &SensorDef, reading: &Reading) -> Ins {
    Ins { name: def.name.clone(), location: floats(reading.position), orientation: floats(reading.angles) }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "INS"
    }

    fn sense(&mut self, view: &View) -> Option<super::Reading> {
        self.integrate(&view.body.pose);
        Some(Reading { position: self.position.into(), angles: self.angles }.into())
    }

    /// Executes `POSE` with exactly six numbers x, y, z, roll, pitch, yaw: sets the estimate and clears the drift.
    fn set(&mut self, opcode: &str, set: &Set, view: &View) -> Effect {
        if opcode == "POSE"
            && let Some([x, y, z, roll, pitch, yaw]) = set.numbers().as_deref()
        {
            self.position = Vector3::new(*x, *y, *z);
            self.angles = [*roll, *pitch, *yaw].map(|angle| angle.rem_euclid(TAU));
            self.angle_bias = [0.0; 3];
            self.position_bias = [0.0; 3];
            self.last = view.body.pose;
            self.integrating = true;
        }
        Effect::None
    }

    fn state(&mut self) -> State<'_> {
        let Self { position, angles, angle_bias, position_bias, last, integrating, rng, .. } = self;
        let last = last.translation.vector.iter_mut().chain(last.rotation.as_mut_unchecked().coords.iter_mut());
        let numbers = position.iter_mut().chain(angles).chain(angle_bias).chain(position_bias).chain(last);
        State { numbers: numbers.collect(), flags: vec![integrating], random: Some(rng) }
    }

    fn conf(&self) -> ItemConf {
        PoseConf { name: self.name.clone(), scan_interval: self.scan_interval as f32 }.into()
    }
}
