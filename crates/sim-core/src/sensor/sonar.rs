//! Ultrasonic range: the nearest echo within a cone, as SonarSensor.uc:28-101 means it.
//!
//! One beam straight ahead, then cones of beams around it. A surface off the axis echoes only if it faces the
//! sensor within the largest angle of incidence. (USARSim compares with the reversed normal, so that none of its
//! cone beams ever counts; the intended rule is built here.)

use std::f64::consts::TAU;

use gamebots_proto::message::{ItemConf, Reading, Sonar};
use gamebots_proto::number::{radians, rotation_units};
use nalgebra::{UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use super::{Mount, Sensor, View};
use crate::scene::Pose;

/// Numbers of a sonar.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// What silence reads, m.
    pub max_range: f64,
    /// Smallest reading, m.
    pub min_range: f64,
    /// Opening angle of the whole cone, rad.
    pub beam_angle: f64,
    /// Largest angle between a beam and the surface's normal at which it echoes, rad.
    pub max_angle_of_incidence: f64,
    /// Beams of one cone.
    pub traces_per_cone: u32,
    /// Cones inside each other.
    pub number_of_cones: u32,
}

impl Default for Config {
    /// DefaultUSAR.ini:163-171.
    fn default() -> Self {
        Self {
            max_range: 5.0,
            min_range: 0.1,
            beam_angle: 0.349,
            max_angle_of_incidence: 0.1745329252,
            traces_per_cone: 16,
            number_of_cones: 10,
        }
    }
}

pub(super) struct Mounted {
    name: String,
    scan_interval: f64,
    pose: Pose,
    config: Config,
    /// Directions of the cone beams in the sensor frame.
    cone_beams: Vec<Vector3<f64>>,
}

impl Config {
    /// Numbers that a cone can be made with.
    pub(super) fn validate(&self) -> Result<(), &'static str> {
        let good = 0.0 <= self.min_range
            && self.min_range < self.max_range
            && self.max_range <= 10_000.0
            && (0.0..=std::f64::consts::PI).contains(&self.beam_angle)
            && (0.0..=std::f64::consts::PI).contains(&self.max_angle_of_incidence)
            && self.number_of_cones <= 100
            && self.traces_per_cone <= 1000;
        if good { Ok(()) } else { Err("min_range < max_range, angles 0 to pi, at most 100 cones of 1000 traces") }
    }
}

impl Config {
    /// The beam ahead and those of the cones.
    pub(super) fn rays(&self) -> usize {
        (self.number_of_cones as usize).saturating_mul(self.traces_per_cone as usize).saturating_add(1)
    }

    pub(super) fn build(&self, mount: Mount) -> Mounted {
        let step = radians(rotation_units(self.beam_angle / 2.0 / f64::from(self.number_of_cones.max(1))));
        let cone_beams = (1..=self.number_of_cones).flat_map(|cone| {
            (0..self.traces_per_cone).map(move |trace| {
                let around = TAU * f64::from(trace) / f64::from(self.traces_per_cone);
                let tilt = f64::from(step) * f64::from(cone);
                UnitQuaternion::from_euler_angles(around, 0.0, 0.0)
                    * (UnitQuaternion::from_euler_angles(0.0, tilt, 0.0) * Vector3::x())
            })
        });
        Mounted {
            name: mount.name.to_owned(),
            scan_interval: mount.scan_interval,
            pose: mount.pose,
            cone_beams: cone_beams.collect(),
            config: self.clone(),
        }
    }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "Sonar"
    }

    fn sense(&mut self, view: &View) -> Option<Reading> {
        let pose = view.body.pose * self.pose;
        let origin = pose.translation.vector.into();
        let cast = |beam: &Vector3<f64>| {
            let direction = pose.rotation * beam;
            view.cast_ray(&origin, &direction, self.config.max_range).map(|hit| (hit, direction))
        };
        let ahead = cast(&Vector3::x()).map(|(hit, _)| hit.distance);
        let around = self.cone_beams.iter().filter_map(cast).filter_map(|(hit, direction)| {
            let incidence = (-hit.normal).angle(&direction);
            (incidence < self.config.max_angle_of_incidence).then_some(hit.distance)
        });
        let nearest = ahead.into_iter().chain(around).fold(self.config.max_range, f64::min);
        let range = nearest.clamp(self.config.min_range, self.config.max_range) as f32;
        Some(Sonar { name: self.name.clone(), range }.into())
    }

    fn conf(&self) -> ItemConf {
        ItemConf::Sonar {
            name: self.name.clone(),
            max_range: self.config.max_range as f32,
            min_range: self.config.min_range as f32,
            scan_interval: self.scan_interval as f32,
            beam_angle: radians(rotation_units(self.config.beam_angle)),
            max_angle_of_incidence: self.config.max_angle_of_incidence as f32,
            traces_per_cone: self.config.traces_per_cone,
            number_of_cones: self.config.number_of_cones,
        }
    }
}
