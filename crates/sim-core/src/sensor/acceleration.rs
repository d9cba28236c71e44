//! Accelerations as differences between two readings, without gravity (Acceleration.uc:27-49) and with it (AcceleroMeter.uc:9-32). The
//! original adds gravity, so at rest an accelerometer reads what a real one reads with the opposite sign.

use gamebots_proto::message::{self, ItemConf, PlainConf};
use nalgebra::Vector3;
use scene::sensor::{acceleration, accelerometer};
use scene::{Pose, SensorDef};

use super::{Mount, Reading, Sensor, State, View, floats};

#[derive(Clone)]
pub(crate) struct Mounted {
    name: String,
    pose: Pose,
    with_gravity: bool,
    /// Time and velocity of the last reading.
    time: f64,
    velocity: Vector3<f64>,
}

pub(super) fn build(with_gravity: bool, mount: Mount) -> Mounted {
    let View { time, carrier, .. } = *mount.view;
    Mounted { name: mount.name.to_owned(), pose: mount.pose, with_gravity, time, velocity: carrier.linear }
}

/// Returns the reading without gravity for the wire.
pub(super) fn wire(def: &SensorDef, reading: &acceleration::Reading) -> message::Acceleration {
    message::Acceleration { name: def.name.clone(), acceleration: floats(reading.acceleration) }
}

/// Returns the reading with gravity for the wire.
pub(super) fn wire_with_gravity(def: &SensorDef, reading: &accelerometer::Reading) -> message::AcceleroMeter {
    message::AcceleroMeter { name: def.name.clone(), acceleration: floats(reading.acceleration) }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        if self.with_gravity { "AcceleroMeter" } else { "Accel" }
    }

    fn sense(&mut self, view: &View) -> Option<Reading> {
        let View { time, carrier, .. } = *view;
        let passed = time - self.time;
        let changed = carrier.linear - self.velocity;
        // Two readings at the same time: no division by zero.
        let mut acceleration = if passed > 0.0 { changed / passed } else { Vector3::zeros() };
        if self.with_gravity {
            acceleration += view.physics.gravity();
        }
        (self.time, self.velocity) = (time, carrier.linear);
        let acceleration = ((carrier.pose.rotation * self.pose.rotation).inverse() * acceleration).into();
        Some(match self.with_gravity {
            true => accelerometer::Reading { acceleration }.into(),
            false => acceleration::Reading { acceleration }.into(),
        })
    }

    fn state(&mut self) -> State<'_> {
        let numbers = [&mut self.time].into_iter().chain(self.velocity.iter_mut());
        State { numbers: numbers.collect(), ..State::default() }
    }

    fn conf(&self) -> ItemConf {
        PlainConf { name: self.name.clone() }.into()
    }
}
