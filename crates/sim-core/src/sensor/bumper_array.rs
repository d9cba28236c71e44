//! A bow of bumpers that feel what is beside it (BumperArray.uc). Each has rays outward from its middle and from its edge.

use std::f64::consts::TAU;

use gamebots_proto::message::{ArcRotation, ItemConf, TouchArray, TouchArrayConf};
use nalgebra::{Point3, UnitQuaternion, Vector3};
use scene::sensor::bumper_array::{Config, Reading};
use scene::{Pose, SensorDef};

use super::{Mount, Sensor, View, beam};

/// Bumpers of the bow.
const BUMPERS: u32 = 20;
/// Rays from the edge of a bumper.
const AROUND: u32 = 6;

#[derive(Clone)]
pub(crate) struct Mounted {
    name: String,
    pose: Pose,
    config: Config,
    /// Origins and directions of the rays in the sensor frame.
    rays: Vec<(Point3<f64>, Vector3<f64>)>,
}

pub(super) fn build(config: &Config, mount: Mount) -> Mounted {
    let [roll, pitch, yaw] = config.arc_rotation;
    let plane = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    let bumper = |number: u32| {
        let along = 0.5 - f64::from(number) / f64::from(BUMPERS - 1);
        let outward = plane * beam(config.arc_angle * along, 0.0);
        let middle = outward * config.arc_radius;
        let edge = (0..AROUND).map(move |ray| {
            let (sin, cos) = libm::sincos(TAU * f64::from(ray) / f64::from(AROUND));
            Vector3::new(0.0, cos, sin) * (config.diameter / 2.0)
        });
        std::iter::once(Vector3::zeros()).chain(edge).map(move |beside| (Point3::from(middle + beside), outward))
    };
    Mounted {
        name: mount.name.to_owned(),
        pose: mount.pose,
        rays: (0..BUMPERS).flat_map(bumper).collect(),
        config: config.clone(),
    }
}

/// Returns the reading for the wire.
pub(super) fn wire(def: &SensorDef, reading: &Reading) -> TouchArray {
    TouchArray { name: def.name.clone(), touch: reading.touch }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "TouchArray"
    }

    fn sense(&mut self, view: &View) -> Option<super::Reading> {
        let pose = view.carrier.pose * self.pose;
        let meets = |(origin, outward): &(Point3<f64>, Vector3<f64>)| {
            view.sight(&(pose * origin), self.config.reach).cast_ray(&(pose.rotation * outward)).is_some()
        };
        Some(Reading { touch: self.rays.iter().any(meets) }.into())
    }

    fn conf(&self) -> ItemConf {
        let [roll, pitch, yaw] = self.config.arc_rotation.map(|angle| angle as f32);
        TouchArrayConf {
            name: self.name.clone(),
            diameter: self.config.diameter as f32,
            arc_rotation: ArcRotation([pitch, roll, yaw]),
            arc_radius: self.config.arc_radius as f32,
            arc_angle: self.config.arc_angle as f32,
        }
        .into()
    }
}
