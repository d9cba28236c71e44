//! Speeds and angles of all driven wheels (Tachometer.uc:27-61), without noise.

use gamebots_proto::command::Set;
use gamebots_proto::message::{ItemConf, Tachometer, WheelsConf};
use scene::SensorDef;
use scene::sensor::tachometer::Reading;

use super::{Effect, Mount, Sensor, State, View};

#[derive(Clone)]
pub(crate) struct Mounted {
    name: String,
    scan_interval: f64,
    /// Time and angles of the last reading.
    last_time: f64,
    last: Vec<f64>,
    /// Angles at the last reset.
    reference: Vec<f64>,
}

pub(super) fn build(mount: Mount) -> Mounted {
    let angles: Vec<f64> = mount.view.wheels.iter().map(|wheel| wheel.angle).collect();
    Mounted {
        name: mount.name.to_owned(),
        scan_interval: mount.scan_interval,
        last_time: mount.view.time,
        last: angles.clone(),
        reference: angles,
    }
}

/// Returns the reading for the wire. `unit` is one wheel-speed unit of the wire, rad/s.
pub(super) fn wire(def: &SensorDef, reading: &Reading, unit: f64) -> Tachometer {
    Tachometer {
        name: def.name.clone(),
        velocities: reading.velocities.iter().map(|speed| (speed / unit) as f32).collect(),
        positions: reading.positions.iter().map(|angle| *angle as f32).collect(),
    }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "Tachometer"
    }

    /// Returns the mean speeds since the last reading, and the angles at the last reading, which are one interval late.
    fn sense(&mut self, view: &View) -> Option<super::Reading> {
        let elapsed = view.time - self.last_time;
        let reading = if elapsed < 1e-6 {
            Reading { velocities: [].into(), positions: [].into() }
        } else {
            let speed = |(now, before): (&crate::WheelState, &f64)| (now.angle - before) / elapsed;
            let positions = self.last.iter().zip(&self.reference).map(|(angle, reference)| angle - reference);
            let velocities = view.wheels.iter().zip(&self.last).map(speed);
            Reading { velocities: velocities.collect(), positions: positions.collect() }
        };
        self.last_time = view.time;
        self.last = view.wheels.iter().map(|wheel| wheel.angle).collect();
        Some(reading.into())
    }

    /// Executes `RESET`: the current angles count as zero.
    fn set(&mut self, opcode: &str, _set: &Set, view: &View) -> Effect {
        if opcode == "RESET" {
            self.reference = view.wheels.iter().map(|wheel| wheel.angle).collect();
            self.last.clone_from(&self.reference);
            self.last_time = view.time;
        }
        Effect::None
    }

    fn state(&mut self) -> State<'_> {
        let Self { last_time, last, reference, .. } = self;
        State { numbers: [last_time].into_iter().chain(last).chain(reference).collect(), ..State::default() }
    }

    fn conf(&self) -> ItemConf {
        WheelsConf { name: self.name.clone(), scan_interval: self.scan_interval as f32 }.into()
    }
}
