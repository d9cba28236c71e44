//! Accelerations and turn rates as differences between two readings (IMU.uc:25-65). The acceleration is along the sensor's axes with z
//! up, without gravity. The turn rates are those of roll, pitch and yaw, which differ from the rates about the body's axes.

use gamebots_proto::message::{Imu, ItemConf, PlainConf};
use nalgebra::Vector3;
use scene::sensor::imu::Reading;
use scene::{Pose, SensorDef, position_and_rotation, wrapped};

use super::{Mount, Sensor, State, View, floats};

#[derive(Clone)]
pub(crate) struct Mounted {
    name: String,
    pose: Pose,
    last: Last,
}

/// State at the last reading.
#[derive(Clone)]
struct Last {
    time: f64,
    velocity: Vector3<f64>,
    angles: [f64; 3],
    rates: [f64; 3],
}

pub(super) fn build(mount: Mount) -> Mounted {
    let View { time, carrier, .. } = *mount.view;
    let (_, angles) = position_and_rotation(&carrier.pose);
    let last = Last { time, velocity: carrier.linear, angles, rates: [0.0; 3] };
    Mounted { name: mount.name.to_owned(), pose: mount.pose, last }
}

/// Returns the reading for the wire.
pub(super) fn wire(def: &SensorDef, reading: &Reading) -> Imu {
    let Reading { acceleration, angular_velocity, angular_acceleration, angles } = *reading;
    Imu {
        name: def.name.clone(),
        acceleration: floats(acceleration),
        angular_velocity: floats(angular_velocity),
        angular_acceleration: floats(angular_acceleration),
        rotation: floats(angles),
    }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "IMU"
    }

    fn sense(&mut self, view: &View) -> Option<super::Reading> {
        let View { time, carrier, .. } = *view;
        let (_, angles) = position_and_rotation(&carrier.pose);
        let passed = time - self.last.time;
        // Two readings at the same time: no division by zero.
        let rate = |change: f64| if passed > 0.0 { change / passed } else { 0.0 };
        let changed = (carrier.linear - self.last.velocity).map(rate);
        let along = (carrier.pose.rotation * self.pose.rotation).inverse() * changed;
        let rates: [f64; 3] = std::array::from_fn(|axis| rate(wrapped(angles[axis] - self.last.angles[axis])));
        let changes = std::array::from_fn(|axis| rate(rates[axis] - self.last.rates[axis]));
        self.last = Last { time, velocity: carrier.linear, angles, rates };
        let reading = Reading {
            acceleration: [along.x, along.y, -along.z],
            angular_velocity: rates,
            angular_acceleration: changes,
            angles,
        };
        Some(reading.into())
    }

    fn state(&mut self) -> State<'_> {
        let Last { time, velocity, angles, rates } = &mut self.last;
        let numbers = [time].into_iter().chain(velocity.iter_mut()).chain(angles).chain(rates);
        State { numbers: numbers.collect(), ..State::default() }
    }

    fn conf(&self) -> ItemConf {
        PlainConf { name: self.name.clone() }.into()
    }
}
