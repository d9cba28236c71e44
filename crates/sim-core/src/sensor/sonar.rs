//! Ultrasonic range: the nearest echo within a cone, as intended by SonarSensor.uc:28-101.
//!
//! One beam points straight ahead, and cones of beams surround it. A surface off the axis echoes only if it faces the sensor within the
//! largest angle of incidence. USARSim compares with the reversed normal, so none of its cone beams ever counts; this code follows the
//! intended rule.

use std::f64::consts::TAU;

use gamebots_proto::message::{ItemConf, Sonar, SonarConf};
use nalgebra::{UnitQuaternion, Vector3};
use scene::rotation_units;

use super::{Mount, Sensor, View};
use scene::sensor::sonar::{Config, Reading};
use scene::{Pose, SensorDef};

#[derive(Clone)]
pub(crate) struct Mounted {
    name: String,
    scan_interval: f64,
    pose: Pose,
    config: Config,
    /// Directions of the cone beams in the sensor frame.
    cone_beams: Vec<Vector3<f64>>,
}

pub(super) fn build(config: &Config, mount: Mount) -> Mounted {
    let step = rotation_units::to_radians(rotation_units::from_radians(
        config.beam_angle / 2.0 / f64::from(config.number_of_cones.max(1)),
    ));
    // Neighbours follow each other, as rays are cast soonest so.
    let cone_beams = (0..config.traces_per_cone).flat_map(|trace| {
        (1..=config.number_of_cones).map(move |cone| {
            let around = TAU * f64::from(trace) / f64::from(config.traces_per_cone);
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
        config: config.clone(),
    }
}

/// Returns the reading for the wire.
pub(super) fn wire(def: &SensorDef, reading: &Reading) -> Sonar {
    Sonar { name: def.name.clone(), range: reading.range as f32 }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "Sonar"
    }

    fn sense(&mut self, view: &View) -> Option<super::Reading> {
        let pose = view.carrier.pose * self.pose;
        let sight = view.sight(&pose.translation.vector.into(), self.config.max_range);
        let least_cosine = libm::cos(self.config.max_angle_of_incidence);
        let ahead = sight.cast_ray(&(pose.rotation * Vector3::x())).map(|hit| hit.distance);
        let directions = self.cone_beams.iter().map(|beam| pose.rotation * beam);
        let hits = sight.cast_rays(directions.clone());
        let around = directions.zip(hits).filter_map(|(direction, hit)| {
            let hit = hit?;
            (-hit.normal.dot(&direction) > least_cosine).then_some(hit.distance)
        });
        let nearest = ahead.into_iter().chain(around).fold(self.config.max_range, f64::min);
        let range = nearest.clamp(self.config.min_range, self.config.max_range);
        Some(Reading { range }.into())
    }

    fn conf(&self) -> ItemConf {
        SonarConf {
            name: self.name.clone(),
            max_range: self.config.max_range as f32,
            min_range: self.config.min_range as f32,
            scan_interval: self.scan_interval as f32,
            beam_angle: rotation_units::to_radians(rotation_units::from_radians(self.config.beam_angle)),
            max_angle_of_incidence: self.config.max_angle_of_incidence as f32,
            traces_per_cone: self.config.traces_per_cone,
            number_of_cones: self.config.number_of_cones,
        }
        .into()
    }
}
