//! Contact with anything in front of a small face (Touch.uc:21-86).
//!
//! A ray leaves the middle of the face along the sensor's x axis, and six leave its edge. The original casts 36 around the edge in six
//! places.

use std::f64::consts::TAU;

use gamebots_proto::message::{ItemConf, Touch, TouchConf};
use nalgebra::Point3;
use scene::sensor::touch::{Config, Reading};
use scene::{Pose, SensorDef};

use super::{Mount, Sensor, View};

/// Reach of the rays, m: 0.16 of Unreal's units of 4 mm (Touch.uc:46-70).
const REACH: f64 = 0.64e-3;
/// Rays around the edge.
const AROUND: u32 = 6;

#[derive(Clone)]
pub(crate) struct Mounted {
    name: String,
    pose: Pose,
    diameter: f64,
    /// Origins of the rays in the sensor frame.
    origins: Vec<Point3<f64>>,
}

pub(super) fn build(config: &Config, mount: Mount) -> Mounted {
    let radius = config.diameter / 2.0;
    let edge = (0..AROUND).map(|number| {
        let (sin, cos) = libm::sincos(TAU * f64::from(number) / f64::from(AROUND));
        Point3::new(0.0, radius * cos, radius * sin)
    });
    Mounted {
        name: mount.name.to_owned(),
        pose: mount.pose,
        diameter: config.diameter,
        origins: std::iter::once(Point3::origin()).chain(edge).collect(),
    }
}

/// Returns the reading for the wire.
pub(super) fn wire(def: &SensorDef, reading: &Reading) -> Touch {
    Touch { name: def.name.clone(), touch: reading.touch }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "Touch"
    }

    fn sense(&mut self, view: &View) -> Option<super::Reading> {
        let pose = view.carrier.pose * self.pose;
        let ahead = pose.rotation * nalgebra::Vector3::x();
        let meets = |origin: &Point3<f64>| view.sight(&(pose * origin), REACH).cast_ray(&ahead).is_some();
        Some(Reading { touch: self.origins.iter().any(meets) }.into())
    }

    fn conf(&self) -> ItemConf {
        TouchConf { name: self.name.clone(), diameter: self.diameter as f32 }.into()
    }
}
