//! Speeds and angles of all driven wheels (Tachometer.uc:27-61), without noise.

use gamebots_proto::command::Set;
use gamebots_proto::message::{ItemConf, Reading, Tachometer, WheelsConf};

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

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "Tachometer"
    }

    /// Returns the mean speeds since the last reading, and the angles at the last reading, which are one interval late.
    fn sense(&mut self, view: &View) -> Option<Reading> {
        let elapsed = view.time - self.last_time;
        let (velocities, positions) = if elapsed < 1e-6 {
            (Vec::new(), Vec::new())
        } else {
            let speed =
                |(now, before): (&crate::WheelState, &f64)| ((now.angle - before) / elapsed / view.speed_unit) as f32;
            let positions = self.last.iter().zip(&self.reference).map(|(angle, reference)| (angle - reference) as f32);
            (view.wheels.iter().zip(&self.last).map(speed).collect(), positions.collect())
        };
        self.last_time = view.time;
        self.last = view.wheels.iter().map(|wheel| wheel.angle).collect();
        Some(Tachometer { name: self.name.clone(), velocities, positions }.into())
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
