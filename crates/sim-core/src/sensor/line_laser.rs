//! Points of a line of light, in the world (LineLaser.uc:193-349). The original scans once and repeats that scan, and reaches 250 times too
//! far; this is what it means.

use gamebots_proto::message::{ItemConf, LineLaser, LineLaserConf};
use scene::sensor::line_laser::{Config, Reading};
use scene::{Pose, SensorDef, position_and_rotation};

use super::{Mount, Sensor, View, beam, floats, points};

#[derive(Clone)]
pub(crate) struct Mounted {
    name: String,
    pose: Pose,
    config: Config,
}

pub(super) fn build(config: &Config, mount: Mount) -> Mounted {
    Mounted { name: mount.name.to_owned(), pose: mount.pose, config: config.clone() }
}

/// Returns the reading for the wire.
pub(super) fn wire(def: &SensorDef, reading: &Reading) -> LineLaser {
    LineLaser {
        name: def.name.clone(),
        location: floats(reading.position),
        orientation: floats(reading.angles),
        points: points(&reading.points),
    }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "LineLaser"
    }

    fn sense(&mut self, view: &View) -> Option<super::Reading> {
        let pose = view.carrier.pose * self.pose;
        let Config { max_range, field_of_view, beams, .. } = self.config;
        let origin = pose.translation.vector.into();
        let sight = view.sight(&origin, max_range);
        let direction = |number: u32| {
            let yaw = field_of_view * (f64::from(number) / f64::from(beams - 1) - 0.5);
            pose.rotation * beam(yaw, 0.0)
        };
        let directions = (0..beams - 1).map(direction);
        let ranges = sight.ranges(directions.clone());
        let points = directions.zip(ranges).map(|(direction, range)| (origin + direction * range).coords);
        let (position, angles) = position_and_rotation(&pose);
        Some(Reading { position, angles, points: points.flat_map(<[f64; 3]>::from).collect() }.into())
    }

    fn conf(&self) -> ItemConf {
        LineLaserConf {
            name: self.name.clone(),
            max_range: self.config.max_range as f32,
            min_range: self.config.min_range as f32,
            fov: self.config.field_of_view as f32,
            resolution: self.config.beams,
        }
        .into()
    }
}
