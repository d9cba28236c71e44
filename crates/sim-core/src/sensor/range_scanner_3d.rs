//! A laser that scans rows, one above the other: a sensor of UT2004 (sensors.md 8).

use gamebots_proto::command::Set;
use gamebots_proto::message::{ItemConf, RangeScanner3D, RangeScanner3DConf};
use nalgebra::Vector3;
use scene::sensor::range_scanner_3d::{Config, Reading};
use scene::{Pose, SensorDef};

use super::{Effect, Mount, Sensor, View, beam};

#[derive(Clone)]
pub(crate) struct Mounted {
    name: String,
    pose: Pose,
    config: Config,
    /// Directions in the sensor frame.
    beams: Vec<Vector3<f64>>,
}

pub(super) fn build(config: &Config, mount: Mount) -> Mounted {
    let [rows, columns] = config.counts();
    let beams = (0..rows).flat_map(|row| {
        let pitch = config.vertical_field_of_view / 2.0 - row as f64 * config.vertical_resolution;
        (0..columns).map(move |column| {
            beam(config.horizontal_field_of_view / 2.0 - column as f64 * config.horizontal_resolution, pitch)
        })
    });
    Mounted { name: mount.name.to_owned(), pose: mount.pose, beams: beams.collect(), config: config.clone() }
}

/// Returns the reading for the wire.
pub(super) fn wire(def: &SensorDef, reading: &Reading) -> RangeScanner3D {
    let config =
        if let scene::sensor::Config::RangeScanner3D(config) = &def.config { config } else { &Config::default() };
    RangeScanner3D {
        name: def.name.clone(),
        resolution: resolution(config),
        field_of_view: field_of_view(config),
        ranges: reading.ranges.iter().map(|range| *range as f32).collect(),
    }
}

fn resolution(config: &Config) -> Vec<f32> {
    vec![config.vertical_resolution as f32, config.horizontal_resolution as f32]
}

fn field_of_view(config: &Config) -> Vec<f32> {
    vec![config.vertical_field_of_view as f32, config.horizontal_field_of_view as f32]
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "RangeScanner3D"
    }

    fn sense(&mut self, view: &View) -> Option<super::Reading> {
        let pose = view.carrier.pose * self.pose;
        let sight = view.sight(&pose.translation.vector.into(), self.config.max_range);
        let ranges = sight.ranges(self.beams.iter().map(|beam| pose.rotation * beam));
        Some(Reading { ranges: ranges.into() }.into())
    }

    /// Executes `SCAN`: one more reading goes out at once.
    fn set(&mut self, opcode: &str, _set: &Set, _view: &View) -> Effect {
        if opcode == "SCAN" { Effect::Scan } else { Effect::None }
    }

    fn conf(&self) -> ItemConf {
        RangeScanner3DConf {
            name: self.name.clone(),
            max_range: self.config.max_range as f32,
            min_range: self.config.min_range as f32,
            resolution: resolution(&self.config),
            fov: field_of_view(&self.config),
        }
        .into()
    }
}
